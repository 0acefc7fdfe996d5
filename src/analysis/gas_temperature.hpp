#pragma once

#include <cmath>

#include "src/model/bodies.hpp"

namespace lichtenberg::analysis {

/// Granular temperature: variance of a velocity component times mass (G 2.12), m0 v0^2.
struct GranularTemperature {
  /// Temperature relative to the mean velocity of a cell, mass-weighted: T = sum_c sum_i m_i (v_i - V_c)^2 / (d sum_c
  /// (n_c - 1)). This is unbiased (G 4.3 divides by n_c, so that isolated grains have T = 0). NaN if no cell has two
  /// grains.
  double local = NAN;
  double total = 0;  ///< total temperature, including flow: <m v^2> / d
};

constexpr double temperature_edge = 5;  ///< d0, edge of the cells

GranularTemperature granular_temperature(const Bodies& bodies, double edge = temperature_edge);

}  // namespace lichtenberg::analysis
