#pragma once

#include <Eigen/Core>
#include <memory>

#include "solvers/laplace/multipole/far_field.hpp"
#include "solvers/laplace/multipole/setting.hpp"

namespace lichtenberg::laplace::multipole {

/// Solution of the multipole method with all data from which the potential at any point follows.
struct SolutionData {
  std::unique_ptr<Setting> setting;
  std::unique_ptr<FarField> far;        ///< Far field with the cells' local expansions
  std::vector<Complex> coefficients;    ///< Multipole coefficients of all sources (V), in the setting's layout
  Eigen::VectorXd extra;                ///< Unknowns other than multipoles
  std::vector<double> group_potential;  ///< Potential of each group (V)
  double level = 0;                     ///< Constant (V) added to the potential of sources and walls
};

/// Potential at a point, and the body that contains the point.
struct PointPotential {
  double value = 0;  ///< V
  int body = -1;     ///< Body that contains the point; -1: none
};

/// Computes the potential at the point z = x + i y (m) from a solution. Inside a body it is the potential of the body's
/// group. Multipoles that contribute less than `accuracy` times their coefficient are neglected.
PointPotential potential_at(Complex z, const SolutionData& solved, double accuracy);

}  // namespace lichtenberg::laplace::multipole
