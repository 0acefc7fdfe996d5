// Tests of packings: the soft repulsion, minimizers, and minimizations that are resumed or use several threads.
#include <doctest/doctest.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "solvers/error.hpp"
#include "solvers/minimize/fire.hpp"
#include "solvers/minimize/gradient_descent.hpp"
#include "solvers/minimize/lbfgs.hpp"
#include "solvers/minimize/newton_cg.hpp"
#include "solvers/parallel/petsc.hpp"
#include "src/effects/contact_law.hpp"
#include "src/effects/effects.hpp"
#include "src/effects/read_scene.hpp"
#include "src/effects/soft_repulsion.hpp"
#include "src/statics/minimization.hpp"
#include "src/statics/potential_energy.hpp"

namespace statics_test {

using namespace lichtenberg;

namespace {

const std::array methods = {"lbfgs-newton", "lbfgs", "newton-cg", "fire", "gradient-descent"};

Scene packing(int dimension, const std::string& method, const std::string& more = "") {
  const std::string size = dimension == 3 ? "[3.9, 3.9, 3.9]" : "[6.4, 6.4]";
  return parse_scene(fmt::format("[domain]\nsize = {}\n[effects.soft_repulsion]\n[minimize]\nmethod = \"{}\"\n{}\n"
                                 "[[population]]\ncount = 50\nradius = [0.4, 0.6]\noverlapping = true\n",
                                 size, method, more),
                     "packing");
}

State state_of(Model& model) {
  update(*model.neighbours, model.bodies);
  return {0, model.bodies, model.neighbours->pairs()};
}

/// Objective sum of scale[i] (x[i] - i)^2 / 2, which is infinite above x[0] = 3.
class Bowl : public minimize::SmoothObjective {
 public:
  int size() const override { return 4; }
  double evaluate(std::span<const double> x, std::span<double> gradient) override {
    if (x[0] > 3) return INFINITY;
    double value = 0;
    for (int i = 0; i < 4; ++i) {
      gradient[i] = scale[i] * (x[i] - i);
      value += 0.5 * gradient[i] * (x[i] - i);
    }
    return value;
  }
  void linearize(std::span<const double>) override {}
  void multiply(std::span<const double> v, std::span<double> product) const override {
    for (int i = 0; i < 4; ++i) product[i] = scale[i] * v[i];
  }
  void precondition(std::span<const double> r, std::span<double> z) const override { std::ranges::copy(r, z.begin()); }

 private:
  static constexpr std::array scale = {1.0, 2.0, 5.0, 0.5};
};

/// Objective x - ln x: minimum at 1, increasingly steep towards 0, and infinite beyond.
class Pit : public minimize::SmoothObjective {
 public:
  int size() const override { return 1; }
  double evaluate(std::span<const double> x, std::span<double> gradient) override {
    if (x[0] <= 0) return INFINITY;
    gradient[0] = 1 - 1 / x[0];
    return x[0] - std::log(x[0]);
  }
  void linearize(std::span<const double> x) override { curvature_ = 1 / (x[0] * x[0]); }
  void multiply(std::span<const double> v, std::span<double> product) const override { product[0] = curvature_ * v[0]; }
  void precondition(std::span<const double> r, std::span<double> z) const override { z[0] = r[0] / curvature_; }

