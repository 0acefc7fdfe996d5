// Tests of Coulomb sums on a mesh in single precision, against double precision with the same mesh and cloud.
#include <doctest/doctest.h>

#include <numeric>

#include "solvers/error.hpp"
#include "solvers/periodic/accuracy.hpp"
#include "solvers/periodic/mesh.hpp"
#include "tests/message.hpp"
#include "tests/periodic_sources.hpp"

namespace periodic_single_test {

using namespace lichtenberg;
using namespace lichtenberg::periodic;

namespace {

// Errors of single precision: sums of some hundred numbers, each rounded to 6e-8. Near fields are a few times larger
// than the remaining sum, and positions are rounded to 2e-7 of the cutoff. Regression values: 0.7 to 4e-7 of the rms
// force.
constexpr double rounding = 1e-6;

double rms(const std::vector<double>& values) {
  double sum = 0;
  for (const double value : values) sum += value * value;
  return std::sqrt(sum / static_cast<double>(values.size()));
}

/// Compares single with double precision. Both lose the cloud's truncation, but their polynomials differ by up to 0.3
/// of it. `neglected` is the square of a force between unit charges, integrated over space; that of the full force is 4
/// pi.
void check_against_double(const SourceSet& sources, const Mesh& mesh, const Cloud& cloud) {
  ParticleMesh reference(mesh, cloud);
  SingleMesh single(mesh, cloud);
  const Response expected = evaluated_on(reference, sources), found = evaluated(single, sources);
  const double most = rounding + 0.3 * std::sqrt(cloud.neglected / (4 * M_PI));
  const auto check = [&](std::vector<double> values, const std::vector<double>& reference_values) {
    const double size = rms(reference_values) + 0.1;  // The offset covers forces between a few distant charges.
    for (std::size_t k = 0; k < values.size(); ++k) values[k] -= reference_values[k];
    CHECK(rms(values) < most * size);
  };
  check(found.force, expected.force);
  check(found.field, expected.field);
  check(found.potential, expected.potential);
  CHECK(std::abs(found.energy - expected.energy) < most * sources.size());
}

SourceSet gas() { return random_sources(300, {12.8, 12.8, 12.8}, 1, false, 2); }
const Mesh fine{{12.8, 12.8, 12.8}, {24, 24, 24}, 7};

/// Particles in a ball across a corner of the box, and one charge far from it.
SourceSet ball() {
  SourceSet sources{.lengths = {30, 30, 30}};
  std::mt19937 random(5);
  std::uniform_real_distribution<double> unit(-1, 1);
  for (int x = -3; x <= 3; ++x)
    for (int y = -3; y <= 3; ++y)
      for (int z = -3; z <= 3; ++z) {
        sources.position.insert(sources.position.end(), {1 + 1.02 * x, 0.5 + 1.02 * y, 29.5 + 1.02 * z});
        sources.charge.push_back(unit(random));
      }
  sources.position.insert(sources.position.end(), {16, 15, 14});
  sources.charge.push_back(2);
  return sources;
}

}  // namespace

TEST_CASE("mesh windows: continuous, with the stated Fourier transforms") {
  for (const Window window : {Window::spline, Window::prolate})
    for (int order = 4; order <= 8; ++order) {
      const auto pieces = window_pieces(window, order);
      CHECK(std::ssize(pieces) == order);
      const auto weight = [&](int c, double s) {
        double sum = 0;
        for (auto term = pieces.rbegin(); term != pieces.rend(); ++term) sum = sum * s + (*term)[c];
        return sum;
      };
      // The c-th point around a position lies c + 1 - order / 2 - (s + 1 / 2) from it, up to half a spacing for an odd
      // order. Its weight is the window's value there. Pieces join continuously at cell boundaries.
      for (int c = 0; c + 1 < order; ++c) CHECK(weight(c, -0.5) == doctest::Approx(weight(c + 1, 0.5)).epsilon(1e-12));
      CHECK(std::abs(weight(order - 1, -0.5)) + std::abs(weight(0, 0.5)) < 1e-14);
      const WindowTransform& transform = WindowTransform::of(window, order);
      // Gauss's rule with three points has an error of (k / parts)^7 / 2016000 for an oscillation of wavenumber k,
      // below 1e-15. Sums of order x parts numbers round by 1e-14. One or two periods away, transforms of order 8 are
      // 1e-8.
      constexpr int parts = 100;  // Parts of a spacing.
      const double nodes[] = {-std::sqrt(0.6), 0, std::sqrt(0.6)}, weights[] = {5.0 / 18, 8.0 / 18, 5.0 / 18};
      for (const double k : {0.0, 0.7, 3.0})
        for (const int turns : {0, 1}) {
          double sum = 0;
          for (int c = 0; c < order; ++c)
            for (int part = 0; part < parts; ++part)
              for (int n = 0; n < 3; ++n) {
                const double s = (part + 0.5 + 0.5 * nodes[n]) / parts - 0.5, x = s + 0.5 * (order - 1) - c;
                sum += weight(c, s) * std::cos((k + 2 * M_PI * turns) * x) * weights[n] / parts;
              }
          CAPTURE(order);
          CAPTURE(turns);
          const double most = 1e-13 + 1.9e-16 * std::pow((k + 2 * M_PI * turns) / 4, 12);
          CHECK(std::abs(transform(k)[WindowTransform::far_aliases + turns] - sum) < most);
        }
    }
}

TEST_CASE("mesh windows: errors are as estimated, smallest for prolate windows") {
  const SourceSet sources = gas();
  const Response exact = by_ewald(sources, 1e-11);
  const auto estimate = [&](Window window, int order, int points, const Cloud& cloud) {
    const Mesh mesh{sources.lengths, {points, points, points}, order, window};
    SingleMesh sum(mesh, cloud);
    const double expected = std::hypot(relative_error(mesh, cloud, 1), error_of_single_precision);
    const double error = relative_difference(evaluated(sum, sources).force, exact.force);
    CAPTURE(order);
    CHECK(error < 1.5 * expected);  // 300 charges are few: regression values are 0.8 to 1.1.
    CHECK(error > expected / 1.5);
    return expected;
  };
  // The spacings suit an accuracy of 1e-2 to 1e-6 with prolate windows.
  struct Case {
    int order, points;
    double band_limit, cutoff;
  };
  for (const Case& mesh_case :
       {Case{4, 12, 7, 3}, {5, 14, 9, 3.5}, {6, 18, 12, 4}, {7, 18, 14, 4.2}, {8, 20, 17, 4.2}}) {
    const Cloud cloud = prolate_cloud(mesh_case.band_limit, mesh_case.cutoff);
    CHECK(estimate(Window::prolate, mesh_case.order, mesh_case.points, cloud) <
          0.9 * estimate(Window::spline, mesh_case.order, mesh_case.points, cloud));
  }
}

TEST_CASE("single-precision mesh: equals double precision for all spline orders") {
  for (const int order : {4, 5, 6, 7})
    check_against_double(gas(), {{12.8, 12.8, 12.8}, {20, 24, 16}, order}, prolate_cloud(16, 3.9));
}

TEST_CASE("single-precision mesh: equals double precision for any mesh size") {
  for (const std::array points : {std::array{16, 18, 20}, {21, 25, 14}, {15, 28, 36}, {22, 27, 26}, {32, 45, 30}})
    check_against_double(gas(), {{12.8, 12.8, 12.8}, points, 6}, prolate_cloud(14, 4.1));
}

TEST_CASE("single-precision mesh: equals double precision in long boxes, clusters") {
  check_against_double(random_sources(200, {10, 12, 31}, 1, false, 3), {{10, 12, 31}, {16, 18, 48}, 6},
                       prolate_cloud(8, 3.3));
  check_against_double(random_sources(200, {31, 10, 12}, 1, false, 3), {{31, 10, 12}, {48, 16, 18}, 6},
                       prolate_cloud(8, 3.3));
  for (const double band_limit : {5.0, 8.0, 11.0, 18.0})
    check_against_double(ball(), {{30, 30, 30}, {32, 32, 32}, 6}, prolate_cloud(band_limit, 6));
  for (const int few : {1, 2, 3, 9, 17})
    check_against_double(random_sources(few, {9, 9, 9}, 1, false, 4), {{9, 9, 9}, {16, 16, 16}, 6},
                         prolate_cloud(9, 3));
}

TEST_CASE("spline windows: order 8 has a smaller error than order 7") {
  const SourceSet sources = gas();
  const Response exact = by_ewald(sources, 1e-10);
  const auto error = [&](int order) {
    SingleMesh sum({sources.lengths, {16, 16, 16}, order}, prolate_cloud(14, 4.2));
    return relative_difference(evaluated(sum, sources).force, exact.force);
  };
  CHECK(error(8) < 0.8 * error(7));
}

TEST_CASE("single-precision mesh: threads and scaling by 2^n change no bit") {
  const SourceSet sources = random_sources(3000, {27.4, 27.4, 27.4}, 0.9, false, 7);
  const Mesh mesh{sources.lengths, {48, 48, 48}, 6};
  const Cloud cloud = prolate_cloud(10, 3.7);
  SingleMesh sum(mesh, cloud);
  const Response one = evaluated(sum, sources);
  for (const int threads : {2, 4}) {
    parallel::Team team(threads);
    for (int repeat = 0; repeat < 5; ++repeat) {
      const Response found = evaluated(sum, sources, team);
      CHECK(found.force == one.force);
      CHECK(found.potential == one.potential);
      CHECK(found.energy == one.energy);
    }
  }
  SourceSet scaled = sources;
  for (double& x : scaled.position) x *= 4;
  for (double& q : scaled.charge) q *= 0.5;
  scaled.lengths = 4.0 * sources.lengths;
  SingleMesh scaled_sum({scaled.lengths, mesh.points, mesh.order}, prolate_cloud(10, 4 * 3.7));
  Response found = evaluated(scaled_sum, scaled);
  for (double& f : found.force) f *= 64;
  CHECK(found.force == one.force);
}

TEST_CASE("single-precision mesh: forces() gives the bits of the full evaluation") {
  const SourceSet sources = random_sources(3000, {27.4, 27.4, 27.4}, 0.9, false, 7);
  for (const double cutoff : {2.5, 3.7, 5.0}) {
    SingleMesh sum({sources.lengths, {48, 48, 48}, 6}, prolate_cloud(10, cutoff));
    std::vector<double> force;
    sum.forces(sources, {}, parallel::Team::single(), force);
    CHECK(force == evaluated(sum, sources).force);
  }
}

TEST_CASE("single-precision mesh: forces sum to zero, images change nothing") {
  SourceSet sources = gas();
  SingleMesh sum(fine, prolate_cloud(11, 4));
  const Response found = evaluated(sum, sources);
  for (int k = 0; k < 3; ++k) {
    double net = 0, all = 0;
    for (int i = 0; i < sources.size(); ++i) net += found.force[3 * i + k], all += std::abs(found.force[3 * i + k]);
    CHECK(std::abs(net) < 1e-14 * all);
  }
  for (int i = 0; i < sources.size(); ++i) sources.position[3 * i] += sources.lengths.x * (i % 3 - 1);
  // Moving a position by the box rounds it to 2e-15, at most one part of 2^-32.
  CHECK(relative_difference(evaluated(sum, sources).force, found.force) < rounding);
}

TEST_CASE("choose_quick_mesh: single precision down to 1e-6, accuracy is met") {
  const SourceSet sources = gas();
  const Response exact = by_ewald(sources, 1e-10);
  for (const double accuracy : {1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7}) {
    const MeshChoice choice = choose_quick_mesh({accuracy, sources.size(), sources.lengths});
    CHECK(choice.single == (accuracy >= 1e-6));
    const auto sum = make_mesh_sum(choice);
    const double error = relative_difference(evaluated_on(*sum, sources).force, exact.force);
    CHECK(error < 1.2 * accuracy);  // The estimate has an error of 17 %.
    CHECK(error > accuracy / 3);
  }
}

TEST_CASE("choose_measured_mesh: force errors are 0.3 to 1.05 of the request") {
  for (const SourceSet& sources : {gas(), ball(), random_sources(800, {17.6, 17.6, 17.6}, 1, false, 8)})
    for (const double accuracy : {1e-2, 1e-3, 1e-4, 1e-5}) {
      const MeshRequest request{accuracy, sources.size(), sources.lengths};
      const MeshChoice choice = choose_measured_mesh(request, sources);
      const auto sum = make_mesh_sum(choice);
      const double error = relative_difference(evaluated_on(*sum, sources).force, by_ewald(sources, 1e-10).force);
      // The finer reference mesh has an error of 1/30 of the request.
      CHECK(error < 1.05 * accuracy);
      CHECK(error > 0.3 * accuracy);
    }
}

TEST_CASE("choose_quick_mesh: given parameters are kept and the rest is chosen") {
  const SourceSet sources = gas();
  const auto chosen = [&](const FixedParameters& fixed) {
    return choose_quick_mesh({.accuracy = 1e-3, .charges = 300, .lengths = sources.lengths, .fixed = fixed});
  };
  const auto check_accuracy = [&](const MeshChoice& choice) {
    CHECK(relative_difference(evaluated_on(*make_mesh_sum(choice), sources).force, by_ewald(sources, 1e-10).force) <
          1.2e-3);
  };
  const MeshChoice with_cutoff = chosen({.cutoff = 3.3}), with_mesh = chosen({.points = 21}),
                   with_order = chosen({.order = 5}), with_alpha = chosen({.alpha = 0.7});
  CHECK(with_cutoff.cutoff == 3.3);
  CHECK(with_mesh.mesh.points == std::array{21, 21, 21});
  CHECK(with_order.mesh.order == 5);
  CHECK(with_alpha.alpha == 0.7);
  for (const MeshChoice& choice : {with_cutoff, with_mesh, with_order, with_alpha}) check_accuracy(choice);
  const MeshChoice fixed = chosen({.cutoff = 3.1, .points = 18, .order = 6});
  CHECK(fixed.cutoff == 3.1);
  CHECK(fixed.mesh.points[1] == 18);
  CHECK(fixed.error == doctest::Approx(relative_difference(evaluated_on(*make_mesh_sum(fixed), sources).force,
                                                           by_ewald(sources, 1e-10).force))
                           .epsilon(0.3));  // Estimates have an error of 17 %, and 300 charges are few.
  CHECK(message_of([&] { chosen({.cutoff = 1.2, .points = 16}); }) ==
        "no mesh of up to 1024 points along a side reaches an accuracy of 0.001 in a box of 12.8 x 12.8 x 12.8 with a "
        "cutoff of up to half of it, with the given parameters");
}

TEST_CASE("single-precision mesh: impossible meshes are refused") {
  const SourceSet sources = gas();
  CHECK(message_of([&] { SingleMesh(fine, prolate_cloud(11, 5)); }) ==
        "a cut-off of 5 is more than a third of the box of 12.8 x 12.8 x 12.8");
  CHECK(message_of([&] {
          SingleMesh({sources.lengths, {24, 24, 23}, 7}, prolate_cloud(11, 4));
        }) == "a mesh in single precision has an even number of points along z: 23 are not");
  CHECK(message_of([&] {
          ParticleMesh({sources.lengths, {24, 24, 24}, 6, Window::prolate}, prolate_cloud(11, 4));
        }) == "a mesh in double precision has splines for windows");
  SingleMesh sum(fine, prolate_cloud(11, 4));
  SourceSet polarized = sources;
  polarized.dipole.resize(sources.position.size());
  CHECK(message_of([&] { evaluated(sum, polarized); }) == "there are no dipoles on a mesh in single precision");
  SourceSet twice = sources;
  std::copy_n(twice.position.begin(), 3, twice.position.begin() + 30);
  CHECK(message_of([&] { evaluated(sum, twice); }) ==
        "the energy of the charges is not finite: two of them have the same position");
}

}  // namespace periodic_single_test
