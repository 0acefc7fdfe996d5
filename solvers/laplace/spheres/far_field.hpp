#pragma once

#include "solvers/laplace/spheres/lattice.hpp"
#include "solvers/laplace/spheres/near_field.hpp"

namespace lichtenberg::laplace::spheres {

/// Images that a far field sums, and the parameters of the sum.
struct FarImages {
  double beyond = 0;  ///< length: nearer images are left out; 0: none
  int degree = 0;     ///< of the derivatives: a source's l plus a target's t
  EwaldSplit split;
};

/// Images beyond a range, which is several times the largest radius of targets and of sources (lengths).
FarImages images_beyond(double range, double target_radius, double source_radius, double accuracy);
/// All images of sources up to `degree`, for targets of one degree more.
FarImages all_images(const Mirrors& mirrors, double largest_radius, int degree, double accuracy);

/// Fields of images, source by source and target by target.
class FarField {
 public:
  /// `past` may have tables that serve again.
  FarField(const Mirrors& mirrors, const std::vector<Site>& targets, const std::vector<Site>& sources,
           const FarImages& images, const FarField* past = nullptr);
  /// Adds to the targets' local coefficients, which reach `beyond` degrees above the targets' own.
  /// `T`: double, or Lanes for eight fields at once.
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
  std::vector<Eigen::MatrixXd> derivatives_;  ///< [mask]: columns [target][source]
};

}  // namespace lichtenberg::laplace::spheres
