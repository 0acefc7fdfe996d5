#pragma once

#include <limits>

#include "src/model/bodies.hpp"

namespace lichtenberg::analysis {

/// Variance of a component of the velocity times mass (G 2.12), m0 v0^2.
struct GranularTemperature {
  /// Of the motion relative to the mean of a cell, weighted by mass, T = sum_c sum_i m_i (v_i - V_c)^2 / (d sum_c (n_c
  /// - 1)): unbiased (G 4.3 divides by n_c, by which lone grains have T = 0). NaN if no cell has two grains.
  double local = std::numeric_limits<double>::quiet_NaN();
  double total = 0;  ///< of all motion, flow with it: <m v^2> / d
};

constexpr double temperature_edge = 5;  ///< d0, of those cells

GranularTemperature granular_temperature(const Bodies& bodies, double edge = temperature_edge);

}  // namespace lichtenberg::analysis
