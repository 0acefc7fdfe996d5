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

/// A scene with a contact potential on its way to rest, by the method that its [minimize] asks for.
class Minimization : public Motion {
 public:
  /// Throws InputError if the energy is infinite at the start, Failure if a force is.
  explicit Minimization(const Scene& scene);
  ~Minimization() override;

  /// Goes on by one iteration. False, and nothing happens, if the method finds no lower energy. Throws Failure if a
  /// force is no finite number.
  bool iterate();
  std::int64_t iteration() const;
  std::int64_t evaluations() const;  ///< of energy and forces
  double energy() const;             ///< J
  double largest_force() const;      ///< N, net, on a particle
  double force_unit() const;         ///< N: stiffness over the mean diameter
  /// No net force exceeds minimize.force_tolerance.
  bool at_rest() const;
  Bodies bodies() const;

  /// The iteration.
  double time() const override { return static_cast<double>(iteration()); }
  std::string time_unit() const override { return "1"; }
  /// A multiple of minimize.record_every, or ever farther apart.
  double next_frame() const override;
  /// Nobody knows when it comes to rest.
  double end_time() const override { return INFINITY; }
  void advance_to(double iteration, const std::function<bool()>& pause) override;
  /// At rest, or minimize.max_iterations are made, or the energy goes no lower.
  bool finished() override;
  bool exact_anywhere() const override { return true; }

  Frame frame() override;
  std::string progress() override;
  /// By the logarithm of the largest force, which falls by steady factors on the way to rest.
  Way way() override;
  Checkpoint checkpoint() override;
  void restore(const Checkpoint& checkpoint) override;

  /// Energy and largest force after iterations that are ever farther apart, and after the last.
  ColumnGroup take_history() override;
  /// What holds the particles (analysis::Packing).
  std::vector<ColumnGroup> findings() override;
  Summary summary() override;
  std::map<std::string, double> seconds() const override;

 private:
  void note();
  double most_iterations() const;
  double force_in_units() const { return largest_force() / force_unit(); }
  const analysis::Packing& packing();

  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
  struct Note {
    std::int64_t iteration = 0;
    double energy = 0;         ///< J
    double largest_force = 0;  ///< N
  };
  std::vector<Note> notes_;                   ///< since the last take_history
  std::int64_t noted_at_ = -1;                ///< iteration of the last note
  bool stuck_ = false;                        ///< the energy goes no lower
  std::optional<analysis::Packing> packing_;  ///< of the iteration packed_at_
  std::int64_t packed_at_ = -1;
  double seconds_ = 0;
};

}  // namespace lichtenberg
