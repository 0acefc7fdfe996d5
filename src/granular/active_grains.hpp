#pragma once

#include <span>
#include <vector>

#include "src/model/bodies.hpp"

namespace lichtenberg::granular {

/// Grain that moves in substeps because it is in contact or may come into contact. Reduced units; vectors of two
/// dimensions have z = 0.
struct ActiveGrain {
  int grain = 0, slot = 0;  ///< indices in the bodies and in the order of cells
  double per_mass = 1, per_inertia = 0, radius = 0.5;
  Vec3 position, velocity, spin;            ///< spin: angular velocity
  Vec3 start;                               ///< velocity at the beginning
  Vec3 slow;                                ///< acceleration by slow forces, which is constant
  Vec3 force, torque;                       ///< of all contacts at the last instant
  Vec3 impulse, angular_impulse;            ///< corrections at the ends of contacts in a substep
  Vec3 predicted_velocity, predicted_spin;  ///< at the end of a substep
  int contacts = 0;
};

/// Grains of a gas during several substeps: free ones move on parabolas under constant forces, active ones in substeps.
/// A grain becomes active at the beginning of a substep and remains so. Grains are numbered by slots, their order in
/// cells, so that near grains are close in memory.
class ActiveGrains {
 public:
  /// State of a free grain at the beginning.
  struct Flight {
    Vec3 position, velocity, acceleration;
    double radius = 0;
  };

  /// Begins at the state of the bodies, with all grains free. `slow_force`: constant forces, [N * d] or empty; `h`:
  /// substep (t0); `grains`: grain of each slot; `slots`: slot of each grain. All must outlive the calls up to
  /// finish().
  void begin(const Bodies& bodies, std::span<const double> slow_force, double h, std::span<const int> grains,
             std::span<const int> slots);
  int slot_of(int grain) const { return slots_[grain]; }
  int grain_in(int slot) const { return grains_[slot]; }
  /// Returns the index of the grain in a slot among the active ones; -1: free.
  int index_of(int slot) const { return index_[slot]; }
  /// Makes a free grain active at the beginning of substep n. Returns its index.
  int activate(int slot, int n);
  /// Returns the position of a grain after n substeps; of an active one its present position.
  Vec3 position(int slot, int n) const {
    if (index_[slot] >= 0) return active_[index_[slot]].position;
    const double t = n * h_;
    const Flight& flight = flight_[slot];
    return flight.position + t * (flight.velocity + 0.5 * t * flight.acceleration);
  }
  const Flight& flight(int slot) const { return flight_[slot]; }
  std::vector<ActiveGrain>& active() { return active_; }
  const std::vector<ActiveGrain>& active() const { return active_; }
  /// Writes the state after n substeps into the bodies. Returns the work of the slow forces.
  double finish(Bodies& bodies, int n);

 private:
  const Bodies* bodies_ = nullptr;
  std::span<const double> slow_force_;
  std::span<const int> grains_, slots_;
  double h_ = 0;
  std::vector<Flight> flight_;  ///< by slot
  std::vector<int> index_;      ///< by slot
  std::vector<ActiveGrain> active_;
};

}  // namespace lichtenberg::granular
