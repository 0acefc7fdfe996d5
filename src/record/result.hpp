#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "src/analysis/network.hpp"
#include "src/model/frame.hpp"
#include "src/record/atomic_file.hpp"
#include "src/record/hdf5.hpp"
#include "src/scene/scene.hpp"

namespace lichtenberg {

/// A copy in memory of the file at `path`. Throws InputError unless it is a result file of this program's format; the
/// message says that only such a file can be `used` ("resumed", say). Throws hdf5::Error if it is damaged.
hdf5::Handle load_result(const std::string& path, const std::string& used);

/// A result file to read frame by frame. The file is read once, when it is opened: a run that goes on writing to it
/// changes nothing here. What members read they throw InputError for if it is missing or damaged.
class Result {
 public:
  /// Throws InputError if the file is missing, damaged, without frames, or none of this program's format.
  explicit Result(const std::string& path);

  const std::string& path() const { return path_; }
  /// What the run was made of. Its text is parsed anew: throws InputError if this version does not read it.
  Scene scene() const;
  int frames() const { return static_cast<int>(times_.size()); }
  const std::vector<double>& times() const { return times_; }  ///< s
  std::vector<double> radius() const;                          ///< m
  std::vector<double> mass() const;                            ///< kg
  /// All its columns but lists, with numbers as doubles.
  Frame frame(int index) const;
  /// A quantity of /observables, one number or several; empty if the run has not recorded it.
  std::vector<double> observable(const std::string& name, int index) const;
  /// Whether the scene has contacts, and with them a network.
  bool has_network() const;
  /// See analysis::successors(). Only where there is a network.
  std::vector<int> successor(int index) const;
  /// The contacts that the run had made; empty if an earlier version wrote the file, which kept those of the last frame
  /// only.
  std::optional<std::vector<analysis::Contact>> contacts(int index) const;

  /// Writes /analysis, over that of an earlier time; everything else in the file stays as it is. Throws Failure, and
  /// leaves the file alone, if it cannot be written or is no longer the one that was opened (its run goes on).
  void put_analysis(const std::vector<Column>& columns) const;

 private:
  template <class Reading>
  auto guarded(Reading reading) const;
  std::vector<double> reals(const std::string& name, int index, std::size_t count) const;
  Column column(const std::string& path, const std::string& name, Column::Of of, int index) const;

  std::string path_;
  FileIdentity identity_;
  std::optional<hdf5::Handle> file_;
  std::vector<double> times_;
  std::size_t conductors_ = 0;
};

}  // namespace lichtenberg
