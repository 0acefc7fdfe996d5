// Tests of Coulomb sums in boxes with open and grounded sides, against sums over images and over waves in the plane.
#include <doctest/doctest.h>

#include <fmt/format.h>

#include <cmath>
#include <numbers>
#include <random>
#include <string>

#include "solvers/error.hpp"
#include "solvers/periodic/bounded.hpp"
#include "solvers/periodic/field_sums.hpp"
#include "tests/periodic_sources.hpp"

namespace periodic_bounded_test {

using namespace lichtenberg;
using namespace lichtenberg::periodic;
using doctest::Approx;
using std::numbers::pi;

namespace {

constexpr Side p = Side::periodic, o = Side::open, g = Side::grounded;

/// Potential of a unit charge at `r` from it, and its gradient.
struct Potential {
  double value = 0;
  Vec3 gradient{};

  void add(double factor, Vec3 r) {  // factor / |r|
    const double one = 1 / norm(r);
    value += factor * one;
    gradient -= (factor * one * one * one) * r;
  }
};

/// Waves of a unit charge's images in the plane z = 0, with periods a and b, with the splitting parameter alpha (Parry
/// 1975, Surf. Sci. 49, 433; de Leeuw and Perram 1979, Mol. Phys. 37, 1313).
void add_waves(double alpha, double a, double b, Vec3 r, Potential& sum) {
  const double area = a * b, most = 12 * alpha / (2 * pi);  // the neglected waves are below exp(-36)
  const int most_x = static_cast<int>(most * a), most_y = static_cast<int>(most * b);
  // exp(k z) erfc(k / 2 alpha + alpha z), without overflow for large z, where it vanishes
  const auto wave = [&](double k, double z) {
    const double tail = std::erfc(k / (2 * alpha) + alpha * z);
    return tail > 0 ? std::exp(k * z) * tail : 0;
  };
  for (int x = -most_x; x <= most_x; ++x)
    for (int y = -most_y; y <= most_y; ++y) {
      if (x == 0 && y == 0) continue;
      const double kx = 2 * pi * x / a, ky = 2 * pi * y / b, k = std::hypot(kx, ky), phase = kx * r.x + ky * r.y;
      const double up = wave(k, r.z), down = wave(k, -r.z);
      sum.value += pi / area * std::cos(phase) / k * (up + down);
      const double across = -pi / area * std::sin(phase) / k * (up + down);
      sum.gradient += Vec3{across * kx, across * ky, pi / area * std::cos(phase) * (up - down)};
    }
  sum.value -= 2 * std::sqrt(pi) / area *
               (std::exp(-alpha * alpha * r.z * r.z) / alpha + std::sqrt(pi) * r.z * std::erf(alpha * r.z));
  sum.gradient.z -= 2 * pi / area * std::erf(alpha * r.z);
}

/// Potential of a unit charge and its images in a layer that is periodic along x and y, with zero potential of a plane
/// in the plane itself. `self`: without the charge itself, which is at r = 0.
Potential in_layer(Vec3 lengths, Vec3 r, bool self) {
  const double alpha = 3.3 / std::min(lengths.x, lengths.y);
  Potential sum;
  for (int x = -2; x <= 2; ++x)
    for (int y = -2; y <= 2; ++y) {
      if (self && x == 0 && y == 0) continue;
      const Vec3 at = r + Vec3{x * lengths.x, y * lengths.y, 0};
      const double d = norm(at), screened = std::erfc(alpha * d) / d;
      sum.value += screened;
      sum.gradient -= ((screened + 2 * alpha / std::sqrt(pi) * std::exp(-alpha * alpha * d * d)) / (d * d)) * at;
    }
  if (self) sum.value -= 2 * alpha / std::sqrt(pi);
  add_waves(alpha, lengths.x, lengths.y, r, sum);
  return sum;
}

/// Potential of a unit charge without periodic images.
Potential alone(Vec3, Vec3 r, bool self) {
  Potential sum;
  if (!self) sum.add(1, r);
  return sum;
}

/// Potential of a unit charge in a wire that is periodic along x; its images add up to a line, whose mean is subtracted
/// image by image. Beyond some images the rest of the sum is an integral.
Potential in_wire(Vec3 lengths, Vec3 r, bool self) {
  constexpr int images = 2000;
  const double length = lengths.x, end = (images + 0.5) * length;
  Potential sum;
  for (int x = -images; x <= images; ++x)
    if (!self || x != 0) sum.add(1, r + Vec3{x * length, 0, 0});
  // The integral of 1/r over the line beyond `end`, less that of the potential -2 log(distance) of the whole line.
  sum.value -= 2 * std::log(2 * end) / length;
  return sum;
}

using PairPotential = Potential (*)(Vec3, Vec3, bool);

/// Sums over pairs and images in grounded sides. Two grounded sides along z have images at all distances 2 n H. In
/// layers the sum from -n to n contains a uniform field, -4 pi times the dipole moment per volume. It is subtracted,
/// because both conductors have the potential 0.
Response by_images(const Enclosure& enclosure, const SourceSet& sources, PairPotential pair) {
  const bool both = enclosure.sides[4] == g && enclosure.sides[5] == g;
  SourceSet all = sources;
  append_images(enclosure, all.position, all.charge, all.dipole);
  const int far = !both ? 0 : pair == alone ? 300 : 3;
  Response response;
  resize(response, sources.size());
  double moment = 0;  // 4 pi times the dipole moment along z per volume
  for (int j = 0; j < sources.size() && both && pair == in_layer; ++j)
    moment += 4 * pi * sources.charge[j] * sources.position[3 * j + 2] /
              (enclosure.lengths.x * enclosure.lengths.y * enclosure.lengths.z);
  for (int i = 0; i < sources.size(); ++i) {
    Potential sum;
    for (int j = 0; j < all.size(); ++j)
      for (int n = -far; n <= far; ++n) {
        const Vec3 r =
            Sources(all).position_of(i) - Sources(all).position_of(j) + Vec3{0, 0, 2 * n * enclosure.lengths.z};
        const Potential one = pair(enclosure.lengths, r, i == j && n == 0);
        sum.value += all.charge[j] * one.value;
        sum.gradient += all.charge[j] * one.gradient;
      }
    sum.value -= moment * sources.position[3 * i + 2];
    sum.gradient.z -= moment;
    store(i, {sum.value, -1.0 * sum.gradient, -all.charge[i] * sum.gradient}, response);
    response.energy += 0.5 * all.charge[i] * sum.value;
  }
  return response;
}

SourceSet box_of_charges(int n, Vec3 lengths, unsigned seed) {
  SourceSet sources = random_sources(n, lengths, 1, false, seed);
  for (int i = 0; i < n; ++i)
    for (int k = 0; k < 3; ++k)
      sources.position[3 * i + k] = std::clamp(sources.position[3 * i + k], 0.5, std::max(0.5, lengths[k] - 0.5));
  return sources;
}

std::unique_ptr<Sum> sum_for(const Enclosure& enclosure, const SourceSet& sources, double accuracy) {
  const MeshRequest request{.accuracy = accuracy, .charges = sources.size(), .contact = 1};
  const MeshChoice choice = choose_bounded_mesh(request, enclosure, sources);
  return std::make_unique<BoundedSum>(request, enclosure, choice);
}

struct Case {
  std::string name;
  Enclosure enclosure;
  PairPotential pair;
};

}  // namespace

// Images in two grounded sides are neglected beyond 3 periods in a layer, where their field is below exp(-6 pi H / L),
// and beyond n = 300 periods without periodic sides, where it decays as n^-3.
TEST_CASE("bounded sum: forces have the requested accuracy, for all kinds of sides") {
  const std::vector<Case> cases = {
      {"cube without images", {{9, 8, 7}, {o, o, o, o, o, o}}, alone},
      {"layer", {{9, 8, 7}, {p, p, p, p, o, o}}, in_layer},
      {"thin layer", {{14, 12, 1}, {p, p, p, p, o, o}}, in_layer},
      {"thick layer", {{5, 6, 20}, {p, p, p, p, o, o}}, in_layer},
      {"layer between grounded sides", {{9, 8, 7}, {p, p, p, p, g, g}}, in_layer},
      {"layer on a grounded side", {{9, 8, 7}, {p, p, p, p, g, o}}, in_layer},
      {"layer below a grounded side", {{9, 8, 7}, {p, p, p, p, o, g}}, in_layer},
      {"wire", {{9, 8, 7}, {p, p, o, o, o, o}}, in_wire},
      {"half space", {{9, 8, 7}, {o, o, o, o, g, o}}, alone},
      {"between grounded sides", {{9, 8, 7}, {o, o, o, o, g, g}}, alone},
  };
  for (const Case& one : cases)
    for (const double accuracy : {1e-3, 1e-6}) {
      CAPTURE(one.name);
      CAPTURE(accuracy);
      const SourceSet sources = box_of_charges(40, one.enclosure.lengths, 3);
      const auto sum = sum_for(one.enclosure, sources, accuracy);
      const Response found = evaluated(*sum, sources), exact = by_images(one.enclosure, sources, one.pair);
      const double error = relative_difference(found.force, exact.force);
      CHECK(error < accuracy);
      CHECK(error > accuracy / 50);
      CHECK(relative_difference(found.potential, exact.potential) < 3 * accuracy);
      CHECK(found.energy == Approx(exact.energy).epsilon(3 * accuracy));
      std::vector<double> force;
      sum->forces(sources, {}, parallel::Team::single(), force);
      CHECK(force == found.force);
    }
}

// Errors follow from spacing, cut-off and order, whatever the box: four random boxes of each kind.
TEST_CASE("bounded sum: forces have the requested accuracy in random boxes") {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> unit(0, 1);
  const std::vector<Case> kinds = {{"space", {{}, {o, o, o, o, o, o}}, alone},
                                   {"layer", {{}, {p, p, p, p, o, o}}, in_layer},
                                   {"grounded", {{}, {p, p, p, p, g, g}}, in_layer},
                                   {"grounded below", {{}, {p, p, p, p, g, o}}, in_layer}};
  for (Case one : kinds)
    for (int box = 0; box < 4; ++box) {
      one.enclosure.lengths = {5 + 8 * unit(random), 5 + 8 * unit(random), 3 + 12 * unit(random)};
      const double accuracy = std::pow(10, -2 - 4 * unit(random));
      CAPTURE(one.name);
      CAPTURE(box);
      const SourceSet sources = box_of_charges(16 + box, one.enclosure.lengths, box);
      const auto sum = sum_for(one.enclosure, sources, accuracy);
      const Response exact = by_images(one.enclosure, sources, one.pair);
      CHECK(relative_difference(evaluated(*sum, sources).force, exact.force) < accuracy);
    }
}

// An unbounded box uses pairs for few charges and a mesh for many, here both for the same cloud.
TEST_CASE("bounded sum: a cloud without sides keeps the accuracy while it expands") {
  for (const double accuracy : {1e-2, 1e-6})
    for (const double size : {1.0, 1.7, 30.0}) {
      CAPTURE(accuracy);
      CAPTURE(size);
      SourceSet sources = random_sources(400, {12, 12, 12}, 1, false, 11);
      for (double& x : sources.position) x = size * x - 50;
      const Enclosure unbounded{.unbounded = true};
      const MeshRequest request{.accuracy = accuracy, .charges = sources.size(), .contact = 1};
      BoundedSum sum(request, unbounded, {});
      const Response found = evaluated(sum, sources), exact = by_images(unbounded, sources, alone);
      CHECK(relative_difference(found.force, exact.force) < accuracy);
      CHECK(found.energy == Approx(exact.energy).epsilon(3 * accuracy));
      SourceSet few = sources;
      few.position.resize(3 * BoundedSum::few), few.charge.resize(BoundedSum::few);
      const Response pairs = evaluated(sum, few);
      CHECK(relative_difference(pairs.force, by_images(unbounded, few, alone).force) < 1e-12);
    }
}

// The mesh scales with the cloud. A mesh that is chosen again changes forces by some of their error, which is 1e-2 here.
TEST_CASE("bounded sum: forces of a cloud that keeps its shape scale with it") {
  const Enclosure unbounded{.unbounded = true};
  SourceSet sources = random_sources(400, {40, 40, 40}, 1, false, 11);
  const MeshRequest request{.accuracy = 1e-2, .charges = sources.size(), .contact = 1};
  BoundedSum sum(request, unbounded, {});
  const Response before = evaluated(sum, sources);
  for (const int eighths : {1, 5, 13, 40}) {
    const double by = std::exp2(eighths / 8.0);
    SourceSet larger = sources;
    for (double& x : larger.position) x *= by;
    Response found = evaluated(sum, larger);
    for (double& f : found.force) f *= by * by;
    CHECK(relative_difference(found.force, before.force) < 1e-5);
    CHECK(by * found.energy == Approx(before.energy).epsilon(1e-5));
  }
}

TEST_CASE("bounded sum: forces are slopes of the energy, dipoles have images") {
  for (const Side upper : {o, g}) {
    const Enclosure enclosure{{9, 8, 7}, {p, p, o, o, g, upper}};
    SourceSet sources = random_sources(20, enclosure.lengths, 1, true, 5);
    const MeshRequest request{.accuracy = 1e-5, .charges = sources.size(), .contact = 1, .polarizability = 0.05};
    const MeshChoice choice = choose_bounded_mesh(request, enclosure, sources);
    BoundedSum sum(request, enclosure, choice);
    const Response found = evaluated(sum, sources);
    for (const int c : {2, 3, 13}) {
      double& x = sources.position[c];
      const double slope = energy_slope(x, 1e-2, [&] { return evaluated(sum, sources).energy; });
      CHECK(-slope == Approx(found.force[c]).epsilon(1e-4).scale(largest(found.force)));
    }
    for (const int c : {2, 4, 12}) {
      const double slope = energy_slope(sources.dipole[c], 0.1, [&] { return evaluated(sum, sources).energy; });
      CHECK(-slope == Approx(found.field[c]).epsilon(1e-4).scale(largest(found.field)));
    }
  }
}

// The force of a plate on a charge at height z above it is that of its image, q^2 / (4 z^2), and the energy half of the
// pair's.
TEST_CASE("bounded sum: a charge near a grounded side, beyond it, in a thin box") {
  const Enclosure enclosure{{10, 10, 10}, {o, o, o, o, g, o}};
  SourceSet sources{.lengths = enclosure.lengths, .position = {5, 5, 0.5}, .charge = {2}};
  const auto sum = sum_for(enclosure, sources, 1e-5);
  const Response response = evaluated(*sum, sources);
  CHECK(response.force[2] == Approx(-4).epsilon(1e-4));
  CHECK(response.energy == Approx(-2).epsilon(1e-4));
  sources.position[2] = -0.1;
  CHECK_THROWS_WITH_AS(evaluated(*sum, sources), doctest::Contains("charge 0 has left the domain through the front"),
                       Failure);
  const Enclosure thin{{10, 10, 0.6}, {p, p, p, p, g, g}};
  sources.position[2] = 0.3;
  CHECK_THROWS_WITH_AS(
      sum_for(thin, sources, 1e-4),
      doctest::Contains("accuracy 0.0001 in a domain of 10 x 10 x 0.6, with images in grounded sides: no "),
      InputError);
}

}  // namespace periodic_bounded_test
