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

// Frames that exceed a memory limit are stored in separate files, the segments, which are never changed:
// `path`.frames/segment-000000.h5 and so on, for a result at `path`. The result is then an index of them.

/// Segment: a separate file with some of the frames of a long run, as listed in the index (the file at `path`).
/// `number` is that in the file's name, `frames` the number of its frames.
struct Segment {
  std::int64_t number = 0, frames = 0;
  Seal seal;
  std::vector<hsize_t> rows{};  ///< rows of each series; not stored in the index
};

/// Returns the path of the folder of segments of the result at `path`: `path`.frames.
std::string segments_folder(const std::string& path);
/// Returns the path of the segment with this number.
std::string segment_file(const std::string& path, std::int64_t number);
/// Returns the path of a segment relative to the result's folder, as stored in the index.
std::string segment_name(const std::string& path, std::int64_t number);

/// Writes the list of segments to an index (a result file whose frames are in segments).
void put_segments(const hdf5::Handle& index, const std::vector<Segment>& segments);
/// Reads the list of segments of an index; none for a file that contains all its frames. Throws hdf5::Error if the list
/// is incomplete.
std::vector<Segment> get_segments(const hdf5::Handle& index);

/// Opens a segment of the result at `path` and verifies its checksum. Throws std::system_error if it is missing or
/// cannot be read, hdf5::Error if it is damaged or differs from the index.
OpenFile open_segment(const std::string& path, const Segment& segment);

/// Throws InputError if segments_folder(path) exists and is a link or no folder.
void check_segments_folder(const std::string& path);
/// Creates segments_folder(path) unless it exists. Throws Failure if it cannot be created or is a link.
void make_segments_folder(const std::string& path);

/// Returns the number of the next segment: 1 plus the largest number of a segment in the folder, or 0 if there is none.
std::int64_t next_segment(const std::string& path);
/// Removes all segments in the folder of the result at `path` except these. Without `segments` it also removes the
/// folder if it is empty then. Does nothing if the folder is a link.
void remove_other_segments(const std::string& path, const std::vector<Segment>& segments);

/// Returns the number of rows of each series (column over all frames) in a file. Throws hdf5::Error if the rows of a
/// series have another shape.
std::vector<hsize_t> rows_in(const hdf5::Handle& file, const std::vector<Series>& series);

/// Frames in an existing file. `open` opens it only while they are copied, because the number of open files is limited.
struct StoredFrames {
  std::vector<hsize_t> rows;  ///< rows of each series
  std::function<std::shared_ptr<const OpenFile>()> open;
};

/// Writes a file with the contents of `rest` and with all frames: those stored in the files `before`, then `frames`.
/// Stored rows are copied in blocks of a few megabytes, or one by one if a row is larger. `check` is called just before
/// the file gets its name and may prevent this by an exception. Returns the file's checksum. Throws Failure if the file
/// cannot be written, std::system_error or hdf5::Error if stored frames cannot be read.
Seal write_with_frames(
    const std::string& path, hdf5::Pages rest, const std::vector<Series>& series, std::span<const StoredFrames> before,
    std::span<const Rows> frames, const std::function<void()>& check = [] {});

}  // namespace lichtenberg
