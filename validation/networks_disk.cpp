// Resistance matrix of a disk with small contacts on its rim, model "disk" of `solvers/network`. It is compared with
// elliptic functions (two contacts), with a spectral solution of Laplace's equation in the disk (any number and width),
// and with the field solver.
//
// The field solver has boxes, not disks. A resistance in the plane is invariant under conformal maps, and
//   z = integral of dt / sqrt(1 - t^4) from 0 to t
// maps the unit disk to a square. The rim points exp(i theta) at odd multiples of pi / 4 become the middles of its
// sides. An insulated box with electrodes at the middles of two or three sides is therefore a disk with as many
// contacts.

#include <Eigen/Core>
#include <cmath>
#include <numbers>

#include "solvers/laplace/cutcell/solver.hpp"
#include "solvers/network/conduction.hpp"
#include "solvers/network/resistor.hpp"
#include "tests/dense_algebra.hpp"
#include "validation/harness.hpp"
#include "validation/program.hpp"

namespace networks_disk_validation {

using namespace lichtenberg;
using namespace lichtenberg::validation;
using network::Network;
using std::numbers::pi;

namespace {

/// Unit disk of sheet resistance 1 with contacts of equal half-angle; angles in radians.
struct ContactedDisk {
  std::vector<double> at;
  double half_angle;
};

/// Returns the resistance between contacts i and j with the others open, from the conductances of all links.
double between(const Eigen::MatrixXd& links, int i, int j) {
  Network net{.nodes = static_cast<int>(links.rows())};
  for (int b = 0; b < net.nodes; ++b)
    for (int a = 0; a < b; ++a) net.links.push_back({a, b, links(a, b)});
  return 1 / network::conductance_between(net, i, j);
}

Eigen::MatrixXd model(const ContactedDisk& disk) {
  network::Particle particle{.radius = 1};
  for (const double angle : disk.at) particle.contacts.push_back({std::cos(angle), std::sin(angle), 0});
  return network::resistor_model("disk").particle({.sheet_resistance = 1, .contact_radius = std::sin(disk.half_angle)},
                                                  particle);
}

/// Returns the exact resistance of two contacts: K(1 - m) / K(m) with the cross-ratio m = (sin eps / sin(theta / 2))^2.
double elliptic(double angle, double half_angle) {
  const double k = std::sin(half_angle) / std::sin(angle / 2);
  return std::comp_ellint_1(std::sqrt(1 - k * k)) / std::comp_ellint_1(k);
}

/// Spectral solution with perfectly conducting contacts. Each carries a current density sum of c_n T_n(t) / sqrt(1 -
/// t^2), where the rim's angle from its middle is 2 asin(s t), s = sin(eps / 2). The potential, from the Neumann
/// Green's function -(1 / pi) ln |x - x'|, is equal at the collocation points of a contact. On the same contact |x -
/// x'| is 2 s |t - t'| h(t, t') with h smooth, and T_n are the eigenfunctions of the logarithm of |t - t'|.
Eigen::MatrixXd spectral(const ContactedDisk& disk, int terms) {
  const int contacts = static_cast<int>(disk.at.size()), points = 2 * terms, n = contacts * terms;
  const double s = std::sin(disk.half_angle / 2);
  const auto node = [](int k, int of) { return std::cos(pi * (k + 0.5) / of); };
  const auto angle = [&](int contact, double t) { return disk.at[contact] + 2 * std::asin(s * t); };
  const auto log_distance = [&](int i, double t, int j, double u) {
    if (i != j) return std::log(std::abs(2 * std::sin(0.5 * (angle(i, t) - angle(j, u)))));
    const double root_t = std::sqrt(1 - s * s * t * t), root_u = std::sqrt(1 - s * s * u * u);
    return std::log(2 * s * (root_u + u * s * s * (t + u) / (root_t + root_u)));
  };
  // Unknowns: all c_n, then the contacts' potentials. One column of currents per contact.
  Eigen::MatrixXd system = Eigen::MatrixXd::Zero(n + contacts, n + contacts);
  Eigen::MatrixXd currents = Eigen::MatrixXd::Zero(n + contacts, contacts);
  for (int i = 0; i < contacts; ++i) {
    for (int m = 0; m < terms; ++m) {
      const double t = node(m, terms);
      for (int j = 0; j < contacts; ++j)
        for (int k = 0; k < terms; ++k) {
          double integral = 0;
          for (int q = 0; q < points; ++q)
            integral += pi / points * log_distance(i, t, j, node(q, points)) * std::cos(k * std::acos(node(q, points)));
          if (i == j) integral += k == 0 ? -pi * std::log(2.0) : -pi / k * std::cos(k * std::acos(t));
          system(i * terms + m, j * terms + k) = -integral / pi;
        }
      system(i * terms + m, n + i) = -1;
    }
    system(n + i, i * terms) = pi;
    currents(n + i, i) = 1;
  }
  return network::links_of_terminals(solve_dense(system, currents).bottomRows(contacts));
}

/// Returns the half-angle of the contact that the map makes of a strip of half-width w at the middle of a side of
/// length 1. The rim moves by d|z| = d theta / sqrt(2 |sin 2 theta|), a whole side by K(1/2) (modulus squared).
double mapped_half_angle(double w) {
  const double target = w * std::comp_ellint_1(std::sqrt(0.5));
  const auto along = [](double eps) {  // Simpson's rule; the integrand is smooth near the middle
    const int steps = 200;
    double sum = 0;
    for (int k = 0; k <= steps; ++k)
      sum += (k == 0 || k == steps ? 1 : k % 2 == 1 ? 4 : 2) / std::sqrt(2 * std::cos(2 * eps * k / steps));
    return sum * eps / (3 * steps);
  };
  double eps = std::sqrt(2.0) * target;
  for (int k = 0; k < 20; ++k) eps -= (along(eps) - target) * std::sqrt(2 * std::cos(2 * eps));
  return eps;
}

/// Returns the same by the field solver, whose charges correspond to currents. The contacts are half-disks of radius b
/// at the middles of the left, bottom and right side of a unit box of conductivity 1. A half-disk on a straight side is
/// equivalent to a strip of half-width 2 b (z + b^2 / z), in a box up to O(b^2).
double in_box(const std::vector<int>& contacts, int from, int to, double b, int cells) {
  const std::array<Vec2, 3> middle = {Vec2{0, 0.5}, Vec2{0.5, 0}, Vec2{1, 0.5}};
  laplace::LaplaceProblem problem{.size = {1, 1}, .permittivity = 1};
  for (const int c : contacts) {
    problem.bodies.push_back({lichtenberg::Disk{middle[c], b}, static_cast<int>(problem.groups.size())});
    problem.groups.push_back({.floating = c != from && c != to, .charge = 0, .potential = c == from ? 1.0 : 0.0});
  }
  laplace::CutCellSolver solver({.cells = cells, .tolerance = 1e-10});
  const laplace::LaplaceSolution solution = solver.solve(problem);
  for (std::size_t k = 0; k < contacts.size(); ++k)
    if (contacts[k] == from) return 1 / solution.body_charge[k];
  return 0;
}

double relative(double value, double exact) { return std::abs(value / exact - 1); }

void two_contacts(Report& report) {
  report.section("two contacts: relative error against elliptic functions");
  for (const double angle : {pi, pi / 2, pi / 5}) {
    for (const double eps : {0.05, 0.2})
      report.at_most(fmt::format("spectral, {:.0f} degrees apart, half-angle {}", angle * 180 / pi, eps),
                     relative(between(spectral({{0, angle}, eps}, 12), 0, 1), elliptic(angle, eps)), 1e-10);
    std::vector<double> error, size;
    for (const double eps : {0.02, 0.04, 0.08}) {
      size.push_back(1 / eps);
      error.push_back(relative(between(model({{0, angle}, eps}), 0, 1), elliptic(angle, eps)));
    }
    // The first neglected term of the expansion of K(1 - m) / K(m) is of order m: eps^2.
    const double m = std::pow(0.02 / std::sin(angle / 2), 2);
    report.at_most(fmt::format("model, {:.0f} degrees apart, half-angle 0.02", angle * 180 / pi), error[0], m);
    report.at_least("  order in the half-angle", order(size, error), 1.8);
  }
}

void three_contacts(Report& report) {
  report.section("three contacts: relative error of the model against the spectral solution");
  const std::vector<double> at = {0, 2.0, 3.5};
  for (const auto& [i, j] : {std::pair{0, 1}, std::pair{1, 2}, std::pair{0, 2}}) {
    std::vector<double> error, size;
    for (const double eps : {0.02, 0.04, 0.08}) {
      size.push_back(1 / eps);
      error.push_back(relative(between(model({at, eps}), i, j), between(spectral({at, eps}, 12), i, j)));
    }
    report.at_most(fmt::format("contacts {} and {}, half-angle 0.02", i, j), error[0], 0.02 * 0.02);  // eps^2
    report.at_least("  order in the half-angle", order(size, error), 1.8);
  }
  report.at_most("spectral, 12 terms against 20, half-angle 0.2",
                 relative(between(spectral({at, 0.2}, 12), 0, 1), between(spectral({at, 0.2}, 20), 0, 1)), 1e-10);
}

void field_solver(Report& report) {
  report.section("contacts at the middles of a box's sides: the field solver, relative error");
  const double b = 0.02;
  const double eps = mapped_half_angle(2 * b);
  const std::vector<double> at = {pi, 3 * pi / 2, 2 * pi};  // left, bottom, right up to a common rotation
  const auto compare = [&](const std::string& what, const std::vector<int>& contacts, int from, int to) {
    ContactedDisk disk{.half_angle = eps};
    int i = 0, j = 0;
    for (const int c : contacts) {
      if (c == from) i = static_cast<int>(disk.at.size());
      if (c == to) j = static_cast<int>(disk.at.size());
      disk.at.push_back(at[c]);
    }
    // Half-disks of ten cells have an error of .1 %, the strip instead of a half-disk b^2 = .04 %, and the model 0.1
    // eps^2, eps^2 = 1.1 %.
    const double field_error = 1e-3 + b * b, model_error = 0.1 * eps * eps;
    const double field = in_box(contacts, from, to, b, 512);
    report.at_most(what + ", spectral", relative(between(spectral(disk, 12), i, j), field), field_error);
    report.at_most(what + ", model", relative(between(model(disk), i, j), field), field_error + model_error);
  };
  compare("two, left and right", {0, 2}, 0, 2);
  compare("two, left and bottom", {0, 1}, 0, 1);
  compare("three, left and right", {0, 1, 2}, 0, 2);
  compare("three, left and bottom", {0, 1, 2}, 0, 1);
}

}  // namespace

int validate(int, char**) {
  Report report("A disk with small contacts");
  two_contacts(report);
  three_contacts(report);
  field_solver(report);
  return report.exit_status();
}

const lichtenberg::validation::Program program("networks_disk", validate);

}  // namespace networks_disk_validation
