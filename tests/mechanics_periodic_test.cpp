#include <doctest/doctest.h>

#include <cmath>
#include <memory>
#include <numeric>
#include <random>

#include "solvers/error.hpp"
#include "src/effects/floating_conductors.hpp"
#include "src/effects/hertz_contact.hpp"
#include "src/effects/wall_contact.hpp"
#include "src/mechanics/cvode.hpp"

using namespace lichtenberg;

namespace {

constexpr double side = 10;

/// 40 spheres of radius .5 and mass 1 at random places of a periodic cube that do not overlap, with random velocities.
Bodies gas(int n) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> place(0, side);
  std::normal_distribution<double> speed(0, 1);
  Bodies bodies{.dimension = 3};
  bodies.box.lengths = {side, side, side};
  bodies.box.sides.fill(Boundary::periodic);
  while (bodies.size() < n) {
    const Vec3 p = {place(random), place(random), place(random)};
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

TEST_CASE("elastic spheres in a periodic cube keep energy and momentum") {
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
  // 58 thousand steps, each wrong by up to 1e-8 of a momentum with either sign: some 2e-6 (measured: 6e-7). Forces of a
  // pair cancel to rounding.
  CHECK(model.kinetic_energy() + model.stored_energy(10) == doctest::Approx(energy).epsilon(5e-6).scale(0));
  CHECK(norm(total_momentum(model.bodies) - momentum) < 1e-11);
}

TEST_CASE("two spheres that meet across a face bounce as inside") {
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

TEST_CASE("walls are for two dimensions, and say so") {
  Scene scene;
  scene.domain.size = {1, 1};
  scene.effects.add<effects::WallContactOptions>();
  const effects::WallContact walls(scene);
  const Bodies space = gas(2);
  std::vector<double> force(6);
  CHECK_THROWS_WITH_AS(walls.add_forces({0, space, {}}, force), doctest::Contains("have 3 dimensions"), InputError);
}
