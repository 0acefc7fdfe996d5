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

/// A result to read frame by frame, as it was when it was opened (ResultFile). What members read they throw InputError
/// for if it is missing or damaged.
class Result {
 public:
  /// Throws InputError if the file is missing, damaged, without frames, or none of this program's format.
  explicit Result(const std::string& path);

  const std::string& path() const { return file_->path(); }
  const ResultFile& file() const { return *file_; }
  /// What the run was made of, whose effects are of these kinds. Its text is parsed anew: throws InputError if this
  /// version does not read it. One that started at places of another result has those of its first frame.
  Scene scene(const EffectKinds& kinds = effects::all_kinds(), const StopRequest& stop = {}) const;
  int frames() const { return static_cast<int>(times_.size()); }
  const std::vector<double>& times() const { return times_; }  ///< s
  std::vector<double> radius() const;                          ///< m
  std::vector<double> mass() const;                            ///< kg
  /// All its columns but lists, with numbers as doubles and without units.
  Frame frame(int index) const;
  /// Places and radii (m) in a frame.
  std::vector<Conductor> bodies(int index) const;
  /// A frame of a run of conductors.
  ConductorFrame conductor_frame(int index) const;
  /// See ResultFile::warnings.
  std::vector<std::string> warnings() const;
  /// A quantity of /observables, one number or several; empty if the run has not recorded it.
  std::vector<double> observable(const std::string& name, int index) const;
  /// Whether the scene has contacts, and with them a network.
  bool has_network() const;
  /// See analysis::successors(). Only where there is a network.
  std::vector<int> successor(int index) const;
  /// The contacts that the run had made; empty if an earlier version wrote the file, which kept those of the last frame
  /// only.
  std::optional<std::vector<analysis::Edge>> contacts(int index) const;

  /// Writes /analysis, over that of an earlier time; everything else in the file stays as it is. The columns are lists
  /// with a row for each frame. Throws Failure, and leaves the file alone, if it cannot be written, its run writes it,
  /// or it is no longer the one that was opened.
  void put_analysis(const std::vector<Column>& columns) const;

 private:
  template <class Reading>
  auto guarded(Reading reading) const;
  std::vector<double> reals(const std::string& name, int index, std::size_t count) const;
  std::vector<std::string> names_in(const std::string& group) const;

  std::string path_;
  std::optional<ResultFile> file_;
  std::vector<double> times_;
  std::vector<std::int64_t> contact_ends_;  ///< of each frame; empty if there are none
  std::size_t conductors_ = 0;
};

}  // namespace lichtenberg
