#pragma once

// Contact law of rough grains on a device: friction, adhesion and walls; state of a contact.

#include <algorithm>
#include <cmath>
#include <variant>
#include <vector>

#include "src/granular/rough_laws.hpp"
#include "src/granular/rough_motion.hpp"
#include "src/model/rough_contact.hpp"

namespace lichtenberg::granular {

/// Contact law of rough grains for a device: the normal law of two grains, and all that is not part of it. Functions of
/// smooth grains that depend on the normal law only accept it as a normal law. Reduced units.
template <class Law>
struct RoughLaw : Law {
  using Normal = Law;
  RoughLawPair<Law> surface;
  RoughPace<Law> pace;
  /// Relative speed (v0) that adhesion can give two grains of mass `lightest` at rest. Their distance changes from that
  /// of the onset of the contact to that of the equilibrium.
  double adhesive_speed = 0;
  int plain = 1;  ///< 1: the restitution is that of the normal law
};
/// True for RoughLaw.
template <class Law>
inline constexpr bool is_rough = false;
template <class Law>
inline constexpr bool is_rough<RoughLaw<Law>> = true;

/// Returns the time (t0) that substeps of rough grains must resolve.
template <class Law>
LICHTENBERG_HOST_DEVICE double time_to_resolve(const RoughLaw<Law>& law, double impact, const GrainProperties& grains) {
  return law.pace.time_to_resolve(impact, grains);
}

namespace device {

/// State of a contact of rough grains between two substeps: forces, stiffness of the tangential spring, overlap, and
/// the energy dissipated since the start of the outer step.
struct RoughContactState {
  SurfaceForces now;
  double stiffness = 0, overlap = 0, dissipated = 0;
};

using AnyRoughLaw = std::variant<RoughLaw<ViscoelasticLaw>, RoughLaw<LinearSpringLaw>>;

/// Returns the relative speed (v0) that the adhesive energy of a contact gives two grains of the smallest mass and the
/// largest radius.
template <class Law>
double adhesive_speed_of(const RoughContactLaw<Law>& law, double lightest, double largest_radius) {
  if (law.adhesion.model == AdhesionModel::none || !(law.adhesion.work > 0)) return 0;
  const RoughPair pair{law.normal.scale(largest_radius, largest_radius), 1, 0.5 * largest_radius, 0};
  double low = 0, high = 2 * largest_radius;
  for (int k = 0; k < 60; ++k) {
    const double middle = 0.5 * (low + high);
    (law.normal_contact(pair, middle, 0).force < 0 ? low : high) = middle;
  }
  return std::sqrt(2 * std::max(0.0, -law.normal_contact(pair, high, 0).stored) / (0.5 * lightest));
}

/// Returns the ratio of the largest forces with walls and materials to those of two grains of the scene's material.
/// Fixed-point sums must hold them.
template <class Law>
double largest_force_ratio(const RoughLaws<Law>& laws, double largest_radius) {
  const auto most_of = [&](const Law& law, double radius) {
    const ContactParts parts = law.parts(largest_radius, law.scale(radius, radius));
    return parts.elastic + 100 * parts.damping;
  };
  const Law &grains = laws.pair().grains.normal, &walls = laws.pair().walls.normal;
  double material = 1;
  for (const GrainMaterial& one : laws.surface().materials)
    material = std::max(material, 2 * one.stiffness * std::max(1.0, one.damping));
  const double two = most_of(grains, largest_radius);
  return material * std::max(1.0, laws.surface().walls ? most_of(walls, 2 * largest_radius) / two : 0);
}

/// Law of rough grains on a device, with data on the host.
struct LawOnDevice {
  AnyRoughLaw law;
  std::vector<GrainMaterial> materials;  ///< of each grain; empty: all have the scene's material
  double force_ratio = 1;                ///< largest_force_ratio()
};

/// Returns the law on a device for grains of these properties. `with`: normal law of two grains.
inline LawOnDevice rough_law(const GrainContactLaw& with, const SurfaceLaw& surface, const GrainProperties& properties,
                             double largest_radius) {
  return std::visit(
      [&]<class Law>(const Law& one) -> LawOnDevice {
        const RoughLaws<Law> laws(one, surface);
        double softest = 1;
        for (const GrainMaterial& material : laws.surface().materials) softest = std::min(softest, material.stiffness);
        RoughContactLaw<Law> soft = laws.pair().grains;
        soft.normal = soft.normal.times(softest);
        const double speed = adhesive_speed_of(soft, properties.lightest, largest_radius);
        return {RoughLaw<Law>{one, laws.pair(), laws.pace(properties), speed, laws.is_plain()},
                laws.surface().materials, largest_force_ratio(laws, largest_radius)};
      },
      with);
}

}  // namespace device
}  // namespace lichtenberg::granular
