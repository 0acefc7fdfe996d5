#pragma once

#include <span>
#include <vector>

#include "solvers/laplace/spheres/images.hpp"
#include "solvers/laplace/spheres/translation.hpp"
#include "solvers/parallel/team.hpp"

namespace lichtenberg::laplace::spheres {

/// Largest degree of harmonics. A sphere has 40401 coefficients then; equal spheres in contact need degree 85 for
/// 1e-10.
inline constexpr int largest_degree = 200;

/// Centre of an expansion in harmonics: a sphere with its degree, or a point at which a field is computed (degree 1,
/// any length as its radius).
struct Site {
  Vec3 centre;
  double radius = 0;
  int degree = 0;
};

/// Returns the start of each site's coefficients in one array, for its degree and `beyond` more, and the total size.
std::vector<int> starts(const std::vector<Site>& sites, int beyond = 0);

/// Source, or image of a source, that acts directly on a target.
struct NearPair {
  int target = 0, source = 0, mask = 0;
  double sign = 1;
  Vec3 displacement;  ///< Displacement from the source (or its image) to the target
};

/// Fields of near sources, pair by pair; exact up to the truncation of degrees. About a target of radius R the
/// potential is sum b_lm (r/R)^l C_lm, that of a source sum a_lm (R/r)^(l+1) C_lm.
class NearField {
 public:
  /// Groups the pairs into batches. `pairs`: by ascending target. Neglects distant terms below `accuracy` times the
  /// largest coefficient.
  NearField(const std::vector<Site>& targets, const std::vector<Site>& sources, const std::vector<NearPair>& pairs,
            double accuracy, parallel::Team& team);

  /// Adds the fields of the sources' multipoles to the targets' local coefficients.
  void add(const double* multipoles, double* local, parallel::Team& team) const;
  /// Adds eight fields at once, [harmonic][field].
  void add(const Lanes* multipoles, Lanes* local, parallel::Team& team) const;

 private:
  struct Batch {
    int source_degree = 0, target_degree = 0, mask = 0, count = 0;
    PairDirections directions;
    std::array<int, lanes> target{}, source{};
    Lanes sign{}, source_factor{}, target_factor{};  ///< sign R_s/d, 2 R_s/d, 2 R_t/d; 0 in empty lanes
  };
  std::vector<Batch> batches(std::span<const NearPair> pairs, const std::vector<Site>& targets,
                             const std::vector<Site>& sources, double accuracy) const;
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

/// Returns shared tables of translations up to at least this degree.
std::shared_ptr<const Translation> translation_up_to(int degree);

}  // namespace lichtenberg::laplace::spheres
