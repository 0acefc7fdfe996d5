#pragma once

#include <memory>
#include <vector>

#include "solvers/laplace/spheres/spheres.hpp"
#include "src/commands/work_precision.hpp"

namespace lichtenberg::work_precision {

/// What is compared of a field of spheres.
struct SphereAnswer {
  std::vector<double> potential;  ///< V, of each group
  std::vector<double> charge;     ///< C, of each sphere
  std::vector<Vec3> force;        ///< N, of each sphere
};

struct SphereSubject {
  laplace::SphereProblem problem;
  SphereAnswer reference;

  /// Whether charges are found and not all given.
  bool has_unknown_charges() const;
  /// Largest error of potentials, forces and, if they are not all given, charges, each over the largest of its kind in
  /// the reference.
  std::vector<double> errors(const SphereAnswer& answer) const;
};

/// Finite elements by FreeFEM (P2) on a mesh by Gmsh, edges at the spheres `size` of the smallest radius long. The
/// seconds are the processor's for all fields, without meshing. Throws InputError where they are not installed, or the
/// scene has what the meshes have not: periodic sides, free space, dielectrics, no ground, spheres that touch or very
/// many.
std::unique_ptr<Trial> make_freefem_trial(const SphereSubject& subject, double size);

}  // namespace lichtenberg::work_precision
