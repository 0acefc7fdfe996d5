#include "validation/theory/disk_between_plates.hpp"

#include <fmt/format.h>
#include <Eigen/Dense>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "solvers/error.hpp"

namespace lichtenberg::theory {
namespace {

using std::numbers::pi;

/// Surface points: x measured from the left plate, angle from +x.
struct Circle {
  Circle(const DiskBetweenPlates& disk, double position, int n)
      : angle(Eigen::VectorXd::LinSpaced(n, 0, 2 * pi * (n - 1) / n)),
        x(0.5 * disk.distance + position + disk.radius * angle.array().cos()),
        y(disk.radius * angle.array().sin()) {}
  Eigen::VectorXd angle, x, y;
};

/// Returns the number of points. The charge density varies like the bipolar one: its coefficients decrease by exp(-u)
/// each, cosh(u) = 1 + gap/R. The last included coefficient is exp(-20) = 2e-9 of the first.
int points(const DiskBetweenPlates& disk, double x) {
  const double gap = disk.position_at_gap(std::abs(x));
  if (!(gap > 0))
    throw InputError(
        fmt::format("a disk of radius {:g} m at x = {:g} m is not between plates at -{:g} and {:g} m: a gap "
                    "greater than 0 must be left to both",
                    disk.radius, x, 0.5 * disk.distance, 0.5 * disk.distance));
  return 2 * std::max(32, static_cast<int>(std::ceil(20 / std::acosh(1 + gap / disk.radius))));
}

/// Returns the weights of the values at distance j on the circle in the integral of ln(4 sin^2(s/2)) f(s) (Kress,
/// Linear Integral Equations, sec. 12.3). `angle`: angles of the points.
Eigen::VectorXd log_weights(const Eigen::VectorXd& angle) {
  const auto n = angle.size(), half = n / 2;
  const Eigen::VectorXd cosine = angle.array().cos();
  Eigen::VectorXd weight(n);
  for (Eigen::Index j = 0; j < n; ++j) {
    double sum = (j % 2 == 0 ? 1.0 : -1.0) / static_cast<double>(n);
    for (Eigen::Index m = 1; m < half; ++m) sum += cosine[m * j % n] / static_cast<double>(m);
    weight[j] = -2 * pi / static_cast<double>(half) * sum;
  }
  return weight;
}

/// Returns the symmetric matrix from surface charge (C/m^2) to potential on the surface (V), with both plates grounded.
Eigen::MatrixXd potential_matrix(const DiskBetweenPlates& disk, const Circle& circle) {
  const auto n = circle.x.size();
  const double half_turn = pi / (2 * disk.distance), ds = 2 * pi * disk.radius / static_cast<double>(n);
  const Eigen::ArrayXd x = half_turn * circle.x, y = half_turn * circle.y;
  const Eigen::ArrayXd sin_x = x.sin(), cos_x = x.cos(), sinh_y = y.sinh(), cosh_y = y.cosh();
  const Eigen::ArrayXd chord = 2 * (0.5 * circle.angle.array()).sin();
  const Eigen::VectorXd weight = log_weights(circle.angle);
  Eigen::MatrixXd matrix(n, n);
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = 0; j <= i; ++j) {
      // |sin(a + ib)|^2 = sin^2(a) + sinh^2(b), by the addition theorems.
      const double one = sin_x[i] * cos_x[j], other = cos_x[i] * sin_x[j];
      const double b = sinh_y[i] * cosh_y[j] - cosh_y[i] * sinh_y[j];
      const double image = (one + other) * (one + other) + b * b, direct = (one - other) * (one - other) + b * b;
      // The direct kernel without its part ln 4 sin^2((t - s) / 2).
      const double smooth = i == j ? std::pow(half_turn * disk.radius, 2) : direct / (chord[i - j] * chord[i - j]);
      matrix(i, j) = matrix(j, i) =
          (ds * std::log(image / smooth) - disk.radius * weight[i - j]) / (4 * pi * disk.permittivity);
    }
  return matrix;
}

/// Surface charges due to a potential of 1 V (plates grounded) and due to the plates' voltage (disk grounded).
struct Response {
  Response(const DiskBetweenPlates& disk, double x)
      : circle(disk, x, points(disk, x)), ds(2 * pi * disk.radius / circle.x.size()) {
    const Eigen::PartialPivLU<Eigen::MatrixXd> lu(potential_matrix(disk, circle));
    held = lu.solve(Eigen::VectorXd::Ones(circle.x.size()));
    induced = lu.solve((disk.voltage * (circle.x.array() / disk.distance - 0.5)).matrix());
  }
  double capacitance() const { return held.sum() * ds; }
  DiskState state(const DiskBetweenPlates& disk, double potential) const {
    const Eigen::VectorXd sigma = induced + potential * held;
    const double push = (sigma.array().square() * circle.angle.array().cos()).sum() * ds / (2 * disk.permittivity);
    return {sigma.sum() * ds, potential, push};
  }
  Circle circle;
  double ds;
  Eigen::VectorXd held, induced;
};

}  // namespace

double charge_near_plate(const DiskBetweenPlates& disk, double gap) {
  // sqrt(h^2 - R^2) / acosh(h / R) = R sinh(u) / u, cosh(u) = h / R.
  const double u = 2 * std::asinh(std::sqrt(0.5 * gap / disk.radius));
  return 2 * pi * disk.permittivity * disk.field() * disk.radius * (u > 0 ? std::sinh(u) / u : 1);
}

double repulsion_at_plate(const DiskBetweenPlates& disk) {
  return disk.permittivity * disk.radius * disk.field() * disk.field() * (pi * pi * pi / 9 + pi / 3);
}

double line_charge_force(const DiskBetweenPlates& disk, double charge, double x) {
  return charge * disk.field() +
         charge * charge / (4 * disk.permittivity * disk.distance) * std::tan(pi * x / disk.distance);
}

DiskState with_charge(const DiskBetweenPlates& disk, double x, double charge) {
  const Response response(disk, x);
  return response.state(disk, (charge - response.induced.sum() * response.ds) / response.capacitance());
}

DiskState at_potential(const DiskBetweenPlates& disk, double x, double potential) {
  return Response(disk, x).state(disk, potential);
}

}  // namespace lichtenberg::theory
