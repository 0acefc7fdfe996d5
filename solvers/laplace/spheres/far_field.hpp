#pragma once

#include "solvers/laplace/spheres/lattice.hpp"
#include "solvers/laplace/spheres/near_field.hpp"

namespace lichtenberg::laplace::spheres {

/// Fields of all images beyond a range, source by source and target by target.
class FarField {
 public:
  FarField(const Mirrors& mirrors, const std::vector<Site>& targets, const std::vector<Site>& sources, double range,
           double accuracy);
  void add(const double* multipoles, double* local, parallel::Team& team) const;

 private:
  void add_background(const double* multipoles, double* local) const;

  const Mirrors* mirrors_;
  std::vector<Site> targets_, sources_;
  std::vector<int> target_start_, source_start_, masks_;
  std::shared_ptr<const Coupling> coupling_;
  std::vector<Eigen::MatrixXd> derivatives_;  ///< [mask]: columns [target][source]
};

}  // namespace lichtenberg::laplace::spheres
