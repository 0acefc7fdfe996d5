#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "src/commands/field_problem.hpp"

namespace lichtenberg {

/// Potential and charge of an electrode or of an electrode side.
struct TerminalAnswer {
  std::string name;
  double potential = 0, charge = 0;  ///< V, C
  int group = 0;                     ///< row of the capacitance matrix
};

/// Capacitance matrix: charge on each group when one is at 1 V and all others are at 0 V.
struct Capacitances {
  std::vector<std::string> names;
  std::vector<double> matrix;  ///< F, names x names
};

/// Field of a scene of conductors at its start, in SI units. Charges, forces and energies are those of a slab of the
/// scene's depth.
struct FieldAnswer {
  Scene scene;
  FieldProblem field{};
  laplace::LaplaceSolution solution{};              ///< per metre of depth; in three dimensions without forces
  std::vector<Vec3> force{};                        ///< N
  std::array<double, 6> side_charge{};              ///< C, of electrode sides; in a plane per metre of depth
  std::optional<double> charge_of_joined_sides{};   ///< C, in three dimensions where electrode sides meet
  Capacitances capacitance{};                       ///< empty if not requested
  std::optional<laplace::Field> potential_field{};  ///< empty if not requested, and in three dimensions

  /// Number of conductors. The functions below take an index of a conductor.
  int size() const { return static_cast<int>(scene.conductors.size()); }
  bool in_space() const { return scene.dimension() == 3; }
  double depth() const { return in_space() ? 1 : scene.medium.depth; }
  double potential(int i) const { return solution.group_potential[field.group_of_body[i]]; }
  double charge(int i) const { return depth() * solution.body_charge[i]; }
  double energy() const { return depth() * solution.energy; }
};

/// Optional parts of a FieldAnswer.
struct RequestedParts {
  bool capacitance = false;      ///< one more solve per group
  bool potential_field = false;  ///< plane scenes only
};

/// Solves the field of a scene's initial state. Makes the choices for a requested accuracy and stores them in the
/// answer's scene. Throws InputError if the scene has no field, Failure if the solution holds a non-finite number.
FieldAnswer solve_field(Scene scene, RequestedParts requested);

/// Returns potentials and charges of the terminals in the order of effects::terminals_of: electrodes, then electrode
/// sides. In space, for sides that meet at edges only the sum of the charges is known; it comes last.
std::vector<TerminalAnswer> terminals(const FieldAnswer& answer);

/// Returns reasons why the solution may be unsafe to use (Summary::warnings).
std::vector<std::string> warnings_of(const FieldAnswer& answer);

}  // namespace lichtenberg
