#include "solvers/laplace/spheres/images.hpp"

namespace lichtenberg::laplace::spheres {
namespace {

struct AxisImage {
  bool mirrored = false;
  double shift = 0, sign = 1;
};

std::vector<AxisImage> images_along(const SphereProblem& problem, int axis, double& period, bool& alternates) {
  const double length = problem.box.lengths[axis];
  const auto sign = [&](int side) { return problem.box.sides[2 * axis + side] == Boundary::electrode ? -1.0 : 1.0; };
  period = length;
  if (problem.box.periodic(axis)) return {{}};
  alternates = sign(0) != sign(1);
  period = alternates ? 4 * length : 2 * length;
  if (!alternates) return {{}, {true, 0, sign(0)}};
  return {{}, {true, 0, sign(0)}, {false, 2 * length, -1}, {true, 2 * length, -sign(0)}};
}

}  // namespace

Mirrors::Mirrors(const SphereProblem& problem) : bounded(!problem.free_space) {
  if (!bounded) {
    images = {{}};
    return;
  }
  std::array<std::vector<AxisImage>, 3> along;
  for (int k = 0; k < 3; ++k) {
    double length = 0;
    along[k] = images_along(problem, k, length, alternates[k]);
    period[k] = length;
  }
  for (const AxisImage& x : along[0])
    for (const AxisImage& y : along[1])
      for (const AxisImage& z : along[2])
        images.push_back({(x.mirrored ? 1 : 0) + (y.mirrored ? 2 : 0) + (z.mirrored ? 4 : 0),
                          {x.shift, y.shift, z.shift},
                          x.sign * y.sign * z.sign});
}

}  // namespace lichtenberg::laplace::spheres
