#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "src/analysis/packing.hpp"
#include "src/statics/minimization.hpp"

namespace lichtenberg {

/// Search for the packing fraction at which a packing has a given pressure, by steps that start from the last packing.
/// The secant of the last two jammed packings gives the step. Each reversal of the direction halves its limit.
struct PressureSearch {
  double limit = 0;    ///< largest change of the packing fraction
  int direction = 0;   ///< sign of the last change
  double filling = 0;  ///< packing fraction of the last packing
  double measure = 0;  ///< its pressure to the power at which it is linear in the packing fraction; 0: not jammed
  double slope = 0;    ///< last positive slope of the measure; 0: none yet

  /// Returns the next packing fraction after one at `at` with `measured`. `target`: wanted measure.
  double next(double at, double measured, double target, double largest_step);
};

/// Quasi-static compression of a packing ([compression]): the domain changes its size in small steps, and a
/// Minimization brings the particles to rest after each. Its "time" is the number of the load (O'Hern et al., Phys.
/// Rev. E 68, 011306 (2003)).
class Compression : public Motion {
 public:
  /// Starts at the positions and the size of the scene. Throws the exceptions of Minimization.
  explicit Compression(const Scene& scene);

  /// Returns the number of finished loads.
  double time() const override { return static_cast<double>(load_); }
  std::string time_unit() const override { return "load"; }
  double next_frame() const override { return time() + 1; }
  double end_time() const override { return static_cast<double>(options().loads()); }
  /// Advances to the end of load `load`. Throws InputError if the packing fraction would exceed 1, Failure if the
  /// pressure jumps across a wanted one.
  void advance_to(double load, const std::function<bool()>& pause) override;
  bool finished() override { return time() >= end_time(); }
  bool exact_anywhere() const override { return true; }

  Frame frame() override;
  std::string progress() override;
  Checkpoint checkpoint() override;
  void restore(const Checkpoint& checkpoint) override;

  std::vector<ColumnGroup> findings() override { return minimization_->findings(); }
  Summary summary() override;
  std::map<std::string, double> seconds() const override { return {{"minimization", seconds_}}; }

  double filling() const { return filling_; }  ///< packing fraction
  /// Returns the pressure (N/m, in space Pa) on the plate, or the mean over the directions.
  double pressure();
  double jamming_fraction() const { return jamming_; }  ///< packing fraction at jamming; NaN unless it was sought
  Bodies bodies() const { return minimization_->bodies(); }

 private:
  const CompressionOptions& options() const { return scene_.compression; }
  /// Returns the packing fraction of the next minimization; empty if the packing at rest has the wanted load.
  std::optional<double> next_filling();
  std::optional<double> towards_filling(double target) const;
  std::optional<double> towards_pressure(double target);
  void minimize_at(double filling);
  bool minimize(const std::function<bool()>& pause);

  Scene scene_;  ///< positions and size at the start of the present minimization
  std::unique_ptr<Minimization> minimization_;
  double earlier_force_ = INFINITY;  ///< N, largest net force at the last check of the present minimization
  std::int64_t load_ = 0;
  double filling_ = 0, jamming_ = NAN;
  PressureSearch search_;
  std::int64_t minimizations_ = 1, not_at_rest_ = 0, evaluations_ = 0;  ///< the last two of finished minimizations
  double seconds_ = 0;
};

}  // namespace lichtenberg
