#pragma once

// Data types of a gas on an executor, in reduced units.

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "solvers/periodic/device/charges.hpp"
#include "src/effects/device_forces.hpp"
#include "src/granular/device/snapshot.hpp"
#include "src/scene/contact_attraction.hpp"
#include "src/scene/scene.hpp"

namespace lichtenberg::granular::device {

using periodic::device::ChargeSums;
using periodic::device::FieldSample;
using periodic::device::PointCharge;
using periodic::device::Totals;

/// Parameters of a gas of grains on a device, in reduced units: forces, box, grains, limits of steps and seed.
struct GasOptions : effects::DeviceForces {
  Vec3 lengths;                      ///< box lengths (d0)
  std::array<Boundary, 6> sides{};   ///< periodic, or walls
  bool rough = false;                ///< grains have friction, adhesion, walls or several materials
  std::vector<double> mass, radius;  ///< [N]
  double step = 0;                   ///< largest outer step (t0); infinite: follows from `max_path`
  double max_path = 0;               ///< largest path of the fastest grain in an outer step (d0)
  ContactAttraction attraction;
  int contact_steps = 1;  ///< contact substeps in the shortest contact
  std::uint64_t seed = 0;
  std::string path;                                    ///< path of the scene, for error messages
  std::optional<periodic::device::MeshTables> tables;  ///< tables of the particle mesh `mesh`
};

/// Converts a position (d0) to fixed-point fractions of the box lengths; `units_per_length`: 2^32 / length for each
/// axis.
LICHTENBERG_HOST_DEVICE inline FixedPointPosition fixed_point_position(Vec3 position, Vec3 units_per_length) {
  return {fixed_point_coordinate(position.x, units_per_length.x),
          fixed_point_coordinate(position.y, units_per_length.y),
          fixed_point_coordinate(position.z, units_per_length.z)};
}

/// Computes the tables of the mesh for an unbounded cloud of charges. `extents`: the largest extents of the cloud (d0)
/// for which it is used, except for growth in a step.
periodic::device::MeshTables cloud_tables(const GasOptions& options, Vec3 extents);
/// Returns the parameters of a gas for a scene that check_scene() accepts.
GasOptions gas_options(const Scene& scene);
/// Throws Failure if a device with `free` bytes of free memory lacks memory for a gas. The message has the number of
/// grains that would fit.
void check_memory(const GasOptions& options, double free);

/// Returns the quanta of fixed-point sums of pair forces and energies: powers of two, about 2^-44 of the largest
/// force and energy of a pair. Sums may be 2^18 times as large as the largest value.
inline PairUnits units_of(const std::vector<std::unique_ptr<DevicePart>>& parts) {
  PairUnits most{0, 0};
  for (const auto& part : parts) {
    const PairUnits size = part->size();
    most.force = std::max(most.force, std::abs(size.force)), most.energy = std::max(most.energy, std::abs(size.energy));
  }
  const auto quantum = [](double value) {
    return value > 0 ? std::ldexp(1.0, static_cast<int>(std::ceil(std::log2(value))) - 44) : 0x1p-44;
  };
  return {quantum(most.force), quantum(most.energy)};
}

/// Maxima over all grains after an outer step, of squares and of the magnitude of the charge. Squares are those of
/// speed, acceleration by smooth forces, and displacement since the last sorting. `lost` is not 0 if a position or
/// velocity is not finite. Operator + takes the maximum of each member, for reductions.
struct StepMaxima {
  double speed2 = 0, acceleration2 = 0, moved2 = 0, charge = 0;
  int lost = 0, unused = 0;

  LICHTENBERG_HOST_DEVICE static double larger(double a, double b) { return b > a ? b : a; }
  LICHTENBERG_HOST_DEVICE StepMaxima& operator+=(const StepMaxima& o) {
    speed2 = larger(speed2, o.speed2), acceleration2 = larger(acceleration2, o.acceleration2);
    moved2 = larger(moved2, o.moved2), charge = larger(charge, o.charge);
    lost |= o.lost;
    return *this;
  }
  friend LICHTENBERG_HOST_DEVICE StepMaxima operator+(StepMaxima a, const StepMaxima& b) { return a += b; }
};

/// Number whose operator + takes the maximum, for reductions to the maximum of one quantity.
struct MaxReduction {
  double value = 0;

