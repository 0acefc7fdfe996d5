#pragma once

#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "solvers/geometry/vec.hpp"

namespace lichtenberg::analysis {

/// A straight line in double logarithmic coordinates, fitted by least squares.
struct PowerLaw {
  double exponent = 0;
  /// Of the exponent, from the scatter of the points about the line. Counts at neighbouring scales are not independent,
  /// and curvature is no scatter: the true uncertainty is larger.
  double standard_error = 0;
  double from = 0, to = 0;  ///< the range of scales of the fit
  int points = 0;
};

/// y ~ x^exponent for positive x and y, at least three of each.
PowerLaw fit_power_law(std::span<const double> x, std::span<const double> y);

/// A straight piece of a drawn tree, from one end to the other.
using Segment = std::pair<Vec2, Vec2>;

/// Box-counting dimension of the lines: boxes of side s that any of them enters ~ s^-D, for s from `from` to `to` in
/// steps of 2^(1/4); at each s the least number over sixteen positions of the boxes. Empty if that is not even a factor
/// of two.
std::optional<PowerLaw> box_counting_dimension(std::span<const Segment> line, double from, double to);

/// Mass-radius dimension of the points, averaged over all of them as centres (the correlation dimension of Grassberger
/// and Procaccia 1983): mean number of other points within r ~ r^D, for r from `from` to `to` in steps of 2^(1/4).
/// Empty if that is not even a factor of two, or if there is no pair within `from`. Every point's neighbourhood counts,
/// so it does not matter where and how large the ground is; towards the edge of the structure neighbours are missing,
/// which makes D smaller.
std::optional<PowerLaw> mass_radius_dimension(std::span<const Vec2> point, double from, double to);

}  // namespace lichtenberg::analysis
