#pragma once

#include "src/record/atomic_file.hpp"

namespace lichtenberg::hdf5 {

/// Checks that every collection of HDF5's global heap, which stores texts of variable length, has a valid chain of
/// objects. HDF5 1.10 itself loops forever if the length of free space is 0. Throws hdf5::Error otherwise. Source: HDF5
/// File Format Specification 3.0, III.E.
void check_global_heaps(const OpenFile& file);

}  // namespace lichtenberg::hdf5
