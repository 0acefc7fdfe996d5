#pragma once

#include <fmt/format.h>

#include <memory>
#include <string>

#include "solvers/error.hpp"
#include "solvers/periodic/accuracy.hpp"
#include "src/effects/coulomb.hpp"

namespace lichtenberg::effects {

// Functions that choose and make the sum of a scene's charges by [effects.coulomb], in reduced units.

/// Returns the largest cutoff (d0) of sums over a list of pairs. Such lists use surface distances with the range that
/// the smallest grains need, and are limited to half of the box.
double longest_cutoff(const Scene& scene);

periodic::MeshRequest mesh_request(const Scene& scene);
periodic::MeshChoice mesh_for(const Scene& scene);
/// Returns a warning if a mesh's force error exceeds effects.coulomb.accuracy, or 0.1 if cutoff, mesh and order are
/// given; empty otherwise.
std::string accuracy_warning(const Scene& scene, const periodic::MeshChoice& choice);
/// Makes the sum of the scene's charges; `warning` gets the warning of a mesh.
std::unique_ptr<periodic::Sum> make_sum(const Scene& scene, std::string& warning);

/// Returns the result of work(), and prefixes the message of an InputError with the scene's path and the table's name.
template <class Work>
auto with_table_name(const Scene& scene, const std::string& table, const Work& work) {
  try {
    return work();
  } catch (const InputError& error) {
    throw InputError(fmt::format("{}: the values in [{}] are not valid: {}", scene.path, table, error.what()));
  }
}

}  // namespace lichtenberg::effects
