#pragma once

#include "solvers/laplace/spheres/near_field.hpp"

namespace lichtenberg::laplace::spheres {

/// Returns the bispherical coordinate alpha of the sphere of radius `radius` next to one of radius `other`; harmonics
/// decrease like exp(-alpha l). `gap`: distance (m) of the surfaces.
double bispherical_coordinate(double radius, double other, double gap);
/// Returns cosh(alpha) - 1 of bispherical_coordinate.
double cosh_less_one(double radius, double other, double gap);

/// Returns the factor by which a narrow gap tightens the accuracy of a solution; 1 for gaps of at least 1/30 of the
/// smaller radius. The force across the gap varies like the squared potential difference over the gap.
double narrowness(double radius, double other, double gap);

/// Solution for two isolated spheres with equal and opposite charges and a potential difference of 1, for the one of
/// `radius`. It holds the axial multipoles (m = 0 about the direction to the other), l = 0, 1, ... up to the degree,
/// and the potential. Method of images: each charge is mirrored at the other sphere until `accuracy` is reached.
struct PairSolution {
  std::vector<double> multipoles;
  double potential = 0;
};
std::array<PairSolution, 2> pair_solution(double radius, double other, double gap, int degree, double accuracy);

/// Close-pair correction (`PairCorrection`) of one sphere at a gap between different potentials. It holds the pair's
/// axial multipoles for a unit amplitude. Only those beyond the sphere's degree act. It also holds the potential on the
/// sphere due to the corrections of both sides.
struct PairCorrection {
  int sphere = 0;
  double sign = 1;                 ///< Sign of the amplitude on this sphere
  Vec3 axis;                       ///< Unit vector to the other side
  std::vector<double> multipoles;  ///< Axial multipoles of all degrees
  std::vector<double> potential;   ///< Potential on the sphere, harmonics up to its degree
  bool faces_image = false;        ///< True if the other side is an image, at centre + axis * distance
  std::vector<double> facing;      ///< Axial multipoles of the other side, for its amplitude
  double facing_radius = 0, distance = 0;
  int facing_degree = 0;
};

/// Gap between different potentials. The spheres' own harmonics end at the degree that a pair at one potential needs.
/// The potential difference excites higher ones, which have one unknown amplitude and the proportions of the exact
/// pair.
struct ClosePair {
  /// Potential of the corrections on another sphere nearby: harmonics up to its degree.
  struct OtherSphere {
    int sphere = 0;
    std::vector<double> potential;
  };
  /// Interaction with the corrections of another pair.
  struct CorrectionInteraction {
    int pair = 0;
    double energy = 0;  ///< Energy over 2 pi eps, for unit amplitudes of both
  };

  std::vector<PairCorrection> corrections;  ///< Two corrections, or one at an electrode
  double energy = 0;  ///< Energy of the corrections with each other, over 2 pi eps, for unit amplitude
  std::vector<OtherSphere> other_spheres;
  std::vector<CorrectionInteraction> interactions;
};

/// Makes close pairs for `gaps`, each pair given in one direction. Omits gaps for which the spheres' harmonics suffice.
/// Throws Failure for a gap so narrow that its correction needs a degree above 30000.
std::vector<ClosePair> close_pairs(const std::vector<Site>& sites, const std::vector<NearPair>& gaps, double accuracy,
                                   parallel::Team& team = parallel::Team::single());

/// Computes the effect of corrections beyond their own gap, `other_spheres` and `interactions`, because the corrections
/// of a sphere extend all around it. `pairs`: all near pairs, in both directions.
void add_correction_interactions(std::vector<ClosePair>& close, const std::vector<Site>& sites,
                                 const std::vector<NearPair>& pairs, double accuracy, parallel::Team& team);

/// Returns forces over 4 pi eps: of the correction with its amplitude on itself, and between it and the multipoles up
/// to the degree.
Vec3 correction_force(const PairCorrection& correction, double amplitude, int degree, const double* multipoles);

/// Returns the interaction force of two corrections of the same sphere, for unit amplitudes and over 4 pi eps.
Vec3 force_between(const PairCorrection& one, const PairCorrection& other, int degree);

/// Adds potential and field of a correction and, if it faces an image, of the image's correction.
void add_correction(const PairCorrection& correction, const Site& site, double amplitude, Vec3 point, double& potential,
                    Vec3& field);

}  // namespace lichtenberg::laplace::spheres
