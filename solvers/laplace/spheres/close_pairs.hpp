#pragma once

#include "solvers/laplace/spheres/image_charges.hpp"
#include "solvers/laplace/spheres/near_field.hpp"

namespace lichtenberg::laplace::spheres {

/// Computes the bispherical coordinate alpha of a sphere of radius `radius` next to a sphere of radius `other`, with
/// the surface distance `gap` (all in m). The multipoles of the first sphere decrease like exp(-alpha l).
double bispherical_coordinate(double radius, double other, double gap);
/// Computes cosh(alpha) - 1 for the alpha of bispherical_coordinate(), without cancellation.
double cosh_less_one(double radius, double other, double gap);

/// Computes the factor by which a narrow gap tightens the accuracy of a solution: sqrt(30 gap / smaller radius), at
/// most 1. It is needed because the force across the gap varies like the squared potential difference over the gap.
double narrowness(double radius, double other, double gap);

/// Close-pair correction of one sphere: multipoles beyond the sphere's own degree that the field in a narrow gap
/// excites (lubrication-type correction). They have the proportions of the exact solution of the isolated pair, and an
/// unknown amplitude; all data are for unit amplitude.
struct PairCorrection {
  int sphere = 0;
  double sign = 1;  ///< Sign of the amplitude on this sphere
  Vec3 axis;        ///< Unit vector to the other side of the gap
  /// Axial multipoles of all degrees, of which only those beyond the sphere's degree act.
  std::vector<double> multipoles;
  std::vector<AxialCharge> charges;  ///< Charges whose field outside the sphere is that of all multipoles
  std::vector<double> potential;     ///< Potential on the sphere due to the corrections of both sides, up to its degree
  bool faces_image = false;          ///< True if the other side is an image, at centre + axis * distance
  std::vector<double> facing;        ///< Axial multipoles of the other side, for its amplitude
  double facing_radius = 0, distance = 0;  ///< Radius of the other side; distance of the centres (m)
  int facing_degree = 0;                   ///< Degree of the other side's own harmonics
};

/// Close pair: two spheres of different potential (or a sphere and its image in an electrode) at a narrow gap, with a
/// correction for each. The spheres' own harmonics end at the degree that a pair at equal potential needs. The
/// potential difference excites higher harmonics, which share one unknown amplitude.
struct ClosePair {
  /// Potential that one correction of the pair (multipoles beyond its sphere's degree) makes on another sphere nearby.
  /// It is for unit amplitude, in harmonics up to the other sphere's degree.
  struct OtherSphere {
    int sphere = 0;
    std::vector<double> potential;
  };
  /// Contribution to the interaction with the corrections of close pair number `pair`; there may be several for one
  /// pair.
  struct CorrectionInteraction {
    int pair = 0;
    double energy = 0;  ///< Energy over 2 pi eps, for unit amplitudes of both pairs
  };

  std::vector<PairCorrection> corrections;  ///< Two corrections, or one at an electrode
  double energy = 0;  ///< Energy of the corrections with each other, over 2 pi eps, for unit amplitude
  std::vector<OtherSphere> other_spheres;
  std::vector<CorrectionInteraction> interactions;
};

/// Makes the close pairs, with their corrections, for the given gaps; each gap is given in one direction only. Gaps for
/// which the spheres' own harmonics suffice are omitted. Throws Failure for a gap so narrow that its correction needs a
/// degree above 30000.
std::vector<ClosePair> close_pairs(const std::vector<Site>& sites, const std::vector<NearPair>& gaps, double accuracy,
                                   parallel::Team& team = parallel::Team::single());

/// Computes the effects of close-pair corrections beyond their own gap, because the field of a correction extends all
/// around its sphere. Sets `other_spheres` and `interactions` of each close pair. `pairs`: all near pairs, in both
/// directions.
void add_correction_interactions(std::vector<ClosePair>& close, const std::vector<Site>& sites,
                                 const std::vector<NearPair>& pairs, double accuracy, parallel::Team& team);

/// Computes the force over 4 pi eps on a sphere due to one of its corrections. It contains the force among the
/// correction's multipoles, and the force between the correction and the sphere's own `multipoles`, which extend to
/// `degree`.
Vec3 correction_force(const PairCorrection& correction, double amplitude, int degree, const double* multipoles);

/// Computes the force over 4 pi eps on a sphere due to the interaction of two of its corrections, for unit amplitudes.
/// `degree`: degree of the sphere's own harmonics.
Vec3 force_between(const PairCorrection& one, const PairCorrection& other, int degree);

/// Adds the potential (V) and field (V/m) of a close-pair correction at a point (m) outside the spheres. If the
/// correction faces an image, the correction of the image is included. `site`: the correction's sphere; `amplitude`: in
/// V.
void add_correction(const PairCorrection& correction, const Site& site, double amplitude, Vec3 point, double& potential,
                    Vec3& field);

}  // namespace lichtenberg::laplace::spheres
