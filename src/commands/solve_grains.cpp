#include "src/commands/solve_grains.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "solvers/error.hpp"
#include "solvers/neighbours/pairs.hpp"
#include "solvers/stopwatch.hpp"
#include "src/commands/output.hpp"
#include "src/effects/coulomb.hpp"
#include "src/effects/induced_dipoles.hpp"
#include "src/effects/multipole_truncation.hpp"
#include "src/model/frame.hpp"

namespace lichtenberg {
namespace {

void describe_method(const Scene& scene, GrainAnswer& answer) {
  const auto& options = *scene.effects.find<effects::CoulombOptions>();
  const auto* dipoles = scene.effects.find<effects::InducedDipolesOptions>();
  if (dipoles && dipoles->degree > 1) {
    const auto truncation = effects::multipole_truncation(scene);
    answer.method = fmt::format("multipoles to degree {}, tolerance {:g}", dipoles->degree, dipoles->tolerance);
    if (truncation && truncation->at_start)
      answer.method += fmt::format("; the degree leaves forces off by {:.1e} of the largest", *truncation->at_start);
    return;
  }
  answer.method = name_of(options.sum);
  if (options.sum == effects::CoulombSum::mesh || options.sum == effects::CoulombSum::ewald)
    answer.accuracy = options.accuracy;
}

}  // namespace

GrainAnswer solve_grain_field(const Scene& scene) {
  if (!scene.effects.has("coulomb"))
    throw InputError(
        fmt::format("{} has no table [effects.coulomb], so its grains have no field to solve", scene.path));
  if (scene.conductors.empty()) throw InputError(fmt::format("{} has no grains to solve the field of", scene.path));
  GrainAnswer answer{.bodies = make_bodies(scene)};
  answer.bodies.charge = initial_charges(scene);
  describe_method(scene, answer);
  {
    const Stopwatch watch(answer.seconds);
    const effects::Coulomb coulomb(scene);
    std::vector<Pair> pairs;
    if (const auto range = coulomb.needs().neighbour_range)
      pairs = pairs_closer_than(spheres<3>(answer.bodies), *range);
    const State state{.bodies = answer.bodies, .neighbours = pairs};
    answer.energy = coulomb.stored_energy(state);
    Frame frame;
    coulomb.add_columns(state, frame);
    answer.potential = frame.reals("coulomb_potential");
    answer.force = frame.vectors("coulomb_force");
    if (scene.effects.has("induced_dipoles")) answer.dipole = frame.vectors("dipole");
    answer.warnings = coulomb.warnings();
  }
  return answer;
}

nlohmann::ordered_json summary_json(const GrainAnswer& answer) {
  nlohmann::ordered_json json;
  json["energy"] = answer.energy;
  json["units"] = {{"position", "d0"},      {"radius", "d0"},    {"charge", "q0"},     {"potential", "q0/d0"},
                   {"force", "m0 v0^2/d0"}, {"dipole", "q0 d0"}, {"energy", "m0 v0^2"}};
  json["method"] = answer.method;
  if (answer.accuracy) json["accuracy"] = {{"asked", *answer.accuracy}};
  json["warnings"] = answer.warnings;
  json["seconds"] = {{"solve", answer.seconds}};
  return json;
}

namespace {

nlohmann::ordered_json json_of(const GrainAnswer& answer) {
  nlohmann::ordered_json json;
  json["conductors"] = nlohmann::ordered_json::array();
  for (int i = 0; i < answer.bodies.size(); ++i) {
    nlohmann::ordered_json grain = {{"position", components(position_in_space(answer.bodies, i))},
                                    {"radius", answer.bodies.radius[i]},
                                    {"charge", answer.bodies.charge[i]},
                                    {"potential", answer.potential[i]},
                                    {"force", components(answer.force[i])}};
    if (!answer.dipole.empty()) grain["dipole"] = components(answer.dipole[i]);
    json["conductors"].push_back(std::move(grain));
  }
  json.update(summary_json(answer));
  return json;
}

void print_table(const GrainAnswer& answer) {
  const bool dipoles = !answer.dipole.empty();
  fmt::print("{:>9} {:>11} {:>11} {:>11} {:>11} {:>13} {:>17} {:>13} {:>13} {:>13}{}\n", "grain", "x (d0)", "y (d0)",
             "z (d0)", "radius (d0)", "charge (q0)", "potential (q0/d0)", "force x", "force y", "force z",
             dipoles ? fmt::format(" {:>13} {:>13} {:>13}", "dipole x", "dipole y", "dipole z") : "");
  for (int i = 0; i < answer.bodies.size(); ++i)
    fmt::print("{:>9}{} {:>11.4g} {:>13.6g} {:>17.7g}{}{}\n", i,
               columns_of(components(position_in_space(answer.bodies, i)), " {:>11.6g}"), answer.bodies.radius[i],
               answer.bodies.charge[i], answer.potential[i], columns_of(components(answer.force[i]), " {:>13.6g}"),
               dipoles ? columns_of(components(answer.dipole[i]), " {:>13.6g}") : "");
  fmt::print("\nenergy      {:.7g} m0 v0^2\n", answer.energy);
  fmt::print("units       forces in m0 v0^2/d0{}\n", dipoles ? ", dipoles in q0 d0" : "");
  fmt::print("method      {}{}\n", answer.method,
             answer.accuracy ? fmt::format(", accuracy {:g}", *answer.accuracy) : "");
  fmt::print("seconds     {:.4f}\n", answer.seconds);
}

}  // namespace

void solve_grains(const Scene& scene, const JsonTarget& json) {
  const GrainAnswer answer = solve_grain_field(scene);
  if (!json.printed()) print_table(answer);
  json.put(json_of(answer), 2);
  print_warnings(answer.warnings);
}

}  // namespace lichtenberg
