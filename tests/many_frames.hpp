#pragma once

#include <fmt/format.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "src/record/recorder.hpp"
#include "src/record/result_file.hpp"
#include "tests/folder.hpp"
#include "tests/message.hpp"

/// Results of many small frames, and their expected numbers.
namespace lichtenberg::many_frames {

namespace fs = std::filesystem;
using Of = Column::Of;

constexpr int particles = 20;
constexpr std::uint64_t few = 3300;  // Limit (bytes) of three frames per segment.

inline Scene some_scene() {
  Scene scene;
  scene.path = "many.toml";
  scene.text = "title = \"many\"\n[stop]\ntime = 1.0\n";
  scene.domain.size = {1, 0.75};
  scene.medium.depth = 0.5;
  for (const int side : {0, 1}) scene.domain.sides[side].periodic = true;
  for (int i = 0; i < particles; ++i) scene.conductors.push_back({.position = {0.01 * i, 0.5}, .radius = 0.001});
  return scene;
}

/// Frame with numbers and a list length that depend on its index.
inline Frame frame(int k) {
  std::vector<double> position, charge;
  std::vector<std::int32_t> pairs;
  for (int i = 0; i < particles; ++i) {
    position.insert(position.end(), {i + 1e-3 * k, 2.0 * k, 0});
    charge.push_back(1e-9 * i * k);
  }
  for (int c = 0; c < k % 4; ++c) pairs.insert(pairs.end(), {c, c + k});
  return {.time = 0.5 * k,
          .columns = {{"position", "m", Of::particles, 3, position},
                      {"charge", "C", Of::particles, 0, charge},
                      {"energy", "J", Of::system, 0, std::vector<double>{1.0 + k}},
                      {"current", "A", Of::system, 2, std::vector<double>{1.0 * k, -1.0 * k}, {"left", "right"}},
                      {"solves", "1", Of::system, 0, std::vector<std::int64_t>{7 * k}},
                      {"contacts", "1", Of::list, 2, pairs}}};
}

inline Milestone milestone(int frames, bool over = false) {
  Milestone m;
  m.checkpoint.reals["mark"] = {1.0 * frames};
  m.seconds["field"] = 0.5;
  m.history = ColumnGroup{"relaxation", {{"iteration", "1", Of::list, 0, std::vector<std::int64_t>{frames}}}};
  if (over) m.summary = {{"energy", 2.5, "J"}};
  return m;
}

inline Recorder start(const std::string& path, std::uint64_t tail = few, bool overwrite = false) {
  return Recorder::start(path, some_scene(), std::vector<double>(particles, 1e-3), overwrite, tail);
}

/// Adds frames up to `end`, with a save at every third frame.
inline void add_until(Recorder& recorder, int end) {
  for (int k = static_cast<int>(recorder.frames()); k < end; ++k) {
    recorder.add(frame(k));
    if (k % 3 == 0) recorder.save(milestone(k + 1));
  }
}

inline void run(const std::string& path, int frames, bool to_the_end, std::uint64_t tail = few) {
  Recorder recorder = start(path, tail);
  add_until(recorder, frames);
  recorder.save(milestone(frames, to_the_end));
}

inline std::int64_t segments(const std::string& path) {
  std::error_code none;
  return std::distance(fs::directory_iterator(segments_folder(path), none), {});
}

using Numbers = std::map<std::string, std::vector<double>>;

/// All numbers of all frames as read from a result.
inline Numbers numbers(const std::string& path) {
  const ResultFile file(path, "read");
  Numbers found;
  for (const std::string name :
       {"particles/conductors/position/value", "particles/conductors/charge/value", "observables/energy/value",
        "observables/current/value", "observables/solves/value", "observables/energy/step", "observables/energy/time",
        "network/contacts_end", "particles/conductors/box/edges/value"})
    found[name] = file.rows<double>(name);
  const auto ends = file.rows<std::int64_t>("network/contacts_end");
  for (std::int64_t k = 0; k < file.frames(); ++k)
    for (const std::int32_t end : file.list<std::int32_t>("contacts", ends, k)) found["contacts"].push_back(end);
  found["mark"] = hdf5::get<double>(file.file(), "checkpoint/reals/mark");
  return found;
}

/// Expected numbers of a result with the given number of frames.
inline Numbers expected(int frames) {
  Numbers all;
  const auto append = [](std::vector<double>& to, const Column& column) {
    std::visit([&](const auto& values) { to.insert(to.end(), values.begin(), values.end()); }, column.values);
  };
  double contacts = 0;
  for (int k = 0; k < frames; ++k) {
    const Frame now = frame(k);
    append(all["particles/conductors/position/value"], now.columns[0]);
    append(all["particles/conductors/charge/value"], now.columns[1]);
    append(all["observables/energy/value"], now.columns[2]);
    append(all["observables/current/value"], now.columns[3]);
    append(all["observables/solves/value"], now.columns[4]);
    if (now.columns[5].size() > 0) append(all["contacts"], now.columns[5]);
    all["observables/energy/step"].push_back(k);
    all["observables/energy/time"].push_back(now.time);
    for (const double number : {1.0, 0.0, 0.0, 0.0, 0.75, 0.0, 0.0, 0.0, 0.5})
      all["particles/conductors/box/edges/value"].push_back(number);
    all["network/contacts_end"].push_back(contacts += static_cast<double>(now.columns[5].rows()));
  }
  all["mark"] = {1.0 * frames};
  return all;
}

inline pid_t in_child(const std::function<void()>& action) {
  const pid_t child = fork();
  if (child != 0) return child;
  const std::string message = message_of(action);
  if (!message.empty()) std::fprintf(stderr, "%s\n", message.c_str());
  _exit(message.empty() ? 0 : 1);
}

inline int status_of(pid_t child) {
  int status = 0;
  waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

/// Runs a script with Debian's python, which has h5py, and returns its exit status.
inline int python(const Folder& folder, const std::string& script) {
  folder.write("script.py", script);
  return std::system(fmt::format("cd '{}' && /usr/bin/python3 script.py", folder.path.string()).c_str());
}

}  // namespace lichtenberg::many_frames
