#include "src/theory/disk_between_plates.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

namespace lichtenberg::theory {
namespace {

using Complex = std::complex<double>;
using std::numbers::pi;

/// Surface points: z measured from the left plate, angle from +x.
struct Circle {
  Circle(const DiskBetweenPlates& disk, double x, int n) : angle(n), z(n) {
    for (int j = 0; j < n; ++j) {
      angle[j] = 2 * pi * j / n;
      z[j] = 0.5 * disk.distance + x + disk.radius * std::polar(1.0, angle[j]);
    }
  }
  Eigen::VectorXd angle;
  Eigen::VectorXcd z;
};

/// The density varies like the bipolar one: its coefficients fall by exp(-u) each, cosh(u) = 1 + gap/R.
int points(const DiskBetweenPlates& disk, double x) {
  const double gap = disk.place(std::abs(x));
  return 2 * std::max(32, static_cast<int>(std::ceil(25 / std::acosh(1 + gap / disk.radius))));
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

/// From surface charge (C/m^2) to potential on the surface (V), both plates grounded.
Eigen::MatrixXd potential_matrix(const DiskBetweenPlates& disk, const Circle& circle) {
  const int n = static_cast<int>(circle.z.size());
  const double half_turn = pi / (2 * disk.distance);
  const Eigen::VectorXd weight = log_weights(n);
  Eigen::MatrixXd matrix(n, n);
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) {
      const Complex direct = half_turn * (circle.z[i] - circle.z[j]);
      const double image = std::log(std::abs(std::sin(half_turn * (circle.z[i] + std::conj(circle.z[j])))));
      // ln |sin(w)| without the ln |2 sin((t - s) / 2)| that is in it.
      const double smooth =
          std::log(half_turn * disk.radius) + (i == j ? 0 : std::log(std::abs(std::sin(direct) / direct)));
      matrix(i, j) =
          disk.radius / (2 * pi * disk.permittivity) * (2 * pi / n * (image - smooth) - 0.5 * weight[std::abs(i - j)]);
    }
  return matrix;
}

/// Surface charges that a potential of 1 V (plates grounded) and the plates' voltage (disk grounded) bring forth.
struct Response {
  Response(const DiskBetweenPlates& disk, double x)
      : circle(disk, x, points(disk, x)), ds(2 * pi * disk.radius / circle.z.size()) {
    const Eigen::PartialPivLU<Eigen::MatrixXd> lu(potential_matrix(disk, circle));
    held = lu.solve(Eigen::VectorXd::Ones(circle.z.size()));
    induced = lu.solve((disk.voltage * (circle.z.real().array() / disk.distance - 0.5)).matrix());
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
