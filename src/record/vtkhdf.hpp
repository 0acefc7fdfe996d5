#pragma once

#include <array>
#include <string>
#include <vector>

#include "solvers/laplace/problem.hpp"
#include "src/record/hdf5.hpp"
#include "src/scene/scene.hpp"

namespace lichtenberg {

/// Adds the field to an HDF5 file as the group /VTKHDF (VTKHDF 1.0, which ParaView opens), over one that is there: the
/// solver's cells, row by row from the lower left corner on, which carry `potential` (V) and `body` (index, -1 in the
/// fluid), all compressed. They are listed one by one (UnstructuredGrid), for the reader of VTK 9.1 fails on images
/// that are flat or carry data of cells. `cells` and `cell_edge` say what grid it is. `stored`: the potential's
/// precision. Throws hdf5::Error.
void put_vtkhdf(const hdf5::Handle& file, const laplace::Field& field,
                StoredField stored = StoredField::double_precision);

/// Its grid alone, unless it is there: the same in all frames of a run.
void put_vtkhdf_grid(const hdf5::Handle& file, const laplace::Field& field);

/// Numbers at the points of a regular lattice.
struct Lattice {
  std::array<int, 3> points{1, 1, 1};  ///< along x, y and z
  double spacing = 0;
  struct Values {
    std::string name, unit;
    int components = 1;         ///< 3 of a vector
    std::vector<double> value;  ///< [z][y][x][components]
  };
  std::vector<Values> values;
};
/// Writes them as a file of the same kind, flat ones in two layers. Throws Failure if the disk does not take it.
void write_lattice_vtkhdf(const std::string& path, const Lattice& lattice);

/// Writes the field to a file of its own. Throws InputError if the file exists and may not be overwritten or its folder
/// cannot be written, Failure if the disk is full.
void write_field_vtkhdf(const std::string& path, const laplace::Field& field, bool overwrite = false);

}  // namespace lichtenberg
