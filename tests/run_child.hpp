#pragma once

#include <doctest/doctest.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cstddef>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "src/commands/command_line.hpp"
#include "tests/file_numbers.hpp"
#include "tests/folder.hpp"

/// Runs in child processes, which may be killed, and what their result files hold.
namespace lichtenberg::run_child {

/// `lichtenberg run six.toml --out <file> ...` in a child process whose output goes to files.
class Child {
 public:
  Child(
      const Folder& folder, const std::string& file, std::vector<std::string> options = {},
      const std::function<void()>& prepare = [] {})
      : messages_(folder / "stderr"), summary_(folder / "stdout") {
    std::vector<std::string> arguments{"run", folder / "six.toml", "--out", folder / file};
    arguments.insert(arguments.end(), options.begin(), options.end());
    std::fflush(nullptr);  // or the child would print what waits in our buffers again
    process_ = fork();
    if (process_ != 0) return;
    for (const auto& [path, stream] : {std::pair{messages_, stderr}, std::pair{summary_, stdout}})
      if (std::freopen(path.c_str(), "w", stream) == nullptr) _exit(99);
    prepare();
    const int status = run_command_line(arguments);
    std::fflush(nullptr);
    _exit(status);
  }
  Child(const Child&) = delete;
  ~Child() { wait(); }

  void send(int signal) const { kill(process_, signal); }
  /// Whether it has a handler for the signal by now.
  bool catches(int signal) const {
    const std::string status = text_of("/proc/" + std::to_string(process_) + "/status"), key = "SigCgt:";
    return std::stoull(status.substr(status.find(key) + key.size()), nullptr, 16) >> (signal - 1) & 1;
  }
  /// A process that it has started; 0: there is none.
  pid_t own_child() const {
    const std::string process = std::to_string(process_);
    const std::string list = text_of("/proc/" + process + "/task/" + process + "/children");
    return list.empty() ? 0 : std::stoi(list);
  }
  /// Exit status, or 128 and the number of the signal that ended it.
  int wait() {
    if (process_ != 0) waitpid(process_, &status_, 0);
    process_ = 0;
    return WIFEXITED(status_) ? WEXITSTATUS(status_) : 128 + WTERMSIG(status_);
  }
  std::string messages() const { return text_of(messages_); }
  std::string summary() const { return text_of(summary_); }

 private:
  std::string messages_, summary_;
  pid_t process_ = 0;
  int status_ = 0;
};

/// Trials of runs that a signal ends on their way.
class Interruptions {
 public:
  /// Leaves a whole run in `file`, which takes as long as runs do.
  Interruptions(const Folder& folder, const std::string& file) : folder_(folder) {
    const auto began = std::chrono::steady_clock::now();
    REQUIRE_EQ(Child(folder, file, {"--quiet"}).wait(), 0);
    whole_ = std::chrono::steady_clock::now() - began;
  }
  /// Sends it to `child`, whose result is `file`: as soon as there is one if `at_first`, since nobody knows how long
  /// the disk took for the whole run, else in the middle of this one of six parts of the time.
  void send(int signal, const Child& child, const std::string& file, int part, bool at_first) const {
    if (at_first)
      while (!std::filesystem::exists(folder_ / file)) usleep(1000);
    else
      usleep(static_cast<useconds_t>(1e6 * whole_.count() * (part + 0.5) / 6));
    child.send(signal);
  }

 private:
  const Folder& folder_;
  std::chrono::duration<double> whole_{};
};

inline int run(const Folder& folder, const std::string& file, const std::vector<std::string>& options = {"--quiet"}) {
  return Child(folder, file, options).wait();
}

/// A run to six.h5 whose files cannot grow beyond `room` bytes, which fails a write as a full disk does, only with
/// another error number: status 1, a sentence, and what was saved before and nothing else is left. Returns what it
/// said.
inline std::string run_on_full_disk(const Folder& folder, rlim_t room) {
  Child child(folder, "six.h5", {"--quiet"}, [room] {
    signal(SIGXFSZ, SIG_IGN);
    const rlimit at_most{room, room};
    setrlimit(RLIMIT_FSIZE, &at_most);
  });
  CHECK_EQ(child.wait(), 1);
  CHECK_NE(child.messages().find("six.h5 cannot be written (File too large); what was saved up to t = "),
           std::string::npos);
  for (const auto& entry : std::filesystem::directory_iterator(std::filesystem::path(folder / "six.h5").parent_path()))
    CHECK(entry.path().string().find(".partial") == std::string::npos);
  return child.messages();
}

/// All numbers of a result file but the provenance's, which are timings.
inline std::map<std::string, std::vector<std::byte>> numbers(const std::string& path) {
  std::map<std::string, std::vector<std::byte>> bytes = numbers_in(path);
  std::erase_if(bytes, [](const auto& entry) { return entry.first.starts_with("/provenance"); });
  return bytes;
}

inline void check_same_numbers(const std::string& path, const std::string& reference) {
  const auto a = numbers(path), b = numbers(reference);
  REQUIRE_EQ(a.size(), b.size());
  for (const auto& [name, bytes] : a) {
    CAPTURE(name);
    CHECK(bytes == b.at(name));
  }
}

}  // namespace lichtenberg::run_child
