#include "solvers/laplace/multipole/potential.hpp"

namespace lichtenberg::laplace::multipole {

namespace {

/// Returns the potential at displacement d from the centre of a source's image.
double image_potential(const Source& source, const Image& image, const Complex* a, Complex d, double accuracy) {
  const Complex ratio = source.radius / d;
  Complex power = 1;
  double sum = -image.sign * a[0].real() * std::log(std::abs(d));
  for (int k = 1; k <= source.order && std::norm(power) > accuracy * accuracy; ++k) {
    power = multiply(power, ratio);
    sum += multiply(image.coefficient(k, a[k]), power).real();
  }
  return sum;
}

/// Returns the potential of all sources that are not near z's cell.
double far_potential(Complex z, const Cells& cells, const FarField& far) {
  const int cell = cells.cell_of(z);
  const Complex step = (z - cells.centre(cell)) / far.scale();
  const Complex* beta = far.local(cell);
  Complex power = 1;
  double sum = 0;
  for (int m = 0; m <= far.order(); ++m) {
    sum += multiply(beta[m], power).real();
    power = multiply(power, step) / (m + 1.0);
  }
  return sum;
}

}  // namespace

PointPotential potential_at(Complex z, const SolutionData& solved, double accuracy) {
  const Setting& setting = *solved.setting;
  const Arrangement& arrangement = setting.arrangement;
  PointPotential point;
  const auto add = [&](int s, const Image& image, Complex shift) {
    const Source& source = arrangement.sources[s];
    const Complex d = z - image.centre(source.centre) - shift;
    if (std::abs(d) < source.radius) point.body = s;
    const Complex* a = &solved.coefficients[setting.layout.start[s]];
    point.value += image_potential(source, image, a, d, accuracy);
  };
  if (setting.mirrors.bounded || arrangement.cells.contains(z)) {
    point.value = far_potential(z, arrangement.cells, *solved.far);
    arrangement.cells.for_each_near(z, add);
  } else {
    for (int s = 0; s < setting.layout.sources(); ++s) add(s, Image{}, 0);
  }
  point.value += solved.level + setting.wall.potential(z);
  if (point.body >= 0) point.value = solved.group_potential[setting.problem.bodies[point.body].group];
  return point;
}

}  // namespace lichtenberg::laplace::multipole
