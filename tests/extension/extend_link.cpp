// Link formula added from outside with its own data: a disk with an insulating coat.
#include <doctest/doctest.h>

#include <cmath>
#include <memory>
#include <numbers>
#include <string>

#include "solvers/error.hpp"
#include "solvers/laplace/cutcell/device/device.hpp"
#include "solvers/laplace/cutcell/solver.hpp"
#include "solvers/laplace/cutcell/surface_links.hpp"
#include "solvers/laplace/multipole/solver.hpp"

namespace extend_link {

using namespace lichtenberg;
using namespace lichtenberg::laplace;

namespace {

/// The potential is logarithmic in the fluid and in the coat. The flux through a face is the angle of the face over
/// ln(r / R) + data[0]: r is the distance of the cell's centre, R the coat's outer radius.
Conductance coated_link(const Outline& disk, Vec2 p, Vec2 e) {
  const Vec2 half = 0.5 * perpendicular(e), r = p - disk.centre;
  const Conductance bare = log_fitted_link(p, p + 0.5 * e + half, p + 0.5 * e - half, disk.centre, disk.size);
  const double log_ratio = std::max(std::log(norm(r) / disk.size), smallest_cut / norm(r));
  const Vec2 log_gradient = (-1 / norm2(r)) * r;
  const double angle = bare.value * log_ratio, logs = log_ratio + disk.data[0];
  const Vec2 angle_gradient = log_ratio * bare.gradient + bare.value * log_gradient;
  return {angle / logs, (angle_gradient - (angle / logs) * log_gradient) / logs};
}

/// Insulating coat, whose outer surface is the disk's.
class Coat : public LinkModel {
 public:
  /// `thickness` (m); `permittivity`: relative to the fluid's.
  Coat(double thickness, double permittivity) : thickness_(thickness), permittivity_(permittivity) {}
  std::string name() const override { return "coat"; }
  std::array<double, 2> data(const Body& body) const override {
    const double radius = std::get<Disk>(body.shape).radius;
    return {std::log(radius / (radius - thickness_)) / permittivity_, 0};
  }
  LinkFunction formula() const override { return coated_link; }

 private:
  double thickness_, permittivity_;
};

constexpr double inner = 0.1, outer = 0.45, thickness = 0.01, permittivity = 0.2;
const Coat coat(thickness, permittivity);

/// Problem of a disk at 1 V in a grounded ring.
LaplaceProblem in_ring(double shift = 0) {
  LaplaceProblem problem{.size = {1, 1}, .permittivity = 1};
  problem.bodies = {{Disk{{0.5 + shift, 0.5}, inner}, 0, &coat}, {Ring{{0.5, 0.5}, outer}, 1}};
  problem.groups = {{false, 0, 1.0}, {false, 0, 0.0}};
  return problem;
}

LaplaceSolution solve(const LaplaceProblem& problem, int cells) {
  return CutCellSolver({.cells = cells, .tolerance = 1e-12}).solve(problem);
}

std::string refusal(LaplaceSolver& solver, const LaplaceProblem& problem) {
  try {
    solver.solve(problem);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

}  // namespace

TEST_CASE("user-defined link model: a coated disk is two capacitors in series") {
  const double series =
      2 * std::numbers::pi / (std::log(outer / inner) + std::log(inner / (inner - thickness)) / permittivity);
  const auto error = [&](int cells) { return std::abs(solve(in_ring(), cells).body_charge[0] / series - 1); };
  const double coarse = error(64), fine = error(256);
  CHECK(coarse < 1. / (64 * 64));
  CHECK(fine < 0.5 * 0.5 * coarse);
}

TEST_CASE("user-defined link model: force is the energy derivative at fixed voltage") {
  const double shift = 0.07, step = 1e-5;
  const auto energy = [&](double x) { return solve(in_ring(x), 64).energy; };
  const double derivative = (energy(shift + step) - energy(shift - step)) / (2 * step);
  CHECK(solve(in_ring(shift), 64).body_force[0].x == doctest::Approx(derivative).epsilon(1e-5));
}

TEST_CASE("user-defined link model: device algorithms give the CPU's solution") {
  const LaplaceSolution cpu = solve(in_ring(0.07), 64);
  const auto device = device::make_host_solver({.cells = 64, .tolerance = 1e-12});
  const LaplaceSolution other = device->solve(in_ring(0.07));
  CHECK(other.body_charge[0] == doctest::Approx(cpu.body_charge[0]).epsilon(1e-10));
  CHECK(other.body_force[0].x == doctest::Approx(cpu.body_force[0].x).epsilon(1e-9));
}

TEST_CASE("user-defined link model: multipole method and coarse grids refuse it") {
  MultipoleSolver multipole(MultipoleOptions{});
  CHECK(refusal(multipole, in_ring()).find("link model") != std::string::npos);
  CutCellSolver coarse({.cells = 8});
  CHECK(refusal(coarse, in_ring()).find("\"coat\" needs a radius of two cells") != std::string::npos);
}

}  // namespace extend_link
