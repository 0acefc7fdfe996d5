#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <new>
#include <numbers>
#include <random>
#include <string>

#include "solvers/error.hpp"
#include "src/model/model.hpp"
#include "src/scene/effect_kind.hpp"
#include "src/scene/scene.hpp"
#include "tests/message.hpp"
#include "tests/near.hpp"

// Counts every allocation of this program.
namespace {
long allocations = 0;
}
[[gnu::noinline]] void* operator new(std::size_t size) {
  ++allocations;
  if (void* memory = std::malloc(size)) return memory;
  throw std::bad_alloc();
}
[[gnu::noinline]] void operator delete(void* memory) noexcept { std::free(memory); }
[[gnu::noinline]] void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }

namespace model_test {

using namespace lichtenberg;

namespace {

Bodies random_bodies(int n, int dimension, double width, std::uint32_t seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> coordinate(0, width), radius(0.5, 1.5);
  Bodies bodies{.dimension = dimension};
  for (int i = 0; i < n; ++i) {
    for (int k = 0; k < dimension; ++k) bodies.position.push_back(coordinate(random));
    bodies.radius.push_back(radius(random));
    bodies.mass.push_back(1);
  }
  bodies.momentum.resize(bodies.position.size());
  return bodies;
}

std::vector<Pair> all_pairs_closer_than(const Bodies& bodies, double range, std::vector<double> reach = {}) {
  reach.resize(bodies.size());
  std::vector<Pair> pairs;
  for (int i = 0; i < bodies.size(); ++i)
    for (int j = i + 1; j < bodies.size(); ++j) {
      double d2 = 0;
      for (int k = 0; k < bodies.dimension; ++k)
        d2 += std::pow(bodies.position[i * bodies.dimension + k] - bodies.position[j * bodies.dimension + k], 2);
      if (std::sqrt(d2) - bodies.radius[i] - bodies.radius[j] < range + reach[i] + reach[j]) pairs.push_back({i, j});
    }
  return pairs;
}

/// Counts its calls and exerts the force (1, 0, ...) on every body.
struct Counting : Effect {
  Counting(Needs n, const std::string& name) : wants(n), own{.name = name, .dimensions = {2, 3}} {}
  const EffectKind& kind() const override { return own; }
  Needs needs() const override { return wants; }
  void add_forces(const State& state, std::span<double> force) const override {
    ++forces;
    neighbours = state.neighbours.size();
    for (int i = 0; i < state.bodies.size(); ++i) force[i * state.bodies.dimension] += 1;
  }
  void add_currents(const State&, std::span<double> current) const override { current[0] += 2; }

