#include "src/theory/disk_between_plates.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace lichtenberg::theory {
namespace {

using std::numbers::pi;

/// Surface points: x measured from the left plate, angle from +x.
struct Circle {
  Circle(const DiskBetweenPlates& disk, double place, int n)
      : angle(Eigen::VectorXd::LinSpaced(n, 0, 2 * pi * (n - 1) / n)),
        x(0.5 * disk.distance + place + disk.radius * angle.array().cos()),
        y(disk.radius * angle.array().sin()) {}
  Eigen::VectorXd angle, x, y;
};

/// The density varies like the bipolar one: its coefficients fall by exp(-u) each, cosh(u) = 1 + gap/R, and the last
/// one counted is exp(-20) = 2e-9 of the first.
int points(const DiskBetweenPlates& disk, double x) {
  const double gap = disk.place(std::abs(x));
  return 2 * std::max(32, static_cast<int>(std::ceil(20 / std::acosh(1 + gap / disk.radius))));
}

/// Weights of the values at distance j on the circle in the integral of ln(4 sin^2(s/2)) f(s) (Kress, Linear Integral
/// Equations, sec. 12.3).
Eigen::VectorXd log_weights(int n) {
  const int half = n / 2;
  Eigen::VectorXd weight(n);
  for (int j = 0; j < n; ++j) {
    double sum = (j % 2 == 0 ? 1.0 : -1.0) / (2.0 * half);
    for (int m = 1; m < half; ++m) sum += std::cos(2 * pi * m * j / n) / m;
    weight[j] = -2 * pi / half * sum;
  }
  return weight;
}

/// From surface charge (C/m^2) to potential on the surface (V), both plates grounded. Symmetric.
Eigen::MatrixXd potential_matrix(const DiskBetweenPlates& disk, const Circle& circle) {
  const auto n = circle.x.size();
  const double half_turn = pi / (2 * disk.distance), ds = 2 * pi * disk.radius / static_cast<double>(n);
  const auto squared_sine = [&](double x, double y) {  // |sin(half_turn (x + iy))|^2
    return std::pow(std::sin(half_turn * x), 2) + std::pow(std::sinh(half_turn * y), 2);
  };
  const Eigen::VectorXd weight = log_weights(static_cast<int>(n));
  Eigen::MatrixXd matrix(n, n);
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = 0; j <= i; ++j) {
      const double image = squared_sine(circle.x[i] + circle.x[j], circle.y[i] - circle.y[j]);
      // The direct kernel without the ln 4 sin^2((t - s) / 2) that is in it.
      const double smooth = i == j ? std::pow(half_turn * disk.radius, 2)
                                   : squared_sine(circle.x[i] - circle.x[j], circle.y[i] - circle.y[j]) /
                                         std::pow(2 * std::sin(0.5 * (circle.angle[i] - circle.angle[j])), 2);
      matrix(i, j) = matrix(j, i) =
          (ds * std::log(image / smooth) - disk.radius * weight[i - j]) / (4 * pi * disk.permittivity);
    }
  return matrix;
}

/// Surface charges that a potential of 1 V (plates grounded) and the plates' voltage (disk grounded) bring forth.
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
