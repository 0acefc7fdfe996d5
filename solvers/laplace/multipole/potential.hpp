#pragma once

#include <Eigen/Core>
#include <memory>

#include "solvers/laplace/multipole/far_field.hpp"
#include "solvers/laplace/multipole/setting.hpp"

namespace lichtenberg::laplace::multipole {

/// A solution: everything the potential is made of.
struct Solved {
  std::unique_ptr<Setting> setting;
  std::unique_ptr<FarField> far;  ///< with the cells' local fields
  std::vector<Complex> coefficients;
  Eigen::VectorXd extra;  ///< unknowns other than multipoles
  std::vector<double> group_potential;
  double level = 0;  ///< V, to be added to the field of sources and walls
};

struct PointPotential {
  double value = 0;  ///< V
  int body = -1;     ///< that covers the point, -1: none
};

/// The potential at z, with multipoles left out that change it by less than `accuracy` of their coefficient.
PointPotential potential_at(Complex z, const Solved& solved, double accuracy);

}  // namespace lichtenberg::laplace::multipole
