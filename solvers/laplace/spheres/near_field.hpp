#pragma once

#include <span>
#include <vector>

#include "solvers/laplace/spheres/images.hpp"
#include "solvers/laplace/spheres/translation.hpp"
#include "solvers/parallel/team.hpp"

namespace lichtenberg::laplace::spheres {

/// Of harmonics: a sphere has 40401 of them then, and equal ones at contact take 85 for 1e-10.
inline constexpr int largest_degree = 200;

/// What has harmonics about its centre: a sphere with its degree, or a point at which a field is wanted (degree 1, and
/// any length as its radius).
struct Site {
  Vec3 centre;
  double radius = 0;
  int degree = 0;
};

/// Where the coefficients of each site, to its degree and `beyond` degrees more, stand in one array.
std::vector<int> starts(const std::vector<Site>& sites, int beyond = 0);

/// A source, or an image of one, that acts on a target one by one.
struct NearPair {
  int target = 0, source = 0, mask = 0;
  double sign = 1;
  Vec3 way;  ///< from the source (its image) to the target
};

/// Fields of near sources, one by one: exact but for the degrees. About a target of radius R the field is sum b_lm
/// (r/R)^l C_lm, a source's a_lm (R/r)^(l+1) C_lm.
class NearField {
 public:
  /// `pairs` by ascending target. Terms below `accuracy` times the largest coefficient are left out at a distance.
  NearField(const std::vector<Site>& targets, const std::vector<Site>& sources, const std::vector<NearPair>& pairs,
            double accuracy, parallel::Team& team);

  /// Adds to the targets' local coefficients what the sources' multipoles make there.
  void add(const double* multipoles, double* local, parallel::Team& team) const;
  /// Does so for eight fields at once, [harmonic][field].
  void add(const Lanes* multipoles, Lanes* local, parallel::Team& team) const;

 private:
  struct Batch {
    int source_degree = 0, target_degree = 0, mask = 0, count = 0;
    Ways ways;
    std::array<int, lanes> target{}, source{};
    Lanes sign{}, source_factor{}, target_factor{};  ///< sign R_s/d, 2 R_s/d, 2 R_t/d; 0 in lanes that are empty
  };
  std::vector<Batch> batches(std::span<const NearPair> pairs, const std::vector<Site>& targets,
                             const std::vector<Site>& sources, double accuracy) const;
  void add_to_batch(Batch& batch, const NearPair& pair, const Site& target, const Site& source) const;
  void add_batch(const Batch& batch, const double* multipoles, double* local, Lanes* value, Lanes* scratch) const;
  void add_pair(const Batch& batch, int pair, const Lanes* multipoles, Lanes* local, Lanes* value,
                Lanes* scratch) const;

  std::vector<int> target_start_, source_start_;
  std::vector<std::vector<Batch>> chunks_;  ///< by targets, so that no two threads add to one
  int largest_degree_ = 0;
  std::vector<double> signs_;  ///< [mask][harmonic]: mirror_sign
  std::shared_ptr<const Translation> translation_;
};

/// Tables of translations up to a degree at least, shared by all that need them.
std::shared_ptr<const Translation> translation_up_to(int degree);

}  // namespace lichtenberg::laplace::spheres
