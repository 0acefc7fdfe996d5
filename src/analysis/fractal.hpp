#pragma once

#include <optional>
#include <span>
#include <utility>

#include "solvers/geometry/vec.hpp"

namespace lichtenberg::analysis {

/// A fitted power law y ~ x^exponent: a straight line in double logarithmic coordinates by least squares.
struct PowerLaw {
  double exponent = 0;
  /// Standard error of the exponent, from the scatter of the points about the line. The true uncertainty is larger,
  /// because counts at neighbouring scales are correlated and the points can follow a curve.
  double standard_error = 0;
  double from = 0, to = 0;  ///< range of scales of the fit
  int points = 0;
};

/// Fits a power law y ~ x^exponent by least squares in logarithms. `x`, `y`: at least three positive values each, of
/// equal number.
PowerLaw fit_power_law(std::span<const double> x, std::span<const double> y);

/// A straight line segment in the plane, given by its ends: an edge of a tree.
using Segment = std::pair<Vec2, Vec2>;

/// Computes the box-counting dimension D of line segments: the number of square boxes of side s that contain part of a
/// line is ~ s^-D. s goes from `from` to `to` in equal ratios of about 2^(1/4). At each s the smallest number over
/// sixteen positions of the boxes is used. Empty if `to` is less than twice `from`, and without segments.
std::optional<PowerLaw> box_counting_dimension(std::span<const Segment> line, double from, double to);

/// Computes the mass-radius dimension D of points, averaged over all points as centres (the correlation dimension of
/// Grassberger and Procaccia 1983). The mean number of other points within r is ~ r^D, for r from `from` to `to` in
/// equal ratios of about 2^(1/4). Empty if `to` is less than twice `from`, or if there is no pair within `from`.
///
/// Every point's neighbourhood counts, so that position and size of the ground have no influence. Towards the edge of
/// the structure neighbours are missing, which reduces D.
std::optional<PowerLaw> mass_radius_dimension(std::span<const Vec2> point, double from, double to);

}  // namespace lichtenberg::analysis
