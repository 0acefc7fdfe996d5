#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "solvers/error.hpp"
#include "solvers/laplace/problem.hpp"
#include "src/model/motion.hpp"
#include "src/record/frame_store.hpp"
#include "src/record/writer_lock.hpp"
#include "src/scene/scene.hpp"

namespace lichtenberg {

/// Data that one save writes in addition to the frames: checkpoint, field, wall-clock times, summary with warnings,
/// time series, and quantities of the last frame.
struct Milestone {
  Checkpoint checkpoint;
  std::optional<laplace::Field> field;    ///< field at the time of the last frame
  std::map<std::string, double> seconds;  ///< wall-clock time since this program started, by activity
  std::vector<Quantity> summary;          ///< only for a run that is over
  std::vector<std::string> warnings{};    ///< only for a run that is over: Summary::warnings
  /// Rows of the run's time series since the last save, which are appended to earlier rows; no columns: none.
  ColumnGroup history;
  std::vector<ColumnGroup> findings;  ///< quantities of the last frame; removed by the next save
};

/// Writes the result file of a run: frames and checkpoints. docs/reference/result-file.md describes its contents.
class Recorder {
 public:
  /// Largest size (bytes) of the tail: the last frames, which stay in memory and are rewritten by each save. Frames
  /// beyond it get a file of their own.
  static constexpr std::uint64_t usual_tail = 8u << 20;

  /// Starts the result of a new run. `mass`: of each particle, in the scene's unit of mass. `tail_bytes`: as
  /// usual_tail. The first save writes the result file; a file that may be overwritten is kept until then. Throws
  /// InputError if `path` exists and may not be overwritten, cannot be created, or is being written by another process.
  /// Throws InputError if the path of its folder of segments is a link or no folder.
  static Recorder start(const std::string& path, const Scene& scene, std::span<const double> mass, bool overwrite,
                        std::uint64_t tail_bytes = usual_tail);

  /// Continues a run from the checkpoint in the result at `path`. Throws InputError if there is no result file of this
  /// program's format, or if another program has changed it or another process is writing it. Throws InputError if the
  /// result's scene differs from `scene` outside of the keys that first_change() ignores, or if the two scenes start
  /// from different results. Throws Failure if the result is damaged or cannot be read.
  static Recorder resume(const std::string& path, const Scene& scene, std::uint64_t tail_bytes = usual_tail);

  /// Returns a warning for a resumed run if a program of another version or commit wrote its last session, because
  /// defaults may differ; otherwise empty.
  const std::string& warning() const { return warning_; }
  /// Returns a warning that names the columns of a resumed run that its file lacks and that are therefore not recorded.
  /// Empty if there are none.
  std::string warning_of_columns() const { return frames_.warning_of_columns(); }
  /// Returns the checkpoint from which to continue; empty for a new run.
  const std::optional<Checkpoint>& checkpoint() const { return checkpoint_; }
  /// Returns the time of the checkpoint on disk, in the frames' unit of time; empty before the first save of a new run.
  std::optional<double> saved_time() const { return saved_time_; }
  /// Returns the time of the last frame, in the frames' unit of time.
  double last_time() const { return frames_.last_time(); }
  /// Returns the summary of a resumed run that is on disk, without units; empty unless that run was over.
  const std::vector<Quantity>& summary() const { return summary_; }
  /// Returns the number of all frames of the run, including those that wait for the next save.
  std::int64_t frames() const { return frames_.frames(); }
  /// Returns true if all frames are in the result file. Frames of long runs are in segments (separate files) until the
  /// end of the run, or longer if merging them failed.
  bool in_one_file() const { return frames_.in_one_file(); }

  /// Keeps a frame for the next save. Throws InputError that names a column with a wrong length, a wrong unit or a
  /// duplicate name. Also throws if a column of earlier frames is missing or the unit of time differs from theirs.
  /// Throws for a column that earlier frames lack, except in a resumed run, which omits it. Frames beyond the tail (the
  /// last frames, which stay in memory) are written to a segment. Throws Failure if this fails.
  void add(Frame frame);

  /// Adds all frames since the last save to the result, and merges all frames into one file if there is a summary.
  /// Returns a warning for the user if they stay in several files, otherwise empty. Throws Failure if the file cannot
  /// be written, or InputError if a column of the history has changed its unit or type. Both leave the result
  /// unchanged.
  std::string save(const Milestone& milestone);

  /// Adds the frames since the last save to the result of a run that is about to end, without a new checkpoint. A
  /// resumed run continues from the last checkpoint and computes those frames again. Does nothing before the first save
  /// or without new frames. Throws Failure and leaves the result unchanged if the file cannot be written.
  void save_frames_alone();

 private:
  Recorder(const std::string& path, const Scene& scene, std::size_t particles, std::uint64_t tail_bytes);
  template <class Put>
  void put_constants(Put put);
  void resume_from(const ResultFile& result);
  hdf5::Pages all_but_frames(const Milestone& milestone) const;
  Failure write_failure(const std::exception& error) const;
  std::string remaining_result() const;

  std::string path_;
  WriterLock lock_;
  /// File of all data that no save changes: the scene, the provenance of earlier sessions, and so on.
  hdf5::Pages constants_;
  int session_ = 0;  ///< 0: the start of the run; incremented by each resumption
  std::string warning_;
  std::optional<Checkpoint> checkpoint_;
  std::optional<double> saved_time_;
  StoredField stored_field_;
  std::vector<Quantity> summary_;
  std::optional<ColumnGroup> history_;  ///< complete history
  FrameStore frames_;
  std::int64_t saved_frames_ = 0;  ///< number of frames up to the checkpoint
};

}  // namespace lichtenberg