  Needs wants;
  EffectKind own;
  mutable int forces = 0;
  mutable std::size_t neighbours = 0;
};

Model model_with(Bodies bodies, std::initializer_list<Needs> needs) {
  std::vector<std::unique_ptr<Effect>> effects;
  for (const Needs& n : needs)
    effects.push_back(std::make_unique<Counting>(n, "counting_" + std::to_string(effects.size())));
  const std::vector<double> charge(bodies.radius.size(), 7);
  return Model(std::move(bodies), std::move(effects), charge);
}

}  // namespace

TEST_CASE("make_bodies: conductors become spheres with mass, momentum, position") {
  Scene scene;
  scene.material.density = 8050;
  scene.conductors = {{.position = {1, 2}, .velocity = {3, 4}, .radius = 0.775e-3},
                      {.position = {5, 6}, .radius = 1e-3}};
  const Bodies bodies = make_bodies(scene);
  REQUIRE(bodies.size() == 2);
  // 4/3 pi 8050 0.775^3 1e-9 = 1.56959e-5 kg: pi * 4/3 * 8050 = 33719.8, 0.775^3 = 0.465484.
  CHECK(bodies.mass[0] == near(1.56959e-5, 1e-5));
  CHECK(position(bodies, 1) == Vec2{5, 6});
  CHECK(bodies.momentum[1] == near(4 * bodies.mass[0]));
  CHECK(norm(velocity(bodies, 0)) == near(5));
  CHECK(bodies.charge.empty());
}

TEST_CASE("bodies in space: access as two-dimensional is refused") {
  const Bodies space = random_bodies(3, 3, 10, 6);
  CHECK(position<3>(space, 1) == Vec3{space.position[3], space.position[4], space.position[5]});
  CHECK_THROWS_WITH_AS(position(space, 1), doctest::Contains("have 3 dimensions"), InputError);
  CHECK_THROWS_AS(velocity<2>(space, 1), InputError);
}

TEST_CASE("wrap: bodies re-enter a periodic box and their images are counted") {
  Bodies bodies{.position = {4.5, 7, -1, -1}, .radius = {1, 1}};
  wrap(bodies);
  CHECK(bodies.image.empty());  // No side is periodic.
  bodies.box.lengths = {4, 8, 0};
  bodies.box.sides[0] = bodies.box.sides[1] = Boundary::periodic;
  wrap(bodies);
  CHECK(bodies.position == std::vector<double>{0.5, 7, 3, -1});
  CHECK(bodies.image == std::vector<int>{1, 0, -1, 0});
  bodies.position[0] += 4;
  wrap(bodies);
  CHECK(bodies.image[0] == 2);
}

// wrap() works on groups of bodies; it must bring back each body outside and change no other.
TEST_CASE("wrap: of 53 bodies only those outside on periodic axes are brought back") {
  Bodies bodies{.dimension = 3, .box = {.lengths = {2, 3, 4}}};
  bodies.box.sides.fill(Boundary::periodic);
  bodies.box.sides[2] = bodies.box.sides[3] = Boundary::wall;  // Not along y.
  constexpr int count = 53;
  for (int i = 0; i < count; ++i) {
    bodies.radius.push_back(0.1);
    for (const double x : {i % 7 == 0 ? 2.5 : 0.25, i % 5 == 0 ? -1.0 : 5.0, i % 11 == 0 ? -4.5 : 0.0})
      bodies.position.push_back(x);
  }
  wrap(bodies);
  REQUIRE(bodies.image.size() == bodies.position.size());
  for (int i = 0; i < count; ++i) {
    CAPTURE(i);
    CHECK(bodies.position[3 * i] == (i % 7 == 0 ? 0.5 : 0.25));
    CHECK(bodies.image[3 * i] == (i % 7 == 0 ? 1 : 0));
    CHECK(bodies.position[3 * i + 1] == (i % 5 == 0 ? -1.0 : 5.0));
    CHECK(bodies.image[3 * i + 1] == 0);
    CHECK(bodies.position[3 * i + 2] == (i % 11 == 0 ? 3.5 : 0.0));
    CHECK(bodies.image[3 * i + 2] == (i % 11 == 0 ? -2 : 0));
  }
}

TEST_CASE("initial_charges: a wired group's charge is divided equally by members") {
  Scene scene;
  scene.groups = {{.name = "pair", .charge = 6e-12}};
  scene.conductors = {{.radius = 1, .group = 0}, {.radius = 1, .charge = 5e-12}, {.radius = 1, .group = 0}};
  CHECK(initial_charges(scene) == std::vector<double>{3e-12, 5e-12, 3e-12});
}

TEST_CASE("pairs_closer_than: equals a search over all pairs, in the same order") {
  for (const int dimension : {2, 3})
    for (const double range : {-0.5, 0.0, 0.7, 3.0, 40.0}) {
      const Bodies bodies = random_bodies(150, dimension, 20, 1);
      CHECK(pairs_closer_than(bodies, range) == all_pairs_closer_than(bodies, range));
    }
}

TEST_CASE("pairs_within_reach (individual cutoffs): equals a search over all pairs") {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> exponent(-2, 2);
  for (const int dimension : {2, 3})
    for (const double range : {-0.5, 0.0, 1.0}) {
      const Bodies bodies = random_bodies(150, dimension, 20, 4);
      std::vector<double> reach(150);
      for (double& r : reach) r = std::pow(10, exponent(random));
      CHECK(pairs_within_reach(bodies, range, reach) == all_pairs_closer_than(bodies, range, reach));
      std::ranges::fill(reach, 0.1);
      reach[7] = 1e12;  // This body may fly to any position.
      CHECK(pairs_within_reach(bodies, range, reach) == all_pairs_closer_than(bodies, range, reach));
    }
}

TEST_CASE("pairs_closer_than: accepts distant bodies, coinciding bodies and none") {
  Bodies bodies = random_bodies(30, 2, 5, 2);
  bodies.position[0] = 1e12;
  bodies.position[2] = bodies.position[4], bodies.position[3] = bodies.position[5];
  CHECK(pairs_closer_than(bodies, 0.1) == all_pairs_closer_than(bodies, 0.1));
  CHECK(pairs_closer_than(Bodies{}, 1).empty());
}

TEST_CASE("NeighbourList: misses no pair, is rebuilt after moves of half a skin") {
  Bodies bodies = random_bodies(60, 2, 15, 3);
  const double range = 0.3, skin = 0.4;
  NeighbourList list(range, skin);
  std::mt19937 random(4);
  std::normal_distribution<double> step(0, 0.02);
  int walks = 0;
  for (; walks < 200; ++walks) {
    update(list, bodies);
    const auto listed = list.pairs();
    for (const Pair pair : all_pairs_closer_than(bodies, range))
      REQUIRE(std::binary_search(listed.begin(), listed.end(), pair));
    for (double& x : bodies.position) x += step(random);
  }
  CHECK(list.searches() > 1);
  // Half a skin of 0.2 is 10 standard deviations of one step: rebuilds are several steps apart.
  CHECK(list.searches() < walks / 4);

  const auto before = list.searches();
  bodies.position[0] += 0.45 * skin;
  NeighbourList still(range, skin);
  update(still, bodies);
  bodies.position[1] += 0.49 * skin;
  update(still, bodies);
  CHECK(still.searches() == 1);
  bodies.position[1] += 0.02 * skin;
  update(still, bodies);
  CHECK(still.searches() == 2);
  CHECK(list.searches() == before);
}

TEST_CASE("Model: charges and neighbour list exist only if an effect needs them") {
  const Bodies bodies = random_bodies(10, 2, 5, 5);
  const Model bare = model_with(bodies, {Needs{}});
  CHECK(bare.bodies.charge.empty());
  CHECK(!bare.neighbours);
  const Model charged = model_with(bodies, {Needs{}, Needs{.charges = true}});
  CHECK(charged.bodies.charge == std::vector<double>(10, 7.0));
  CHECK(!charged.neighbours);
  CHECK(model_with(bodies, {Needs{.neighbour_range = 0.0}}).neighbours);
}

TEST_CASE("Model: two effects of one name are refused") {
  std::vector<std::unique_ptr<Effect>> effects;
  for (int k = 0; k < 2; ++k) effects.push_back(std::make_unique<Counting>(Needs{}, "twin"));
  CHECK_THROWS_WITH_AS(Model(random_bodies(1, 2, 1, 5), std::move(effects), {}),
                       doctest::Contains("two effects are named \"twin\""), InputError);
}

TEST_CASE("Model: another number of charges than bodies is refused") {
  const auto with = [](std::size_t charges) {
    std::vector<std::unique_ptr<Effect>> effects;
    effects.push_back(std::make_unique<Counting>(Needs{.charges = true}, "counting"));
    return Model(random_bodies(3, 2, 5, 5), std::move(effects), std::vector<double>(charges));
  };
  CHECK(with(3).bodies.charge.size() == 3);
  for (const std::size_t other : {0, 2, 4})
    CHECK_THROWS_WITH_AS(with(other), doctest::Contains("effects.counting needs 3 charges, one for each body"),
                         InputError);
}

TEST_CASE("Model: its neighbour list has the largest range of all effects") {
  Bodies bodies = random_bodies(2, 2, 1, 6);
  bodies.radius = {1, 1};
  bodies.position = {0, 0, 4.5, 0};  // The gap of 2.5 exceeds the range of 1 plus the skin of 0.3.
  std::vector<double> force(4);
  Model near = model_with(bodies, {Needs{.neighbour_range = 1.0}});
  near.forces(0, force);
  CHECK(near.neighbours->pairs().empty());
  Model far = model_with(bodies, {Needs{.neighbour_range = 1.0}, Needs{.neighbour_range = 2.6}});
  far.forces(0, force);
  CHECK(far.neighbours->pairs().size() == 1);
}

TEST_CASE("Model::forces: sum over effects, one call each, no memory allocation") {
  Model model = model_with(random_bodies(20, 2, 5, 7), {Needs{}, Needs{.neighbour_range = 0.0}});
  std::vector<double> force(40, 99.0), current(20, 99.0);
  model.forces(0, force);  // This call rebuilds the neighbour list.
  const long before = allocations;
  model.forces(1, force);
  CHECK(allocations == before);
  CHECK(force[0] == 2);
  CHECK(force[1] == 0);
  const auto* first = static_cast<const Counting*>(model.effects[0].get());
  CHECK(first->forces == 2);
  CHECK(model.neighbours->searches() == 1);
  model.currents(0, current);
  CHECK(current[0] == 4);
  CHECK(current[1] == 0);
}

TEST_CASE("Model::largest_move: smallest one of the effects, times smallest radius") {
  Bodies bodies = random_bodies(2, 2, 5, 8);
  bodies.radius = {3, 2};
  CHECK(std::isinf(model_with(bodies, {Needs{}}).largest_move()));
  CHECK(model_with(bodies, {Needs{.largest_move = 0.5}, Needs{.largest_move = 0.7}, Needs{}}).largest_move() == 1);
}

TEST_CASE("ForceJacobian::add_central: block has normal and transverse stiffness") {
  ForceJacobian jacobian(2);
  const std::vector<double> n = {0.6, 0.8};
  jacobian.add_central(1, 0, n, 5, 2);
  // (5 - 2) n n' + 2 = [[3.08, 1.44], [1.44, 3.92]], in rows 2 and 3 and columns 0 and 1.
  REQUIRE(jacobian.by_position.size() == 4);
  CHECK(jacobian.by_position[0].row == 2);
  CHECK(jacobian.by_position[3].column == 1);
  CHECK(jacobian.by_position[0].value == near(3.08));
  CHECK(jacobian.by_position[1].value == near(1.44));
  CHECK(jacobian.by_position[2].value == near(1.44));
  CHECK(jacobian.by_position[3].value == near(3.92));
}

TEST_CASE("Drag: laws of one body add up, the Jacobian is the force's derivative") {
  for (const int dimension : {2, 3}) {
    CAPTURE(dimension);
    Bodies bodies{.dimension = dimension, .position = {0, 0, 0}, .momentum = {3, -4, 2}, .mass = {2}, .radius = {1}};
    bodies.position.resize(dimension), bodies.momentum.resize(dimension);
    Drag drag(1);
    CHECK(drag.add(0, {.linear = 0.5, .nonlinear = [](double v) { return DragForce{v * v, 2 * v}; }}));
    CHECK(!drag.is_linear());
    CHECK(drag.add(0, {.nonlinear = [](double v) { return DragForce{v * v * v, 3 * v * v}; }}));
    CHECK(!drag.add(0, {}));
    const auto force = [&] {
      std::vector<double> sum(dimension);
      drag.add_forces({0, bodies, {}}, sum);
      return sum;
    };
    const double v = norm(velocity_in_space(bodies, 0));
    const double size = norm(vector_at(force(), dimension, 0));
    CHECK(size == near(0.5 * v + v * v + v * v * v));
    CHECK(drag.power(0, position_in_space(bodies, 0), velocity_in_space(bodies, 0)) == near(size * v));
    // Transverse to the velocity the resistance is smaller than along it.
    CHECK(drag.resistance(0, v) == near(0.5 + v + v * v));
    ForceJacobian jacobian(dimension);
    drag.add_jacobian({0, bodies, {}}, jacobian);
    std::vector<double> analytic(dimension * dimension);
    for (const auto& entry : jacobian.by_momentum) analytic[entry.row * dimension + entry.column] += entry.value;
    for (int column = 0; column < dimension; ++column) {
      const double middle = bodies.momentum[column], step = 1e-4;
      bodies.momentum[column] = middle + step;
      const std::vector<double> above = force();
      bodies.momentum[column] = middle - step;
      const std::vector<double> below = force();
      bodies.momentum[column] = middle;
      // The third derivatives are a few times the first over v^2. The error is 1e-8 of the step, and rounding over the
      // step.
      for (int row = 0; row < dimension; ++row)
        CHECK(analytic[row * dimension + column] == near((above[row] - below[row]) / (2 * step), 1e-6));
    }
  }
  CHECK_THROWS_AS(Drag(1).add(0, {.linear = -1}), InputError);
}

TEST_CASE("Drag: a law with force at rest, wrong sign or wrong slope is refused") {
  const auto refusal = [](const std::function<DragForce(double)>& law) {
    return message_of<InputError>([&] { Drag(1).add(0, {.nonlinear = law}); });
  };
  CHECK(refusal([](double v) { return DragForce{v * v, 2 * v}; }).empty());
  CHECK(refusal([](double v) { return DragForce{std::min(v, 1.0), v < 1 ? 1.0 : 0.0}; }).empty());  // A kink at 1 m/s.
  CHECK(refusal([](double) { return DragForce{1e-6, 0}; }).find("1e-06 N at rest") != std::string::npos);
  CHECK(refusal([](double v) { return DragForce{-v * v, 2 * v}; }).find("at least 0") != std::string::npos);
  CHECK(refusal([](double v) { return DragForce{v * v, -2 * v}; }).find("at least 0") != std::string::npos);
  CHECK(refusal([](double v) { return DragForce{v * v, 0}; }).find("derivative") != std::string::npos);
}

}  // namespace model_test
