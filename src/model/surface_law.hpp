#pragma once

#include <optional>
#include <vector>

#include "src/scene/grain_material.hpp"

namespace lichtenberg {

/// Friction of two surfaces: a tangential spring with a dashpot, limited by Coulomb's law (Cundall and Strack 1979),
/// and a resistance against rolling.
struct FrictionLaw {
  double coefficient = 0;            ///< mu: largest tangential over normal force
  double stiffness_ratio = 2.0 / 7;  ///< tangential stiffness over the slope of the normal elastic force
  double damping_ratio = 2.0 / 7;    ///< tangential over normal damping coefficient
  double rolling_coefficient = 0;    ///< mu_r: largest rolling torque over normal force and effective radius
};

/// Models of adhesion: Derjaguin, Muller and Toporov 1975; Johnson, Kendall and Roberts 1971.
enum class AdhesionModel { none, dmt, jkr };

/// Adhesion of two surfaces in reduced units.
struct AdhesionLaw {
  AdhesionModel model = AdhesionModel::none;
  double work = 0;  ///< m0 v0^2/d0^2: work of adhesion w per area, twice the surface energy of one material
};

/// Constants of the contact of a grain and a flat wall that differ from those of two grains, in reduced units; empty:
/// no difference.
struct WallContact {
  std::optional<double> stiffness, damping;  ///< constants of the normal contact law (E and D, or A and B)
  std::optional<double> friction;            ///< mu
};

/// Forces at the surfaces of grains in addition to the normal contact law, in reduced units. Effects define its parts
/// (Effect::set_surface).
struct SurfaceLaw {
  double inertia = 0;  ///< moment of inertia over mass times squared radius; 0: grains do not rotate
  FrictionLaw friction;
  AdhesionLaw adhesion;
  std::optional<WallContact> walls{};      ///< empty: the sides of the domain are not walls
  std::vector<GrainMaterial> materials{};  ///< of each grain
};

}  // namespace lichtenberg
