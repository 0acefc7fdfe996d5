#pragma once

#include <array>
#include <string>
#include <vector>

#include "solvers/laplace/problem.hpp"
#include "src/record/hdf5.hpp"
#include "src/scene/scene.hpp"

namespace lichtenberg {

/// Writes the potential of a two-dimensional field to an HDF5 file as the group /VTKHDF (VTKHDF 1.0, which ParaView
/// opens). An existing potential is replaced. The cells of the solver are in rows from the lower left corner, with
/// `potential` (V) and `body` (index, -1 in the fluid), both compressed. Cells are listed explicitly
/// (UnstructuredGrid), because the reader of VTK 9.1 fails for flat images and for images with cell data. The datasets
/// `cells` and `cell_edge` describe the grid. `stored`: precision of the potential (none counts as double precision).
/// Throws hdf5::Error.
void put_vtkhdf(const hdf5::Handle& file, const laplace::Field& field,
                StoredField stored = StoredField::double_precision);

/// Writes the grid of the field to the group /VTKHDF, unless the group has a grid with the same numbers of cells. A
/// group with another grid is replaced.
void put_vtkhdf_grid(const hdf5::Handle& file, const laplace::Field& field);

/// Values at the centres of cubic cells. The first cell has a corner at the origin, so the first centre is half a
/// spacing from it along each axis.
struct Lattice {
  std::array<int, 3> points{1, 1, 1};  ///< numbers of points along x, y and z
  double spacing = 0;                  ///< in the unit of length of the caller
  struct Values {
    std::string name, unit;
    int components = 1;         ///< 3 for a vector
    std::vector<double> value;  ///< [z][y][x][components]
  };
  std::vector<Values> values;
};
/// Writes the values of a lattice as a VTKHDF image file; lattices with one layer along z get two. Throws Failure if
/// the disk refuses a write.
void write_lattice_vtkhdf(const std::string& path, const Lattice& lattice);

/// Writes the potential of a two-dimensional field to a separate VTKHDF file. Throws InputError if the file exists and
/// may not be overwritten, or for the reasons of check_writable. Throws Failure if the disk refuses a write.
void write_field_vtkhdf(const std::string& path, const laplace::Field& field, bool overwrite = false);

}  // namespace lichtenberg
