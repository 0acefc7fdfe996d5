// Integrator of grains added from outside: leapfrog, with one evaluation of all forces per step.
#include <doctest/doctest.h>

#include <fmt/format.h>

#include <cmath>
#include <memory>
#include <span>
#include <vector>

#include "src/effects/read_scene.hpp"
#include "src/granular/contacts.hpp"
#include "src/granular/granular_motion.hpp"
#include "src/granular/integrator.hpp"
#include "tests/grains.hpp"

namespace extend_grain_integrator {

using namespace lichtenberg;

namespace {

/// Half a drift, the forces at the middle for the whole step, and half a drift (Verlet 1967, position form). Second
/// order for elastic contacts.
class Leapfrog final : public granular::GasIntegrator {
 public:
  double longest_step(granular::Gas& gas, granular::Instant& now) const override {
    return granular::step_that_resolves_contacts(gas, now, 10);
  }

  granular::Instant step(granular::Gas& gas, granular::Instant, double end, granular::Want) override {
    const double begin = gas.time(), dt = end - begin;
    const std::vector<double> from = gas.bodies().position;
    const auto near = gas.candidate_pairs(dt);
    const std::vector<Pair> pairs(near.begin(), near.end());
    fly(gas, begin + 0.5 * dt, 0.5 * dt);
    const granular::ContactLoad load = gas.contact_load(pairs);
    gas.add_impulse(dt, gas.smooth_forces());
    gas.add_impulse(dt, load.force);
    fly(gas, end, 0.5 * dt);
    gas.note(granular::contacts_in_step(from, gas.bodies(), gas.contacts(), pairs, begin, dt), begin,
             dt * load.dissipation);
    granular::Instant there = gas.instant();
    gas.exchange_charges(there);
    return there;
  }

 private:
  static void fly(granular::Gas& gas, double time, double dt) {
    const Bodies& b = gas.bodies();
    std::vector<double> path;
    for (std::size_t k = 0; k < b.momentum.size(); ++k) path.push_back(dt * b.momentum[k] / b.mass[k / b.dimension]);
    gas.move(path, time);
  }
};

constexpr IntegratorKind leapfrog = {
    .name = "leapfrog", .moves_grains = true, .keys = {"step", "threads"}, .usual_step = 0.005};

constexpr double end = 2;  // In t0: about ten oscillations.

/// Momenta at the end of a run of two opposite charges that oscillate in contact. They start at the contact threshold,
/// because a fast onset within a step would add an error that depends on its time in the step.
std::vector<double> momenta(const std::string& integrator, double step) {
  std::string text = fmt::format(
      "reference = {{}}\nstop = {{ time = {} }}\noutput = {{ every = 20.0 }}\n"
      "mechanics = {{ integrator = \"{}\", step = {} }}\n"
      "effects = {{ viscoelastic_contact = {{ stiffness = 278.6, damping = 0 }}, "
      "coulomb = {{ coupling_constant = 5, sum = \"minimum-image\" }} }}\n[domain]\nsize = [10, 10, 10]\n",
      end, integrator, step);
  for (const char* side : {"left", "right", "bottom", "top", "front", "back"})
    text += fmt::format("{} = \"periodic\"\n", side);
  for (const int sign : {-1, 1})
    text += fmt::format("[[conductor]]\nposition = [{}, 5, 5]\nvelocity = [0, {}, 0]\nradius = 0.5\ncharge = {}\n",
                        5 + sign * 0.5000005, -0.3 * sign, -sign);
  GranularMotion motion(parse_scene(text, "scene.toml"));
  motion.advance_to(end, [] { return false; });
  return motion.checkpoint().reals.at("momentum");
}

double error(double step, const std::vector<double>& exact) {
  const std::vector<double> found = momenta("leapfrog", step);
  double most = 0;
  for (std::size_t k = 0; k < exact.size(); ++k) most = std::max(most, std::abs(found[k] - exact[k]));
  return most;
}

}  // namespace

TEST_CASE("user-defined grain integrator (leapfrog): error is of second order") {
  granular::add_integrator(leapfrog,
                           []() -> std::unique_ptr<granular::GasIntegrator> { return std::make_unique<Leapfrog>(); });
  const std::vector<double> exact = momenta("cvode", 0.05);
  const double coarse = error(0.004, exact), middle = error(0.002, exact), fine = error(0.001, exact);
  CHECK(coarse < 0.01);
  CHECK(coarse / middle == doctest::Approx(4).epsilon(0.1));
  CHECK(middle / fine == doctest::Approx(4).epsilon(0.1));
}

}  // namespace extend_grain_integrator
