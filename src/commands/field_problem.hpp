#pragma once

#include <string>
#include <vector>

#include "src/effects/floating_conductors.hpp"

namespace lichtenberg {

/// Field problem of a scene at its start, with the names of its groups.
struct FieldProblem {
  effects::ElectricalGroups groups;
  laplace::LaplaceProblem problem;       ///< plane scene
  laplace::SphereProblem spheres;        ///< scene in three dimensions
  std::vector<int> group_of_body;        ///< first the conductors, then the electrodes
  std::vector<std::string> group_names;  ///< by group of the problem
};

/// Closes the contacts that exist at the start. A group has the name of the scene's [[group]] if it contains one,
/// otherwise of its conductors, and of electrodes at its potential. Throws InputError if the scene has no field.
FieldProblem make_field_problem(const Scene& scene);

/// Returns the description of the method for `explain` and `solve`.
std::string method_in_words(const FieldOptions& field);
/// Returns the choice for an accuracy in one line.
std::string choice_in_words(const FieldOptions& field);

}  // namespace lichtenberg
