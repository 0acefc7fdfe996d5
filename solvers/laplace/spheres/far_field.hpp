#pragma once

#include "solvers/laplace/spheres/lattice.hpp"
#include "solvers/laplace/spheres/near_field.hpp"

namespace lichtenberg::laplace::spheres {

/// Choice of the images in a far field, and parameters of their Ewald sum.
struct FarImages {
  double beyond = 0;  ///< Distance (m) below which images are excluded; 0: all images are included
  int degree = 0;     ///< Highest degree of the derivatives: sum of a source's l and a target's t
  EwaldSplit split;
};

/// Chooses the degree (3 to 40) and the parameters of an Ewald sum over images beyond `range`, for a relative error
/// `accuracy`. The range must be several times the largest radii of targets and sources (all in m).
FarImages images_beyond(double range, double target_radius, double source_radius, double accuracy);
/// Chooses the parameters of an Ewald sum over all images, for sources of the given degree at targets of one degree
/// more. `accuracy`: relative error; `largest_radius`: of all spheres (m).
FarImages all_images(const Mirrors& mirrors, double largest_radius, int degree, double accuracy);

/// Far field for few spheres: Ewald sum over mirror images, for each pair of source and target site.
class FarField {
 public:
  /// Computes the derivatives of the potential between all pairs of sites. `past`: earlier field whose tables are used
  /// again if possible.
  FarField(const Mirrors& mirrors, const std::vector<Site>& targets, const std::vector<Site>& sources,
           const FarImages& images, const FarField* past = nullptr);
  /// Adds the field of the sources with `multipoles` (V) to the targets' `local` coefficients (V); both arrays are
  /// [site][harmonic]. The local coefficients extend `beyond` degrees above the targets' own. `T`: double, or Lanes for
  /// eight fields at once.
  template <class T>
  void add(const T* multipoles, T* local, parallel::Team& team, int beyond = 0) const;

 private:
  void find_derivatives(int mask, bool same_sites);
  template <class T>
  void add_background(const T* multipoles, const std::vector<int>& target_start, T* local) const;

  Mirrors mirrors_;
  std::vector<Site> targets_, sources_;
  std::vector<int> source_start_, masks_;
  std::shared_ptr<const Coupling> coupling_;
  std::shared_ptr<const LatticeSum> lattice_;
  std::vector<Eigen::MatrixXd> derivatives_;  ///< Layout [mask]: columns [target][source]
};

}  // namespace lichtenberg::laplace::spheres
