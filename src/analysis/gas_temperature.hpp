#pragma once

#include <cmath>

#include "src/model/bodies.hpp"

namespace lichtenberg::analysis {

/// Granular temperature: variance of a velocity component times mass (G 2.12), in m0 v0^2.
struct GranularTemperature {
  /// Temperature relative to the mean velocity V_c of each cell c, mass-weighted:
  /// T = sum_c sum_i m_i (v_i - V_c)^2 / (d sum_c (n_c - 1)), with n_c grains in a cell and d dimensions. This is
  /// unbiased (G 4.3 divides by n_c, so that isolated grains have T = 0). NaN if no cell has two grains.
  double local = NAN;
  double total = 0;  ///< total temperature, including flow: <m v^2> / d
};

constexpr double temperature_edge = 5;  ///< d0, edge of the cells

/// Computes the granular temperature, relative to the flow in cells of about this edge (d0), and in total.
GranularTemperature granular_temperature(const Bodies& bodies, double edge = temperature_edge);

}  // namespace lichtenberg::analysis
