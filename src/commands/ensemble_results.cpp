#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>

#include "solvers/error.hpp"
#include "src/analysis/network.hpp"
#include "src/analysis/strahler.hpp"
#include "src/commands/ensemble.hpp"
#include "src/commands/reading.hpp"
#include "src/effects/read_scene.hpp"
#include "src/record/hdf5.hpp"
#include "src/record/result.hpp"
#include "src/record/result_file.hpp"
#include "src/record/scene_change.hpp"
#include "src/scene/effect_kind.hpp"
#include "src/scene/scene.hpp"

namespace lichtenberg::ensemble {
namespace {

bool same_end(const Scene& a, const Scene& b) {
  return a.stop.time == b.stop.time && a.stop.stationary == b.stop.stationary && a.stop.force == b.stop.force &&
         a.minimize.force_tolerance == b.minimize.force_tolerance &&
         a.minimize.max_iterations == b.minimize.max_iterations;
}

constexpr const char* times = "particles/conductors/position/time";

/// Returns the last number of a dataset. Throws hdf5::Error if it is empty, which happens in damaged files only.
double last_number(hid_t parent, const std::string& name) {
  const std::vector<double> numbers = hdf5::get<double>(parent, name);
  if (numbers.empty()) throw hdf5::Error(name + " is empty");
  return numbers.back();
}

/// Returns the wall time (s) of all sessions of the run.
double wall_seconds(const hdf5::Handle& file) {
  double all = 0;
  for (int session = 0;; ++session) {
    const std::string path = fmt::format("provenance/session-{}/seconds", session);
    if (!hdf5::exists(file, path)) return all;
    const hdf5::Handle seconds = hdf5::open_group(file, path);
    for (const std::string& activity : hdf5::names(seconds)) all += last_number(seconds, activity);
  }
}

using Quantities = std::map<std::string, double>;
using Json = nlohmann::ordered_json;

void add_fractions(Quantities& quantities, const std::string& suffix, const analysis::DegreeDistribution& degrees) {
  quantities["endpoint_fraction" + suffix] = degrees.fraction(1);
  quantities["branch_fraction" + suffix] = degrees.branching();
}

/// Adds f1 and B for other readings of D's definition. The readings use degrees in the tree A instead of the graph G,
/// degrees without the ground, or degrees by the contacts of D 7.1. The latter have no hysteresis. Their reading uses
/// the same tree. Otherwise no root would remain if hysteresis alone keeps the only contact with the ground.
void add_other_readings(Quantities& quantities, const analysis::ContactNetwork& network, const Scene& scene,
                        const std::vector<Vec2>& position, const std::vector<double>& radius) {
  std::vector<analysis::Edge> tree;
  for (int i = 0; i < static_cast<int>(position.size()); ++i) {
    const int next = network.successor[i];
    if (next == analysis::to_ground) tree.emplace_back(i, next);
    if (next >= 0) tree.emplace_back(std::minmax(i, next));
  }
  add_fractions(quantities, "_in_tree", analysis::network(std::move(tree), position).degrees);
  analysis::ContactGraph graph = analysis::contact_graph(static_cast<int>(position.size()), network.contacts);
  graph.grounded.assign(position.size(), false);
  add_fractions(quantities, "_without_ground", analysis::degree_distribution(graph, network.successor));
  const auto near = analysis::contacts(position, radius, number_in(scene, &EffectKind::contact_gap).value_or(0),
                                       analysis::ground_of(scene));
  graph = analysis::contact_graph(static_cast<int>(position.size()), near);
  add_fractions(quantities, "_without_hysteresis", analysis::degree_distribution(graph, network.successor));
}

/// Adds the topology of the last frame.
void add_topology(Quantities& quantities, const Result& result) {
  const int last = result.frames() - 1;
  if (!result.has_network()) return;
  const auto contacts = result.contacts(last);
  if (!contacts) return;  // file of an earlier format
  const Scene scene = result.scene();
  const std::vector<Vec2> position = result.frame(last).plane_vectors("position");
  const analysis::ContactNetwork network = analysis::network(*contacts, position);
  for (const int degree : {2, 3, 4})
    quantities[fmt::format("degree_fraction_{}", degree)] = network.degrees.fraction(degree);
  const analysis::StrahlerDistribution orders =
      analysis::strahler_distribution(network.successor, analysis::strahler_numbers(network.successor));
  for (const int order : {1, 2, 3}) {
    const double count = order <= orders.highest() ? orders.conductors[order] : 0;
    quantities[fmt::format("strahler_{}", order)] = count;
    quantities[fmt::format("strahler_fraction_{}", order)] = count / std::max(network.degrees.connected, 1);
  }
  add_other_readings(quantities, network, scene, position, result.radius());
}

Quantities quantities_of(const ResultFile& from) {
  const hdf5::Handle& file = from.file();
  Quantities result;
  const hdf5::Handle summary = hdf5::open_group(file, "summary");
  for (const std::string& name : hdf5::names(summary)) result[name] = last_number(summary, name);
  result["conductors"] = static_cast<double>(hdf5::get<double>(file, "particles/conductors/radius").size());
  for (const std::string name : {"connected", "endpoints", "branch_points", "field_solves", "iterations"})
    if (const std::string path = "observables/" + name + "/value"; from.has(path))
      result[name] = hdf5::single(from.rows<double>(path, from.frames() - 1, 1), path);
  result["seconds"] = wall_seconds(file);
  return result;
}

/// Throws InputError if the run is past the present [stop]. It would end at once, with another summary or none.
void refuse_past(const std::string& path, const ResultFile& file, const Scene& now, bool just_ended) {
  // The "time" of a packing counts its iterations.
  const bool later = !now.effects.has(&EffectKind::packing) &&
                     hdf5::single(file.rows<double>(times, file.frames() - 1, 1), times) > now.stop.time;
  if (just_ended || later)
    throw InputError(
        fmt::format("the result file {} is already past the end that [stop] now sets: move it away, or name another "
                    "folder with --out",
                    path));
}

/// Returns the state of a result file. Throws InputError or hdf5::Error.
Json inspect_file(const std::string& path, const Member& member, bool just_ended) {
  const ResultFile file(path, "gone on with");
  const std::string text = hdf5::get_text(file.file(), "scene/text");
  const std::string change = first_change(text, member.text, path + ":/scene/text");
  if (!change.empty())
    throw InputError(
        fmt::format("key `{}` has changed since the result file {} was started: move that file away, or name another "
                    "folder with --out",
                    change, path));
  const Scene now = parse_scene(member.text, path);
  const bool over = hdf5::exists(file.file(), "summary") && (just_ended || same_end(parse_scene(text, path), now));
  if (!over) {
    refuse_past(path, file, now, just_ended);
    return {{"state", "waiting"}};
  }
  Quantities quantities = quantities_of(file);
  add_topology(quantities, Result(path));
  return {{"state", "finished"}, {"quantities", quantities}, {"warnings", file.warnings()}};
}

}  // namespace

Json inspect(const std::string& path, const Member& member, bool just_ended) {
  const auto failed = [](const std::string& sentence) { return Json{{"state", "failed"}, {"sentence", sentence}}; };
  try {
    try_reading(path, [&] { inspect_file(path, member, just_ended); });
    return inspect_file(path, member, just_ended);
  } catch (const InputError& error) {
    return failed(error.what());
  } catch (const hdf5::Error& error) {
    return failed(fmt::format("{} is damaged ({})", path, error.what()));
  }
}

}  // namespace lichtenberg::ensemble
