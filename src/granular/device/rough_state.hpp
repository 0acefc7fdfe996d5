#pragma once

// State of rough grains on an executor, in addition to GasState. It is loaded from a checkpoint of Gas and stored to
// one.

#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include "src/granular/device/rough_steps.hpp"
#include "src/granular/device/state.hpp"

namespace lichtenberg::granular::device {

/// Data of a rough grain that move with it when grains are sorted again.
struct RoughGrain {
  Vec3 spin;
  double inertia = 0;
  unsigned at_walls = 0, unused = 0;
};

/// State of the rough grains of a gas on an executor (CPU or CUDA device): rotation, contacts with walls, and laws.
/// Reduced units.
template <class Executor>
class RoughOn {
  template <class T>
  using Array = parallel::Array<T, Executor>;

 public:
  explicit RoughOn(const Executor& run) : run_(&run) {}

  /// Loads the state from a checkpoint of Gas. `law`: that of the grains on a device; `gas`: the other state, loaded
  /// before.
  void load(const Checkpoint& checkpoint, const SurfaceLaw& surface, const LawOnDevice& law,
            const GasState<Executor>& gas) {
    law_ = law.law;
    n_ = gas.n;
    RoughView& view = arrays_.view;
    arrays_.resize(n_, view.spin, view.inertia, view.at_walls, view.predicted_velocity, view.predicted_spin);
    arrays_.resize(n_, view.torque, view.angular_impulse, view.touched);
    arrays_.zero(view.torque, view.angular_impulse, view.touched, view.predicted_velocity, view.predicted_spin);
    spare_.resize(n_);
    load_rotation(checkpoint, surface, gas.options);
    load_walls(checkpoint, surface.walls.has_value(), gas);
    materials_.upload(law.materials);
    view.material = materials_.size() > 0 ? materials_.data() : nullptr;
    const double length = std::exp2(std::ceil(std::log2(gas.largest_radius)));
    view.torque_unit = length * gas.units.force, view.angular_unit = length * gas.units.impulse;
  }

  const AnyRoughLaw& law() const { return law_; }
  const RoughView& view() const { return arrays_.view; }

  /// Copies the state of a gas that a checkpoint needs to host memory. `springs`: elongations of the springs of its
  /// contacts of two grains.
  std::shared_ptr<const RoughSnapshot> snapshot(const GrainsView& grains, std::vector<Vec3> springs) const {
    auto taken = std::make_shared<RoughSnapshot>();
    taken->springs = std::move(springs);
    taken->rotates = rotates_;
    list_records(grains);
    taken->grains = records_.download();
    list_walls(*taken);
    return taken;
  }

  // Public because nvcc requires it of functions with kernels.

  /// Sorts the data of the grains again, as GasState::permute().
  void permute(const int* order) {
    RoughGrain* to = spare_.data();
    const RoughView all = view();
    run_->for_each(n_, [=] LICHTENBERG_HOST_DEVICE(int s) {
      const int i = order[s];
      to[s] = {all.spin[i], all.inertia[i], all.at_walls[i], 0};
    });
    run_->for_each(n_, [=] LICHTENBERG_HOST_DEVICE(int s) {
      all.spin[s] = to[s].spin, all.inertia[s] = to[s].inertia, all.at_walls[s] = to[s].at_walls;
    });
  }
  /// Lists rotation and contacts with walls of the grains in the order of the scene.
  void list_records(const GrainsView& grains) const {
    records_.resize(n_);
    RoughRecord* to = records_.data();
    const RoughView all = view();
    run_->for_each(n_, [=] LICHTENBERG_HOST_DEVICE(int s) {
      to[grains.number[s]] = {all.spin[s], all.at_walls[s], 0};
    });
  }
  /// Adds the contacts with walls to a snapshot that has its grains, in the order of grains and sides.
  void list_walls(RoughSnapshot& to) const {
    const RoughView all = view();
    const int walls = all.walls.count();
    for (int i = 0; i < static_cast<int>(to.grains.size()); ++i)
      for (int k = 0; k < walls; ++k)
        if (to.grains[i].at_walls >> k & 1) to.walls.push_back({i, all.walls.side(k), k, 0});
    if (to.walls.empty()) return;
    wall_records_.upload(to.walls);
    WallRecord* record = wall_records_.data();
    run_->for_each(static_cast<long>(to.walls.size()), [=] LICHTENBERG_HOST_DEVICE(int w) {
      WallRecord& one = record[w];
      const long index = static_cast<long>(one.grain) * walls + one.wall;
      one.since = all.wall_since[index], one.impact_speed = all.wall_speed[index], one.spring = all.wall_spring[index];
    });
    to.walls = wall_records_.download();
  }

 private:
  template <class T>
  void upload(T* to, const std::vector<T>& values) {
    if (!values.empty()) run_->to_device(to, values.data(), values.size() * sizeof(T));
  }
  void load_rotation(const Checkpoint& checkpoint, const SurfaceLaw& surface, const GasOptions& options) {
    rotates_ = surface.inertia > 0;
    std::vector<Vec3> spin(n_);
    std::vector<double> inertia(n_);
    if (rotates_) {
      const std::vector<double>& saved = reals(checkpoint, "angular_velocity", 3 * static_cast<std::size_t>(n_));
      for (int i = 0; i < n_; ++i) {
        spin[i] = {saved[3 * i], saved[3 * i + 1], saved[3 * i + 2]};
        inertia[i] = surface.inertia * options.mass[i] * options.radius[i] * options.radius[i];
      }
    }
    upload(view().spin, spin);
    upload(view().inertia, inertia);
  }
  void load_walls(const Checkpoint& checkpoint, bool walled, const GasState<Executor>& gas) {
    Bodies box;
    box.box = gas.box, box.dimension = 3;
    RoughView& view = arrays_.view;
    view.walls = RoughSides(box, walled);
    const int walls = view.walls.count();
    const std::size_t all = static_cast<std::size_t>(n_) * walls;
    std::vector<unsigned> at_walls(n_);
    std::vector<double> since(all), speed(all);
    std::vector<Vec3> spring(all);
    const std::vector<std::int64_t>& pairs = integers(checkpoint, "wall_contacts");
    const std::vector<double>& data = reals(checkpoint, "wall_springs", pairs.size() / 2 * 5);
    for (std::size_t c = 0; 2 * c + 1 < pairs.size(); ++c)
      for (int k = 0; k < walls; ++k) {
        if (view.walls.side(k) != pairs[2 * c + 1] - n_) continue;
        const std::size_t index = pairs[2 * c] * walls + k;
        const double* of = &data[5 * c];
        at_walls[pairs[2 * c]] |= 1u << k;
        since[index] = of[0], speed[index] = of[1], spring[index] = {of[2], of[3], of[4]};
      }
    upload(view.at_walls, at_walls);
    if (walls == 0) return;
    arrays_.resize(all, view.wall_since, view.wall_speed, view.wall_spring, view.wall_state);
    upload(view.wall_since, since), upload(view.wall_speed, speed), upload(view.wall_spring, spring);
  }

  const Executor* run_;
  int n_ = 0;
  bool rotates_ = false;
  AnyRoughLaw law_;
  parallel::Arrays<RoughView, Executor> arrays_{*run_};
  Array<GrainMaterial> materials_{*run_};  ///< by number in the scene; empty: all have the scene's material
  mutable Array<RoughGrain> spare_{*run_};
  mutable Array<RoughRecord> records_{*run_};
  mutable Array<WallRecord> wall_records_{*run_};
};

}  // namespace lichtenberg::granular::device
