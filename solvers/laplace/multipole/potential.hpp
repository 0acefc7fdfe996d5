#pragma once

#include <Eigen/Core>
#include <memory>

#include "solvers/laplace/multipole/far_field.hpp"
#include "solvers/laplace/multipole/setting.hpp"

namespace lichtenberg::laplace::multipole {

/// Solution, with all data that determine the potential.
struct SolutionData {
  std::unique_ptr<Setting> setting;
  std::unique_ptr<FarField> far;  ///< Far field with the cells' local fields
  std::vector<Complex> coefficients;
  Eigen::VectorXd extra;  ///< Unknowns other than multipoles
  std::vector<double> group_potential;
  double level = 0;  ///< Potential level (V), added to the field of sources and walls
};

struct PointPotential {
  double value = 0;  ///< V
  int body = -1;     ///< Body that contains the point; -1: none
};

/// Computes the potential at z; neglects multipoles that contribute less than `accuracy` of their coefficient.
PointPotential potential_at(Complex z, const SolutionData& solved, double accuracy);

}  // namespace lichtenberg::laplace::multipole
