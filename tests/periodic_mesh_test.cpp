// Tests of Coulomb sums on a mesh: their parts, and the sum against Ewald's.
#include <doctest/doctest.h>

#include <atomic>
#include <chrono>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <numeric>
#include <thread>

#include "solvers/error.hpp"
#include "solvers/periodic/accuracy.hpp"
#include "solvers/periodic/mesh.hpp"
#include "tests/message.hpp"
#include "tests/periodic_sources.hpp"
#include "tests/source_folder.hpp"

namespace periodic_mesh_test {

using namespace lichtenberg;
using namespace lichtenberg::periodic;

namespace {

Response by_mesh(const SourceSet& sources, const Mesh& mesh, const Cloud& cloud) {
  ParticleMesh sum(mesh, cloud);
  return evaluated_on(sum, sources);
}

Response by_accuracy(const SourceSet& sources, double accuracy, double contact) {
  const MeshChoice choice = choose_mesh(accuracy, sources.size(), sources.lengths, contact);
  return by_mesh(sources, choice.mesh, prolate_cloud(choice.band_limit, choice.cutoff));
}

void neutralize(SourceSet& sources) {
  const double mean = std::accumulate(sources.charge.begin(), sources.charge.end(), 0.0) / sources.size();
  for (double& q : sources.charge) q -= mean;
}

/// 300 charges at the density of G's gas.
SourceSet gas(unsigned seed, Vec3 lengths = {12.8, 12.8, 12.8}) { return random_sources(300, lengths, 1, false, seed); }

/// Balls of touching grains in an empty box.
SourceSet clusters() {
  SourceSet sources{.lengths = {20, 20, 20}};
  std::mt19937 random(5);
  std::uniform_real_distribution<double> unit(-1, 1);
  for (const Vec3 centre : {Vec3{5, 5, 5}, Vec3{14, 12, 6}})
    for (int x = -3; x <= 3; ++x)
      for (int y = -3; y <= 3; ++y)
        for (int z = -3; z <= 3; ++z) {
          if (x * x + y * y + z * z > 10) continue;
          sources.position.insert(sources.position.end(),
                                  {centre.x + 1.02 * x, centre.y + 1.02 * y, centre.z + 1.02 * z});
          sources.charge.push_back(unit(random));
        }
  neutralize(sources);
  return sources;
}

}  // namespace

TEST_CASE("spline windows: weights sum to one and reproduce linear functions") {
  for (int order = 4; order <= 8; ++order) {
    const auto pieces = window_pieces(Window::spline, order);
    for (const double at : {-0.5, -0.2, 0.0, 0.49}) {
      double sum = 0, mean = 0, power = 1;
      for (const std::vector<double>& coefficients : pieces) {
        for (int c = 0; c < order; ++c) sum += coefficients[c] * power, mean += coefficients[c] * power * c;
        power *= at;
      }
      CHECK(sum == doctest::Approx(1).epsilon(1e-14));
      CHECK(mean == doctest::Approx(at + 0.5 * (order - 1)).epsilon(1e-14));
    }
  }
}

TEST_CASE("charge clouds: potential, transform and background are consistent") {
  const double alpha = 0.8, cutoff = 5;
  CHECK(gauss_cloud(alpha, cutoff).background == doctest::Approx(M_PI / (alpha * alpha)));
  CHECK(gauss_cloud(alpha, cutoff).potential(0) == doctest::Approx(gauss_cloud(alpha, cutoff).potential(1e-5)));
  for (const Cloud& cloud : {gauss_cloud(alpha, cutoff), prolate_cloud(9, cutoff), prolate_cloud(20, cutoff)}) {
    // The integral of the transform over all waves is the potential at one position. Simpson's rule integrates the near
    // rest.
    const int steps = 4000;
    const double limit = std::min(cloud.band_limit, 12.0), dk = limit / steps, dr = cutoff / steps;
    const auto weight = [&](int n) { return (n == 0 || n == steps ? 1.0 : n % 2 ? 4.0 : 2.0) / 3; };
    for (const double r : {0.3, 1.0, 2.5, 4.5}) {
      double sum = 0;
      for (int n = 0; n <= steps; ++n)
        sum += weight(n) * dk * cloud.transform(n * dk) * (n == 0 ? 1 : std::sin(n * dk * r) / (n * dk * r));
      // The prolate cloud omits 1e-3 to 1e-8 beyond the band limit, the square root of `neglected`.
      CHECK(std::abs(2 / M_PI * sum - cloud.potential(r)) < std::sqrt(cloud.neglected));
    }
    double near = 0;
    for (int n = 1; n <= steps; ++n)
      near += weight(n) * dr * 4 * M_PI * n * dr * (1 - n * dr * cloud.potential(n * dr));
    CHECK(near == doctest::Approx(cloud.background).epsilon(1e-6));  // erfc(4), 2e-8, is omitted.
    // The next term is (k r)^2 / 20 of this one, with waves up to k = 4.
    const double r = 1e-3;
    const double curvature = 2 * (cloud.potential(r) - cloud.potential(0)) / (r * r);
    CHECK(-curvature == doctest::Approx(cloud.dipole_field).epsilon(1e-6));
  }
  CHECK(prolate_cloud(9, cutoff).potential(5.5) == 1 / 5.5);
}

TEST_CASE("mesh sum of twenty charges: forces and energy accurate to 1e-6") {
  std::ifstream file(source_folder() + "/validation/data/periodic/ewald20.json");
  const nlohmann::json exact = nlohmann::json::parse(file);
  const auto numbers = [&](const char* name) {
    std::vector<double> result;
    for (const auto& value : exact[name].flatten())
      result.push_back(value.is_string() ? std::stod(std::string(value)) : double(value));
    return result;
  };
  const double length = exact["length"];
  const SourceSet sources{{length, length, length}, numbers("position"), numbers("charge")};
  for (const Cloud& cloud : {gauss_cloud(0.85, 5), prolate_cloud(18, 5)}) {
    const Mesh mesh{sources.lengths, {40, 40, 40}, 7};
    const Response response = by_mesh(sources, mesh, cloud);
    // Twenty charges are few for a statistical estimate; the bound has a factor of three.
    const double bound = 3 * relative_error(mesh, cloud, 1);
    CHECK(bound < 1e-6);
    CHECK(relative_difference(response.force, numbers("force")) < bound);
    CHECK(relative_difference(response.potential, numbers("potential")) < bound);
    CHECK(response.energy == doctest::Approx(std::stod(std::string(exact["energy"]))).epsilon(bound));
  }
}

TEST_CASE("mesh sum: Madelung's constants of rock salt and of a single charge") {
  // Two unit cells per side, because half a box is too short a cutoff for an accuracy of 1e-6.
  SourceSet salt{.lengths = {4, 4, 4}};
  for (int n = 0; n < 64; ++n) {
    const int x = n % 4, y = n / 4 % 4, z = n / 16;
    for (const int coordinate : {x, y, z}) salt.position.push_back(coordinate);
    salt.charge.push_back((x + y + z) % 2 == 0 ? 1 : -1);
  }
  // The errors of charges in a lattice have equal signs: up to N^(1/2) times those of random charges.
  CHECK(by_accuracy(salt, 1e-6, 1).energy / 32 == doctest::Approx(-1.7475645946331822).epsilon(1e-5));
  for (const Vec3 position : {Vec3{0, 0, 0}, Vec3{0.1, 0.2, 0.3}}) {
    const SourceSet lone = lattice(1, {position}, {1});
    const Response response = by_mesh(lone, {lone.lengths, {24, 24, 24}, 7}, prolate_cloud(14, 0.5));
    CHECK(2 * response.energy == doctest::Approx(-2.8372974794806195).epsilon(1e-5));
    CHECK(largest(response.force) < 1e-15);  // The only force is the mesh's net force, which is subtracted.
  }
}

TEST_CASE("mesh sum: self-energy is independent of the position on the mesh") {
  const Mesh mesh{{1, 1, 1}, {12, 12, 12}, 6};
  std::vector<double> energy;
  for (const double position : {0.0, 0.02, 0.04, 0.06})
    energy.push_back(by_mesh(lattice(1, {{position, 0.5 * position, 0.3}}, {1}), mesh, prolate_cloud(9, 0.5)).energy);
  // Without the correction the two subtracted waves would contribute 1.3e-5 and 1.6e-7; the remaining waves are
  // shorter.
  const auto [least, most] = std::ranges::minmax(energy);
  CHECK(most - least < 5e-8);
}

TEST_CASE("mesh sum of random charges: errors are 0.5 to 2 times the estimate") {
  for (const Vec3 lengths : {Vec3{12.8, 12.8, 12.8}, Vec3{10, 20, 10.5}}) {
    const SourceSet sources = gas(1, lengths);
    const Response exact = by_ewald(sources, 1e-11);
    for (const Cloud& cloud : {gauss_cloud(0.75, 4.5), prolate_cloud(10, 4.5)})
      for (int order = 4; order <= 7; ++order)
        for (const double spacing : {1.3, 0.8}) {
          Mesh mesh{lengths, {}, order};
          for (int k = 0; k < 3; ++k) mesh.points[k] = std::max(2 * order, static_cast<int>(lengths[k] / spacing));
          const Response response = by_mesh(sources, mesh, cloud);
          const double estimate = relative_error(mesh, cloud, 1);
          const double error = relative_difference(response.force, exact.force);
          CAPTURE(order);
          CAPTURE(spacing);
          CHECK(error < 2 * estimate);
          CHECK(error > estimate / 2);
          // Potentials and the energy need fewer waves than forces.
          CHECK(relative_difference(response.potential, exact.potential) < 2 * estimate);
        }
  }
}

TEST_CASE("choose_mesh: force errors are 0.1 to 2 times the requested accuracy") {
  for (const SourceSet& sources : {gas(2), clusters()}) {
    const Response exact = by_ewald(sources, 1e-11);
    for (const double accuracy : {1e-2, 1e-3, 1e-4, 1e-6}) {
      const double error = relative_difference(by_accuracy(sources, accuracy, 1).force, exact.force);
      CAPTURE(accuracy);
      CHECK(error < 2 * accuracy);
      CHECK(error > 0.1 * accuracy);
    }
  }
}

TEST_CASE("choose_measured_mesh: counts the partners of charges in a cluster") {
  constexpr double accuracy = 1e-3;
  SourceSet sources = random_sources(1000, {20, 20, 20}, 1, false, 4);
  MeshRequest request{.accuracy = accuracy, .charges = 1000, .lengths = {20, 20, 20}};
  CHECK(choose_measured_mesh(request, sources).mesh.open.volume == 0);
  sources.lengths = request.lengths = {200, 200, 200};
  for (double& x : sources.position) x += 190;  // across the sides of the box
  const MeshChoice choice = choose_measured_mesh(request, sources);
  CHECK(choice.error < accuracy);
  CHECK(choice.cutoff < choose_quick_mesh(request).cutoff);
  CHECK(choice.mesh.open.volume > 4000);
  CHECK(choice.mesh.open.volume < 32000);
  CHECK(seconds_of(choice, request) > seconds_of({.mesh = choice.mesh, .cutoff = 1, .single = choice.single}, request));
}

TEST_CASE("mesh sum with net charge: equals Ewald's for four charge clouds") {
  SourceSet sources = gas(3);
  for (double& q : sources.charge) q += 0.5;
  const Response exact = by_ewald(sources);
  for (const double band_limit : {19.0, 20.5})
    for (const double cutoff : {5.0, 6.0}) {
      const Response response = by_mesh(sources, {sources.lengths, {48, 48, 48}, 7}, prolate_cloud(band_limit, cutoff));
      CHECK(response.energy == doctest::Approx(exact.energy).epsilon(1e-6));
      CHECK(relative_difference(response.potential, exact.potential) < 1e-6);
      CHECK(relative_difference(response.force, exact.force) < 1e-6);
    }
}

TEST_CASE("mesh sum, forces: negative energy slopes less shares of the net force") {
  SourceSet sources = random_sources(40, {6, 7, 8}, 0.5, false, 4);
  // The mesh is so coarse that its error of 1e-2 is visible.
  ParticleMesh sum({sources.lengths, {12, 12, 12}, 5}, prolate_cloud(8, 2.9));
  const Response at = evaluated_on(sum, sources);
  Vec3 net;
  for (int i = 0; i < sources.size(); ++i)
    for (int k = 0; k < 3; ++k) net[k] += at.force[3 * i + k];
  CHECK(norm(net) < 1e-14 * sources.size() * largest(at.force));
  const double square = std::inner_product(sources.charge.begin(), sources.charge.end(), sources.charge.begin(), 0.0);
  const double step = 1e-4;
  std::vector<double> slope(sources.position.size()), missing(3);
  for (std::size_t k = 0; k < slope.size(); ++k) {
    const double x = sources.position[k];
    sources.position[k] = x + step;
    const double above = evaluated_on(sum, sources).energy;
    sources.position[k] = x - step;
    const double below = evaluated_on(sum, sources).energy;
    sources.position[k] = x;
    slope[k] = -(above - below) / (2 * step);
    missing[k % 3] += slope[k] / square;
  }
  CHECK(largest(missing) > 1e-5);  // The net force of the slopes is not zero.
  for (std::size_t k = 0; k < slope.size(); ++k)
    // Third derivatives are 6 / r^4 per pair, 100 at the smallest distance: the error is step^2 / 6 of that, and
    // rounding of about 10 divided by the step.
    CHECK(std::abs(slope[k] - missing[k % 3] * std::pow(sources.charge[k / 3], 2) - at.force[k]) < 1e-6);
}

// The mesh has the period of the shift, so that forces change by rounding only.
TEST_CASE("mesh sum: a cluster that moves leaves nothing behind on the mesh") {
  SourceSet sources = random_sources(60, {4, 4, 4}, 0.5, false, 6);
  sources.lengths = {32, 32, 32};
  const Mesh mesh{sources.lengths, {64, 64, 64}, 5};
  const Cloud cloud = prolate_cloud(8, 2);
  ParticleMesh sum(mesh, cloud);
  const Response before = evaluated(sum, sources);
  for (const double shift : {15.0, 30.0}) {
    for (double& x : sources.position) x += shift;
    const Response moved = evaluated(sum, sources);
    ParticleMesh fresh(mesh, cloud);
    CHECK(moved.force == evaluated(fresh, sources).force);
    CHECK(relative_difference(moved.force, before.force) < 1e-12);
  }
  CHECK(relative_difference(before.force, by_ewald(sources, 1e-10).force) < 1e-3);
}

TEST_CASE("mesh tiles: tiles processed concurrently reach no common charge") {
  const SourceSet sources = random_sources(1500, {30, 20, 12}, 0.5, false, 10);
  const double reach = 2.4;
  Columns<double> columns(sources.lengths, {.together = 8, .widest = 4, .reach = reach});
  columns.sort(sources, parallel::Team::single());
  const auto position = [&](int s, int k) { return 0x1p-64 * columns.coordinate(k)[s] * sources.lengths[k]; };
  std::vector<std::atomic<int>> reached(sources.size());
  std::atomic<int> conflicts = 0, seen = 0;
  parallel::Team team(4);
  columns.for_each_tile(team, [&](int first_column, int end_column) {
    const int first = columns.begin(first_column), end = columns.begin(end_column);
    std::vector<bool> mine(sources.size());
    for (int s = first; s < end; ++s)
      for (int other = 0; other < sources.size(); ++other) {
        double farthest = 0;
        for (int k = 0; k < 2; ++k) {
          const double separation = position(s, k) - position(other, k);
          farthest = std::max(farthest, std::abs(std::remainder(separation, sources.lengths[k])));
        }
        if (farthest < reach) mine[other] = true;
      }
    for (int k = 0; k < sources.size(); ++k)
      if (mine[k]) conflicts += reached[k].fetch_add(1) > 0;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));  // Gives other threads time to join.
    for (int k = 0; k < sources.size(); ++k)
      if (mine[k]) --reached[k];
    seen += end - first;
  });
  CHECK(conflicts == 0);
  // Points are spread to within half a spline, in units of the largest spacing.
  CHECK(reach_of({{8, 8, 12}, {16, 16, 16}, 5}) == 2.5 * 0.75);
  CHECK(seen == sources.size());
}