  LICHTENBERG_HOST_DEVICE MaxReduction& operator+=(const MaxReduction& o) {
    value = StepMaxima::larger(value, o.value);
    return *this;
  }
  friend LICHTENBERG_HOST_DEVICE MaxReduction operator+(MaxReduction a, const MaxReduction& b) { return a += b; }
};

/// Sets *to to the maximum of value(s) over the grains s = 0 ... n - 1; 0 if no value is positive.
template <class Executor, class Value>
void find_maximum(const Executor& run, int n, double* to, Value value) {
  constexpr int a_part = 256;
  run.for_each(1, [=] LICHTENBERG_HOST_DEVICE(int) { *to = 0; });
  run.sum_segments((n + a_part - 1) / a_part,
                   [=] LICHTENBERG_HOST_DEVICE(int p) { return n - p * a_part < a_part ? n - p * a_part : a_part; },
                   [=] LICHTENBERG_HOST_DEVICE(int p, int t) { return MaxReduction{value(p * a_part + t)}; },
                   [=] LICHTENBERG_HOST_DEVICE(int, MaxReduction most) { parallel::max_atomically(to, most.value); });
}

/// Data of a grain that move with it when grains are sorted again.
struct Grain {
  Vec3 position, momentum;
  double charge = 0, inverse_mass = 0, radius = 0;
  std::int64_t collisions = 0, dissipated = 0;
  PointCharge charged;
  FieldSample field_at_source;
  ImageCount image;
  int number = 0;
};

/// Energies on a device (m0 v0^2): the potential energy of smooth forces and its changes by charge exchange. Also the
/// factor that converts charges to PointCharge::charge, and the largest charge, from which the factor follows.
struct FieldEnergyBudget {
  /// Potential energy of smooth forces, and the sum of its changes by charge exchange since the start.
  double energy = 0, exchanged = 0;
  double scale = 1;           ///< PointCharge::charge over charge (1/q0)
  double largest_charge = 0;  ///< largest magnitude of a charge (q0)
};

/// Smooth forces on the grains on a device (all forces except contacts): Coulomb forces, with or without induced
/// dipoles, and forces of pair laws. Returns the force on a grain and the potential energy from the results of the
/// sums.
struct ForceView {
  const PointCharge* charges = nullptr;
  const FieldSample* field_at_source = nullptr;
  const Totals* totals = nullptr;
  const FieldEnergyBudget* budget = nullptr;
  double strength = 0, background = 0;
  const FieldSample* force = nullptr;         ///< null: no dipoles
  const FixedPointVec* pair_force = nullptr;  ///< [N], quanta; null: no pair laws
  const std::int64_t* pair_energy = nullptr;
  PairUnits units{};

  /// Returns the total smooth force on grain s (m0 v0^2/d0).
  LICHTENBERG_HOST_DEVICE Vec3 operator()(int s) const {
    return pair_force ? charge_force(s) + pair_force[s].times(units.force) : charge_force(s);
  }
  /// Returns the Coulomb force on grain s (m0 v0^2/d0). Errors of the mesh leave a net force on all grains. It is
  /// subtracted in proportion to the squared charges (with dipoles, to the squared source strengths).
  LICHTENBERG_HOST_DEVICE Vec3 charge_force(int s) const {
    if (!field_at_source || totals->square == 0) return {};
    if (force) {
      const double share = force[s].potential / totals->square, unit = strength / (budget->scale * budget->scale);
      return {unit * (force[s].x - share * totals->x), unit * (force[s].y - share * totals->y),
              unit * (force[s].z - share * totals->z)};
    }
    const double q = charges[s].charge, over = q / totals->square,
                 factor = strength * q / (budget->scale * budget->scale);
    return {factor * (field_at_source[s].x - over * totals->x), factor * (field_at_source[s].y - over * totals->y),
            factor * (field_at_source[s].z - over * totals->z)};
  }
  /// Returns the potential energy of all smooth forces (m0 v0^2).
  LICHTENBERG_HOST_DEVICE double energy() const {
    const double pair_sum = pair_energy ? units.energy * static_cast<double>(*pair_energy) : 0;
    if (!field_at_source) return pair_sum;
    return pair_sum + strength / (budget->scale * budget->scale) *
                          (totals->energy + 0.5 * background * totals->charge * totals->charge);
  }
};

}  // namespace lichtenberg::granular::device
