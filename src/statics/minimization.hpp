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

/// Minimization of the potential energy of a scene's soft particles, by the method of the table [minimize]. Methods are
/// gradient descent, FIRE, L-BFGS, Newton-CG, or the last two combined. Its "time" is the number of the iteration.
class Minimization : public Motion {
 public:
  /// Starts at the positions of the scene. Throws InputError if the energy there is infinite, Failure if a force is not
  /// finite.
  explicit Minimization(const Scene& scene);
  ~Minimization() override;

  /// Computes one iteration of the minimizer. Returns false without a change if the method finds no lower energy.
  /// Throws Failure if a force is not finite.
  bool iterate();
  std::int64_t iteration() const;
  std::int64_t evaluations() const;  ///< number of evaluations of energy and forces
  double energy() const;             ///< J
  double largest_force() const;      ///< N, largest net force on a particle
  double force_unit() const;         ///< N, stiffness (J) over the mean diameter
  /// Returns true if no net force on a particle exceeds minimize.force_tolerance, in force_unit().
  bool at_rest() const;
  /// Returns the particles at the positions of the present iteration, unwrapped, in the order of the scene.
  Bodies bodies() const;
  /// Returns contacts, coordination and pressure of the present packing.
  const analysis::Packing& packing();

  /// Returns the number of iterations so far, which takes the place of the time of other motions.
  double time() const override { return static_cast<double>(iteration()); }
  std::string time_unit() const override { return "1"; }
  /// Returns the number of the iteration of the next frame, at most minimize.max_iterations. It is the next multiple of
  /// minimize.record_every. If that is 0, frames are at the powers of sqrt(2), rounded.
  double next_frame() const override;
  /// Returns infinity, because the number of iterations to rest is unknown.
  double end_time() const override { return INFINITY; }
  /// Iterates until the number of the iteration is `iteration`, the minimization has finished or `pause` returns true.
  void advance_to(double iteration, const std::function<bool()>& pause) override;
  /// Returns true at rest, after minimize.max_iterations, or if the energy cannot decrease.
  bool finished() override;
  bool exact_anywhere() const override { return true; }

  Frame frame() override;
  std::string progress() override;
  /// Returns minus the logarithm of the largest force in force_unit(), which grows at a roughly steady rate, and its
  /// value for minimize.force_tolerance.
  ProgressMeasure progress_measure() override;
  Checkpoint checkpoint() override;
  void restore(const Checkpoint& checkpoint) override;

  /// Returns energy (J) and largest force (N) by iteration, recorded since the last call. Intervals between records
  /// increase with the number of iterations. The last iteration of a finished minimization is recorded too.
  ColumnGroup take_history() override;
  /// Returns properties of the present packing: contacts, coordination, rattlers and pressure (analysis::Packing).
  std::vector<ColumnGroup> findings() override;
  Summary summary() override;
  std::map<std::string, double> seconds() const override;

 private:
  void record_history();
  double most_iterations() const;
  double force_in_units() const { return largest_force() / force_unit(); }

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
