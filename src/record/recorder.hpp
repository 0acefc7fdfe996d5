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

/// What a save writes besides the frames.
struct Milestone {
  Checkpoint checkpoint;
  std::optional<laplace::Field> field;    ///< at the time of the last frame
  std::map<std::string, double> seconds;  ///< wall-clock time since this program started, by activity
  std::vector<Quantity> summary;          ///< of a run that is over
  std::vector<std::string> warnings{};    ///< of a run that is over: Summary::warnings
  ColumnGroup history;                    ///< rows since the last save, added to those before; without columns: none
  std::vector<ColumnGroup> findings;      ///< what was found of the last frame; gone with the next save
};

/// Writes the result file of a run (README.md describes what stands in it and how it stays whole).
///
/// Frames become part of the result by save(), together with a checkpoint. So the result on disk is complete and
/// consistent at any moment: it holds a checkpoint and the frames up to it, and a run that is killed goes on from
/// there. From start() or resume() on to its end a recorder is the only one that writes the result.
class Recorder {
 public:
  /// Of frames, that wait in memory and are rewritten by each save before they get a file of their own.
  static constexpr std::uint64_t usual_tail = 8u << 20;

  /// For a new run; `mass` (kg) of each conductor. Nothing is written yet, and a file that may be overwritten stays
  /// until the first save. Throws InputError if `path` exists and may not be overwritten, cannot be created, or is
  /// being written by another process.
  static Recorder start(const std::string& path, const Scene& scene, std::span<const double> mass, bool overwrite,
                        std::uint64_t tail_bytes = usual_tail);

  /// For a run that goes on from the checkpoint in `path`. Throws InputError if there is no result file of this
  /// program's format, if another program has changed it or another process is writing it, or if the scene in it
  /// differs from this one outside of [stop], [output] and [network]; Failure if it is damaged.
  static Recorder resume(const std::string& path, const Scene& scene, std::uint64_t tail_bytes = usual_tail);

  /// What the user of a resumed run should be told if another build of this program was the last to carry it on: what
  /// the scene leaves open may have another default here. Else empty.
  const std::string& warning() const { return warning_; }
  /// FrameStore::warning_of_columns
  std::string warning_of_columns() const { return frames_.warning_of_columns(); }
  /// The checkpoint to go on from; empty for a new run.
  const std::optional<Checkpoint>& checkpoint() const { return checkpoint_; }
  /// Of the checkpoint on disk, in the frames' unit of time; empty for a new run.
  std::optional<double> saved_time() const { return saved_time_; }
  /// Of the last frame.
  double last_time() const { return frames_.last_time(); }
  /// Of the run on disk, without units; none unless it is over.
  const std::vector<Quantity>& summary() const { return summary_; }
  /// All frames of the run so far, those that wait for the next save among them.
  std::int64_t frames() const { return frames_.frames(); }
  /// Whether no frames stand in files of their own, as they do until the end of a long run, or longer if that failed.
  bool in_one_file() const { return frames_.in_one_file(); }

  /// Keeps a frame for the next save. Throws InputError that names the column which has the wrong length or unit, a
  /// name of another one, or is not one of those of the frames before; Failure if a frame of many bytes, which does not
  /// wait, finds no room on the disk.
  void add(Frame frame);

  /// Makes all frames added so far part of the result, and puts them together into one file if there is a summary.
  /// Returns what the user should be told if they stay apart, else nothing. Throws Failure (a full disk, say), which
  /// leaves the result as it was.
  std::string save(const Milestone& milestone);

  /// Makes the frames added since the last save part of the result too, of a run that is to end at once: its checkpoint
  /// stays that of the save, and who resumes it goes on from there and makes those frames anew. Throws Failure, which
  /// leaves the result as it was.
  void save_frames_alone();

 private:
  Recorder(const std::string& path, const Scene& scene, std::size_t particles, std::uint64_t tail_bytes);
  template <class Put>
  void put_constants(Put put);
  void take_over(const ResultFile& result);
  hdf5::Pages all_but_frames(const Milestone& milestone) const;
  Failure not_written(const std::exception& error) const;
  std::string what_stands() const;

  std::string path_;
  WriterLock lock_;
  hdf5::Pages constants_;  ///< a file of all that no save changes: the scene, where the program ran before ...
  int session_ = 0;        ///< 0: the start of the run, then one more for each time it was resumed
  std::string warning_;
  std::optional<Checkpoint> checkpoint_;
  std::optional<double> saved_time_;
  StoredField stored_field_;
  std::vector<Quantity> summary_;
  std::optional<ColumnGroup> history_;  ///< all of it
  FrameStore frames_;
  std::int64_t saved_frames_ = 0;  ///< up to the checkpoint
};

}  // namespace lichtenberg
