#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <optional>

#include "src/commands/commands.hpp"
#include "src/commands/recorded_run.hpp"
#include "src/commands/start_from.hpp"
#include "src/commands/theory_kind.hpp"
#include "src/effects/read_scene.hpp"
#include "src/model/bodies.hpp"
#include "src/record/result.hpp"
#include "src/record/segments.hpp"
#include "tests/gas_text.hpp"
#include "tests/source_folder.hpp"
#include "validation/fuzz/command.hpp"
#include "validation/fuzz/damage.hpp"

namespace lichtenberg::fuzz {
namespace {

namespace fs = std::filesystem;

const std::string result_file = "run.h5";

/// Reads a scene of the folder scenes/ with changed keys.
Scene shipped(const std::string& name, const std::vector<Setting>& settings) {
  return read_scene(source_folder() + "/scenes/" + name + ".toml", settings);
}

/// An intact result, and the scene of its run.
struct Source {
  std::optional<Scene> scene;  ///< empty: it is not resumed
  Input files;
};

std::string bytes_of(const fs::path& path) {
  std::ifstream stream(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

/// Runs a scene. `stays_open`: it stops before its end, with frames in segments.
Source recorded(const Scene& of, bool stays_open = false) {
  Scene scene = prepare_run(of);
  scene.output.file = result_file;
  RecordedRun run(
      scene,
      Recorder::start(result_file, scene, make_bodies(scene).mass, true, stays_open ? 3000 : Recorder::usual_tail),
      [](const std::string&) {});
  run.begin();
  for (int k = 0; !run.finished() && !(stays_open && k == 5); ++k) run.to_next_frame([] { return false; });
  if (stays_open)
    run.stop();
  else
    run.end();
  Source source{scene, {{result_file, bytes_of(result_file)}}};
  if (fs::exists(segments_folder(result_file)))
    for (const fs::directory_entry& segment : fs::directory_iterator(segments_folder(result_file)))
      source.files.push_back({segment.path().string(), bytes_of(segment.path())});
  std::ranges::sort(source.files.begin() + 1, source.files.end(), {}, &File::name);
  for (const fs::directory_entry& left : fs::directory_iterator(".")) fs::remove_all(left.path());
  return source;
}

/// Reads all that a result offers.
std::string read_all() {
  const Result result(result_file);
  result.radius(), result.mass(), result.warnings();
  for (int k = 0; k < std::min(result.frames(), 4); ++k) {
    result.frame(k), result.bodies(k), result.contacts(k), result.observable("energy", k);
    if (result.has_network()) result.successor(k);
    result.conductor_frame(k);
  }
  result.scene();
  return "read";
}

std::string resume(const Scene& scene) {
  RecordedRun run(scene, Recorder::resume(result_file, scene), [](const std::string&) {});
  run.begin();
  int pauses = 0;
  if (!run.finished()) run.to_next_frame([&] { return ++pauses > 5 || out_of_time(); });
  if (pauses <= 5) run.save();
  return "resumed";
}

std::string start(Scene scene) {
  bodies_in(result_file, {});
  start_from(result_file, {}, scene);
  return "started from";
}

/// Calls a command that reads the result and prints. NaN in its output is an error if it prints no
/// warning.
std::string act(const Command& command, const std::vector<std::pair<std::string, std::string>>& arguments) {
  for (const auto& [name, value] : arguments) set(command, name, value);
  command.act();
  const Printed text = printed();
  if (text.err.empty()) check_no_nan(text.out);
  return command.name;
}

std::string read_result(const Source& source, Dice& dice) {
  switch (dice.below(source.scene ? 9 : 5)) {
    case 0:
    case 1:
      return read_all();
    case 2:
      return act(analyse_command(), {{"RESULT", result_file}});
    case 3:
      return act(analyse_command(), {{"RESULT", result_file}, {"--frame", "0"}, {"--json", "true"}});
    case 4:
      return act(frame_fields_command(), {{"RESULT", result_file}, {"--quiet", ""}});
    case 5:
      return act(network_command(), {{"RESULT", result_file}, {"--no-picture", ""}, {"--quiet", ""}});
    case 6:
      return act(theory_command(theory_kinds()), {{"NAME", "haff"}, {"RESULT", result_file}});
    case 7:
      return resume(*source.scene);
    default:
      return start(*source.scene);
  }
}

}  // namespace

Target results() {
  const auto sources = std::make_shared<std::vector<Source>>();
  sources->push_back(recorded(shipped("seedling", {{"population[0].count", "4"},
                                                   {"field.cells", "16"},
                                                   {"output.every", "0.01"},
                                                   {"output.checkpoint_every", "2"},
                                                   {"stop.time", "0.03"}})));
  sources->push_back(recorded(shipped("packing", {{"population[0].count", "10"}, {"domain.size", "[3e-3, 3e-3]"}})));
  sources->push_back(recorded(parse_scene(gas_text(6, 6, 0.02, 0.01), "run.toml")));
  sources->push_back(recorded(parse_scene(gas_text(6, 6, 0.1, 0.01), "run.toml"), true));
  sources->push_back({{}, {{result_file, bytes_of(source_folder() + "/tests/format-1.h5")}}});
  // The source of a case, which `draw` chooses and `attempt` uses.
  const auto chosen = std::make_shared<std::size_t>(0);
  return {.draw =
              [sources, chosen](Dice& dice) {
                *chosen = dice.below(sources->size());
                Input input = (*sources)[*chosen].files;
                File& target = input[dice.chance(0.5) ? 0 : dice.below(input.size())];
                target.bytes = damaged(target.bytes, dice);
                return input;
              },
          .attempt = [sources, chosen](const Input&, Dice& dice) { return read_result((*sources)[*chosen], dice); },
          .hdf5_may_crash = true};
}

}  // namespace lichtenberg::fuzz
