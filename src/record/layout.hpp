#pragma once

#include <span>
#include <vector>

#include "src/model/checkpoint.hpp"
#include "src/record/hdf5.hpp"
#include "src/record/provenance.hpp"
#include "src/scene/scene.hpp"

namespace lichtenberg {

// The parts of a result file, each written by one function. All throw hdf5::Error.

/// Changes when a reader of the files has to change.
constexpr int result_format = 2;

/// Root attributes, and /h5md (H5MD 1.1): who wrote the file, in which units.
void put_header(const hdf5::Handle& file, const Scene& scene, const Provenance& provenance);

/// /scene: the text, and the geometry that a picture needs.
void put_scene(const hdf5::Handle& file, const Scene& scene);

/// The box's edges as the nine numbers of three vectors, in the scene's unit of length; none unless an axis is
/// periodic. A plane box is as deep as the medium.
std::vector<double> box_edges(const Scene& scene);

/// What does not change of /particles/conductors: box, species, radius, mass (kg, one a conductor).
void put_conductors(const hdf5::Handle& file, const Scene& scene, std::span<const double> mass);

/// /checkpoint. The names of the arrays must not contain slashes.
void put_checkpoint(const hdf5::Handle& file, const Checkpoint& checkpoint);
Checkpoint get_checkpoint(const hdf5::Handle& file);

}  // namespace lichtenberg
