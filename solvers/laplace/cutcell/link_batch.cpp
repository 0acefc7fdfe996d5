#include "solvers/laplace/cutcell/link_batch.hpp"

#include <cmath>

#include "solvers/laplace/cutcell/link.hpp"

namespace lichtenberg::laplace {

namespace {

/// Returns 1 + z/3 + z^2/5 + ..., which is atanh(sqrt z) / sqrt z, and atan(sqrt -z) / sqrt -z for negative z. Eighteen
/// terms have an error below 1e-16 up to |z| = .15, the largest value for a link.
double odd_series(double z) {
  double sum = 1.0 / 35;
#pragma GCC unroll 17
  for (int k = 16; k >= 0; --k) sum = sum * z + 1.0 / (2 * k + 1);
  return sum;
}

}  // namespace

BatchConductances log_fitted_links(const LinkBatch& links) {
  BatchConductances c;
#pragma GCC ivdep
  for (int k = 0; k < LinkBatch::width; ++k) {
    const double x = links.x[k], y = links.y[k], ex = links.ex[k], ey = links.ey[k];
    const double ax = x + 0.5 * (ex - ey), ay = y + 0.5 * (ey + ex);  // ends of the face
    const double bx = x + 0.5 * (ex + ey), by = y + 0.5 * (ey - ex);
    // a x b is positive, because the face is nearer to the disk's centre than the fluid cell is; a - b is normal to e.
    const double across = -(x * ex + y * ey + 0.5), along = ax * bx + ay * by;
    // Two halvings by tan(u/2) = tan u / (1 + sqrt(1 + tan^2 u)) shorten the series.
    const double half = across / (std::sqrt(across * across + along * along) + along);
    const double quarter = half / (1 + std::sqrt(1 + half * half));
    const double eighth = quarter / (1 + std::sqrt(1 + quarter * quarter));
    const double theta = 8 * eighth * odd_series(-eighth * eighth);
    const double r2 = x * x + y * y, distance = std::sqrt(r2), sum = distance + links.radius[k];
    const double w = (r2 - links.radius2[k]) / (sum * sum);  // ln(r/R) = 2 atanh(w)
    const double log_ratio = at_least(2 * w * odd_series(w * w), smallest_cut / distance);
    const double inverse = 1 / log_ratio, value = theta * inverse;
    const double a2 = ax * ax + ay * ay, b2 = bx * bx + by * by, product = inverse / (a2 * b2 * r2);
    const double weight_a = b2 * r2 * product, weight_b = a2 * r2 * product, weight_r = value * a2 * b2 * product;
    c.value[k] = value;
    c.gradient_x[k] = weight_b * by - weight_a * ay + weight_r * x;
    c.gradient_y[k] = weight_a * ax - weight_b * bx + weight_r * y;
  }
  return c;
}

}  // namespace lichtenberg::laplace
