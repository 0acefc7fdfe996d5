#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "src/record/hdf5.hpp"
#include "src/record/segments.hpp"

namespace lichtenberg {

/// Result file opened for reading, including its frames in segments (separate files of a long run), in the state in
/// which it was opened. A run that continues to write it neither affects this object nor is affected. The checksum, if
/// the file has one, is verified before HDF5 reads any data.
class ResultFile {
 public:
  /// Opens a result file. Throws InputError unless `path` is a readable result file of a format that this program
  /// reads. `used`: verb for the message, which says that only such a file can be "resumed", for example. Throws
  /// hdf5::Error if the file is damaged or one of its segments cannot be read.
  ResultFile(const std::string& path, const std::string& used);

  const std::string& path() const { return path_; }
  const FileIdentity& identity() const { return index_->identity(); }
  const std::shared_ptr<const OpenFile>& opened() const { return index_; }
  int format() const { return format_; }
  /// Returns true if the file has a valid checksum (Seal). Otherwise another program has changed it, and its bytes are
  /// not verified.
  bool is_sealed() const { return sealed_; }
  /// Returns the file, which has all data except for the frames in segments.
  const hdf5::Handle& file() const { return *file_; }
  const std::vector<Segment>& segments() const { return segments_; }
  /// Returns the file of segment k.
  const std::shared_ptr<const OpenFile>& segment(std::size_t k) const { return files_[k]; }

  /// Returns reasons why the result may be unreliable, from the end of its run (Summary::warnings).
  std::vector<std::string> warnings() const;
  /// Returns the number of frames; 0 in a file without frames.
  std::int64_t frames() const { return frames_; }
  /// Returns true if the file has a dataset or group of this path, such as "observables/energy/value".
  bool has(const std::string& dataset) const;
  /// Reads the rows of `count` frames from frame `first` of a dataset with one row for each frame. Throws hdf5::Error
  /// if there are fewer.
  template <class Number>
  std::vector<Number> rows(const std::string& dataset, std::int64_t first, std::int64_t count) const;
  /// Reads the rows of all frames of a dataset with one row for each frame. Throws hdf5::Error if the dataset is
  /// missing.
  template <class Number>
  std::vector<Number> rows(const std::string& dataset) const {
    return rows<Number>(dataset, 0, frames_);
  }
  /// Reads a list column ("contacts"), whose number of rows differs between frames, for `count` frames from `frame` on.
  /// All these frames must be in one file (the result file or one segment). `ends`: for each frame, number of rows of
  /// the list up to its end. Throws hdf5::Error for frames that the file lacks or for descending `ends`.
  template <class Number>
  std::vector<Number> list(const std::string& name, const std::vector<std::int64_t>& ends, std::int64_t frame,
                           std::int64_t count = 1) const;

 private:
  struct FrameRange {
    std::int64_t first = 0, frames = 0;
    int segment = -1;  ///< index in segments_; -1: the frames are in the file itself
  };
  void open_index(const std::string& used);
  void open_segments();
  void find_ranges();
  const FrameRange& range_with(std::int64_t frame) const;
  /// Calls reading(file, prefix of its datasets) for the file that contains the range.
  template <class Reading>
  auto in(const FrameRange& range, Reading reading) const;

  std::string path_;
  std::shared_ptr<const OpenFile> index_;
  std::shared_ptr<hdf5::Handle> file_;
  int format_ = 0;
  bool sealed_ = false;
  std::vector<Segment> segments_;
  std::vector<std::shared_ptr<const OpenFile>> files_;
  std::vector<FrameRange> ranges_;
  std::int64_t frames_ = 0;
};

/// Adds data to a result file on the disk: `put` writes them to a copy, which then replaces the file. The frames of a
/// file of more than `in_memory` bytes, with a checksum and without segments, are copied in blocks of a few megabytes.
/// Throws Failure if a run is writing the file, if it has been replaced since it was opened, or if the disk refuses a
/// write. Throws the exceptions of `put` and WriterLock::if_free. Until the copy is complete, the file is unchanged.
void store(const ResultFile& opened, const std::function<void(const hdf5::Handle& file)>& put,
           std::uint64_t in_memory = 64u << 20);

/// Copies the format number and these groups of an open result file to another file, except for the datasets of frames.
void copy_all_but_frames(const hdf5::Handle& from, const hdf5::Handle& to, const std::vector<std::string>& groups);

/// Reads the radii [N] of the particles of a result. Throws hdf5::Error if one of them is not greater than 0.
std::vector<double> radii_in(const hdf5::Handle& file);

}  // namespace lichtenberg
