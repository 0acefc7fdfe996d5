// Tests of given and induced dipoles on a mesh, against Ewald's sum and against invariants.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <tuple>

#include "solvers/periodic/accuracy.hpp"
#include "solvers/periodic/dipoles.hpp"
#include "solvers/periodic/mesh.hpp"
#include "solvers/periodic/screened.hpp"
#include "tests/periodic_sources.hpp"

namespace periodic_mesh_dipoles_test {

using namespace lichtenberg;
using namespace lichtenberg::periodic;

namespace {

parallel::Team& alone = parallel::Team::single();

/// 300 charges and dipoles at the density of scenes/granular-gas.toml.
SourceSet gas(unsigned seed) { return random_sources(300, {12.8, 12.8, 12.8}, 1, true, seed); }

SourceSet without_charges(SourceSet sources) {
  std::ranges::fill(sources.charge, 0);
  return sources;
}
SourceSet without_dipoles(SourceSet sources) {
  sources.dipole.clear();
  return sources;
}
SourceSet with_dipoles(SourceSet sources, double factor) {
  for (double& mu : sources.dipole) mu *= factor;
  return sources;
}

ParticleMesh mesh_for(const MeshChoice& choice) {
  return {choice.mesh, prolate_cloud(choice.band_limit, choice.cutoff)};
}

std::vector<double> dipole_field(ParticleMesh& sum, const SourceSet& sources, parallel::Team& team = alone) {
  std::vector<double> field(sources.dipole.size());
  sum.dipole_field(sources, pairs_of(sources, sum.cutoff()), team, field);
  return field;
}

double product(const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 0;
  for (std::size_t k = 0; k < a.size(); ++k) sum += a[k] * b[k];
  return sum;
}

/// Negative derivatives of the energy by every coordinate of `x`, a part of the particles.
std::vector<double> slopes(ParticleMesh& sum, const SourceSet& sources, std::vector<double>& x, double step) {
  std::vector<double> result;
  for (double& coordinate : x)
    result.push_back(-energy_slope(coordinate, step, [&] { return evaluated_on(sum, sources).energy; }));
  return result;
}

/// Eight grains of diameter 0.9 to 1.
SourceSet grains() { return random_sources(8, {4, 4.5, 5}, 0.9, false, 8); }

ParticleMesh mesh_for_grains() { return mesh_for(choose_mesh(1e-6, 8, grains().lengths, 0.9, lowest_dipole_order)); }

Response with_induced(Sum& far, const SourceSet& sources, DipoleSum variant, std::vector<double>& dipole) {
  Response response;
  InducedDipoles(far, variant, 0.075, 1e-13)
      .evaluate(sources, pairs_of(sources, far.cutoff()), alone, dipole, response);
  return response;
}

constexpr DipoleSum variants[] = {DipoleSum::ewald, DipoleSum::mixed_consistent, DipoleSum::minimum_image,
                                  DipoleSum::source};

}  // namespace

// Errors are waves, and a dipole at either end multiplies them by k / sqrt(3). Their wavenumbers lie between the
// cloud's band limit, where the transform is cut off, and the mesh's first alias, 2 pi over its spacing. For positions
// at least 1 apart the squared forces sum to 4 pi between charges, 8 pi / 3 from charges on dipoles and 8 pi between
// dipoles. The errors of charges are at most 1.25 of the estimate.
TEST_CASE("mesh sum of dipoles: error is that of charges times k, for forces k^2") {
  const SourceSet sources = gas(1), dipoles = without_charges(sources);
  const Response exact = by_ewald(sources, 1e-11), exact_of_dipoles = by_ewald(dipoles, 1e-11);
  for (const auto& [band_limit, cutoff, points] : {std::tuple{6.3, 1.8, 16}, {9.0, 3.0, 18}, {15.4, 5.3, 24}})
    for (int order = lowest_dipole_order; order <= 7; ++order) {
      const Mesh mesh{sources.lengths, {points, points, points}, order};
      const Cloud cloud = prolate_cloud(band_limit, cutoff);
      ParticleMesh sum(mesh, cloud);
      const double charges = relative_error(mesh, cloud, 1);
      const double longest = 0.5 * band_limit / cutoff / std::sqrt(3);
      const double shortest = 1.25 * 2 * M_PI / mesh.spacing().x / std::sqrt(3);
      const Response response = evaluated_on(sum, dipoles);
      CAPTURE(order);
      CAPTURE(points);
      const double field = relative_difference(response.field, exact_of_dipoles.field);
      CHECK(field < shortest * std::sqrt(1.5) * charges);
      CHECK(field > longest * std::sqrt(1.5) * charges);
      const double force = relative_difference(response.force, exact_of_dipoles.force);
      CHECK(force < shortest * shortest * std::sqrt(0.5) * charges);
      CHECK(force > longest * longest * std::sqrt(0.5) * charges);
      // Charges contribute 1/4 of the dipoles' fields, and less of the error.
      const Response both = evaluated_on(sum, sources);
      CHECK(relative_difference(both.field, exact.field) < field);
      CHECK(relative_difference(both.force, exact.force) < force);
      CHECK(relative_difference(both.potential, exact.potential) < field);
      CHECK(both.energy == doctest::Approx(exact.energy).epsilon(field));
    }
}

TEST_CASE("mesh sum of charges and dipoles: error is 0.5 to 2 times the estimate") {
  for (const double factor : {0.1, 0.5, 3.0}) {
    const SourceSet sources = with_dipoles(gas(4), factor);
    const Response exact = by_ewald(sources, 1e-11);
    const double charge2 = product(sources.charge, sources.charge);
    const double dipole2 = product(sources.dipole, sources.dipole) / charge2;
    const double rms = std::sqrt(product(exact.force, exact.force) / sources.size());
    const double charge_force = random_force(charge2, sources.size(), std::pow(sources.lengths.x, 3), 1);
    for (const Cloud& cloud : {gauss_cloud(0.75, 4.5), prolate_cloud(9, 3), prolate_cloud(15.4, 5.3)})
      for (const int points : {18, 24})
        for (int order = lowest_dipole_order; order <= 7; ++order) {
          const Mesh mesh{sources.lengths, {points, points, points}, order};
          ParticleMesh sum(mesh, cloud);
          const double estimate = relative_error(mesh, cloud, 1, dipole2);
          const double error = relative_difference(evaluated_on(sum, sources).force, exact.force) * rms / charge_force;
          CAPTURE(factor);
          CAPTURE(points);
          CAPTURE(order);
          CAPTURE(estimate);
          CHECK(error < 2 * estimate);
          CHECK(error > estimate / 2);
        }
  }
}

TEST_CASE("induced_dipole2: 1.5 times the result for a lattice of random charges") {
  // A simple cubic lattice of touching grains whose charges have random signs. The mean square field is the sum of the
  // squared fields of single charges: 12.60 by Ewald's sum over the other sites of 9^3 (16.5 for an infinite lattice).
  // The prediction is 4 pi + 6 = 18.57. Interactions between dipoles subtract (8 pi / 3) 2 A, 1/30. Statistical error:
  // 2/3 per site and about 40 independent sites per lattice, sqrt(2 / 3 / 320) = 0.05 for eight lattices.
  constexpr int side = 9, lattices = 8;
  constexpr double polarizability = 0.002;
  std::mt19937 random(5);
  Ewald ewald(1e-4);
  double found = 0;
  for (int n = 0; n < lattices; ++n) {
    SourceSet sources{.lengths = {side, side, side}};
    for (int i = 0; i < side * side * side; ++i) {
      for (const int k : {i % side, i / side % side, i / (side * side)}) sources.position.push_back(k);
      sources.charge.push_back(random() % 2 == 0 ? 1 : -1);
    }
    std::vector<double> dipole;
    Response response;
    InducedDipoles(ewald, DipoleSum::ewald, polarizability, 1e-3).evaluate(sources, {}, alone, dipole, response);
    found += product(dipole, dipole) / sources.size() / lattices;
  }
  const double ratio = found / induced_dipole2(polarizability, 1, 1);
  CHECK(ratio == doctest::Approx(12.60 / 18.57).epsilon(0.15));
}

TEST_CASE("mesh sum: dipoles of 10 % of charges raise errors at most as estimated") {
  const SourceSet sources = with_dipoles(gas(2), 0.1);
  const Response exact = by_ewald(sources, 1e-11);
  for (const double accuracy : {1e-2, 1e-3, 1e-4, 1e-6}) {
    const MeshChoice choice = choose_mesh(accuracy, sources.size(), sources.lengths, 1, lowest_dipole_order);
    ParticleMesh sum = mesh_for(choice);
    const Response response = evaluated_on(sum, sources);
    // The mean squares are 1/3 for charges and 0.01 for dipoles. The squared errors grow by this factor, and again for
    // the dipoles that the field acts on. Wavenumbers and 1.25 are as above.
    const double growth = 1 + 0.03 * std::pow(2 * M_PI / choice.mesh.spacing().x, 2) / 3;
    CHECK(relative_difference(response.field, exact.field) < 1.25 * std::sqrt(growth) * accuracy);
    CHECK(relative_difference(response.force, exact.force) < 1.25 * growth * accuracy);
  }
}

TEST_CASE("near field of multipoles: equals derivatives of the screened potential") {
  constexpr double alpha = 0.75, cutoff = 4.5;
  const Vec3 lengths{12, 12, 12}, direction{2.0 / 3, -1.0 / 3, 2.0 / 3};
  const Cloud cloud = gauss_cloud(alpha, cutoff);
  const Near<double> near(lengths, cloud);
  Columns<double> columns(lengths, near.layout(0));
  constexpr double by_potential = 1 / cutoff, by_field = 1 / (cutoff * cutoff);  // The largest charge is 1.
  // The choice of the degree ignores rounding in the last terms of the series.
  CHECK(Near<double>(lengths, prolate_cloud(15.4, 5.3)).degree(Kind::dipoles) <= 18);
  // The first factor is the error of a force between charges; each dipole adds a factor k of the cloud.
  const double bound = 0.1 * std::sqrt(cloud.neglected / (4 * M_PI / 3 * std::pow(cutoff, 3))),
               k = std::sqrt(2) * alpha;
  for (double distance = 0.5; distance < cutoff; distance += 0.01) {
    SourceSet sources{.lengths = lengths, .position = {1, 1, 1}, .charge = {1, 1}, .dipole = {1, 0, 0, 0, 0.6, -0.8}};
    for (int c = 0; c < 3; ++c) sources.position.push_back(1 + distance * direction[c]);
    for (const Kind kind : {Kind::charges, Kind::dipoles, Kind::multipoles}) {
      if (kind == Kind::dipoles) sources = without_charges(sources);
      if (kind == Kind::multipoles) sources.charge = {1, 1};
      columns.sort(sources, alone);
      std::vector<double> field(8), force(kind == Kind::multipoles ? 8 : 0);
      near.compute(columns, kind, true, {field, force}, alone);
      Multipole on = multipole(sources, 0), from = multipole(sources, 1);
      if (kind == Kind::charges) from.dipole = on.dipole = {};
      const FieldSample exact = pair_field(screened(distance * distance, alpha), distance * direction, on, from);
      const double* found = &field[4 * columns.sorted()[0]];
      const double most = bound * (kind == Kind::charges ? 1 : kind == Kind::dipoles ? k : 1 + k);
      CHECK(norm(by_field * Vec3{found[0], found[1], found[2]} - exact.field) < most);
      if (kind != Kind::multipoles) continue;
      const double* found_force = &force[4 * columns.sorted()[0]];
      CHECK(norm(by_field * Vec3{found_force[0], found_force[1], found_force[2]} - exact.force) <
            bound * (1 + k) * (1 + k));
      CHECK(std::abs(by_potential * found[3] - exact.potential) < bound * (1 + 1 / k));
    }
  }
}

TEST_CASE("mesh sum, one dipole in a cube: field is 4 pi / (3 L^3) times dipole") {
  const double length = 6, own = 4 * M_PI / 3 / (length * length * length);
  const Cloud cloud = prolate_cloud(18, 3);
  ParticleMesh sum({{length, length, length}, {32, 32, 32}, 7}, cloud);
  for (const double x : {0.0, 0.05, 0.1, 2.9}) {
    SourceSet lone{{length, length, length}, {x, 1 - x, 0.5 * x}, {0}, {0.3, -0.4, 0.5}};
    const Response response = evaluated_on(sum, lone);
    // Splines of order 7 alias a fraction (1.1 / (2 pi - 1.1))^7 = 2e-5 of the waves at the band limit, 1.1 per
    // spacing, and less of longer ones.
    for (int k = 0; k < 3; ++k) CHECK(std::abs(response.field[k] / lone.dipole[k] - own) < 1e-6 * cloud.dipole_field);
    CHECK(largest(response.force) < 1e-16);
  }
}

TEST_CASE("mesh sum, dipoles: negative energy slopes less shares of the net force") {
  SourceSet sources = random_sources(20, {6, 7, 8}, 0.8, true, 4);
  // The mesh is so coarse that its error is visible.
  const Mesh mesh{sources.lengths, {12, 12, 12}, 5};
  ParticleMesh sum(mesh, prolate_cloud(8, 2.9));
  const Response at = evaluated_on(sum, sources);
  // The energy is quadratic in the dipoles: the difference is rounding.
  const std::vector<double> field = slopes(sum, sources, sources.dipole, 0.1);
  CHECK(largest_difference(field, at.field) < 1e-12 * largest(at.field));

  const double separation = 0.5 * mesh.order * mesh.spacing().z;
  std::vector<double> strength, missing(3), net(3);
  for (int i = 0; i < sources.size(); ++i) {
    const Multipole source = multipole(sources, i);
    strength.push_back(source.charge * source.charge + norm2(source.dipole) / (separation * separation));
  }
  // Third derivatives of splines of order 5 jump. The error is step / 4 of the jump: 1e-7 of the force contribution of
  // the mesh's waves.
  std::vector<double> force = slopes(sum, sources, sources.position, 1e-5);
  double all = 0;
  for (const double s : strength) all += s;
  for (std::size_t k = 0; k < force.size(); ++k) missing[k % 3] += force[k] / all, net[k % 3] += at.force[k];
  for (std::size_t k = 0; k < force.size(); ++k) force[k] -= strength[k / 3] * missing[k % 3];
  CHECK(largest(missing) > 1e-5);  // The net force of the slopes is not zero.
  CHECK(largest(net) < 1e-14 * sources.size() * largest(at.force));
  CHECK(largest_difference(force, at.force) < 1e-6 * largest(at.force));
}

TEST_CASE("mesh sum: field of dipoles is linear and symmetric to rounding") {
  SourceSet a = random_sources(200, {10, 11, 12}, 0.8, true, 5), b = a, both = a;
  std::ranges::rotate(b.dipole, b.dipole.begin() + 100);
  for (std::size_t k = 0; k < a.dipole.size(); ++k) both.dipole[k] = 0.5 * a.dipole[k] - 4 * b.dipole[k];
  ParticleMesh sum({a.lengths, {14, 14, 14}, 5}, prolate_cloud(6, 2.5));
  const std::vector<double> field_a = dipole_field(sum, a), field_b = dipole_field(sum, b),
                            field_both = dipole_field(sum, both);
  std::vector<double> expected(field_a.size());
  for (std::size_t k = 0; k < field_a.size(); ++k) expected[k] = 0.5 * field_a[k] - 4 * field_b[k];
  CHECK(largest_difference(field_both, expected) < 1e-14 * largest(expected));
  const double magnitude = std::sqrt(product(field_a, field_a) * product(b.dipole, b.dipole));
  CHECK(std::abs(product(field_a, b.dipole) - product(field_b, a.dipole)) < 1e-15 * magnitude);
  // The evaluation with forces gives the same field.
  CHECK(largest_difference(field_a, evaluated_on(sum, without_charges(a)).field) < 1e-14 * largest(field_a));
}

TEST_CASE("mesh sum: zero dipoles change nothing; no charge or dipole, no force") {
  SourceSet sources = gas(3);
  std::fill_n(sources.dipole.begin(), 30, 0.0);
  std::fill_n(sources.charge.begin(), 10, 0.0);
  ParticleMesh sum({sources.lengths, {16, 16, 16}, 6}, prolate_cloud(20, 5));
  const Response response = evaluated_on(sum, sources);
  for (int k = 0; k < 30; ++k) CHECK(response.force[k] == 0);
  const Response none = evaluated_on(sum, with_dipoles(sources, 0)),
                 charges = evaluated_on(sum, without_dipoles(sources));
  // The polynomials have other degrees: 1e-8 of the cloud's truncation.
  CHECK(relative_difference(none.force, charges.force) < 1e-8);
  CHECK(relative_difference(none.field, charges.field) < 1e-8);
  CHECK(relative_difference(none.potential, charges.potential) < 1e-8);
}

TEST_CASE("mesh sum with dipoles: threads give identical bits") {
  const SourceSet sources = random_sources(2000, {30, 24, 21}, 0.5, true, 5);
  ParticleMesh sum({sources.lengths, {36, 30, 24}, 5}, prolate_cloud(8, 3));
  const Response expected = evaluated_on(sum, sources);
  const std::vector<double> field = dipole_field(sum, sources);
  for (const int threads : {1, 2, 4}) {
    parallel::Team team(threads);
    const Response response = evaluated_on(sum, sources, 0.7, team);
    CHECK(response.potential == expected.potential);
    CHECK(response.field == expected.field);
    CHECK(response.force == expected.force);
    CHECK(response.energy == expected.energy);
    CHECK(dipole_field(sum, sources, team) == field);
  }
}

TEST_CASE("mesh sum with dipoles: scaling by powers of two is exact") {
  const SourceSet sources = gas(6);
  SourceSet scaled = with_dipoles(sources, 0.5);
  for (double& x : scaled.position) x *= 2;
  for (int k = 0; k < 3; ++k) scaled.lengths[k] *= 2;
  for (double& q : scaled.charge) q *= 0.25;
  ParticleMesh sum({sources.lengths, {16, 18, 20}, 6}, prolate_cloud(9, 4)),
      scaled_sum({scaled.lengths, {16, 18, 20}, 6}, prolate_cloud(9, 8));
  const Response expected = evaluated_on(sum, sources), response = evaluated_on(scaled_sum, scaled);
  CHECK(response.energy == expected.energy / 32);
  const std::vector<double> field = dipole_field(sum, sources), scaled_field = dipole_field(scaled_sum, scaled);
  for (int i = 0; i < sources.size(); ++i) CHECK(response.potential[i] == expected.potential[i] / 8);
  for (int k = 0; k < 3 * sources.size(); ++k) {
    CHECK(response.field[k] == expected.field[k] / 16);
    CHECK(response.force[k] == expected.force[k] / 64);
    CHECK(scaled_field[k] == field[k] / 16);
  }
}

TEST_CASE("induced dipoles on a mesh: largest polarizability equals Ewald's") {
  const SourceSet sources = grains();
  Ewald ewald(1e-14);
  ParticleMesh mesh = mesh_for_grains();
  const auto largest_by = [&](Sum& sum) {
    const auto pairs = pairs_of(sources, sum.cutoff());
    return largest_polarizability(field_by(sum, sources, pairs, alone), sources.size());
  };
  // An accuracy of 1e-6 for charges, times wavenumbers of 2 pi / 0.2 over sqrt(3).
  CHECK(largest_by(mesh) == doctest::Approx(largest_by(ewald)).epsilon(2e-5));
}

TEST_CASE("induced dipoles on a mesh: each DipoleSum agrees with that by Ewald") {
  const SourceSet sources = grains();
  Ewald ewald(1e-14);
  ParticleMesh mesh = mesh_for_grains();
  for (const DipoleSum variant : variants) {
    std::vector<double> dipole, exact_dipole;
    const Response response = with_induced(mesh, sources, variant, dipole);
    const Response exact = with_induced(ewald, sources, variant, exact_dipole);
    // Eight charges are few for a statistical estimate; wavenumbers are as above.
    CHECK(relative_difference(dipole, exact_dipole) < 1e-5);
    CHECK(relative_difference(response.force, exact.force) < 1e-5);
    CHECK(relative_difference(response.field, exact.field) < 1e-5);
    CHECK(relative_difference(response.potential, exact.potential) < 1e-5);
    CHECK(response.energy == doctest::Approx(exact.energy).epsilon(1e-5));
    // The near-field polynomials of charges and of multipoles differ by less than 10 % of the accuracy.
    for (std::size_t k = 0; k < dipole.size(); ++k)
      CHECK(std::abs(0.075 * response.field[k] - dipole[k]) < 1e-7 * largest(dipole));
  }
}

TEST_CASE("dipoles on a mesh: forces are -dE/dx except for DipoleSum::source") {
  SourceSet sources = grains();
  ParticleMesh mesh = mesh_for_grains();
  for (const DipoleSum variant : variants) {
    std::vector<double> dipole;
    const Response at = with_induced(mesh, sources, variant, dipole);
    double worst = 0;
    for (std::size_t k = 0; k < 6; ++k) {
      const double slope =
          energy_slope(sources.position[k], 1e-3, [&] { return with_induced(mesh, sources, variant, dipole).energy; });
      worst = std::max(worst, std::abs(slope + at.force[k]));
    }
    // The subtracted net force and the truncation at the cutoff are errors of the mesh.
    if (variant == DipoleSum::source)
      CHECK(worst > 1e-3);
    else
      CHECK(worst < 1e-5 * largest(at.force));
  }
}

}  // namespace periodic_mesh_dipoles_test
