#include "solvers/minimize/newton_cg.hpp"

#include <algorithm>
#include <cmath>

#include "solvers/minimize/vectors.hpp"

namespace lichtenberg::minimize {

NewtonCg::NewtonCg(SmoothObjective& objective, std::vector<double> x, double largest_move, double gradient_unit)
    : Minimizer(objective, std::move(x)),
      smooth_(objective),
      largest_move_(largest_move),
      gradient_unit_(gradient_unit),
      next_(point_) {}

/// Minimizes the quadratic model (Steihaug 1983). Norms in M follow from products that CG computes anyway (Conn, Gould
/// & Toint 2000, section 7.5.1).
NewtonCg::Step NewtonCg::solve_model() {
  const std::size_t n = point_.x.size();
  std::vector<double> r = point_.gradient, z(n), p(n), hp(n);
  smooth_.precondition(r, z);
  double rz = shared_dot(objective_, r, z);
  if (radius_ == 0) radius_ = std::sqrt(rz) * std::min(1.0, largest_move_ / largest(z));
  for (std::size_t i = 0; i < n; ++i) p[i] = -z[i];
  const double first = std::sqrt(rz);
  // Loose tolerance: more accuracy is useless far from the minimum, and near it beyond the requested digits.
  const double goal = first * std::clamp(std::sqrt(largest(point_.gradient) / gradient_unit_), 0.1, 0.3);
  Step step{std::vector<double>(n)};
  double ss = 0, sp = 0, pp = rz;  // Products s'Ms, s'Mp, p'Mp
  constexpr int most = 2000;
  for (int k = 0; k < most && std::sqrt(rz) > goal; ++k) {
    smooth_.multiply(p, hp);
    ++products_;
    const double curvature = shared_dot(objective_, p, hp);
    const double to_edge = (-sp + std::sqrt(sp * sp + pp * (radius_ * radius_ - ss))) / pp;
    const double length = curvature > 0 ? rz / curvature : to_edge;
    step.to_edge = length >= to_edge;
    const double taken = std::min(length, to_edge);
    step.predicted_decrease += taken * (rz - 0.5 * taken * curvature);
    share_blocks(objective_, n, [&](int, std::size_t from, std::size_t end) {
      for (std::size_t i = from; i < end; ++i) step.move[i] += taken * p[i], r[i] += taken * hp[i];
    });
    if (step.to_edge) break;
    ss += 2 * taken * sp + taken * taken * pp;
    smooth_.precondition(r, z);
    const double before = rz;
    rz = shared_dot(objective_, r, z);
    const double turn = rz / before;
    share_blocks(objective_, n, [&](int, std::size_t from, std::size_t end) {
      for (std::size_t i = from; i < end; ++i) p[i] = turn * p[i] - z[i];
    });
    sp = turn * (sp + taken * pp);
    pp = rz + turn * turn * pp;
  }
  return step;
}

/// Returns the decrease of the value. If it is below the value's rounding, it follows from the slopes at both ends.
double NewtonCg::gain(const Step& step) const {
  if (!std::isfinite(next_.value)) return -INFINITY;
  if (step.predicted_decrease > 1e-9 * std::abs(point_.value)) return point_.value - next_.value;
  return -0.5 * (dot(point_.gradient, step.move) + dot(next_.gradient, step.move));
}

bool NewtonCg::iterate() {
  constexpr int most_tries = 60;
  smooth_.linearize(point_.x);
  for (int attempt = 0; attempt < most_tries; ++attempt) {
    const Step step = solve_model();
    if (!(step.predicted_decrease > 0)) return false;
    for (std::size_t i = 0; i < step.move.size(); ++i) next_.x[i] = point_.x[i] + step.move[i];
    evaluate(next_);
    const double kept = gain(step) / step.predicted_decrease;
    if (kept < 0.25)
      radius_ *= 0.25;
    else if (kept > 0.75 && step.to_edge)
      radius_ *= 2;
    if (kept < 0.05) continue;
    std::swap(point_, next_);
    return true;
  }
  return false;
}

}  // namespace lichtenberg::minimize