TEST_CASE("mesh sum: threads and pairs beyond the cutoff change no bit") {
  const SourceSet sources = random_sources(2000, {30, 24, 21}, 0.5, false, 5);
  const Mesh fine{sources.lengths, {36, 30, 24}, 5}, coarse{sources.lengths, {14, 14, 14}, 7};
  ParticleMesh near_reaches_far(fine, prolate_cloud(8, 3)), mesh_reaches_far(coarse, prolate_cloud(2, 0.6));
  for (ParticleMesh* sum : {&near_reaches_far, &mesh_reaches_far}) {
    const Response expected = evaluated_on(*sum, sources);
    for (const int threads : {1, 2, 4})
      for (const double skin : {0.0, 0.7}) {
        parallel::Team team(threads);
        const Response response = evaluated_on(*sum, sources, skin, team);
        CHECK(response.potential == expected.potential);
        CHECK(response.field == expected.field);
        CHECK(response.force == expected.force);
        CHECK(response.energy == expected.energy);
      }
  }
}

TEST_CASE("mesh sum: scaling lengths and charges by powers of two is exact") {
  const SourceSet sources = gas(6);
  SourceSet scaled = sources;
  for (double& x : scaled.position) x *= 2;
  for (int k = 0; k < 3; ++k) scaled.lengths[k] *= 2;
  for (double& q : scaled.charge) q *= 0.25;
  const auto response_of = [](const SourceSet& charges, double unit) {
    return by_mesh(charges, {charges.lengths, {16, 18, 20}, 6}, prolate_cloud(9, 4 * unit));
  };
  const Response expected = response_of(sources, 1), response = response_of(scaled, 2);
  CHECK(response.energy == expected.energy / 32);
  for (int i = 0; i < sources.size(); ++i) CHECK(response.potential[i] == expected.potential[i] / 8);
  for (int k = 0; k < 3 * sources.size(); ++k) CHECK(response.force[k] == expected.force[k] / 64);
}

