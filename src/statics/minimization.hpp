#pragma once

#include <cmath>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "src/analysis/packing.hpp"
#include "src/model/bodies.hpp"
#include "src/model/motion.hpp"
#include "src/scene/scene.hpp"

namespace lichtenberg {

/// Minimization of a scene's contact potential by the method of its [minimize].
class Minimization : public Motion {
 public:
  /// Throws InputError if the energy is infinite at the start, Failure if a force is.
  explicit Minimization(const Scene& scene);
  ~Minimization() override;

  /// Computes one iteration. Returns false without a change if the method finds no lower energy. Throws Failure if a
  /// force is not finite.
  bool iterate();
  std::int64_t iteration() const;
  std::int64_t evaluations() const;  ///< number of evaluations of energy and forces
  double energy() const;             ///< J
  double largest_force() const;      ///< N, largest net force on a particle
  double force_unit() const;         ///< N, stiffness over the mean diameter
  /// Returns true if no net force exceeds minimize.force_tolerance.
  bool at_rest() const;
  Bodies bodies() const;

  /// Returns the number of the iteration.
  double time() const override { return static_cast<double>(iteration()); }
  std::string time_unit() const override { return "1"; }
  /// Returns the iteration of the next frame: the next multiple of minimize.record_every or, if that is 0, after an
  /// interval that increases. At most minimize.max_iterations.
  double next_frame() const override;
  /// The number of iterations to rest is unknown.
  double end_time() const override { return INFINITY; }
  void advance_to(double iteration, const std::function<bool()>& pause) override;
  /// Returns true at rest, after minimize.max_iterations, or if the energy cannot decrease.
  bool finished() override;
  bool exact_anywhere() const override { return true; }

  Frame frame() override;
  std::string progress() override;
  /// Progress as the logarithm of the largest force, which decreases by steady factors.
  ProgressMeasure progress_measure() override;
  Checkpoint checkpoint() override;
  void restore(const Checkpoint& checkpoint) override;

  /// Returns energy and largest force at iterations with increasing intervals, and at the last iteration.
  ColumnGroup take_history() override;
  /// Returns the packing (analysis::Packing).
  std::vector<ColumnGroup> findings() override;
  Summary summary() override;
  std::map<std::string, double> seconds() const override;

 private:
  void record_history();
  double most_iterations() const;
  double force_in_units() const { return largest_force() / force_unit(); }
  const analysis::Packing& packing();

  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
  struct HistoryRecord {
    std::int64_t iteration = 0;
    double energy = 0;         ///< J
    double largest_force = 0;  ///< N
  };
  std::vector<HistoryRecord> history_;        ///< records since the last take_history
  std::int64_t recorded_at_ = -1;             ///< iteration of the last record
  bool cannot_decrease_ = false;              ///< true: the energy cannot decrease
  std::optional<analysis::Packing> packing_;  ///< packing at the iteration packed_at_
  std::int64_t packed_at_ = -1;
  double seconds_ = 0;
};

}  // namespace lichtenberg
