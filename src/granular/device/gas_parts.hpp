#pragma once

// Data types of a gas on an executor, in reduced units.

#include <cmath>
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

/// Options of a gas on a device.
struct GasOptions : effects::DeviceForces {
  Vec3 lengths;
  std::vector<double> mass, radius;  ///< [N]
  double step = 0;                   ///< t0, largest; infinite: follows from `max_path`
  double max_path = 0;               ///< d0, largest path of the fastest grain in a step
  ContactAttraction attraction;
  int contact_steps = 1;
  std::uint64_t seed = 0;
  std::string path;
  std::optional<periodic::device::MeshTables> tables;  ///< of `mesh`
};

/// Returns a position in fixed-point units of the box lengths; `units_per_length`: units per d0.
LICHTENBERG_HOST_DEVICE inline FixedPointPosition fixed_point_position(Vec3 position, Vec3 units_per_length) {
  return {fixed_point_coordinate(position.x, units_per_length.x),
          fixed_point_coordinate(position.y, units_per_length.y),
          fixed_point_coordinate(position.z, units_per_length.z)};
}

/// Returns the options for a scene that check_scene accepts.
GasOptions gas_options(const Scene& scene);
/// Throws Failure, with the number of grains that would fit, if a device with `free` bytes lacks memory for a gas.
void check_memory(const GasOptions& options, double free);

/// Step maxima over all grains.
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

/// Maximum of one quantity.
struct MaxReduction {
  double value = 0;

  LICHTENBERG_HOST_DEVICE MaxReduction& operator+=(const MaxReduction& o) {
    value = StepMaxima::larger(value, o.value);
    return *this;
  }
  friend LICHTENBERG_HOST_DEVICE MaxReduction operator+(MaxReduction a, const MaxReduction& b) { return a += b; }
};

/// Data of a grain that sorting moves.
struct Grain {
  Vec3 position, momentum;
  double charge = 0, inverse_mass = 0, radius = 0;
  std::int64_t collisions = 0, dissipated = 0;
  PointCharge charged;
  FieldSample field_at_source;
  ImageCount image;
  int number = 0;
};

/// Field energy (m0 v0^2), and the part of it from charge exchange.
struct FieldEnergyBudget {
  double energy = 0, exchanged = 0;
  double scale = 1;           ///< factor of PointCharge::charge
  double largest_charge = 0;  ///< magnitude
};

/// Smooth forces on grains: by charges, or charges with dipoles, and by pair laws.
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

  LICHTENBERG_HOST_DEVICE Vec3 operator()(int s) const {
    return pair_force ? charge_force(s) + pair_force[s].times(units.force) : charge_force(s);
  }
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
  LICHTENBERG_HOST_DEVICE double energy() const {
    const double pair_sum = pair_energy ? units.energy * static_cast<double>(*pair_energy) : 0;
    if (!field_at_source) return pair_sum;
    return pair_sum + strength / (budget->scale * budget->scale) *
                          (totals->energy + 0.5 * background * totals->charge * totals->charge);
  }
};

}  // namespace lichtenberg::granular::device
