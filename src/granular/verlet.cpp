#include "src/granular/integrator.hpp"

namespace lichtenberg::granular {
namespace {

constexpr double verlet_steps_a_contact = 10;  ///< with fewer, errors of the restitution exceed .02

/// Velocity Verlet integrator. Contact forces at the end of a step depend on the velocities there, which depend on
/// these forces. With velocities in the middle of the step (Singh 2019, eq. 3.44) the method has first order. This
/// implementation predicts the velocities with the contact forces at the start, which gives second order.
class Verlet final : public GasIntegrator {
 public:
  double longest_step(Gas& gas, Instant& now) const override {
    return step_that_resolves_contacts(gas, now, verlet_steps_a_contact);
  }

  Instant step(Gas& gas, Instant now, double end, Want want) override {
    const double begin = gas.time(), dt = end - begin, half = 0.5 * dt;
    gas.find_forces(now);
    gas.drive(now, begin, half);
    const std::vector<double> from = gas.bodies().position;
    if (load_.force.empty()) load_ = gas.contact_load(gas.candidate_pairs(dt));
    gas.add_impulse(half, now.force);
    gas.add_impulse(half, load_.force);
    const std::span<const Pair> near = gas.candidate_pairs(dt);
    fly(gas, end);
    Instant there;
    gas.find_forces(there, want);
    gas.add_impulse(half, there.force);
    ContactLoad then = predicted(gas, half, near);
    gas.add_impulse(half, then.force);
    gas.note(contacts_in_step(from, gas.bodies(), gas.contacts(), near, begin, dt), begin,
             half * (load_.dissipation + then.dissipation));
    load_ = std::move(then);
    there.statistics = gas.instant().statistics;
    gas.drive(there, begin + half, half);
    gas.exchange_charges(there);
    return there;
  }

  void reset_history() override { load_ = {}; }
  void save(Checkpoint& checkpoint) const override {
    checkpoint.reals["verlet_force"] = load_.force;
    checkpoint.reals["verlet_dissipation"] = {load_.dissipation};
  }
  void restore(const Checkpoint& checkpoint) override {
    const std::vector<double>& momentum = checkpoint.reals.at("momentum");
    const bool begun = checkpoint.reals.contains("verlet_force") && !checkpoint.reals.at("verlet_force").empty();
    load_.force = reals(checkpoint, "verlet_force", begun ? momentum.size() : 0);
    load_.dissipation = reals(checkpoint, "verlet_dissipation", 1).front();
  }

 private:
  static void fly(Gas& gas, double end) {
    const Bodies& b = gas.bodies();
    std::vector<double> path;
    for (std::size_t k = 0; k < b.momentum.size(); ++k)
      path.push_back((end - gas.time()) * b.momentum[k] / b.mass[k / b.dimension]);
    gas.move(path, end);
  }

  /// Returns the contact forces at the end of a step. The velocities there are predicted with the contact forces at its
  /// start. `half`: half of the step; `near`: candidate pairs.
  ContactLoad predicted(Gas& gas, double half, std::span<const Pair> near) const {
    const std::vector<double> momentum = gas.bodies().momentum;
    gas.add_impulse(half, load_.force);
    ContactLoad load = gas.contact_load(near);
    gas.model().bodies.momentum = momentum;
    return load;
  }

  ContactLoad load_;  ///< at the end of the last step, with predicted velocities; empty: not computed
};

}  // namespace

std::unique_ptr<GasIntegrator> make_verlet() { return std::make_unique<Verlet>(); }

}  // namespace lichtenberg::granular
