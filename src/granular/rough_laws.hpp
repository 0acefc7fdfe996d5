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

/// Laws of the contacts of a gas of rough grains: those between grains, and those with walls. A contact with a side of
/// the domain is the pair of a grain and the number N + side. Reduced units.
template <class Law>
class RoughLaws {
 public:
  RoughLaws(const Law& law, const Law& at_walls, const SurfaceLaw& surface)
      : grains_{law, surface.friction, surface.adhesion},
        walls_{at_walls, surface.friction, surface.adhesion},
        surface_(surface) {
    if (std::ranges::all_of(surface.materials, is_usual)) surface_.materials.clear();
    if (surface.walls && surface.walls->friction) walls_.friction.coefficient = *surface.walls->friction;
  }

  const SurfaceLaw& surface() const { return surface_; }
  const RoughContactLaw<Law>& of(const Bodies& bodies, Pair pair) const {
    return pair.j < bodies.size() ? grains_ : walls_;
  }
  /// Returns the constants of a contact. Two materials act like springs in series, each with its own viscous time. A
  /// wall counts as a grain of infinite radius of the scene's material.
  RoughPair constants(const Bodies& b, Pair pair) const {
    const auto [i, j] = pair;
    const double ri = b.radius[i], inertia = b.inertia.empty() ? 0 : b.inertia[i];
    RoughPair of{walls_.normal.scale(2 * ri, 2 * ri), 1, ri, inertia};  // the effective radius is R_i
    if (j < b.size()) {
      const double rj = b.radius[j], other = b.inertia.empty() ? 1 : b.inertia[j];
      of = {grains_.normal.scale(ri, rj), 1, ri * rj / (ri + rj), inertia * other / (inertia + other)};
    }
    if (surface_.materials.empty()) return of;
    const GrainMaterial a = surface_.materials[i], c = j < b.size() ? surface_.materials[j] : GrainMaterial{};
    const double compliance = 1 / a.stiffness + 1 / c.stiffness;
    of.scale *= 2 / compliance;
    of.damping = (a.damping / a.stiffness + c.damping / c.stiffness) / compliance;
    return of;
  }
  /// Returns an open contact with this elongation of its spring.
  RoughOpen opened(const Bodies& bodies, const GrainContact& contact, Vec3 spring = {}) const {
    RoughOpen one{.contact = contact, .constants = constants(bodies, contact.pair), .spring = {.elongation = spring}};
    one.last_overlap = of(bodies, contact.pair).last_overlap(one.constants);
    const bool is_plain = surface_.adhesion.model == AdhesionModel::none && surface_.materials.empty();
    if (!is_plain) one.contact.alone = false;  // its restitution is not that of the law
    return one;
  }
  /// Returns the stored energy of a contact with this overlap and elongation of its spring.
  double energy(const Bodies& bodies, Pair pair, double overlap, Vec3 spring) const {
    const RoughContactLaw<Law>& law = of(bodies, pair);
    const NormalContact now = law.normal_contact(constants(bodies, pair), overlap, 0);
    return now.stored + 0.5 * law.friction.stiffness_ratio * now.slope * norm2(spring);
  }

  /// Returns the time that substeps must resolve (RoughMotion::time_to_resolve).
  double time_to_resolve(double impact, const GrainProperties& grains) const {
    double most = 1;  // factor of the law for the stiffest and most damped material
    for (const GrainMaterial& one : surface_.materials)
      most = std::max(most, one.stiffness * std::max(1.0, one.damping));
    double time = granular::time_to_resolve(grains_.normal.times(most), impact, grains);
    if (surface_.walls) time = std::min(time, granular::time_to_resolve(walls_.normal.times(most), impact, grains));
    return std::min(time / tangential_rate(), adhesive_time(grains));
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
    const RoughPair pair{grains_.normal.scale(grains.smallest, grains.smallest), 1, 0.5 * grains.smallest, 0};
    const auto force = [&](double overlap) { return grains_.normal_contact(pair, overlap, 0).force; };
    double low = 0, high = 2 * grains.smallest;
    for (int k = 0; k < 60; ++k) {
      const double middle = 0.5 * (low + high);
      (force(middle) < 0 ? low : high) = middle;
    }
    const double part = 1e-4 * high;
    return std::numbers::pi * std::sqrt(0.5 * grains.lightest * part / (force(high + part) - force(high)));
  }

  RoughContactLaw<Law> grains_, walls_;
  SurfaceLaw surface_;
};

}  // namespace lichtenberg::granular
