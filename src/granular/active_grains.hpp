#pragma once

#include <span>
#include <vector>

#include "src/model/bodies.hpp"

namespace lichtenberg::granular {

/// Grain that moves in substeps because it is in contact or may come into contact. Reduced units; vectors of two
/// dimensions have z = 0.
struct ActiveGrain {
  int grain = 0;
  double per_mass = 1, per_inertia = 0, radius = 0.5;
  Vec3 position, velocity, spin;            ///< spin: angular velocity
  Vec3 slow;                                ///< acceleration by slow forces, which is constant
  Vec3 force, torque;                       ///< of all contacts at the last instant
  Vec3 impulse, angular_impulse;            ///< corrections at the ends of contacts in a substep
  Vec3 predicted_velocity, predicted_spin;  ///< at the end of a substep
  int contacts = 0;
};

/// Grains of a gas during several substeps: free ones move on parabolas under constant forces, active ones in substeps.
/// A grain becomes active at the beginning of a substep and remains so.
class ActiveGrains {
 public:
  /// Begins at the state of the bodies, with all grains free. `slow_force`: constant forces, [N * d] or empty; `h`:
  /// substep (t0). `bodies` must outlive all calls before finish().
  void begin(const Bodies& bodies, std::span<const double> slow_force, double h);
  /// Returns the index of a grain among the active ones; -1: free.
  int index_of(int grain) const { return index_[grain]; }
  /// Makes a free grain active at the beginning of substep n. Returns its index.
  int activate(int grain, int n);
  Vec3 position(int grain, int n) const;  ///< of any grain; for an active one its present position
  Vec3 velocity(int grain) const { return vector_at(bodies_->momentum, d_, grain) / bodies_->mass[grain]; }
  Vec3 acceleration(int grain) const;  ///< of a free grain
  std::vector<ActiveGrain>& active() { return active_; }
  const std::vector<ActiveGrain>& active() const { return active_; }
  /// Writes the state after n substeps into the bodies. Returns the work of the slow forces.
  double finish(Bodies& bodies, int n);

 private:
  const Bodies* bodies_ = nullptr;
  std::span<const double> slow_force_;
  double h_ = 0;
  int d_ = 3;
  std::vector<int> index_;
  std::vector<ActiveGrain> active_;
};

}  // namespace lichtenberg::granular
