#pragma once

#include <span>
#include <vector>

#include "src/model/checkpoint.hpp"
#include "src/record/hdf5.hpp"
#include "src/record/provenance.hpp"
#include "src/scene/scene.hpp"

namespace lichtenberg {

// Parts of a result file, each written by one function. All functions throw hdf5::Error.

/// Format number, which changes when readers of the files have to change.
constexpr int result_format = 2;

/// Writes root attributes and /h5md (H5MD 1.1): author and program of the file, and its units.
void put_header(const hdf5::Handle& file, const Scene& scene, const Provenance& provenance);

/// Writes /scene: the text, and the geometry that a picture needs.
void put_scene(const hdf5::Handle& file, const Scene& scene);

/// Returns the box's edges as the nine numbers of three vectors, in the scene's unit of length; empty unless an axis is
/// periodic. The third edge of a plane box is the depth of the medium.
std::vector<double> box_edges(const Scene& scene);

/// Writes the constant parts of /particles/conductors: box, species, radius, mass (kg, one for each conductor).
void put_conductors(const hdf5::Handle& file, const Scene& scene, std::span<const double> mass);

/// Writes /checkpoint. The names of the arrays must not contain slashes.
void put_checkpoint(const hdf5::Handle& file, const Checkpoint& checkpoint);
/// Reads /checkpoint.
Checkpoint get_checkpoint(const hdf5::Handle& file);

}  // namespace lichtenberg
