#pragma once

#include <array>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "src/commands/field_problem.hpp"

namespace lichtenberg {

/// Solved potential and charge of one electrode or electrode side of the domain.
struct TerminalAnswer {
  std::string name;
  double potential = 0, charge = 0;  ///< V, C
  int group = 0;                     ///< row in the capacitance matrix
};

/// Force on an electrode of shape polygon, ellipse or curve, and torque about the centroid of its area.
struct CurveForce {
  std::string name;
  Vec2 force;         ///< N
  double torque = 0;  ///< N m, anticlockwise
  Vec2 centroid;      ///< m
};

/// Capacitance matrix of equipotential groups (conductors and electrodes of one potential) and electrode sides; sides
/// that meet count as one. Element (i, j) is the charge on i if j is at 1 V and all others are at 0 V.
struct Capacitances {
  std::vector<std::string> names;
  std::vector<double> matrix;  ///< F, names x names
};

/// Solved field of a scene of conductors at its start, in SI units. In two dimensions, `force` and the results of the
/// functions are those of a slab of the scene's depth.
struct FieldAnswer {
  Scene scene;
  FieldProblem field{};
  laplace::LaplaceSolution solution{};              ///< per metre of depth; in three dimensions without forces
  std::vector<Vec3> force{};                        ///< N
  std::array<double, 6> side_charge{};              ///< C, of electrode sides; in a plane per metre of depth
  std::optional<double> charge_of_joined_sides{};   ///< C, in three dimensions where electrode sides meet
  Capacitances capacitance{};                       ///< empty if not requested
  std::optional<laplace::Field> potential_field{};  ///< empty if not requested, and in three dimensions

  /// Returns the number of conductors.
  int size() const { return static_cast<int>(scene.conductors.size()); }
  /// Returns true in three dimensions.
  bool in_space() const { return scene.dimension() == 3; }
  /// Returns the factor (m) from values per metre of depth to SI values; 1 in three dimensions.
  double depth() const { return in_space() ? 1 : scene.medium.depth; }
  /// Returns the potential (V) of conductor i.
  double potential(int i) const { return solution.group_potential[field.group_of_body[i]]; }
  /// Returns the charge (C) of conductor i.
  double charge(int i) const { return depth() * solution.body_charge[i]; }
  /// Returns the energy (J) of the field.
  double energy() const { return depth() * solution.energy; }
};

/// Optional parts of a FieldAnswer that solve_field() computes on request.
struct RequestedParts {
  bool capacitance = false;      ///< one more solve per row of the matrix
  bool potential_field = false;  ///< plane scenes only
};

/// Solves the field of a scene at its start. For a requested accuracy it chooses the field options and stores them in
/// the answer's scene. Throws InputError if the scene has no field, Failure if the solution has a non-finite number,
/// and the exceptions of the solver.
FieldAnswer solve_field(Scene scene, RequestedParts requested);

/// Returns the potentials and charges of the terminals: electrodes, then electrode sides (order of
/// effects::terminals_of). In three dimensions, electrode sides that meet at edges have the charge NaN; their total
/// charge comes last.
std::vector<TerminalAnswer> terminals(const FieldAnswer& answer);

/// Returns the forces on electrodes of shape polygon, ellipse or curve whose surface the grid resolves as smooth. At
/// sharp corners the field is singular and forces are wrong by several percent, so that these electrodes are left out.
std::vector<CurveForce> curve_forces(const FieldAnswer& answer);

/// Returns reasons why the solution may be unreliable (Summary::warnings).
std::vector<std::string> warnings_of(const FieldAnswer& answer);

/// Returns the entries of `lichtenberg solve --json` except those of single conductors.
nlohmann::ordered_json summary_json(const FieldAnswer& answer);

}  // namespace lichtenberg