 private:
  double curvature_ = 0;
};

}  // namespace

TEST_CASE("soft repulsion: w(q) = (q - 1) ln q and its derivatives") {
  const effects::ContactLaw half = effects::contact_law(0.5);
  CHECK(half.energy == doctest::Approx(0.5 * std::log(2)).scale(0).epsilon(1e-15));
  CHECK(half.slope == doctest::Approx(-std::log(2) - 1).scale(0).epsilon(1e-15));  // ln q + 1 - 1/q
  CHECK(half.curvature == doctest::Approx(6));                                     // (q + 1) / q^2
  const effects::ContactLaw touching = effects::contact_law(1);
  CHECK(touching.energy == 0);
  CHECK(touching.slope == 0);
  CHECK(touching.curvature == 2);
  // For q slightly below 1, w is (1 - q)^2 without loss of digits.
  const double e = 0x1p-30;
  CHECK(effects::contact_law(1 - e).energy == doctest::Approx(e * e).scale(0).epsilon(2 * e));
}

TEST_CASE("logarithm_near_one: as accurate as the library's logarithm") {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> depth(0, 1 - effects::near_one);
  for (int k = 0; k < 100000; ++k) {
    const double q = 1 - (k % 2 ? depth(random) : std::pow(depth(random), 5)), exact = std::log1p(q - 1);
    // Roundings of s, t and a sum that grows by at most 1 %, and of the library: several units of 2^-53.
    CHECK(std::abs(effects::logarithm_near_one(q) - exact) <= 6 * 0x1p-53 * std::abs(exact));
  }
  CHECK(effects::logarithm_near_one(1) == 0);
}

/// Scene of random overlaps, some of them deep, in a square or cube.
Scene random_packing(int dimension, int count, double side = 24) {
  return parse_scene(fmt::format("[domain]\nsize = [{0}, {0}{1}]\n[effects.soft_repulsion]\n"
                                 "[[population]]\ncount = {2}\nradius = [0.3, 0.5]\noverlapping = true\n",
                                 side, dimension == 3 ? fmt::format(", {}", side) : "", count),
                     "crowd");
}

TEST_CASE("SoftRepulsion: energy and forces are sums over all pairs and walls") {
  for (const int dimension : {2, 3}) {
    const int n = dimension == 3 ? 6000 : 1000;
    const Scene scene = random_packing(dimension, n);
    Model model = effects::make_model(scene);
    const State state = state_of(model);
    const effects::SoftRepulsion potential(scene);
    const std::vector<double>& p = model.bodies.position;
    double energy = 0;
    std::vector<double> expected(p.size()), rounding(p.size());
    const auto add = [&](int i, const std::array<double, 3>& separation, double reach, double sign) {
      const double distance = std::hypot(separation[0], separation[1], separation[2]);
      if (distance >= reach) return;
      const effects::ContactLaw w = effects::contact_law(distance / reach);
      if (sign > 0) energy += w.energy;
      for (int k = 0; k < dimension; ++k) {
        expected[i * dimension + k] -= sign * w.slope / reach * separation[k] / distance;
        // q has four roundings, which w' and w'' amplify. A force has about twelve of its own, and a sum of ten forces
        // as many.
        rounding[i * dimension + k] += 0x1p-53 * (4 * w.curvature - 20 * w.slope) / reach;
      }
    };
    for (int i = 0; i < n; ++i) {
      for (int j = i + 1; j < n; ++j) {
        std::array<double, 3> separation{};
        for (int k = 0; k < dimension; ++k) separation[k] = p[i * dimension + k] - p[j * dimension + k];
        const double reach = model.bodies.radius[i] + model.bodies.radius[j];
        add(i, separation, reach, 1), add(j, separation, reach, -1);
      }
      for (int k = 0; k < dimension; ++k)
        for (const double side : {0.0, 24.0}) {
          std::array<double, 3> separation{};
          separation[k] = p[i * dimension + k] - side;
          add(i, separation, model.bodies.radius[i], 1);
        }
    }
    std::vector<double> force(p.size());
    CHECK(potential.energy_and_forces(state, force) == doctest::Approx(energy).epsilon(1e-13));
    for (std::size_t k = 0; k < p.size(); ++k) CHECK(std::abs(force[k] - expected[k]) <= rounding[k]);

    std::vector<double> parts(p.size());
    std::vector<ParticleForce> outside_forces;
    double sum = 0;
    for (const auto& [first, end] : {std::pair{0, n / 3}, {n / 3, n / 3}, {n / 3, n}})
      sum += potential.energy_and_forces(state, first, end, parts, outside_forces);
    CHECK(outside_forces.size() > 10);
    for (const ParticleForce& one : outside_forces)
      for (int k = 0; k < dimension; ++k) parts[one.particle * dimension + k] += one.force[k];
    CHECK(sum == doctest::Approx(energy).epsilon(1e-13));
    for (std::size_t k = 0; k < p.size(); ++k) CHECK(std::abs(parts[k] - expected[k]) <= rounding[k]);
  }
}

TEST_CASE("SoftRepulsion: an older neighbour list changes no bit of the forces") {
  std::mt19937 random(2);
  std::uniform_real_distribution<double> little(-0.05, 0.05);
  for (int trial = 0; trial < 20; ++trial) {
    const Scene scene = random_packing(2, 1000);
    Model early = effects::make_model(scene);
    state_of(early);
    for (double& x : early.bodies.position) x = std::clamp(x + little(random), 0.1, 23.9);
    Model late = effects::make_model(scene);
    late.bodies = early.bodies;
    const State old_list = state_of(early), new_list = state_of(late);
    REQUIRE(early.neighbours->searches() == 1);
    REQUIRE(old_list.neighbours.size() != new_list.neighbours.size());
    std::vector<double> old_force(2000), new_force(2000);
    const effects::SoftRepulsion potential(scene);
    CHECK(potential.energy_and_forces(old_list, old_force) == potential.energy_and_forces(new_list, new_force));
    CHECK(old_force == new_force);
  }
}

TEST_CASE("PotentialEnergy: energy and gradient equal the sum over all pairs") {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> step(-1, 1);
  for (const int dimension : {2, 3}) {
    const double side = dimension == 3 ? 24 : 60;
    const Scene scene = random_packing(dimension, 6000, side);
    Model model = effects::make_model(scene);
    const effects::SoftRepulsion potential(scene);
    statics::PotentialEnergy kept(scene, 2);
    std::vector<double> x = model.bodies.position;
    // Steps of various lengths: candidates stay valid, are collected again, or are searched for again.
    for (const double length : {0.0, 1e-4, 1e-4, 1e-2, 0.1, 1.0, 1e-5, 1e-5, 0.03, 0.03, 0.03, 0.03}) {
      CAPTURE(dimension);
      CAPTURE(length);
      for (double& c : x) c = std::clamp(c + length * step(random), 0.05, side - 0.05);
      std::vector<double> gradient(x.size()), fresh_gradient(x.size()), force(x.size());
      const double energy = kept.evaluate(x, gradient);
      statics::PotentialEnergy fresh(scene, 1);
      CHECK(fresh.evaluate(x, fresh_gradient) == energy);
      CHECK(fresh_gradient == gradient);
      model.bodies.position = x;
      // About 1e5 terms: rounding is far below 1e-12 of their sum.
      CHECK(potential.energy_and_forces(state_of(model), force) == doctest::Approx(energy).epsilon(1e-12));
      double largest = 0, difference = 0;
      for (std::size_t k = 0; k < x.size(); ++k) {
        largest = std::max(largest, std::abs(force[k]));
        difference = std::max(difference, std::abs(force[k] + gradient[k]));
      }
      CHECK(difference <= 1e-13 * largest);
    }
  }
}

TEST_CASE("PotentialEnergy: infinite for coinciding centres and crossed walls") {
  const Scene scene = random_packing(2, 1000);
  statics::PotentialEnergy energy(scene, 1);
  const std::vector<double> start = energy.model().bodies.position;
  std::vector<double> gradient(start.size());
  for (const double left : {0.0, -1e-3, -2.0}) {
    CHECK(std::isfinite(energy.evaluate(start, gradient)));
    std::vector<double> x = start;
    x[0] = left;
    CHECK(std::isinf(energy.evaluate(x, gradient)));
  }
  CHECK(std::isfinite(energy.evaluate(start, gradient)));
  std::vector<double> x = start;
  x[0] = x[2], x[1] = x[3];
  CHECK(std::isinf(energy.evaluate(x, gradient)));
}

TEST_CASE("SoftRepulsion: a pair counts once, energy beyond a wall is infinite") {
  Scene scene = packing(2, "lbfgs");
  scene.conductors = {{.position = {2, 3}, .radius = 1}, {.position = {3, 3}, .radius = 1}};
  Model model = effects::make_model(scene);
  const effects::SoftRepulsion potential(scene);
  CHECK(potential.energy(state_of(model)) == doctest::Approx(0.5 * std::log(2)));  // q = 1/2, once.
  model.bodies.position = {0.5, 3, 4, 3};
  CHECK(potential.energy(state_of(model)) == doctest::Approx(0.5 * std::log(2)));
  std::vector<double> force(4);
  model.forces(0, force);
  CHECK(force[0] == doctest::Approx(std::log(2) + 1));  // Inward.
  for (const double beyond : {0.0, -0.5}) {
    model.bodies.position[0] = beyond;
    CHECK(std::isinf(potential.energy(state_of(model))));
    CHECK_THROWS_AS(model.forces(0, force), Failure);
  }
  model.bodies.position = {3, 3, 3, 3};
  CHECK(std::isinf(potential.energy(state_of(model))));
}

TEST_CASE("minimizers: each finds the minimum of a quadratic bowl") {
  const std::vector<double> start = {-2, 4, 4, -3};
  const auto check = [](minimize::Minimizer&& minimizer) {
    for (int k = 0; k < 20000 && minimizer.point().value > 1e-24 && minimizer.iterate(); ++k)
      CHECK(std::isfinite(minimizer.point().value));
    for (int i = 0; i < 4; ++i) CHECK(minimizer.point().x[i] == doctest::Approx(i).epsilon(1e-9));
  };
  Bowl bowl;
  check(minimize::GradientDescent(bowl, start, 0.1, 1));
  check(minimize::Fire(bowl, start, 0.5, 1));
  check(minimize::Lbfgs(bowl, start, 0.1, 1));
  check(minimize::NewtonCg(bowl, start, 1, 1));
  CHECK_THROWS_AS(minimize::Lbfgs(bowl, {4, 0, 0, 0}, 0.1, 1), InputError);
}

TEST_CASE("minimizers: the state of another minimization is refused") {
  Bowl bowl;
  const auto check = [&](minimize::Minimizer&& minimizer, minimize::Memory memory, const std::string& damaged) {
    minimizer.remember(memory);
    memory.at(damaged).push_back(0);
    CHECK_THROWS_AS(minimizer.remember(memory), Failure);
    memory.erase(damaged);
    CHECK_THROWS_AS(minimizer.remember(memory), Failure);
  };
  const std::vector<double> start = {-2, 4, 4, -3};
  minimize::Lbfgs lbfgs(bowl, start, 0.1, 1);
  lbfgs.iterate();
  for (const char* damaged : {"products 00", "products with gradient"})
    check(minimize::Lbfgs(bowl, start, 0.1, 1), lbfgs.memory(), damaged);
  for (const char* damaged : {"velocity", "fire"})
    check(minimize::Fire(bowl, start, 0.5, 1), minimize::Fire(bowl, start, 0.5, 1).memory(), damaged);
  check(minimize::NewtonCg(bowl, start, 1, 1), {{"radius", {1}}}, "radius");
}

TEST_CASE("minimizers: each finds the minimum from deep within a steep wall") {
  Pit pit;
  const auto check = [](minimize::Minimizer&& minimizer) {
    for (int k = 0; k < 20000 && std::abs(minimizer.point().gradient[0]) > 1e-9 && minimizer.iterate(); ++k)
      REQUIRE(minimizer.point().x[0] > 0);
    CHECK(minimizer.point().x[0] == doctest::Approx(1).epsilon(1e-8));
  };
  for (const double depth : {1e-3, 1e-9}) {
    CAPTURE(depth);
    check(minimize::GradientDescent(pit, {depth}, 0.1, 0.2));
    check(minimize::Fire(pit, {depth}, 0.5, 0.2));
    check(minimize::Lbfgs(pit, {depth}, 0.1, 0.2));
    check(minimize::NewtonCg(pit, {depth}, 0.2, 1));
  }
}

TEST_CASE("Minimization: progress is the logarithm of the largest force") {
  Minimization packed(packing(2, "lbfgs", "force_tolerance = 1e-6"));
  const ProgressMeasure start = packed.progress_measure();
  CHECK(start.whole == doctest::Approx(6 * std::log(10.0)));
  CHECK(start.done == doctest::Approx(-std::log(packed.largest_force() / packed.force_unit())));
  CHECK(start.done < start.whole);
  while (!packed.at_rest()) REQUIRE(packed.iterate());
  CHECK(packed.progress_measure().done >= packed.progress_measure().whole);
}

TEST_CASE("packing, disk deep in a wall: every method brings it to rest") {
  for (const std::string method : methods) {
    CAPTURE(method);
    Minimization minimization(
        parse_scene("[domain]\nsize = [1.8, 1.8]\n[effects.soft_repulsion]\n[minimize]\nmethod = \"" + method +
                        "\"\n[[conductor]]\nposition = [0.001, 0.9]\nradius = 1\n",
                    "wall"));
    while (!minimization.at_rest() && minimization.iterate()) {
    }
    CHECK(minimization.at_rest());
    CHECK(minimization.bodies().position[0] == doctest::Approx(0.9).epsilon(1e-7));
  }
}

TEST_CASE("packing: stiffness times 2^146 or 2^-146 changes no bit, by every method") {
  for (const std::string method : methods) {
    CAPTURE(method);
    const auto at_rest = [&](double stiffness) {
      Scene scene = packing(2, method);
      scene.effects.find<effects::SoftRepulsionOptions>()->stiffness = stiffness;
      Minimization minimization(scene);
      while (!minimization.at_rest() && minimization.iterate()) {
      }
      CHECK(minimization.at_rest());
      return minimization.bodies().position;
    };
    const std::vector<double> usual = at_rest(1);
    for (const double stiffness : {0x1p-146, 0x1p146}) CHECK(at_rest(stiffness) == usual);
  }
}

TEST_CASE("packing with overflowing forces: throws Failure for every method") {
  const std::string start =
      "[domain]\nsize = [4.0, 4.0]\n[effects.soft_repulsion]\nbox = false\n"
      "[[wall]]\npoint = [-3.0, 0.0]\nnormal = [1.0, 0.0]\n[[conductor]]\nposition = [0.0, 1.0]\nradius = 1\n";
  for (const std::string method : methods) {
    const std::string text =
        start + "[[conductor]]\nposition = [1e-160, 1.0]\nradius = 1\n[minimize]\nmethod = \"" + method + "\"\n";
    CHECK_THROWS_AS(Minimization(parse_scene(text, "coincident")), Failure);
  }
}

TEST_CASE("packing: every method brings it to rest without charges or field") {
  for (const int dimension : {2, 3})
    for (const std::string method : methods) {
      CAPTURE(method);
      Minimization minimization(packing(dimension, method));
      double energy = minimization.energy();
      while (!minimization.at_rest() && minimization.iterate()) {
        if (method == "fire") continue;  // FIRE may temporarily increase the energy.
        CHECK(minimization.energy() <= energy * (1 + 1e-12));
        energy = minimization.energy();
      }
      CHECK(minimization.at_rest());
      CHECK(minimization.bodies().charge.empty());
      const std::vector<double> position = minimization.frame().reals("position");
      REQUIRE(position.size() == 150);
      CHECK((position[2] != 0) == (dimension == 3));
    }
  CHECK(!parallel::petsc_started());
}

TEST_CASE("packing not at rest: its summary gives a warning") {
  Minimization minimization(packing(2, "lbfgs", "max_iterations = 3"));
  minimization.advance_to(3, {});
  REQUIRE(!minimization.at_rest());
  const std::vector<std::string> warnings = minimization.summary().warnings;
  REQUIRE(!warnings.empty());
  CHECK(warnings.front().starts_with("not at rest after 3 iterations: "));
  Minimization rests(packing(2, "lbfgs-newton"));
  rests.advance_to(1e9, {});
  REQUIRE(rests.at_rest());
  CHECK(rests.summary().warnings.empty());
}

TEST_CASE("minimization: restored from a checkpoint, it has identical bits") {
  for (const std::string method : methods) {
    CAPTURE(method);
    const Scene scene = packing(2, method);
    Minimization whole(scene), first(scene), second(scene);
    for (int k = 0; k < 300 && !whole.at_rest(); ++k) whole.iterate();
    for (int k = 0; k < 137 && !first.at_rest(); ++k) first.iterate();
    second.restore(first.checkpoint());
    for (int k = 137; k < 300 && !second.at_rest(); ++k) second.iterate();
    CHECK(second.bodies().position == whole.bodies().position);
    CHECK(second.iteration() == whole.iteration());
  }
}

TEST_CASE("PotentialEnergy: one and three threads give identical bits") {
  const Scene scene = parse_scene(
      "[domain]\nsize = [50.0, 50.0]\n[effects.soft_repulsion]\n"
      "[[population]]\ncount = 5000\nradius = [0.3, 0.4]\noverlapping = true\n",
      "packing");
  std::vector<std::vector<double>> results;
  for (const int threads : {1, 3}) {
    statics::PotentialEnergy energy(scene, threads);
    const std::vector<double> x = energy.model().bodies.position;
    std::vector<double> gradient(x.size()), product(x.size());
    const double value = energy.evaluate(x, gradient);
    gradient.push_back(value);
    energy.linearize(x);
    energy.multiply(x, product);
    gradient.insert(gradient.end(), product.begin(), product.end());
    results.push_back(gradient);
  }
  CHECK(results[0] == results[1]);
}

}  // namespace statics_test
