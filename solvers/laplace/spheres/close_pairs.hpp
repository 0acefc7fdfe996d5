#pragma once

#include "solvers/laplace/spheres/near_field.hpp"

namespace lichtenberg::laplace::spheres {

/// Bispherical coordinate alpha of sphere `radius` beside another one: harmonics fall off like exp(-alpha l). `gap`
/// (m) between the surfaces.
double bispherical_coordinate(double radius, double other, double gap);
/// cosh(alpha) - 1 of the same.
double cosh_less_one(double radius, double other, double gap);

/// The share of an accuracy that is left to a solution where a gap is so narrow, 1 from a thirtieth of the
/// smaller radius up: a force there goes like the square of a potential difference over the gap (README.md).
double narrowness(double radius, double other, double gap);

/// Two spheres alone with equal and opposite charges and a potential difference of 1: the axial multipoles of the one
/// of `radius` (m = 0 about the way to the other), l = 0, 1, ... up to the degree, and its potential. By image charges:
/// every charge mirrored at the other sphere, until `accuracy` is left.
struct PairSolution {
  std::vector<double> multipoles;
  double potential = 0;
};
std::array<PairSolution, 2> pair_solution(double radius, double other, double gap, int degree, double accuracy);

/// Of one sphere at a gap whose sides have different potentials: what harmonics beyond its degree there are for a unit
/// of the pair's amplitude, and the potential that those of both make on it.
struct Tail {
  int sphere = 0;
  double sign = 1;                 ///< of the amplitude on this sphere
  Vec3 axis;                       ///< unit vector to the other side
  std::vector<double> multipoles;  ///< axial ones, all degrees
  std::vector<double> potential;   ///< harmonics up to the sphere's degree, on it
  bool faces_image = false;        ///< the other side is an image, at centre + axis * distance
  std::vector<double> facing;      ///< axial multipoles of the other side, for its amplitude
  double facing_radius = 0, distance = 0;
  int facing_degree = 0;
};

/// A gap between different potentials. The spheres' own harmonics end where those of a pair at one potential do; what
/// the difference drives into the gap beyond them has one unknown amplitude, and is the exact pair's.
struct ClosePair {
  /// What the tails make on a sphere beside them that is not at the gap: harmonics up to its degree.
  struct Elsewhere {
    int sphere = 0;
    std::vector<double> potential;
  };
  /// With the tails of another pair.
  struct Meeting {
    int pair = 0;
    double energy = 0;  ///< over 2 pi eps, for a unit of both amplitudes
  };

  std::vector<Tail> tails;  ///< two, or one beside an electrode
  double energy = 0;        ///< of the tails with each other, over 2 pi eps, for a unit of amplitude
  std::vector<Elsewhere> elsewhere;
  std::vector<Meeting> meetings;
};

/// `gaps`: the pairs, each in one direction. Adds nothing where the sphere's harmonics are enough. Throws Failure for a
/// gap that takes too long.
std::vector<ClosePair> close_pairs(const std::vector<Site>& sites, const std::vector<NearPair>& gaps, double accuracy,
                                   parallel::Team& team = parallel::Team::single());

/// What tails do beyond their own gap, `elsewhere` and `meetings`: tails of one sphere ring all round it. `pairs`: all
/// that are near, in both directions.
void let_tails_meet(std::vector<ClosePair>& close, const std::vector<Site>& sites, const std::vector<NearPair>& pairs,
                    double accuracy, parallel::Team& team);

/// Over 4 pi eps: of the tail with its amplitude, and of it and the multipoles up to the degree.
Vec3 tail_force(const Tail& tail, double amplitude, int degree, const double* multipoles);

/// Of one sphere's tail on another one of its own: what both together have beyond what each has alone, for a unit of
/// both amplitudes and over 4 pi eps.
Vec3 force_between(const Tail& one, const Tail& other, int degree);

/// Potential and field of a tail and, if it faces an image, of that one's.
void add_tail(const Tail& tail, const Site& site, double amplitude, Vec3 point, double& potential, Vec3& field);

}  // namespace lichtenberg::laplace::spheres
