#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "src/analysis/network.hpp"
#include "src/model/checkpoint.hpp"
#include "src/model/frame.hpp"
#include "src/record/hdf5.hpp"
#include "src/record/provenance.hpp"
#include "src/scene/scene.hpp"

namespace lichtenberg {

// The parts of a result file, each written by one function. All throw hdf5::Error.

/// Changes when a reader of the files has to change.
constexpr int result_format = 1;

/// Root attributes, and /h5md (H5MD 1.1): who wrote the file.
void put_header(const hdf5::Handle& file, const Provenance& provenance);

/// /scene: the text, and the geometry that a picture needs.
void put_scene(const hdf5::Handle& file, const Scene& scene);

/// What does not change of /particles/conductors: box, species, radius, mass (kg, one a conductor).
void put_conductors(const hdf5::Handle& file, const Scene& scene, std::span<const double> mass);

/// Appends a frame: to /particles/conductors, /observables and, lists, /network.
void append_frame(const hdf5::Handle& file, const Frame& frame);

/// Of every frame, where its contacts end among those of all frames; empty in a file that holds the last frame's only.
std::vector<std::int64_t> contact_ends(const hdf5::Handle& file);
/// Those from `first` on, up to before `end`.
std::vector<analysis::Contact> contacts_between(const hdf5::Handle& file, std::int64_t first, std::int64_t end);

/// Appends rows to a group.
void append_history(const hdf5::Handle& file, const ColumnGroup& history);

/// Writes columns as a group, over those of an earlier time.
void put_group(const hdf5::Handle& file, const ColumnGroup& columns);

/// /checkpoint. The names of the arrays must not contain slashes.
void put_checkpoint(const hdf5::Handle& file, const Checkpoint& checkpoint);
Checkpoint get_checkpoint(const hdf5::Handle& file);

/// s, at least one.
std::vector<double> frame_times(const hdf5::Handle& file);

}  // namespace lichtenberg
