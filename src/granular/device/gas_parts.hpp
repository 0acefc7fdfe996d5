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

using periodic::device::Charged;
using periodic::device::ChargeSums;
using periodic::device::Felt;
using periodic::device::Totals;

/// Options of a gas on a device.
struct GasOptions : effects::DeviceForces {
  Vec3 lengths;
  std::vector<double> mass, radius;  ///< [N]
  double step = 0;                   ///< t0, largest; infinite: follows from `way`
  double way = 0;                    ///< d0, largest path of the fastest grain in a step
  ContactAttraction attraction;
  int contact_steps = 1;
  std::uint64_t seed = 0;
  std::string path;
  std::optional<periodic::device::MeshTables> tables;  ///< of `mesh`
};

/// Returns a position in fixed-point units of the box lengths; `a_length`: units per d0.
LICHTENBERG_HOST_DEVICE inline Turns turns_of(Vec3 place, Vec3 a_length) {
  return {turns(place.x, a_length.x), turns(place.y, a_length.y), turns(place.z, a_length.z)};
}

/// Returns the options for a scene that check_scene accepts.
GasOptions gas_options(const Scene& scene);
/// Throws Failure, with the number of grains that would fit, if a device with `free` bytes lacks memory for a gas.
void check_room(const GasOptions& options, double free);

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
  Vec3 place, momentum;
  double charge = 0, over_mass = 0, radius = 0;
  std::int64_t collisions = 0, dissipated = 0;
  Charged charged;
  Felt felt;
  ImageCount image;
  int number = 0;
};

/// Field energy (m0 v0^2), and the part of it from charge exchange.
struct FieldBook {
  double energy = 0, exchanged = 0;
  double scale = 1;           ///< factor of Charged::charge
  double largest_charge = 0;  ///< magnitude
};

/// Smooth forces on grains: by charges, or charges with dipoles, and by pair laws.
struct ForceView {
  const Charged* charges = nullptr;
  const Felt* felt = nullptr;
  const Totals* totals = nullptr;
  const FieldBook* book = nullptr;
  double strength = 0, background = 0;
  const Felt* force = nullptr;         ///< null: no dipoles
  const WholeVec* of_pairs = nullptr;  ///< [N], quanta; null: no pair laws
  const std::int64_t* pair_energy = nullptr;
  PairQuanta quanta{};

  LICHTENBERG_HOST_DEVICE Vec3 operator()(int s) const {
    return of_pairs ? of_charges(s) + of_pairs[s].times(quanta.force) : of_charges(s);
  }
  LICHTENBERG_HOST_DEVICE Vec3 of_charges(int s) const {
    if (!felt || totals->square == 0) return {};
    if (force) {
      const double share = force[s].potential / totals->square, unit = strength / (book->scale * book->scale);
      return {unit * (force[s].x - share * totals->x), unit * (force[s].y - share * totals->y),
              unit * (force[s].z - share * totals->z)};
    }
    const double q = charges[s].charge, over = q / totals->square, factor = strength * q / (book->scale * book->scale);
    return {factor * (felt[s].x - over * totals->x), factor * (felt[s].y - over * totals->y),
            factor * (felt[s].z - over * totals->z)};
  }
  LICHTENBERG_HOST_DEVICE double energy() const {
    const double of_others = pair_energy ? quanta.energy * static_cast<double>(*pair_energy) : 0;
    if (!felt) return of_others;
    return of_others + strength / (book->scale * book->scale) *
                           (totals->energy + 0.5 * background * totals->charge * totals->charge);
  }
};

}  // namespace lichtenberg::granular::device
