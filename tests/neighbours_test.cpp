#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <tuple>

#include "solvers/error.hpp"
#include "solvers/neighbours/cell_order.hpp"
#include "solvers/neighbours/list.hpp"
#include "solvers/neighbours/reach_list.hpp"

namespace neighbours_test {

using namespace lichtenberg;

namespace {

template <int d>
Box<d> periodic_box(double length, int axes = d) {
  Box<d> box;
  for (int k = 0; k < d; ++k) box.lengths[k] = length;
  for (int k = 0; k < axes; ++k) box.sides[2 * k] = box.sides[2 * k + 1] = Boundary::periodic;
  return box;
}

struct SphereSet {
  std::vector<double> position, radius;
};

/// Returns n random particles in [-spread, 1 + spread] times a box of the given length.
SphereSet random_spheres(int n, int dimension, double length, double smallest, double largest, double spread,
                         unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> coordinate(-spread * length, (1 + spread) * length), radius(smallest, largest);
  SphereSet result;
  for (int i = 0; i < n; ++i) {
    for (int k = 0; k < dimension; ++k) result.position.push_back(coordinate(random));
    result.radius.push_back(radius(random));
  }
  return result;
}

/// Distance to the nearest image of the second particle within three box lengths.
template <int d>
double nearest(const Spheres<d>& s, int i, int j) {
  double sum = 0;
  for (int k = 0; k < d; ++k) {
    const int most_images = s.box.periodic(k) ? 3 : 0;
    double least = INFINITY;
    for (int image = -most_images; image <= most_images; ++image)
      least = std::min(least, std::abs(s.position[i * d + k] - s.position[j * d + k] + image * s.box.lengths[k]));
    sum += least * least;
  }
  return std::sqrt(sum);
}

template <int d>
std::vector<Pair> all_pairs(const Spheres<d>& s, double range, std::vector<double> reach = {}) {
  reach.resize(s.size());
  std::vector<Pair> pairs;
  for (int i = 0; i < s.size(); ++i)
    for (int j = i + 1; j < s.size(); ++j)
      if (nearest(s, i, j) - s.radius[i] - s.radius[j] < range + reach[i] + reach[j]) pairs.push_back({i, j});
  return pairs;
}

}  // namespace

TEST_CASE("pairs_closer_than: equals a search over all pairs and periodic images") {
  // Boxes of 2 to 11 cells per side, with positions up to one box length outside.
  for (const double length : {6.5, 8.0, 9.5, 13.0, 33.0}) {
    const SphereSet two = random_spheres(200, 2, length, 0.2, 1, 1, 1),
                    three = random_spheres(200, 3, length, 0.2, 1, 1, 2);
    for (const double range : {-0.3, 0.0, 1.2})
      for (int axes = 0; axes <= 3; ++axes) {
        CAPTURE(length);
        CAPTURE(range);
        CAPTURE(axes);
        const Spheres<3> spheres{three.position, three.radius, periodic_box<3>(length, axes)};
        CHECK(pairs_closer_than(spheres, range) == all_pairs(spheres, range));
        if (axes > 2) continue;
        const Spheres<2> disks{two.position, two.radius, periodic_box<2>(length, axes)};
        CHECK(pairs_closer_than(disks, range) == all_pairs(disks, range));
      }
  }
}

TEST_CASE("box without periodic sides: pairs equal those without a box") {
  const SphereSet some = random_spheres(100, 2, 10, 0.2, 1, 1, 3);
  CHECK(pairs_closer_than(Spheres<2>{some.position, some.radius, periodic_box<2>(1, 0)}, 0.5) ==
        pairs_closer_than(Spheres<2>{some.position, some.radius}, 0.5));
}

TEST_CASE("periodic box: pairs across faces, edges and corners are found once") {
  const Box<3> box = periodic_box<3>(10);
  const std::vector<double> radius = {0.5, 0.5};
  for (int x = -1; x <= 1; ++x)
    for (int y = -1; y <= 1; ++y)
      for (int z = -1; z <= 1; ++z) {
        // The particles lie 0.2 inside the sides between them and next to each other along the other axes.
        const auto low = [](int image) { return image == 0 ? 5.0 : 0.2; };
        const auto high = [](int image) { return image == 0 ? 5.2 : 9.8; };
        std::vector<double> position;
        for (const int image : {x, y, z}) position.push_back(image < 0 ? high(image) : low(image));
        for (const int image : {x, y, z}) position.push_back(image < 0 ? low(image) : high(image));
        CHECK(pairs_closer_than(Spheres<3>{position, radius, box}, 0.0) == std::vector<Pair>{{0, 1}});
      }
}

TEST_CASE("pair search beyond half of a periodic box's length: refused") {
  const std::vector<double> position = {1, 1, 2, 2}, radius = {0.5, 0.5};
  Box<2> box = periodic_box<2>(4, 1);
  CHECK(pairs_closer_than(Spheres<2>{position, radius, box}, 1.0).size() == 1);  // The distance of 2 is half of 4.
  CHECK_THROWS_WITH_AS(pairs_closer_than(Spheres<2>{position, radius, box}, 1.1),
                       doctest::Contains("4 long from left to right, but particles up to 2.1 apart"), InputError);
  CHECK(pairs_closer_than(Spheres<2>{position, radius, periodic_box<2>(4, 0)}, 1.1).size() == 1);
}

TEST_CASE("range larger than all distances: pair searches find every pair") {
  const SphereSet some = random_spheres(20, 2, 1, 0.01, 0.02, 0, 1);
  const Spheres<2> spheres{some.position, some.radius};
  const std::vector<double> reach(20, 1e300);
  for (const double range : {1e3, 1e300, 1.7e308, double{INFINITY}}) {
    CHECK(pairs_closer_than(spheres, range).size() == 20 * 19 / 2);
    CHECK(pairs_within_reach(spheres, range, reach).size() == 20 * 19 / 2);
    CHECK(ReachList().pairs(spheres, range, reach).size() == 20 * 19 / 2);
  }
}

TEST_CASE("pairs_closer_than: particles without finite positions are refused") {
  for (const double wrong : {double{INFINITY}, std::nan("")}) {
    SphereSet some = random_spheres(20, 2, 1, 0.01, 0.02, 0, 1);
    some.position[7] = wrong;
    CHECK_THROWS_AS(pairs_closer_than(Spheres<2>{some.position, some.radius}, 0), Failure);
    CHECK_THROWS_AS(pairs_closer_than(Spheres<2>{some.position, some.radius, periodic_box<2>(1)}, 0), Failure);
  }
}

TEST_CASE("pairs_closer_than: three threads find the same pairs as one") {
  const SphereSet some = random_spheres(20000, 3, 40, 0.3, 0.7, 0, 4);
  const Spheres<3> spheres{some.position, some.radius, periodic_box<3>(40)};
  parallel::Team three(3);
  const std::vector<Pair> alone = pairs_closer_than(spheres, 0.5);
  CHECK(alone.size() > 1000);
  CHECK(std::ranges::is_sorted(alone));
  CHECK(pairs_closer_than(spheres, 0.5, three) == alone);
}

TEST_CASE("pairs_within_reach (individual cutoffs): equals a search over all images") {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> exponent(-2, 1);
  const SphereSet some = random_spheres(150, 3, 9, 0.2, 1, 0.5, 6);
  const Spheres<3> spheres{some.position, some.radius, periodic_box<3>(9)};
  std::vector<double> reach(150);
  for (double& r : reach) r = std::pow(10, exponent(random));
  CHECK(pairs_within_reach(spheres, 0.1, reach) == all_pairs(spheres, 0.1, reach));
  std::ranges::fill(reach, 0.05);
  reach[7] = 1e12;  // This particle may fly to any position.
  CHECK(pairs_within_reach(spheres, 0.1, reach) == all_pairs(spheres, 0.1, reach));
}

TEST_CASE("pairs_within_reach: a pair with two large cutoffs is found") {
  SphereSet some = random_spheres(1000, 3, 100, 0.01, 0.01, 0, 9);
  std::vector<double> reach(1000, 0.0);
  reach[3] = reach[5] = 5;
  for (int k = 0; k < 3; ++k) some.position[9 + k] = 50, some.position[15 + k] = 50;
  // The cells are 10 wide, and the distance of 9.9 is below the sum of the cutoffs.
  some.position[9] = 53, some.position[15] = 62.9;
  const Spheres<3> spheres{some.position, some.radius};
  CHECK(pairs_within_reach(spheres, 0, reach) == all_pairs(spheres, 0, reach));
  CHECK(std::ranges::count(all_pairs(spheres, 0, reach), Pair{3, 5}) == 1);
}

TEST_CASE("NeighbourList: misses no pair of a cold gas with one fast grain") {
  constexpr int d = 3, n = 150;
  const double length = 10, range = 0.1, skin = 0.5;
  SphereSet gas = random_spheres(n, d, length, 0.5, 0.5, 0, 7);
  const Box<d> box = periodic_box<d>(length);
  const Spheres<d> spheres{gas.position, gas.radius, box};
  std::mt19937 random(8);
  std::normal_distribution<double> step(0, 1e-3);
  NeighbourList list(range, skin);
  for (int steps = 0; steps < 200; ++steps) {
    list.update(spheres);
    for (const Pair pair : all_pairs(spheres, range)) REQUIRE(std::ranges::binary_search(list.pairs(), pair));
    for (int k = 0; k < n * d; ++k) gas.position[k] += step(random);
    for (int k = 0; k < d; ++k) gas.position[k] += 0.5;
    for (int i = 0; i < n; ++i) {
      Vec<d> p = spheres.centre(i);
      Image<d> image{};
      box.wrap(p, image);
      for (int k = 0; k < d; ++k) gas.position[i * d + k] = p[k];
    }
  }
  CHECK(list.searches() == 200);
}

TEST_CASE("NeighbourList: another number of particles causes a new search") {
  std::vector<double> position = {0, 0, 1.2, 0, 2.4, 0}, radius = {0.5, 0.5, 0.5};
  NeighbourList list(0.3, 0.4);
  list.update(Spheres<2>{position, radius});
  CHECK(list.pairs().size() == 2);
  position.resize(4), radius.resize(2);
  list.update(Spheres<2>{position, radius});
  CHECK(list.pairs().size() == 1);
  position = {0, 0, 1.2, 0, 2.4, 0, 3.6, 0}, radius.resize(4, 0.5);
  list.update(Spheres<2>{position, radius});
  CHECK(list.pairs().size() == 3);
}

TEST_CASE("NeighbourList: wrapping around the box counts as no motion") {
  std::vector<double> position = {9.99, 5, 0.5, 5}, radius = {0.5, 0.5};
  const Spheres<2> disks{position, radius, periodic_box<2>(10)};
  NeighbourList list(0, 0.4);
  list.update(disks);
  CHECK(list.pairs().size() == 1);
  position[0] = 0.01;  // A displacement of 0.02 across the side.
  list.update(disks);
  CHECK(list.searches() == 1);
  position[0] = 0.2;  // A displacement of 0.21, more than half the skin.
  list.update(disks);
  CHECK(list.searches() == 2);
}

namespace {

/// Moves particles randomly, three of them fast. Compares a kept list with a new search for two ranges and for
/// individual cutoffs, some of them large. Returns the number of searches of the list.
template <int d>
int count_rebuilds(const Box<d>& box, int steps) {
  SphereSet disks = random_spheres(150, d, 20, 0.3, 0.5, 0, 7);
  std::mt19937 random(5);
  std::uniform_real_distribution<double> unit(-1, 1);
  ReachList list;
  for (int step = 0; step < steps; ++step) {
    std::vector<double> reach;
    for (std::size_t i = 0; i < disks.radius.size(); ++i)
      reach.push_back(i % 70 == 3 ? 2.0 : 0.01 * (1 + unit(random)));
    const Spheres<d> now{disks.position, disks.radius, box};
    const double range = step % 2 == 0 ? 0.4 : 0.0;
    CHECK(list.pairs(now, range, reach) == pairs_within_reach(now, range, reach));
    for (std::size_t i = 0; i < disks.radius.size(); ++i)
      for (int k = 0; k < d; ++k) disks.position[i * d + k] += (i % 60 == 5 ? 0.2 : 0.01) * unit(random);
  }
  return list.searches();
}

}  // namespace

TEST_CASE("ReachList: equals a new search; rebuilt rarely, in periodic boxes always") {
  // A random step of 0.01 per axis covers half a skin of 0.3 after about 0.15^2 / (0.01^2 2/3) = 340 steps. The two
  // fast particles and the three large cutoffs are too few for a rebuild.
  CHECK(count_rebuilds(Box<2>{}, 200) <= 3);
  CHECK(count_rebuilds(Box<3>{}, 50) <= 3);
  CHECK(count_rebuilds(periodic_box<2>(20), 10) == 10);  // A rebuild in each step.
}

TEST_CASE("ReachList: a large cutoff finds moved pairs without a new search") {
  std::vector<double> position = {0, 0, 3.5, 0}, reach = {0, 0};
  const std::vector<double> radius = {0.5, 0.5};
  ReachList list;
  const auto pairs = [&] { return list.pairs(Spheres<2>{position, radius}, 0.4, reach).size(); };
  CHECK(pairs() == 0);
  position[2] = 3.3;  // Less than half a skin of 0.5.
  reach[0] = 2;       // More than half a skin: centres up to 1.4 + 2 apart.
  CHECK(pairs() == 1);
  position[2] = 3.45;
  CHECK(pairs() == 0);
  CHECK(list.searches() == 1);
}

TEST_CASE("ReachList: large moves cause a rebuild, large cutoffs stay correct") {
  SphereSet disks = random_spheres(100, 2, 20, 0.3, 0.5, 0, 8);
  ReachList list;
  std::vector<double> reach(100, 0.0);
  const auto same = [&] {
    const Spheres<2> now{disks.position, disks.radius, Box<2>{}};
    return list.pairs(now, 0.4, reach) == pairs_within_reach(now, 0.4, reach);
  };
  CHECK(same());
  // Half of the particles move by more than half a skin.
  for (std::size_t k = 0; k < 100; ++k) disks.position[k] += 0.5;
  CHECK(same());
  CHECK(list.searches() == 2);
  CHECK(list.moved()[0] == 0);
  std::ranges::fill(reach, 0.5);
  CHECK(same());
}

namespace {

/// Pairs of particles in ascending order, found by a search in cell order.
template <int d>
std::vector<Pair> pairs_in_cells(const Spheres<d>& spheres, double range, int threads = 1) {
  CellOrder<d> cells;
  cells.sort(spheres, range);
  parallel::Team team(threads);
  std::vector<Pair> pairs;
  for (const auto& [a, b] : cells.pairs(team)) {
    CHECK(a < b);
    const int i = cells.particles()[a], j = cells.particles()[b];
    CHECK(cells.slots()[i] == a);
    pairs.push_back({std::min(i, j), std::max(i, j)});
  }
  std::ranges::sort(pairs);
  return pairs;
}

/// Pairs that meet in a flight in ascending order; velocities are in particle order.
std::vector<Pair> pairs_that_meet_in_cells(const Spheres<3>& spheres, double range, const std::vector<Vec3>& velocity,
                                           const CellOrder<3>::Flight& flight, int threads) {
  CellOrder<3> cells;
  cells.sort(spheres, range);
  for (int i = 0; i < spheres.size(); ++i) cells.set_velocity(cells.slots()[i], velocity[i]);
  parallel::Team team(threads);
  std::vector<Pair> pairs;
  for (const auto& [a, b] : cells.pairs_that_meet(flight, team)) {
    const int i = cells.particles()[a], j = cells.particles()[b];
    pairs.push_back({std::min(i, j), std::max(i, j)});
  }
  std::ranges::sort(pairs);
  return pairs;
}

/// Pairs within the range that are `near`, or that approach to `within` at the rate of change of their distance.
std::vector<Pair> meeting(const Spheres<3>& spheres, double range, const std::vector<Vec3>& velocity,
                          const CellOrder<3>::Flight& flight) {
  std::vector<Pair> pairs;
  for (const Pair pair : all_pairs(spheres, range)) {
    const Vec3 separation = spheres.box.difference(spheres.centre(pair.j), spheres.centre(pair.i));
    const double distance = norm(separation), rate = dot(separation, velocity[pair.j] - velocity[pair.i]) / distance;
    if (distance < flight.near || distance + rate * flight.time < flight.within) pairs.push_back(pair);
  }
  return pairs;
}

}  // namespace

TEST_CASE("CellOrder::pairs: finds each pair of a search over all images once") {
  // Boxes of 1 to 11 cells per side, with positions up to one box length outside. Single-precision positions add pairs
  // but lose none: rounding is at most 4 times 6e-8 of 100 m.
  for (const double length : {2.5, 6.5, 9.5, 13.0, 33.0}) {
    const SphereSet two = random_spheres(200, 2, length, 0, 0, 1, 1),
                    three = random_spheres(200, 3, length, 0, 0, 1, 2);
    for (const double range : {0.9, 3.0})
      for (int axes = 0; axes <= 3; ++axes) {
        CAPTURE(length);
        CAPTURE(range);
        CAPTURE(axes);
        const auto check = [&](const auto& spheres) {
          const std::vector<Pair> found = pairs_in_cells(spheres, range);
          CHECK(std::ranges::adjacent_find(found) == found.end());
          CHECK(std::ranges::includes(found, all_pairs(spheres, range)));
          CHECK(std::ranges::includes(all_pairs(spheres, range + 1e-4), found));
          CHECK(pairs_in_cells(spheres, range, 3) == found);
        };
        check(Spheres<3>{three.position, three.radius, periodic_box<3>(length, axes)});
        if (axes < 3) check(Spheres<2>{two.position, two.radius, periodic_box<2>(length, axes)});
      }
  }
}

TEST_CASE("CellOrder::pairs_that_meet: finds the pairs that may meet in a flight") {
  constexpr double range = 2;
  // Some axes have one cell and fold. Rounding adds pairs that miss by 4 x 1.2e-7 of 33 m and, for a path of 2 x 3.5 x
  // 0.1 m, by 2 x 1.6e-5 in its direction: 4e-5 m in total.
  for (const double length : {5.5, 9.5, 33.0}) {
    const SphereSet here = random_spheres(400, 3, length, 0, 0, 1, 5), fast = random_spheres(400, 3, 4, 0, 0, 0, 6);
    std::vector<Vec3> velocity;  // From -2 to 2 along each axis.
    for (int i = 0; i < 400; ++i)
      velocity.push_back(Vec3{fast.position[3 * i], fast.position[3 * i + 1], fast.position[3 * i + 2]} -
                         Vec3{2, 2, 2});
    for (const int axes : {0, 2, 3}) {
      CAPTURE(length);
      CAPTURE(axes);
      const Spheres<3> spheres{here.position, here.radius, periodic_box<3>(length, axes)};
      const CellOrder<3>::Flight flight{.time = 0.1, .within = 1.5, .near = 1};
      const auto more = [&](double by) {
        return CellOrder<3>::Flight{.time = 0.1, .within = flight.within + by, .near = flight.near + by};
      };
      const std::vector<Pair> found = pairs_that_meet_in_cells(spheres, range, velocity, flight, 1);
      CHECK(std::ranges::includes(found, meeting(spheres, range, velocity, flight)));
      CHECK(std::ranges::includes(meeting(spheres, range + 1e-4, velocity, more(1e-4)), found));
      CHECK(pairs_that_meet_in_cells(spheres, range, velocity, flight, 3) == found);
      CHECK(found.size() < all_pairs(spheres, range).size());
    }
  }
}

}  // namespace neighbours_test
