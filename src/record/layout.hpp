#pragma once

#include <span>
#include <vector>

#include "src/model/checkpoint.hpp"
#include "src/record/hdf5.hpp"
#include "src/record/provenance.hpp"
#include "src/scene/scene.hpp"

namespace lichtenberg {

// Parts of a result file, each written by one function. All functions throw hdf5::Error.

/// Format number of result files. It changes when readers of the files have to change.
constexpr int result_format = 2;

/// Writes the format number (an attribute of the root) and the group /h5md (H5MD 1.1) of a result file: author, program
/// and system of units.
void put_header(const hdf5::Handle& file, const Scene& scene, const Provenance& provenance);

/// Writes the group /scene: the text of the scene, and the geometry and constants that a picture needs. For grains it
/// also writes /reference, the units in SI.
void put_scene(const hdf5::Handle& file, const Scene& scene);

/// Returns the names of the scene's effects that are not built in, which other programs add; empty if there are none.
std::string added_effects(const Scene& scene);

/// Returns the edges of the periodic box as three vectors (nine numbers), in the scene's unit of length. Empty unless
/// an axis is periodic. The third edge of a plane box is the depth of the medium.
std::vector<double> box_edges(const Scene& scene);

/// Writes the parts of /particles/conductors that do not change: dimension and boundaries of the box, species, radius
/// and mass. It also writes the radii of the species for VMD (/parameters/vmd_structure). `mass`: one for each
/// particle, in the scene's unit of mass (kg, or m0 of a scene of grains).
void put_conductors(const hdf5::Handle& file, const Scene& scene, std::span<const double> mass);

/// Writes the arrays of a checkpoint to the group /checkpoint. Their names must not contain slashes.
void put_checkpoint(const hdf5::Handle& file, const Checkpoint& checkpoint);
/// Reads the checkpoint from the group /checkpoint.
Checkpoint get_checkpoint(const hdf5::Handle& file);

}  // namespace lichtenberg
