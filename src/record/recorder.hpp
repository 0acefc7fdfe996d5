#pragma once

#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "solvers/laplace/problem.hpp"
#include "src/model/frame.hpp"
#include "src/model/motion.hpp"
#include "src/record/hdf5.hpp"
#include "src/record/layout.hpp"
#include "src/record/provenance.hpp"
#include "src/scene/scene.hpp"

namespace lichtenberg {

/// What a save writes besides the frames.
struct Milestone {
  Checkpoint checkpoint;
  std::optional<laplace::Field> field;    ///< at the time of the last frame
  std::map<std::string, double> seconds;  ///< wall-clock time since this program started, by activity
  std::vector<Quantity> summary;          ///< of a run that is over
  std::vector<ColumnGroup> findings;      ///< of the last frame of a run that is over
  ColumnGroup history;                    ///< rows that are added
};

/// Writes the result file of a run (README.md describes what stands in it).
///
/// Frames are kept in memory until save() writes them together with a checkpoint, and save() replaces the file as a
/// whole. So the file on disk is complete and consistent at any moment: it holds a checkpoint and the frames up to it,
/// and a run that is killed goes on from there.
class Recorder {
 public:
  /// For a new run; `mass` (kg) of each conductor. Nothing is written yet, and a file that may be overwritten stays
  /// until the first save. Throws InputError if `path` exists and may not be overwritten, or cannot be created.
  static Recorder start(const std::string& path, const Scene& scene, std::span<const double> mass, bool overwrite);

  /// For a run that goes on from the checkpoint in `path`. Throws InputError if there is no result file of this
  /// program's format, or if the scene in it differs from this one outside of [stop], [output] and [network]; Failure
  /// if it is damaged.
  static Recorder resume(const std::string& path, const Scene& scene);

  /// The checkpoint to go on from; empty for a new run.
  const std::optional<Checkpoint>& checkpoint() const { return checkpoint_; }
  /// s, of the last frame on disk; empty for a new run.
  std::optional<double> saved_time() const { return saved_time_; }
  /// Of the run on disk; none unless it is over.
  const std::vector<Quantity>& summary() const { return summary_; }
  /// All frames of the run so far, those that wait for the next save among them.
  std::int64_t frames() const { return saved_frames_ + static_cast<std::int64_t>(waiting_.size()); }

  /// Keeps a frame for the next save.
  void add(Frame frame);

  /// Writes all frames added since the last save. Throws Failure (a full disk, say), which leaves the file as it was.
  void save(const Milestone& milestone);

 private:
  Recorder(std::string path, const Scene& scene, std::vector<double> mass);
  hdf5::Handle new_file() const;
  void put_frames(const hdf5::Handle& file) const;
  void put_session(const hdf5::Handle& file, const std::map<std::string, double>& seconds) const;
  std::string what_stands() const;

  std::string path_;
  Scene scene_;
  std::vector<double> mass_;
  Provenance provenance_ = provenance();
  int session_ = 0;  ///< 0: the start of the run, then one more for each time it was resumed
  std::optional<Checkpoint> checkpoint_;
  std::optional<double> saved_time_;
  std::vector<Quantity> summary_;
  std::int64_t saved_frames_ = 0;
  std::vector<Frame> waiting_;
};

}  // namespace lichtenberg
