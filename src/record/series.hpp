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

/// One column of the frames over time, as stored in a file: a dataset whose first dimension grows with the frames.
struct Series {
  Column::Of of = Column::Of::system;
  std::string name;     ///< name of the column
  std::string dataset;  ///< "particles/conductors/position/value", say
  std::string unit;     ///< empty: no unit is written
  Values kind;          ///< an empty array of the type of the numbers
  hdf5::Shape row;      ///< shape of a row of the dataset
  std::vector<std::string> labels;

  /// Returns the size of a row (bytes).
  std::uint64_t row_bytes() const;
};

/// Determines the series (datasets) that record frames with the columns of this one. They are step and time, the
/// columns, and the end index of each list (column with a variable number of rows). `particles`: number of rows of the
/// columns of particles. Throws InputError that names a column with an invalid or duplicate name, without a unit, or
/// with a wrong number of values or labels. Throws InputError if no column belongs to the particles or to the whole
/// system.
std::vector<Series> series_of(const Frame& frame, std::size_t particles);

/// Returns the series of the box's edges, which H5MD stores in every frame: three vectors, the rows of a matrix.
/// `unit`: unit of length.
Series series_of_box_edges(const std::string& unit);

/// Reads the series (datasets of frames) of a file, step and time first. Throws hdf5::Error if it has no frames or a
/// dataset of frames is damaged.
std::vector<Series> series_in(const hdf5::Handle& file);

/// Returns the path of an H5MD element (group of a column) of a file that contains step and time. Empty in a file
/// without frames.
std::string element_with_time(const hdf5::Handle& file);

/// Values that one frame adds to each series, in the order of the series.
using Rows = std::vector<Values>;

/// Converts a frame to the values that it adds to each series, with `step` (number of the frame), time and the ends of
/// lists. `ends`: for each list, number of its rows in all frames; updated. `box_edges`: the nine numbers of the series
/// of that name, if there is one. Throws InputError that names a column which earlier frames lack, which only they
/// have, or which has changed its unit, type, width or labels. Throws the exceptions of series_of.
Rows rows_of(Frame frame, std::size_t particles, const std::vector<Series>& series, std::int64_t step,
             std::map<std::string, std::int64_t>& ends, const std::vector<double>& box_edges);

/// Returns the size of a frame's values (bytes).
std::uint64_t bytes_of(const Rows& rows);
/// Returns the values as bytes, as a view.
std::span<const std::byte> bytes_of(const Values& values);
/// Returns the number of rows that a frame's values fill in the dataset of a series: 1, except for a list.
hsize_t rows_in(const Values& values, const Series& series);

/// Reads `count` rows of a dataset from row `first`, as the number type of the series. Throws hdf5::Error if there are
/// fewer rows.
Values read_rows(hid_t file, const std::string& dataset, const Series& series, hsize_t first, hsize_t count);

// Each of these functions writes all series to a file, below `prefix`, with units and labels. All H5MD elements (groups
// of columns) share step and time.

/// Writes the datasets of these frames to a file, below the group path `prefix`. If `compressed`, rows of several
/// numbers are compressed, except rows of more than 1 MiB.
void put_frames(const hdf5::Handle& file, const std::string& prefix, const std::vector<Series>& series,
                std::span<const Rows> frames, bool compressed);

/// Creates the datasets of all series with `rows` rows each, without values. Returns the file offsets (bytes) at which
/// their values must be written; undefined for 0 rows.
std::vector<std::uint64_t> allocate_rows(const hdf5::Handle& file, const std::vector<Series>& series,
                                         std::span<const hsize_t> rows);

/// File whose datasets are a part of virtual datasets: those below `prefix` in the file `file` ("." is the file of the
/// virtual datasets itself).
struct RowSource {
  std::string file, prefix;
  std::vector<hsize_t> rows;  ///< rows of each series
};

/// Writes virtual datasets, one for each series, that concatenate the rows of the files `parts`.
void put_virtual(const hdf5::Handle& file, const std::vector<Series>& series, std::span<const RowSource> parts);

/// Writes columns as datasets of a group, with their units.
void put_columns(hid_t group, const std::vector<Column>& columns);
/// Reads all datasets of a group as list columns. Throws hdf5::Error for a dataset without dimensions or with more than
/// two.
std::vector<Column> get_columns(hid_t group);

}  // namespace lichtenberg
