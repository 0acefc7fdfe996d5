#include <doctest/doctest.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <numeric>
#include <random>
#include <string>

#include "solvers/error.hpp"
#include "src/effects/effects.hpp"
#include "src/effects/floating_conductors.hpp"
#include "src/effects/hertz_contact.hpp"
#include "src/effects/read_scene.hpp"
#include "src/mechanics/cvode.hpp"
#include "src/mechanics/simulation.hpp"

namespace mechanics_periodic_test {

using namespace lichtenberg;

namespace {

constexpr double side = 10;

/// Gas of 40 spheres of radius 0.5 and mass 1 at random positions in a periodic cube, without overlaps and with random
/// velocities.
Bodies gas(int n) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> coordinate(0, side);
  std::normal_distribution<double> speed(0, 1);
  Bodies bodies{.dimension = 3};
  bodies.box.lengths = {side, side, side};
  bodies.box.sides.fill(Boundary::periodic);
  while (bodies.size() < n) {
    const Vec3 p = {coordinate(random), coordinate(random), coordinate(random)};
    bool free = true;
    for (int i = 0; i < bodies.size(); ++i) free &= norm(bodies.box.difference(p, position<3>(bodies, i))) > 1.05;
    if (!free) continue;
    for (int k = 0; k < 3; ++k) bodies.position.push_back(p[k]), bodies.momentum.push_back(speed(random));
    bodies.mass.push_back(1), bodies.radius.push_back(0.5);
  }
  return bodies;
}

Model elastic(Bodies bodies) {
  std::vector<std::unique_ptr<Effect>> effects;
  effects.push_back(std::make_unique<effects::HertzContact>(effects::HertzContactOptions{.young = 1000, .poisson = 0}));
  return Model(std::move(bodies), std::move(effects), {});
}

Vec3 total_momentum(const Bodies& bodies) {
  Vec3 sum;
  for (int i = 0; i < bodies.size(); ++i) sum += bodies.mass[i] * velocity<3>(bodies, i);
  return sum;
}

}  // namespace

TEST_CASE("elastic spheres in a periodic cube: energy and momentum are conserved") {
  Model model = elastic(gas(40));
  mechanics::Cvode cvode(model, {.relative = 1e-8, .position = 1e-9, .momentum = std::vector<double>(40, 1e-9)});
  const double energy = model.kinetic_energy() + model.stored_energy(0);
  const Vec3 momentum = total_momentum(model.bodies);
  const std::vector<double> start = model.bodies.momentum;
  for (int k = 0; k < 20; ++k) {
    cvode.advance(0.5 * k, 0.5 * (k + 1));
    wrap(model.bodies);
  }
  int crossings = 0, deflected = 0;
  for (const int turns : model.bodies.image) crossings += std::abs(turns);
  for (std::size_t k = 0; k < start.size(); ++k) deflected += std::abs(model.bodies.momentum[k] - start[k]) > 0.1;
  CHECK(crossings > 40);
  CHECK(deflected > 60);
  for (const double x : model.bodies.position) CHECK((x >= 0 && x < side));
  // 58000 steps with errors of up to 1e-8 of a momentum and random sign give about 2e-6 (regression value: 6e-7).
  // Forces of a pair cancel to rounding.
  CHECK(model.kinetic_energy() + model.stored_energy(10) == doctest::Approx(energy).epsilon(5e-6).scale(0));
  CHECK(norm(total_momentum(model.bodies) - momentum) < 1e-11);
}

TEST_CASE("collision across a periodic face: momenta equal those inside the box") {
  const auto after = [](double x) {
    Bodies bodies{.dimension = 3,
                  .position = {x, 5, 5, x + 1.25, 5.25, 5},
                  .momentum = {1, 0, 0, -1, 0, 0},
                  .mass = {1, 1},
                  .radius = {0.5, 0.5}};
    bodies.box.lengths = {side, side, side};
    bodies.box.sides.fill(Boundary::periodic);
    Model model = elastic(std::move(bodies));
    wrap(model.bodies);
    mechanics::Cvode cvode(model, {.relative = 1e-9, .position = 1e-10, .momentum = {1e-10, 1e-10}});
    cvode.advance(0, 1);
    return model.bodies.momentum;
  };
  const std::vector<double> inside = after(4), across = after(9);
  CHECK(inside[0] < 0);
  for (int k = 0; k < 6; ++k) CHECK(across[k] == doctest::Approx(inside[k]).epsilon(1e-7));
}

namespace {

/// Scene of 30 elastic spheres that move through the sides of a cube, or 12 disks through those of a square.
Scene scene_of_gas(int dimension, const std::string& integrator) {
  std::string text = fmt::format("domain = {{ size = [{}]", dimension == 3 ? "10.0, 10.0, 10.0" : "10.0, 10.0");
  for (int s = 0; s < 2 * dimension; ++s) text += fmt::format(", {} = \"periodic\"", side_names[s]);
  text +=
      " }\neffects.hertz_contact = { young = 1e6, poisson = 0.0 }\nmaterial.density = 10.0\n"
      "output.every = 0.5\nstop = { time = 10.0, stationary = false }\n";
  const std::string steps = integrator == "euler" ? "euler_step = 1e-3" : "relative_tolerance = 1e-8";
  text += fmt::format("mechanics = {{ integrator = \"{}\", {} }}\n", integrator, steps);
  for (int i = 0; i < 6; ++i)
    text +=
        fmt::format("[[conductor]]\nposition = [{0}, {0}{1}]\nvelocity = [{2}, {3}{4}]\nradius = 0.5\n", 0.75 + 1.5 * i,
                    dimension == 3 ? ", 5.0" : "", i % 2 ? 3.0 : -2.5, i % 3 - 1.25, dimension == 3 ? ", 1.5" : "");
  text += fmt::format("[[population]]\ncount = {}\nradius = 0.5\nmin_gap = 0.05\n", dimension == 3 ? 24 : 6);
  return parse_scene(text, "gas.toml");
}

void run_to(Simulation& simulation, double end) {
  while (simulation.time() < end) simulation.advance_to(simulation.next_frame());
}

}  // namespace

