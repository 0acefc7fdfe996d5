#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "src/commands/json_output.hpp"
#include "src/model/bodies.hpp"
#include "src/scene/scene.hpp"

namespace lichtenberg {

/// Solved forces, potentials and dipoles of the charged grains of a scene at its start, in reduced units.
struct GrainAnswer {
  Bodies bodies;
  std::vector<double> potential;  ///< q0/d0, at a grain's centre, due to all other charges and dipoles
  std::vector<Vec3> force;        ///< m0 v0^2/d0
  std::vector<Vec3> dipole;       ///< q0 d0; empty without [effects.induced_dipoles]
  double energy = 0;              ///< m0 v0^2
  std::string method;
  std::optional<double> accuracy;  ///< requested accuracy, for sums that have one
  std::vector<std::string> warnings;
  double seconds = 0;
};

/// Computes the forces, potentials and energy of the charges of a scene's grains at the start, induced dipoles
/// included. Throws InputError for a scene without [effects.coulomb] or without grains.
GrainAnswer solve_grain_field(const Scene& scene);

/// Returns the entries of `lichtenberg solve --json` except those of single grains.
nlohmann::ordered_json summary_json(const GrainAnswer& answer);

/// Calls solve_grain_field(), and prints the result as a table or writes it as JSON to its target. Throws the
/// exceptions of solve_grain_field() and JsonTarget::put().
void solve_grains(const Scene& scene, const JsonTarget& json);

}  // namespace lichtenberg
