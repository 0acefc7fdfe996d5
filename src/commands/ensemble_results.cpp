#include <fmt/format.h>

#include <array>
#include <filesystem>
#include <utility>

#include "solvers/error.hpp"
#include "src/commands/ensemble.hpp"
#include "src/record/hdf5.hpp"
#include "src/record/layout.hpp"
#include "src/record/scene_change.hpp"
#include "src/scene/scene.hpp"

namespace lichtenberg::ensemble {
namespace {

bool same_end(const StopOptions& a, const StopOptions& b) {
  return a.time == b.time && a.stationary == b.stationary && a.force == b.force;
}

/// Of all sessions of the run.
double wall_seconds(const hdf5::Handle& file) {
  double all = 0;
  for (int session = 0;; ++session) {
    const std::string path = fmt::format("provenance/session-{}/seconds", session);
    if (!hdf5::exists(file, path)) return all;
    const hdf5::Handle seconds = hdf5::open_group(file, path);
    for (const std::string& activity : hdf5::names(seconds)) all += hdf5::get<double>(seconds, activity).at(0);
  }
}

std::map<std::string, double> quantities_of(const hdf5::Handle& file) {
  std::map<std::string, double> result;
  const hdf5::Handle summary = hdf5::open_group(file, "summary");
  for (const std::string& name : hdf5::names(summary)) result[name] = hdf5::get<double>(summary, name).at(0);
  result["conductors"] = static_cast<double>(hdf5::shape(file, "particles/conductors/radius").at(0));
  for (const std::string name : {"connected", "endpoints", "branch_points", "field_solves", "iterations"})
    if (const std::string path = "observables/" + name + "/value"; hdf5::exists(file, path))
      result[name] = hdf5::get<double>(file, path).back();
  result["seconds"] = wall_seconds(file);
  return result;
}

/// Sets the member's state, or throws InputError or hdf5::Error. A run that has just ended was given the [stop] of now,
/// even if its file still has that of its start.
void inspect_file(const std::string& path, Member& member) {
  if (!hdf5::is_hdf5(path)) throw InputError(fmt::format("{} is no result file of a run", path));
  const hdf5::Handle file = hdf5::load(path);
  const std::optional<int> format = hdf5::integer_attribute(file, "lichtenberg_result");
  if (format != result_format)
    throw InputError(fmt::format("{} was not written by this version of `lichtenberg run`", path));
  const std::string text = hdf5::get_text(file, "scene/text");
  const std::string change = first_change(text, member.text);
  if (!change.empty())
    throw InputError(
        fmt::format("key `{}` is not what it was when {} was started: move that file away, or name "
                    "another folder with --out",
                    change, path));
  const bool just_ended = member.state == State::finished;
  const bool over = hdf5::exists(file, "summary");
  if (!over || !(just_ended || same_end(parse_scene(text, path).stop, parse_scene(member.text, path).stop))) return;
  member.quantities = quantities_of(file);
  member.state = State::finished;
}

}  // namespace

void inspect(const std::string& folder, Member& member) {
  const std::string path = result_file(folder, member);
  if (!std::filesystem::exists(path)) return;
  try {
    inspect_file(path, member);
  } catch (const InputError& error) {
    member.state = State::failed;
    member.sentence = error.what();
  } catch (const hdf5::Error& error) {
    member.state = State::failed;
    member.sentence = fmt::format("{} is damaged ({})", path, error.what());
  }
}

}  // namespace lichtenberg::ensemble
