#pragma once

#include <span>
#include <vector>

#include "solvers/laplace/spheres/images.hpp"
#include "solvers/laplace/spheres/translation.hpp"
#include "solvers/parallel/team.hpp"

namespace lichtenberg::laplace::spheres {

/// Largest degree l of solid harmonics on a sphere, for which it has 40401 coefficients. Equal spheres in contact need
/// degree 85 for an accuracy of 1e-10.
inline constexpr int largest_degree = 200;

/// Site: the centre of an expansion in solid harmonics. It is a sphere with its radius (m) and degree, or a point at
/// which a field is computed (degree 1, any length as its radius).
struct Site {
  Vec3 centre;
  double radius = 0;
  int degree = 0;
};

/// Returns the index of the first coefficient of each site in an array of all coefficients [site][harmonic], followed
/// by the total size. A site has the harmonics up to its degree plus `beyond`.
std::vector<int> starts(const std::vector<Site>& sites, int beyond = 0);

/// Near pair: a target site, and a near source site or its mirror image, whose field is computed directly.
struct NearPair {
  /// Indices of target and source; axes along which the source is mirrored (bits x, y, z).
  int target = 0, source = 0, mask = 0;
  double sign = 1;    ///< Sign of the image's charge
  Vec3 displacement;  ///< Displacement from the source (or its image) to the target (m)
};

/// Near field of multipoles: translates the multipoles of near sources to local expansions at targets, pair by pair,
/// exact up to the truncation of degrees. A source of radius R has the potential sum a_lm (R/r)^(l+1) C_lm. About a
/// target of radius R the potential is sum b_lm (r/R)^l C_lm. C_lm are solid harmonics (harmonics.hpp).
class NearField {
 public:
  /// Sorts the pairs into batches of equal degrees for SIMD. `pairs` must be sorted by target. Terms below about
  /// `accuracy` times the largest coefficient are neglected.
  NearField(const std::vector<Site>& targets, const std::vector<Site>& sources, const std::vector<NearPair>& pairs,
            double accuracy, parallel::Team& team);

  /// Adds the fields of the sources with `multipoles` a_lm (V) to the targets' `local` coefficients b_lm (V); both
  /// arrays are [site][harmonic].
  void add(const double* multipoles, double* local, parallel::Team& team) const;
  /// Adds the fields of the sources to the targets' `local` coefficients (V) for eight sets of `multipoles` (V) at
  /// once. Each array element contains the eight values of a coefficient.
  void add(const Lanes* multipoles, Lanes* local, parallel::Team& team) const;

 private:
  class DegreesByDistance;
  /// Up to eight pairs of equal degrees and mirrors.
  struct Batch {
    int source_degree = 0, target_degree = 0, mask = 0, count = 0;
    PairDirections directions;
    std::array<int, lanes> target{}, source{};
    Lanes sign{}, source_factor{}, target_factor{};  ///< sign R_s/d, 2 R_s/d, 2 R_t/d; 0 in empty lanes
  };
  std::vector<Batch> batches(std::span<const NearPair> pairs, const std::vector<Site>& targets,
                             const std::vector<Site>& sources, const DegreesByDistance& degrees) const;
  static void complete(Batch& batch);
  void add_to_batch(Batch& batch, const NearPair& pair, const Site& target, const Site& source) const;
  void add_batch(const Batch& batch, const double* multipoles, double* local, Lanes* value, Lanes* scratch) const;
  void add_pair(const Batch& batch, int pair, const Lanes* multipoles, Lanes* local, Lanes* value,
                Lanes* scratch) const;

  std::vector<int> target_start_, source_start_;
  std::vector<std::vector<Batch>> chunks_;  ///< Batches by targets, so that no two threads add to one target
  int largest_degree_ = 0;
  std::vector<double> signs_;  ///< Layout [mask][harmonic]: mirror_sign
  std::shared_ptr<const Translation> translation_;
};

/// Returns the translation tables that all solvers share, for this degree or a higher one.
std::shared_ptr<const Translation> translation_up_to(int degree);

}  // namespace lichtenberg::laplace::spheres
