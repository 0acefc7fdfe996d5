#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <optional>
#include <variant>

#include "src/commands/commands.hpp"
#include "src/commands/recorded_run.hpp"
#include "src/effects/effects.hpp"
#include "src/effects/gas_drag.hpp"
#include "src/effects/read_scene.hpp"
#include "src/model/bodies.hpp"
#include "src/record/result.hpp"
#include "src/scene/stopping.hpp"
#include "tests/source_folder.hpp"
#include "validation/fuzz/command.hpp"
#include "validation/fuzz/grammar.hpp"

namespace lichtenberg::fuzz {
namespace {

const std::string scene_file = "scene.toml";

// Work beyond these bounds is not begun: a case takes milliseconds.
constexpr std::size_t most_bodies = 24;
constexpr int most_cells = 64, most_placements = 3000;
constexpr double most_redraws = 1e4;  ///< of the velocity of a gas

struct Work {
  int frames, pauses;
};
constexpr Work work_of_scene{3, 12}, work_of_gas{100, 400};
constexpr std::size_t most_grains = 80;

Document with_changes(const Grammar& grammar, Dice& dice) {
  Document document = dice.of(grammar.scenes);
  for (int k = dice.chance(0.3) ? 2 : 1; k > 0; --k) change(document, grammar, dice);
  return document;
}

bool is_small(const Scene& scene, std::size_t most = most_bodies) {
  if (scene.conductors.size() > most) return false;
  const auto* drag = scene.effects.find<effects::GasDragOptions>();
  if (drag && scene.stop.time / drag->correlation_time > most_redraws) return false;
  if (!scene.effects.has(&EffectKind::field)) return true;
  const FieldOptions* field = std::get_if<FieldOptions>(&scene.field_table);
  return field ? field->cells <= most_cells : scene.field_request()->accuracy >= 0.05;
}

/// Throws Fault for a NaN among the numbers of a frame, or a number that is not finite among those of its particles. A
/// recorded run refuses some columns with such numbers, and the excess over jamming is not known before it. The
/// resistance of a structure needs two sources.
void check_numbers(const Frame& frame) {
  for (const Column& column : frame.columns) {
    const auto* values = std::get_if<std::vector<double>>(&column.values);
    if (!values) continue;
    const bool exempt = column.name == "position" || column.name == "velocity" || column.name == "charge" ||
                        column.name == "force" || column.name == "excess_fraction" ||
                        column.name == "structure_resistance";
    for (const double value : *values)
      if (!exempt && (std::isnan(value) || (column.of == Column::Of::particles && !std::isfinite(value))))
        throw Fault{fmt::format("silent {} in the column {} at {:g}", value, column.name, frame.time)};
  }
}

/// Runs a scene from its start for some steps.
std::string begin_run(const Scene& scene, bool records, const Work& most) {
  bool warned = false;
  std::optional<Recorder> recorder;
  Scene prepared = prepare_run(scene);
  if (records) recorder = Recorder::start("run.h5", prepared, make_bodies(prepared).mass, true);
  RecordedRun run(std::move(prepared), std::move(recorder), [&](const std::string&) { warned = true; });
  run.begin();
  int pauses = 0;
  for (int k = 0; k < most.frames && !run.finished() && pauses <= most.pauses; ++k)
    run.to_next_frame([&] { return ++pauses > most.pauses || out_of_time(); });
  if (!warned && run.motion().warnings().empty()) check_numbers(run.motion().frame());
  if (!run.finished()) return "run begun";
  run.end();
  return "run";
}

/// Solves, or explains, as the command does.
std::string command(const Command& command, Dice& dice, bool may_solve) {
  set(command, "SCENE", scene_file);
  if (dice.chance(0.3)) set(command, "--json", "true");
  if (may_solve && dice.chance(0.2)) set(command, "--capacitance", "");
  command.act();
  const Printed text = printed();
  if (text.err.empty()) check_no_nan(text.out);
  return command.name;
}

Scene parsed(const Input& input, const std::vector<Setting>& settings) {
  int placements = 0;
  return parse_scene(input.front().bytes, scene_file, effects::all_kinds(), settings,
                     [&] { return ++placements > most_placements || out_of_time(); });
}

std::string try_scene(const Grammar& grammar, const Input& input, Dice& dice) {
  std::vector<Setting> settings;
  if (dice.chance(0.05)) {
    auto table = grammar.known.begin();
    std::advance(table, static_cast<std::ptrdiff_t>(dice.below(grammar.known.size())));
    const std::string name = table->first.substr(table->first.find_first_not_of('['));
    if (!table->second.empty())
      settings.push_back({name.substr(0, name.find(']')) + "." + dice.of(table->second), drawn_value("1.0", dice)});
  }
  const Scene scene = parsed(input, settings);
  if (!is_small(scene) || !settings.empty()) return "parsed";
  const std::size_t kind = dice.below(10);
  if (kind < 4) return command(explain_command(), dice, false);
  if (kind < 6) return command(solve_command(), dice, scene.effects.has(&EffectKind::field));
  return begin_run(scene, kind == 9 && dice.chance(0.3), work_of_scene);
}

std::string try_gas(const Input& input, Dice& dice) {
  const Scene scene = parsed(input, {});
  if (!is_small(scene, most_grains)) return "parsed";
  return dice.chance(1.0 / 3) ? command(explain_command(), dice, false) : begin_run(scene, true, work_of_gas);
}

Grammar grammar_of_shipped_scenes() {
  Grammar grammar{{}, known_keys()};
  std::vector<std::filesystem::path> paths;
  for (const auto& entry : std::filesystem::directory_iterator(source_folder() + "/scenes"))
    if (entry.path().extension() == ".toml") paths.push_back(entry.path());
  std::ranges::sort(paths);
  for (const std::filesystem::path& path : paths) {
    std::ifstream text(path);
    grammar.scenes.push_back(small_scene({std::istreambuf_iterator<char>(text), {}}));
  }
  return grammar;
}

}  // namespace

Target scenes() {
  const auto grammar = std::make_shared<const Grammar>(grammar_of_shipped_scenes());
  return {.draw =
              [grammar](Dice& dice) {
                std::string text = text_of(with_changes(*grammar, dice));
                if (dice.chance(0.08)) text = with_changed_characters(std::move(text), dice);
                return Input{{scene_file, text}};
              },
          .attempt = [grammar](const Input& input, Dice& dice) { return try_scene(*grammar, input, dice); }};
}

Target gases() {
  return {.draw = [](Dice& dice) { return Input{{scene_file, random_gas(dice)}}; }, .attempt = try_gas};
}

}  // namespace lichtenberg::fuzz
