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

/// The rows of one column over all frames, as they stand in a file: a dataset whose first dimension grows.
struct Series {
  Column::Of of = Column::Of::system;
  std::string name;     ///< of the column
  std::string dataset;  ///< "particles/conductors/position/value", say
  std::string unit;     ///< empty: none is written
  Values kind;          ///< empty; its type is that of the numbers
  hdf5::Shape row;      ///< of a row of the dataset
  std::vector<std::string> labels;

  std::uint64_t row_bytes() const;
};

/// The series that a frame of these columns adds to: step and time, its columns, and for each list where it ends.
/// Throws InputError that names the column if a name, a unit or a number of values cannot be; `particles`: how many
/// rows the columns of particles must have.
std::vector<Series> series_of(const Frame& frame, std::size_t particles);

/// The box's edges as H5MD has them in every frame: three vectors, the rows of a matrix.
Series series_of_box_edges(const std::string& unit);

/// Those of a file, step and time first. Throws hdf5::Error if it has no frames.
std::vector<Series> series_in(const hdf5::Handle& file);

/// Where step and time stand in a file: beside any of its elements. Empty in a file without frames.
std::string home_of_time(const hdf5::Handle& file);

/// What a frame adds to each series.
using Rows = std::vector<Values>;

/// Puts a frame's columns into the order of the series, with step and time and the ends of lists, which are added to
/// `ends`; `box_edges`: the nine numbers of the series of that name, if there is one. Throws InputError that names the
/// column if it is not one of those of the frames before.
Rows rows_of(Frame frame, std::size_t particles, const std::vector<Series>& series, std::int64_t step,
             std::map<std::string, std::int64_t>& ends, const std::vector<double>& box_edges);

std::uint64_t bytes_of(const Rows& rows);
std::span<const std::byte> bytes_of(const Values& values);
/// How many rows of its dataset a frame's values are.
hsize_t rows_in(const Values& values, const Series& series);

/// Reads rows of a dataset as the series has them.
Values read_rows(hid_t file, const std::string& dataset, const Series& series, hsize_t first, hsize_t count);

// Each writes all series into a file, below `prefix`, with units and labels, step and time shared by all elements.

/// The frames themselves; if so wanted rows of many numbers are compressed, unless they are long.
void put_frames(const hdf5::Handle& file, const std::string& prefix, const std::vector<Series>& series,
                std::span<const Rows> frames, bool compressed);

/// Room for so many rows of each series, whose bytes are to be written at the offsets that are returned.
std::vector<std::uint64_t> put_room(const hdf5::Handle& file, const std::vector<Series>& series,
                                    std::span<const hsize_t> rows);

/// Rows that stand elsewhere: in the dataset of the same name below `prefix` of another file ("." for this one).
struct Elsewhere {
  std::string file, prefix;
  std::vector<hsize_t> rows;  ///< of each series
};

/// Virtual datasets over what stands elsewhere, one after the other.
void put_virtual(const hdf5::Handle& file, const std::vector<Series>& series, std::span<const Elsewhere> parts);

/// Writes columns as datasets of a group, with their units.
void put_columns(hid_t group, const std::vector<Column>& columns);
/// All datasets of a group, as columns that are lists.
std::vector<Column> get_columns(hid_t group);

}  // namespace lichtenberg
