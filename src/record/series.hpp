#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "src/model/frame.hpp"
#include "src/record/hdf5.hpp"

namespace lichtenberg {

using Values = decltype(Column::values);

/// Rows of one column over all frames, as stored in a file: a dataset whose first dimension grows.
struct Series {
  Column::Of of = Column::Of::system;
  std::string name;     ///< name of the column
  std::string dataset;  ///< "particles/conductors/position/value", say
  std::string unit;     ///< empty: no unit is written
  Values kind;          ///< an empty array of the type of the numbers
  hdf5::Shape row;      ///< shape of a row of the dataset
  std::vector<std::string> labels;

  std::uint64_t row_bytes() const;
};

/// Returns the series of a frame with these columns: step and time, its columns, and the end index of each list. Throws
/// InputError that names a column with an invalid or duplicate name, an invalid unit or number of values. Throws
/// InputError without a column of particles or of the system. `particles`: number of rows of the columns of particles.
std::vector<Series> series_of(const Frame& frame, std::size_t particles);

/// Returns the series of the box's edges, which H5MD stores in every frame: three vectors, the rows of a matrix.
Series series_of_box_edges(const std::string& unit);

/// Returns the series of a file, step and time first. Throws hdf5::Error if it has no frames or a dataset of frames is
/// damaged.
std::vector<Series> series_in(const hdf5::Handle& file);

/// Returns the element of a file that contains step and time. Empty in a file without frames.
std::string element_with_time(const hdf5::Handle& file);

/// Values that a frame adds to each series.
using Rows = std::vector<Values>;

/// Returns a frame's columns in the order of the series, with step and time and the ends of lists, which are added to
/// `ends`. `box_edges`: the nine numbers of the series of that name, if there is one. Throws InputError that names a
/// column which earlier frames lack, which only they have, or which has changed its unit, type or width.
Rows rows_of(Frame frame, std::size_t particles, const std::vector<Series>& series, std::int64_t step,
             std::map<std::string, std::int64_t>& ends, const std::vector<double>& box_edges);

std::uint64_t bytes_of(const Rows& rows);
std::span<const std::byte> bytes_of(const Values& values);
/// Returns the number of rows that a frame's values fill in the dataset of the series.
hsize_t rows_in(const Values& values, const Series& series);

/// Reads `count` rows of a dataset from row `first`, with the number type of the series. Throws hdf5::Error if there
/// are fewer rows.
Values read_rows(hid_t file, const std::string& dataset, const Series& series, hsize_t first, hsize_t count);

// Each of these functions writes all series to a file, below `prefix`, with units and labels. All elements share step
// and time.

/// Writes the frames. If `compressed`, rows of several numbers are compressed unless they are long.
void put_frames(const hdf5::Handle& file, const std::string& prefix, const std::vector<Series>& series,
                std::span<const Rows> frames, bool compressed);

/// Allocates `rows` rows of each series and returns the file offsets at which their bytes must be written.
std::vector<std::uint64_t> allocate_rows(const hdf5::Handle& file, const std::vector<Series>& series,
                                         std::span<const hsize_t> rows);

/// Rows in the dataset of the same name below `prefix` of another file ("." for this file).
struct RowSource {
  std::string file, prefix;
  std::vector<hsize_t> rows;  ///< rows of each series
};

/// Writes virtual datasets that concatenate the rows of `parts`.
void put_virtual(const hdf5::Handle& file, const std::vector<Series>& series, std::span<const RowSource> parts);

/// Writes columns as datasets of a group, with their units.
void put_columns(hid_t group, const std::vector<Column>& columns);
/// Returns all datasets of a group as list columns. Throws hdf5::Error for a dataset without or with more than two
/// dimensions.
std::vector<Column> get_columns(hid_t group);

}  // namespace lichtenberg
