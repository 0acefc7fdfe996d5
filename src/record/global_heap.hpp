#pragma once

#include "src/record/atomic_file.hpp"

namespace lichtenberg::hdf5 {

/// Checks that every collection of HDF5's global heap, which holds texts of variable length, can be walked from object
/// to object: HDF5 1.10 itself goes on forever where the length of free space is 0. Throws hdf5::Error otherwise.
/// Source: HDF5 File Format Specification 3.0, III.E.
void check_global_heaps(const OpenFile& file);

}  // namespace lichtenberg::hdf5