TEST_CASE("scene in a periodic box, 2D and 3D: energy and momentum are conserved") {
  for (const int dimension : {2, 3}) {
    Simulation simulation(scene_of_gas(dimension, "cvode"));
    const Model& model = simulation.model();
    const auto momentum = [&] {
      std::array<double, 3> sum{};
      for (std::size_t k = 0; k < model.bodies.momentum.size(); ++k) sum[k % dimension] += model.bodies.momentum[k];
      return sum;
    };
    const double energy = model.kinetic_energy();
    const std::array<double, 3> before = momentum();
    run_to(simulation, 10);
    Model now = effects::make_model(scene_of_gas(dimension, "cvode"));
    now.bodies = model.bodies;
    CHECK(now.kinetic_energy() + now.stored_energy(10) == doctest::Approx(energy).epsilon(1e-5).scale(0));
    for (int k = 0; k < dimension; ++k) CHECK(std::abs(momentum()[k] - before[k]) < 1e-9 * std::sqrt(energy));
  }
}

TEST_CASE("periodic box: a restored run has identical bits and image counts") {
  for (const char* integrator : {"cvode", "euler"}) {
    const Scene scene = scene_of_gas(3, integrator);
    Simulation whole(scene), first(scene), second(scene);
    run_to(whole, 5);
    run_to(first, 2.5);
    second.restore(first.checkpoint());
    run_to(second, 5);
    CHECK(second.model().bodies.position == whole.model().bodies.position);
    CHECK(second.model().bodies.momentum == whole.model().bodies.momentum);
    CHECK(second.model().bodies.image == whole.model().bodies.image);
    CHECK(std::ranges::any_of(whole.model().bodies.image, [](int turns) { return std::abs(turns) > 1; }));
  }
}

TEST_CASE("frames: z positions in 3D; image counts of bodies, 0 along z in 2D") {
  Simulation simulation(scene_of_gas(3, "cvode"));
  simulation.advance_to(2);
  const Frame frame = simulation.frame();
  CHECK(frame.reals("position") == simulation.model().bodies.position);
  CHECK(frame.integers("image") == simulation.model().bodies.image);
  CHECK(frame.reals("velocity")[2] == doctest::Approx(velocity<3>(simulation.model().bodies, 0).z));
  CHECK_FALSE(simulation.progress().empty());
  CHECK(simulation.summary().quantities.front().value == 2);

  Simulation plane(scene_of_gas(2, "cvode"));
  plane.advance_to(5);
  const std::vector<int> shown = plane.frame().integers("image"), &turns = plane.model().bodies.image;
  REQUIRE(shown.size() == 3 * 12);
  for (int i = 0; i < 12; ++i) {
    CHECK(std::pair(shown[3 * i], shown[3 * i + 1]) == std::pair(turns[2 * i], turns[2 * i + 1]));
    CHECK(shown[3 * i + 2] == 0);
  }
  CHECK(std::ranges::any_of(turns, [](int turn) { return turn != 0; }));
}

TEST_CASE("periodic box shorter than twice the range of interaction: refused") {
  const Scene scene = parse_scene(
      "domain = { size = [1.9, 9.0], left = \"periodic\", right = \"periodic\" }\neffects.hertz_contact = {}\n"
      "[[conductor]]\nposition = [1.0, 4.0]\nradius = 0.5\n[[conductor]]\nposition = [1.0, 6.0]\nradius = 0.5\n",
      "short.toml");
  CHECK_THROWS_WITH_AS(Simulation(scene).frame(),
                       doctest::Contains("short.toml: the periodic box is 1.9 long from left to right"), InputError);
}

/// Effect without support of periodic sides.
struct WallsOnlyOptions {
  static const EffectKind& kind();
};
struct WallsOnly : Effect {
  const EffectKind& kind() const override { return WallsOnlyOptions::kind(); }
};
const EffectKind& WallsOnlyOptions::kind() {
  static const EffectKind kind = {.name = "walls_only",
                                  .description = "needs walls",
                                  .help = "It needs walls.",
                                  .options = WallsOnlyOptions{},
                                  .make = [](const Scene&) { return std::make_unique<WallsOnly>(); }};
  return kind;
}

TEST_CASE("effect without support of periodic sides: make_model refuses it") {
  Scene scene;
  scene.domain.size = {1, 1};
  scene.domain.sides[0].periodic = scene.domain.sides[1].periodic = true;
  scene.conductors = {{.position = {0.5, 0.5}, .radius = 0.1}};
  scene.effects.add(WallsOnlyOptions{});
  CHECK_THROWS_WITH_AS(effects::make_model(scene),
                       doctest::Contains("effects.walls_only is not allowed with a periodic"), InputError);
}

}  // namespace mechanics_periodic_test
