#pragma once

#include <string>
#include <vector>

#include "src/effects/floating_conductors.hpp"

namespace lichtenberg {

/// Field problem of a scene at its start, with the names of its equipotential groups (conductors and electrodes of one
/// potential).
struct FieldProblem {
  effects::ElectricalGroups groups;
  laplace::LaplaceProblem problem;       ///< plane scene
  laplace::SphereProblem spheres;        ///< scene in three dimensions
  std::vector<int> group_of_body;        ///< first the conductors, then the electrodes
  std::vector<std::string> group_names;  ///< by group of the problem
};

/// Throws InputError for a side in a circuit: only a run computes its potential.
void check_side_potentials(const Scene& scene);

/// Makes the field problem of a scene at its start, with the electrical contacts of the initial positions closed. A
/// group is named after the scene's [[group]] in it, otherwise after its conductors, and also after its electrodes.
/// A side in a circuit has a potential of 0. Throws InputError if the scene has no field.
FieldProblem make_field_problem(const Scene& scene);

/// Describes the field method with its options, for `explain` and `solve`.
std::string method_in_words(const FieldOptions& field);
/// Describes in one line the method, cells and tolerance that were chosen for field.accuracy.
std::string choice_in_words(const FieldOptions& field);

}  // namespace lichtenberg
