#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>

#include "src/granular/pace.hpp"
#include "src/granular/pair_state.hpp"
#include "src/granular/rough_sides.hpp"
#include "src/model/grain_contact.hpp"
#include "src/model/rough_contact.hpp"

namespace lichtenberg::granular {

/// An open contact of two grains, or of a grain and a side (pair.j = N + side).
struct RoughOpen {
  GrainContact contact;
  RoughPair constants;
  double last_overlap = 0;  ///< overlap at which it ends
  int i = -1, j = -1;       ///< indices of its active grains; j = -1: side
  TangentialSpring spring;
  SurfaceForces now;   ///< at the last instant
  double overlap = 0;  ///< at the last instant
  bool fresh = false;  ///< it began in this substep
  bool open = true;
};

/// Laws of the contacts between grains and with walls. For the host and for a device. Reduced units.
template <class Law>
struct RoughLawPair {
  RoughContactLaw<Law> grains, walls;

  /// Returns the constants of a contact of two grains. Their moments of inertia are 0 if grains do not rotate.
  LICHTENBERG_HOST_DEVICE RoughPair between(double ri, double rj, double inertia, double other_inertia) const {
    const double sum = inertia + other_inertia;
    return {grains.normal.scale(ri, rj), 1, ri * rj / (ri + rj), sum > 0 ? inertia * other_inertia / sum : 0};
  }
  /// Returns the constants of a contact with a wall, which counts as a grain of infinite radius.
  LICHTENBERG_HOST_DEVICE RoughPair at_wall(double radius, double inertia) const {
    return {walls.normal.scale(2 * radius, 2 * radius), 1, radius, inertia};  // the effective radius is R_i
  }
  /// Changes the constants for the materials of the two partners. They act like springs in series, each with its own
  /// viscous time. Walls have the scene's material.
  LICHTENBERG_HOST_DEVICE static void set_materials(const GrainMaterial& a, const GrainMaterial& b, RoughPair& of) {
    const double compliance = 1 / a.stiffness + 1 / b.stiffness;
    of.scale *= 2 / compliance;
    of.damping = (a.damping / a.stiffness + b.damping / b.stiffness) / compliance;
  }
};

/// Time that substeps of rough grains must resolve. For the host and for a device. Reduced units.
template <class Law>
struct RoughPace {
  Law grains, walls;           ///< laws of the stiffest and most damped material
  double tangential_rate = 1;  ///< of tangential over normal motion, at least 1
  double adhesive_time = INFINITY;

  /// Returns the time for impact speeds up to `impact` (RoughMotion::time_to_resolve).
  LICHTENBERG_HOST_DEVICE double time_to_resolve(double impact, const GrainProperties& properties) const {
    const double between = granular::time_to_resolve(grains, impact, properties),
                 at_walls = granular::time_to_resolve(walls, impact, properties);
    const double time = (at_walls < between ? at_walls : between) / tangential_rate;
    return adhesive_time < time ? adhesive_time : time;
  }
};

/// Returns the normal law of contacts with walls. `law`: that of two grains.
template <class Law>
Law law_at_walls(const Law& law, const SurfaceLaw& surface) {
  Law wall = law;
  auto& [stiffness, damping] = wall;
  if (surface.walls && surface.walls->stiffness) stiffness = *surface.walls->stiffness;
  if (surface.walls && surface.walls->damping) damping = *surface.walls->damping;
  return wall;
}

/// Laws of the contacts of a gas of rough grains: those between grains, and those with walls. A contact with a side of
/// the domain is the pair of a grain and the number N + side. Reduced units.
template <class Law>
class RoughLaws {
 public:
  RoughLaws(const Law& law, const SurfaceLaw& surface)
      : pair_{{law, surface.friction, surface.adhesion},
              {law_at_walls(law, surface), surface.friction, surface.adhesion}},
        surface_(surface) {
    if (std::ranges::all_of(surface.materials, is_usual)) surface_.materials.clear();
    if (surface.walls && surface.walls->friction) pair_.walls.friction.coefficient = *surface.walls->friction;
  }

