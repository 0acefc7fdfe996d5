#pragma once

#include <fmt/format.h>

#include <memory>
#include <string>

#include "solvers/error.hpp"
#include "solvers/periodic/bounded.hpp"
#include "src/effects/coulomb.hpp"

namespace lichtenberg::effects {

// Functions that choose and make the sum of a scene's charges by [effects.coulomb], in reduced units.

/// Returns the box of a scene with the conditions at its sides. A plane has open sides in space.
periodic::Enclosure enclosure_of(const Domain& domain);

/// Describes for `explain` how the sum treats sides that are not periodic; empty if all are.
std::string sides_in_words(const Scene& scene);

/// Returns the largest cutoff (d0, distance of centres) of a sum over neighbour pairs: half of the shortest side minus
/// the difference of the largest and smallest diameter. Neighbour lists use gaps between surfaces, so that pairs of
/// large grains reach farther than pairs of small ones.
double longest_cutoff(const Scene& scene);

/// Returns the requirements of a scene on the particle mesh of its Coulomb sum: accuracy, number of charges, box and
/// given parameters.
periodic::MeshRequest mesh_request(const Scene& scene);
/// Chooses the particle-mesh parameters for a scene, with an estimate of the force error. The estimate is for the
/// initial positions, or for random positions if cutoff, mesh and order are all given. Throws InputError if the given
/// parameters exclude the accuracy.
periodic::MeshChoice mesh_for(const Scene& scene);
/// Returns a warning if the force error of a particle mesh exceeds effects.coulomb.accuracy, or 0.1 if cutoff, mesh and
/// order are all given; empty otherwise.
std::string accuracy_warning(const Scene& scene, const periodic::MeshChoice& choice);
/// Makes the Coulomb sum that the scene selects. Sets `warning` to accuracy_warning() for a mesh, and leaves it
/// unchanged otherwise. Throws the exceptions of mesh_for().
std::unique_ptr<periodic::Sum> make_sum(const Scene& scene, std::string& warning);

struct DeviceForces;
/// Adds the Coulomb forces of a scene to those of a device (EffectKind::device). Throws InputError for options that a
/// device does not support.
void coulomb_on_device(const Scene& scene, DeviceForces& forces);

/// Returns the result of work(). If work() throws InputError, rethrows it with the path of the scene and the name of
/// the table before its message.
template <class Work>
auto with_table_name(const Scene& scene, const std::string& table, const Work& work) {
  try {
    return work();
  } catch (const InputError& error) {
    throw InputError(fmt::format("{}: the values in [{}] are not valid: {}", scene.path, table, error.what()));
  }
}

}  // namespace lichtenberg::effects
