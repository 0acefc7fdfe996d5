#include <doctest/doctest.h>

#include <cmath>
#include <random>
#include <utility>

#include "solvers/neighbours/pairs.hpp"
#include "solvers/parallel/host_executor.hpp"
#include "src/effects/contact_law.hpp"
#include "src/effects/hertz.hpp"
#include "src/model/pair_loop.hpp"
#include "src/model/pair_part.hpp"
#include "tests/partner_table.hpp"
#include "tests/screened_coulomb.hpp"

namespace effects_pairs_test {

using namespace lichtenberg;

namespace {

template <int d>
Box<d> periodic_box(double length) {
  Box<d> box;
  for (int k = 0; k < d; ++k) box.lengths[k] = length;
  box.sides.fill(Boundary::periodic);
  return box;
}

/// Particles of radius 0.3 to 0.5 at random positions of a periodic box, and their pairs.
template <int d>
struct RandomSpheres {
  RandomSpheres(int n, double length) : box(periodic_box<d>(length)) {
    std::mt19937 random(1);
    std::uniform_real_distribution<double> coordinate(0, length), size(0.3, 0.5);
    for (int i = 0; i < n; ++i) radius.push_back(size(random));
    for (int k = 0; k < n * d; ++k) position.push_back(coordinate(random));
    pairs = pairs_closer_than(spheres(), 0.1);
  }
  Spheres<d> spheres() const { return {position, radius, box}; }

  Box<d> box;
  std::vector<double> position, radius;
  std::vector<Pair> pairs;
};

template <int d, class Law>
void check_law(const Law& law, const RandomSpheres<d>& particles) {
  const Spheres<d> spheres = particles.spheres();
  parallel::Team three(3);
  std::vector<double> alone(particles.position.size()), shared(alone);
  const PairSum sum = add_pair_forces(law, spheres, particles.pairs, alone, parallel::Team::single());
  CHECK(add_pair_forces(law, spheres, particles.pairs, shared, three).energy == sum.energy);
  CHECK(shared == alone);
  if constexpr (d == 3) {
    const parallel::HostExecutor run;
    const PartnerTable<parallel::HostExecutor> table(run, particles.pairs, spheres.size());
    const DeviceGrains grains{.count = spheres.size(),
                              .box = particles.box,
                              .position = reinterpret_cast<const Vec3*>(particles.position.data()),
                              .radius = particles.radius.data(),
                              .partners = table.view()};
    std::vector<FixedPointVec> force(spheres.size());
    std::int64_t energy = 0;
    const PairUnits quanta{0x1p-44, 0x1p-44};
    PairPart<Law, parallel::HostExecutor>(run, law, {}).add_forces(grains, quanta, force.data(), &energy);
    // About ten terms of a sum, each rounded to a quantum and by 1e-16 of the largest.
    double largest = 0;
    for (const double f : alone) largest = std::max(largest, std::abs(f));
    for (int i = 0; i < spheres.size(); ++i)
      for (int k = 0; k < 3; ++k)
        CHECK(std::abs(force[i].times(quanta.force)[k] - alone[3 * i + k]) < 20 * quanta.force + 1e-13 * largest);
    CHECK(quanta.energy * static_cast<double>(energy) ==
          doctest::Approx(law.energy_unit() * sum.energy).epsilon(1e-12));
  }
}

}  // namespace

TEST_CASE("add_pair_forces: threads give identical bits, device algorithm agrees") {
  const RandomSpheres<2> plane(6000, 60);
  const RandomSpheres<3> space(6000, 16);
  REQUIRE(space.pairs.size() > 6000);
  check_law(effects::HertzLaw{2}, plane);
  check_law(effects::HertzLaw{2}, space);
  check_law(effects::ContactPotentialLaw{2}, plane);
  check_law(effects::ContactPotentialLaw{2}, space);
  check_law(ScreenedCoulombLaw{1, 0.5, 0.9}, space);
}

TEST_CASE("ContactPotentialLaw::quick: equals the full law at small overlaps") {
  const effects::ContactPotentialLaw law{3};
  for (double q = 0.8; q < 1; q += 0.01) {
    const PairGeometry pair{.distance = 2 * q, .reach = 2};
    REQUIRE(law.quick_holds(pair));
    CHECK(law.quick(pair).energy == doctest::Approx((q - 1) * std::log(q)).epsilon(1e-13).scale(0));
    CHECK(law.quick(pair).force == doctest::Approx(law(pair).force).epsilon(1e-13).scale(0));
  }
  CHECK_FALSE(law.quick_holds({.distance = 1.5, .reach = 2}));
}

TEST_CASE("Hertz force across periodic faces: equals that inside the box") {
  const effects::HertzLaw law{1e3};
  const std::vector<double> radius = {0.5, 0.5};
  const std::vector<Pair> pairs = {{0, 1}};
  const auto forces = [&](std::vector<double> position) {
    std::vector<double> force(6);
    add_pair_forces(law, Spheres<3>{position, radius, periodic_box<3>(8)}, pairs, force, parallel::Team::single());
    return force;
  };
  // Positions and differences are sums of powers of two, so wrapping loses no bit.
  const std::vector<double> inside = forces({4, 4, 4, 4.5, 4.25, 3.75});
  CHECK(inside[0] < 0);
  CHECK(forces({7.75, 7.875, 0.125, 0.25, 0.125, 7.875}) == inside);
  CHECK(forces({-0.25, 7.875, 16.125, 0.25, 0.125, 7.875}) == inside);
  CHECK(inside[3] == -inside[0]);
}

TEST_CASE("Hertz forces in a periodic box: equal negative energy derivatives") {
  RandomSpheres<3> particles(400, 6.5);
  const effects::HertzLaw law{5};
  const auto energy = [&] {
    double sum = 0;
    for_each_in_reach(law, particles.spheres(), particles.pairs,
                      [&](const auto& found) { sum += law(found.geometry).energy; });
    return sum;
  };
  std::vector<double> force(particles.position.size());
  const PairSum sum = add_pair_forces(law, particles.spheres(), particles.pairs, force, parallel::Team::single());
  CHECK(sum.energy == doctest::Approx(energy()).epsilon(1e-13));
  const double h = 1e-6;  // Truncation: h^2 times a third derivative of 10 to 1000 N/m^2; rounding 1e-16 * 1e3 / h.
  for (int k = 0; k < 60; ++k) {
    const double at = std::exchange(particles.position[k], particles.position[k] + h), above = energy();
    particles.position[k] = at - h;
    const double below = energy();
    particles.position[k] = at;
    CHECK(std::abs((below - above) / (2 * h) - force[k]) < 1e-6);
  }
}

}  // namespace effects_pairs_test
