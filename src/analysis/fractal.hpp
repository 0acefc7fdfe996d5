#pragma once

#include <optional>
#include <span>
#include <utility>

#include "solvers/geometry/vec.hpp"

namespace lichtenberg::analysis {

/// A straight line in double logarithmic coordinates, fitted by least squares.
struct PowerLaw {
  double exponent = 0;
  /// Standard error of the exponent, from the scatter of the points about the line. Counts at neighbouring scales are
  /// correlated, and curvature is not scatter, so the true uncertainty is larger.
  double standard_error = 0;
  double from = 0, to = 0;  ///< range of scales of the fit
  int points = 0;
};

/// Fits y ~ x^exponent to positive x and y, at least three of each.
PowerLaw fit_power_law(std::span<const double> x, std::span<const double> y);

/// A straight line of a drawn tree, given by its ends.
using Segment = std::pair<Vec2, Vec2>;

/// Returns the box-counting dimension D of the lines: the number of boxes of side s that contain part of a line is ~
/// s^-D. s goes from `from` to `to` in steps of 2^(1/4). At each s the smallest number over sixteen positions of the
/// boxes is used. Empty if `to` is less than twice `from`.
std::optional<PowerLaw> box_counting_dimension(std::span<const Segment> line, double from, double to);

/// Returns the mass-radius dimension D of the points, averaged over all points as centres (the correlation dimension of
/// Grassberger and Procaccia 1983). The mean number of other points within r is ~ r^D, for r from `from` to `to` in
/// steps of 2^(1/4). Empty if `to` is less than twice `from`, or if there is no pair within `from`.
///
/// Every point's neighbourhood counts, so position and size of the ground have no influence. Towards the edge of the
/// structure neighbours are missing, which reduces D.
std::optional<PowerLaw> mass_radius_dimension(std::span<const Vec2> point, double from, double to);

}  // namespace lichtenberg::analysis