  const SurfaceLaw& surface() const { return surface_; }
  const RoughLawPair<Law>& pair() const { return pair_; }
  /// Returns true if the restitution of contacts is that of the normal law.
  bool is_plain() const { return surface_.adhesion.model == AdhesionModel::none && surface_.materials.empty(); }
  const RoughContactLaw<Law>& of(const Bodies& bodies, Pair pair) const {
    return pair.j < bodies.size() ? pair_.grains : pair_.walls;
  }
  /// Returns the constants of a contact.
  RoughPair constants(const Bodies& b, Pair pair) const {
    const auto [i, j] = pair;
    const auto inertia = [&](int k) { return b.inertia.empty() ? 0 : b.inertia[k]; };
    const bool at_wall = j >= b.size();
    RoughPair of = at_wall ? pair_.at_wall(b.radius[i], inertia(i))
                           : pair_.between(b.radius[i], b.radius[j], inertia(i), inertia(j));
    if (!surface_.materials.empty())
      RoughLawPair<Law>::set_materials(surface_.materials[i], at_wall ? GrainMaterial{} : surface_.materials[j], of);
    return of;
  }
  /// Returns an open contact with this elongation of its spring.
  RoughOpen opened(const Bodies& bodies, const GrainContact& contact, Vec3 spring = {}) const {
    RoughOpen one{.contact = contact, .constants = constants(bodies, contact.pair), .spring = {.elongation = spring}};
    one.last_overlap = of(bodies, contact.pair).last_overlap(one.constants);
    if (!is_plain()) one.contact.alone = false;  // its restitution is not that of the law
    return one;
  }
  /// Returns the stored energy of a contact with this overlap and elongation of its spring.
  double energy(const Bodies& bodies, Pair pair, double overlap, Vec3 spring) const {
    return of(bodies, pair).energy(constants(bodies, pair), overlap, spring);
  }

  /// Returns the time that substeps must resolve for these grains.
  RoughPace<Law> pace(const GrainProperties& properties) const {
    double most = 1;  // factor of the law for the stiffest and most damped material
    for (const GrainMaterial& one : surface_.materials)
      most = std::max(most, one.stiffness * std::max(1.0, one.damping));
    const Law &grains = pair_.grains.normal, &walls = surface_.walls ? pair_.walls.normal : grains;
    return {grains.times(most), walls.times(most), tangential_rate(), adhesive_time(properties)};
  }

 private:
  static bool is_usual(const GrainMaterial& one) { return one.stiffness == 1 && one.damping == 1; }
  /// Returns the larger of the frequency and the damping rate of the tangential motion of a sticking contact over those
  /// of the normal motion, at least 1. The effective mass of the tangential motion is m_eff / (1 + m R^2 / I).
  double tangential_rate() const {
    if (!(surface_.inertia > 0)) return 1;
    const double lighter = 1 + 1 / surface_.inertia;
    return std::max(
        {1.0, std::sqrt(surface_.friction.stiffness_ratio * lighter), surface_.friction.damping_ratio * lighter});
  }
  /// Returns half the period of the oscillation of the two lightest grains that adhesion binds; infinite without it.
  double adhesive_time(const GrainProperties& grains) const {
    if (surface_.adhesion.model == AdhesionModel::none || !(surface_.adhesion.work > 0)) return INFINITY;
    const RoughPair pair{pair_.grains.normal.scale(grains.smallest, grains.smallest), 1, 0.5 * grains.smallest, 0};
    const auto force = [&](double overlap) { return pair_.grains.normal_contact(pair, overlap, 0).force; };
    double low = 0, high = 2 * grains.smallest;
    for (int k = 0; k < 60; ++k) {
      const double middle = 0.5 * (low + high);
      (force(middle) < 0 ? low : high) = middle;
    }
    const double part = 1e-4 * high;
    return std::numbers::pi * std::sqrt(0.5 * grains.lightest * part / (force(high + part) - force(high)));
  }

  RoughLawPair<Law> pair_;
  SurfaceLaw surface_;
};

}  // namespace lichtenberg::granular
