#pragma once

#include <string>
#include <vector>

#include "src/effects/floating_conductors.hpp"

namespace lichtenberg {

/// The field problem of a scene's first instant, and what its groups are called.
struct FieldProblem {
  effects::ElectricalGroups groups;
  laplace::LaplaceProblem problem;       ///< of a plane scene
  laplace::SphereProblem spheres;        ///< of one in three dimensions
  std::vector<int> group_of_body;        ///< the conductors, then the electrodes
  std::vector<std::string> group_names;  ///< by the problem's group
};

/// Contacts that exist at the start are made. A group is named after the scene's [[group]] if it holds one, otherwise
/// after its conductors, and after the electrodes that have its potential. Throws InputError if the scene has no field.
FieldProblem make_field_problem(const Scene& scene);

/// As `explain` and `solve` name it.
std::string method_in_words(const FieldOptions& field);
/// What was chosen for an accuracy, in a line.
std::string choice_in_words(const FieldOptions& field);

}  // namespace lichtenberg