TEST_CASE("mesh sum: shifts by whole spacings and boxes change only rounding") {
  const SourceSet sources = gas(7);
  const Mesh mesh{sources.lengths, {16, 16, 16}, 5};
  SourceSet moved = sources;
  for (int i = 0; i < sources.size(); ++i)
    for (int k = 0; k < 3; ++k)
      moved.position[3 * i + k] += (k + 3) * mesh.spacing()[k] + (i % 5 - 2) * sources.lengths[k];
  const Cloud cloud = prolate_cloud(9, 4);
  const Response expected = by_mesh(sources, mesh, cloud), response = by_mesh(moved, mesh, cloud);
  // Positions are rounded by 1e-15 of several lengths; the gradients of the forces multiply this by 2 over a distance
  // of 1.
  CHECK(largest_difference(response.force, expected.force) < 1e-13 * largest(expected.force));
  CHECK(response.energy == doctest::Approx(expected.energy).epsilon(1e-12));
}

TEST_CASE("mesh sum without charges: energy and forces are zero") {
  const Mesh mesh{{10, 10, 10}, {16, 16, 16}, 4};
  CHECK(by_mesh(SourceSet{.lengths = mesh.lengths}, mesh, prolate_cloud(8, 4)).energy == 0);
  SourceSet sources = random_sources(5, mesh.lengths, 1, false, 8);
  std::ranges::fill(sources.charge, 0);
  CHECK(largest(by_mesh(sources, mesh, prolate_cloud(8, 4)).force) == 0);
}

