#pragma once

#include <cstdint>
#include <map>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "src/record/pages.hpp"
#include "src/record/result_file.hpp"
#include "src/record/segments.hpp"
#include "src/scene/scene.hpp"

namespace lichtenberg {

/// Frames of the result file at `path` while its run writes them. The last frames are the tail in memory, which each
/// save writes again. Older frames are in segments (separate files that never change). The tail is written to a segment
/// before a frame would make it exceed its limit. A frame larger than the limit gets its own segment immediately. If a
/// run is resumed from a large file without segments, the earlier frames stay in that file until the next frame or
/// save.
class FrameStore {
 public:
  /// Makes an empty store for the result at `path`. `particles`: number of rows of each column of particles.
  /// `tail_limit`: largest size of the tail (bytes).
  FrameStore(std::string path, const Scene& scene, std::size_t particles, std::uint64_t tail_limit);

  /// Continues with the first `frames` frames of a result. Segments with later frames stay on the disk until
  /// remove_stale_segments(). Throws hdf5::Error if the result is damaged.
  void resume_from(const ResultFile& result, std::int64_t frames);

  /// Returns the number of all frames, including those since the last save.
  std::int64_t frames() const { return frames_; }
  /// Returns the time of the last frame, in time_unit().
  double last_time() const { return last_time_; }
  /// Returns the unit of the frames' time; "1" if time counts iterations.
  std::string time_unit() const { return series_.empty() ? Frame{}.time_unit : series_[1].unit; }
  /// Returns true if no frames are in segments.
  bool in_one_file() const { return segments_.empty(); }
  /// Returns a warning that names the columns of a resumed run that its file lacks and that are therefore not recorded.
  /// Empty if there are none.
  std::string warning_of_columns() const;

  /// Adds a frame. Throws InputError for columns that cannot be recorded (series_of, rows_of), or another
  /// std::exception if a segment cannot be written.
  void add(Frame frame);
  /// Makes the file at `path` the first segment before a save replaces it, if the store has left all its earlier frames
  /// in this file. Otherwise does nothing. The segment is a hard link to the file, or a copy on a disk without hard
  /// links. Throws Failure if the segment cannot be made.
  void link_as_first_segment();

  /// Writes the list columns of the last frame, such as its contacts, to the group "network".
  void put_last_lists(const hdf5::Handle& file) const;
  /// Writes the tail, and the index of the segments if there are any. `is_over`: the run has ended. Only then, and only
  /// without segments, are rows compressed, because each save would compress the tail again.
  void write_to(const hdf5::Handle& file, bool is_over) const;
  /// Removes segments that are not in the saved index. They belong to an overwritten run or to frames after the
  /// checkpoint.
  void remove_stale_segments();
  /// Replaces the result's index and segments by one file with all frames and with `rest`, its other contents. If this
  /// fails, it throws std::exception and keeps index and segments.
  void merge_into_one_file(hdf5::Pages rest);

 private:
  std::int64_t resume_segments(const ResultFile& result);
  void resume_rows(const ResultFile& result, std::size_t k, std::int64_t begin);
  void omit_new_columns(Frame& frame);
  void keep(Rows rows);
  void clear_tail();
  Segment new_segment(std::int64_t frames) const;
  void write_segment(std::span<const Rows> frames);

  std::string path_;
  std::uint64_t tail_limit_;
  std::size_t particles_;
  std::vector<double> box_edges_;  ///< nine numbers, or empty in a box without a periodic axis
  std::string length_unit_;
  bool is_resumed_ = false;
  std::set<std::string> omitted_;  ///< names of omitted columns

  std::int64_t frames_ = 0;
  double last_time_ = 0;
  std::vector<Series> series_;                ///< empty before the first frame
  std::map<std::string, std::int64_t> ends_;  ///< lists: number of rows of all frames
  std::vector<Column> last_lists_;            ///< lists of the last frame
  bool is_whole_file_ = false;                ///< the frames on the disk are in the file at path_
  std::vector<Segment> segments_;
  bool stale_segments_remain_ = true;  ///< true: the disk may have segments that are not in segments_
  std::vector<Rows> tail_;             ///< frames after those of the segments
  std::uint64_t tail_bytes_ = 0;
};

}  // namespace lichtenberg
