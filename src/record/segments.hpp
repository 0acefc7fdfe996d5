#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "src/record/seal.hpp"
#include "src/record/series.hpp"

namespace lichtenberg {

// Frames that fill more than some memory stand in files of their own, which are never changed: `path`.frames/
// segment-000000.h5 and so on, for a result at `path`, which then is an index of them.

struct Segment {
  std::int64_t number = 0, frames = 0;
  Seal seal;
  std::vector<hsize_t> rows{};  ///< of each series; the index does not say
};

std::string segments_folder(const std::string& path);
std::string segment_file(const std::string& path, std::int64_t number);
/// From the result's folder, as the index names it.
std::string segment_name(const std::string& path, std::int64_t number);

/// Those that an index is of; none in a file that holds all its frames itself.
void put_segments(const hdf5::Handle& index, const std::vector<Segment>& segments);
std::vector<Segment> get_segments(const hdf5::Handle& index);

/// Throws std::system_error if it is missing, hdf5::Error if it is another than the index says, or damaged.
OpenFile open_segment(const std::string& path, const Segment& segment);

/// Throws InputError if the folder of segments is there and is a link or no folder.
void check_segments_folder(const std::string& path);
/// Throws Failure if the folder is not there and cannot be made.
void make_segments_folder(const std::string& path);

/// The number of a segment that can be written next, beside all files that are there.
std::int64_t next_segment(const std::string& path);
/// Removes all segments in the folder but these, and the folder if it is empty then; nothing if it is a link.
void remove_other_segments(const std::string& path, const std::vector<Segment>& segments);

/// How many rows of each series stand in a file.
std::vector<hsize_t> rows_in(const hdf5::Handle& file, const std::vector<Series>& series);

/// Frames that stand in a file, which is open only while they are copied: there may be more than a process may open.
struct StoredFrames {
  std::vector<hsize_t> rows;  ///< of each series
  std::function<std::shared_ptr<const OpenFile>()> open;
};

/// Writes a file of all that stands in `rest`, and of frames: those that stand `before`, then `frames`. The rows go
/// to the disk by a few megabytes at a time. Throws Failure.
Seal write_with_frames(
    const std::string& path, hdf5::Pages rest, const std::vector<Series>& series, std::span<const StoredFrames> before,
    std::span<const Rows> frames, const std::function<void()>& check = [] {});

}  // namespace lichtenberg
