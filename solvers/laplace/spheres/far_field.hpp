#pragma once

#include "solvers/laplace/spheres/lattice.hpp"
#include "solvers/laplace/spheres/near_field.hpp"

namespace lichtenberg::laplace::spheres {

/// Images that a far field includes, and the parameters of their sum.
struct FarImages {
  double beyond = 0;  ///< Distance (length) below which images are excluded; 0: all images
  int degree = 0;     ///< Degree of the derivatives: sum of a source's l and a target's t
  EwaldSplit split;
};

/// Returns the parameters for images beyond a range, which must be several times the largest radii of targets and
/// sources (lengths).
FarImages images_beyond(double range, double target_radius, double source_radius, double accuracy);
/// Returns the parameters for all images of sources up to `degree`, at targets of one degree more.
FarImages all_images(const Mirrors& mirrors, double largest_radius, int degree, double accuracy);

/// Fields of images, computed for each pair of source and target.
class FarField {
 public:
  /// Computes the derivatives between all sites. `past`: earlier field whose tables are used again if possible.
  FarField(const Mirrors& mirrors, const std::vector<Site>& targets, const std::vector<Site>& sources,
           const FarImages& images, const FarField* past = nullptr);
  /// Adds to the targets' local coefficients, which extend `beyond` degrees above the targets' own. `T`: double, or
  /// Lanes for eight fields at once.
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
