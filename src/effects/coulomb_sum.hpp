#pragma once

#include <fmt/format.h>

#include <memory>
#include <string>

#include "solvers/error.hpp"
#include "solvers/periodic/accuracy.hpp"
#include "src/effects/coulomb.hpp"

namespace lichtenberg::effects {

// The sum of a scene's charges by [effects.coulomb]. Reduced units.

/// Of sums that are given pairs: lists of these go by surfaces, up to what the smallest grains need, and find nothing
/// beyond half of the box.
double longest_cutoff(const Scene& scene);

periodic::MeshRequest mesh_request(const Scene& scene);
periodic::MeshChoice mesh_for(const Scene& scene);
/// Warning about a mesh whose force error exceeds the accuracy asked for; empty if it does not.
std::string doubt_about(const Scene& scene, const periodic::MeshChoice& choice);
/// `doubt` is filled in for a mesh.
std::unique_ptr<periodic::Sum> make_sum(const Scene& scene, std::string& doubt);

/// Result of work(). An InputError gets the scene's path and the table's name in front.
template <class Work>
auto naming_the_table(const Scene& scene, const std::string& table, const Work& work) {
  try {
    return work();
  } catch (const InputError& error) {
    throw InputError(fmt::format("{}: {}: {}", scene.path, table, error.what()));
  }
}

}  // namespace lichtenberg::effects
