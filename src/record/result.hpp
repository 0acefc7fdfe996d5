#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "src/analysis/network.hpp"
#include "src/effects/conductor_frame.hpp"
#include "src/effects/effects.hpp"
#include "src/model/column.hpp"
#include "src/model/frame.hpp"
#include "src/record/result_file.hpp"
#include "src/scene/scene.hpp"
#include "src/scene/stopping.hpp"

namespace lichtenberg {

/// Result file of a run with the trajectory of its bodies, read frame by frame, in the state in which it was opened
/// (ResultFile). Members throw InputError if data are missing or damaged.
class Result {
 public:
  /// Opens the file. Throws InputError if it is missing, damaged, without frames, or not of this program's format.
  explicit Result(const std::string& path);

  const std::string& path() const { return file_->path(); }
  const ResultFile& file() const { return *file_; }
  /// Returns the scene of the run, parsed again from its text with effects of these kinds. Throws InputError if this
  /// version does not support it. If the run started from another result, the bodies have their positions in frame 0 of
  /// this result. `stop` can end the placement of bodies (stopping.hpp).
  Scene scene(const EffectKinds& kinds = effects::all_kinds(), const StopRequest& stop = {}) const;
  int frames() const { return static_cast<int>(times_.size()); }
  const std::vector<double>& times() const { return times_; }  ///< in the frames' unit (s, t0 or iterations)
  std::vector<double> radius() const;                          ///< in the scene's unit of length (m or d0)
  std::vector<double> mass() const;                            ///< in the scene's unit of mass (kg or m0)
  // The following functions throw InputError if their data in the file are missing or damaged.

  /// Returns all columns of a frame except lists, with numbers as doubles and without units. `index`: from 0.
  Frame frame(int index) const;
  /// Returns the positions and radii of the bodies in a frame, in the unit of length of the scene (m, or d0 of grains).
  std::vector<Conductor> bodies(int index) const;
  /// Returns a frame of a run of conductors, with charges, potentials and energies.
  ConductorFrame conductor_frame(int index) const;
  /// Returns reasons why the result may be unreliable, from the end of its run.
  std::vector<std::string> warnings() const;
  /// Returns a quantity of the whole system in a frame by its name, one number or several (group /observables). Empty
  /// if the run has not recorded it.
  std::vector<double> observable(const std::string& name, int index) const;
  /// Returns true if the run recorded a network of contacts.
  bool has_network() const;
  /// Returns for each conductor in a frame the next conductor on its path to ground along the contact network
  /// (analysis::successors). Requires a network.
  std::vector<int> successor(int index) const;
  /// Returns the closed contacts of a frame as pairs of conductors. Empty if the file has no contacts of each frame, as
  /// in files of older versions.
  std::optional<std::vector<analysis::Edge>> contacts(int index) const;

  /// Writes columns with one row for each frame to the group /analysis and replaces an existing group. Everything else
  /// in the file is unchanged. Throws Failure and leaves the file unchanged in these cases: it cannot be written, its
  /// run writes it, or it has been replaced since it was opened.
  void put_analysis(const std::vector<Column>& columns) const;

 private:
  template <class Reading>
  auto guarded(Reading reading) const;
  std::vector<double> reals(const std::string& name, int index, std::size_t count) const;
  std::vector<std::string> names_in(const std::string& group) const;

  std::string path_;
  std::optional<ResultFile> file_;
  std::vector<double> times_;
  std::vector<std::int64_t> contact_ends_;  ///< contact rows up to the end of each frame; empty if there are none
  std::size_t conductors_ = 0;
};

}  // namespace lichtenberg
