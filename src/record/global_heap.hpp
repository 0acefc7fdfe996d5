#pragma once

#include "src/record/atomic_file.hpp"

namespace lichtenberg::hdf5 {

/// Checks the collections of HDF5's global heap in a file, which store texts of variable length. Throws hdf5::Error
/// unless each has a valid chain of objects: HDF5 1.10 loops forever if the length of free space is 0. Source: HDF5
/// File Format Specification 3.0, III.E.
void check_global_heaps(const OpenFile& file);

}  // namespace lichtenberg::hdf5