TEST_CASE("mesh sum: impossible parameters are refused with an error message") {
  const Vec3 cube{10, 10, 10};
  const Cloud cloud = prolate_cloud(8, 4);
  const Mesh mesh{cube, {16, 16, 16}, 4};
  CHECK(message_of([&] {
          ParticleMesh({cube, {16, 16, 16}, 3}, cloud);
        }) == "windows of order 3 are not available: 4 to 7 are");
  CHECK(message_of([&] {
          ParticleMesh({cube, {16, 12, 16}, 7}, cloud);
        }) == "a mesh with 12 points along an axis is too coarse for windows of order 7: 14 are needed");
  CHECK(message_of([&] { ParticleMesh(mesh, prolate_cloud(8, 5.5)); }) ==
        "a cutoff of 5.5 is more than half of the box's 10: a charge would meet two images of one other");
  CHECK(message_of([&] {
          ParticleMesh({{10, 0, 10}, {16, 16, 16}, 4}, cloud);
        }) == "a periodic box has the lengths 10, 0 and 10: all must be positive and finite");
  CHECK(message_of([] { prolate_cloud(0.5, 1); }) ==
        "a cloud's band limit 0.5 must be from 1 to 100 and its cutoff 1 positive");
  CHECK(message_of([] { gauss_cloud(-1, 1); }) == "a cloud's alpha -1 and its cutoff 1 must be positive");
  SourceSet sources = random_sources(5, cube, 1, true, 9);
  CHECK(message_of([&] { by_mesh(sources, mesh, cloud); }) ==
        "dipoles on a mesh need splines of order 5 at least: these are of order 4");
  sources.dipole.clear();
  std::copy_n(sources.position.begin(), 3, sources.position.begin() + 6);
  CHECK(message_of([&] { by_mesh(sources, mesh, cloud); }) ==
        "the energy of the charges is not finite: two of them have the same position");
  ParticleMesh other({{10, 10, 11}, {16, 16, 16}, 4}, cloud);
  CHECK(message_of([&] { evaluated_on(other, sources); }) ==
        "the box is 10 x 10 x 10 long, but the mesh was made for 10 x 10 x 11");
  CHECK(message_of([&] { choose_mesh(1e-9, 100, cube, 1); }) ==
        "the accuracy 1e-09 is not possible for a mesh: it must be from 1e-8 to 0.1");
  CHECK(message_of([&] {
          choose_mesh(1e-8, 100, {1e4, 1, 1}, 0.4);
        }).starts_with("no mesh of up to 1024 points along a side reaches an accuracy of 1e-08"));
}

}  // namespace periodic_mesh_test
