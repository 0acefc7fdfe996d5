#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "src/record/hdf5.hpp"
#include "src/record/segments.hpp"

namespace lichtenberg {

/// A result file as it was when it was opened, its frames in segments among them: a run that goes on writing to it
/// changes nothing here, and is not disturbed. Nothing is read before its checksum is found right.
class ResultFile {
 public:
  /// Throws InputError unless there is a result file of this program's format at `path`; the message says that only
  /// such a file can be `used` ("resumed", say). Throws hdf5::Error if it is damaged.
  ResultFile(const std::string& path, const std::string& used);

  const std::string& path() const { return path_; }
  const FileIdentity& identity() const { return index_->identity(); }
  const std::shared_ptr<const OpenFile>& opened() const { return index_; }
  int format() const { return format_; }
  /// Whether it is as this program wrote it; else another one has changed it, and nothing speaks for its bytes.
  bool is_sealed() const { return sealed_; }
  /// All but the frames in segments.
  const hdf5::Handle& file() const { return *file_; }
  const std::vector<Segment>& segments() const { return segments_; }
  /// The file of a segment, by its place among them.
  const std::shared_ptr<const OpenFile>& segment(std::size_t k) const { return files_[k]; }

  /// Reasons why the result may be unsafe to use, from the end of its run (Summary::warnings).
  std::vector<std::string> warnings() const;
  /// None in a file without frames.
  std::int64_t frames() const { return frames_; }
  /// Whether frames have a dataset of this path ("observables/energy/value").
  bool has(const std::string& dataset) const;
  /// The rows of `count` frames from `first` on. Throws hdf5::Error if there are not as many.
  template <class Number>
  std::vector<Number> rows(const std::string& dataset, std::int64_t first, std::int64_t count) const;
  /// Those of all frames.
  template <class Number>
  std::vector<Number> rows(const std::string& dataset) const {
    return rows<Number>(dataset, 0, frames_);
  }
  /// The rows that `count` frames in one file have of a list ("contacts"); `ends`: where each frame's end.
  template <class Number>
  std::vector<Number> list(const std::string& name, const std::vector<std::int64_t>& ends, std::int64_t frame,
                           std::int64_t count = 1) const;

 private:
  struct Part {
    std::int64_t first = 0, frames = 0;
    int segment = -1;  ///< its place among them; -1: the frames are in the file itself
  };
  void open_index(const std::string& used);
  void open_segments();
  void find_parts();
  const Part& part_of(std::int64_t frame) const;
  /// Calls reading(file, prefix of its datasets).
  template <class Reading>
  auto in(const Part& part, Reading reading) const;

  std::string path_;
  std::shared_ptr<const OpenFile> index_;
  std::shared_ptr<hdf5::Handle> file_;
  int format_ = 0;
  bool sealed_ = false;
  std::vector<Segment> segments_;
  std::vector<std::shared_ptr<const OpenFile>> files_;
  std::vector<Part> parts_;
  std::int64_t frames_ = 0;
};

/// Adds to the file on the disk what `put` writes, unless it stands there already. Throws Failure, and leaves the file
/// alone, if that cannot be done, if a run is writing it or if it is no longer the one that was opened.
/// The frames of a file of more than `in_memory` bytes are copied by a few megabytes at a time.
void store(const ResultFile& opened, const std::function<void(const hdf5::Handle& file)>& put,
           std::uint64_t in_memory = 64u << 20);

/// Copies what stands in these groups of a file, frames excepted, into another.
void copy_all_but_frames(const hdf5::Handle& from, const hdf5::Handle& to, const std::vector<std::string>& groups);

/// Radii [N] of the particles of a result. Throws hdf5::Error if one of them is not greater than 0.
std::vector<double> radii_in(const hdf5::Handle& file);

}  // namespace lichtenberg
