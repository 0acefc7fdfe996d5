#include <array>

#include "src/granular/integrator.hpp"

namespace lichtenberg::granular {
namespace {

constexpr double gear_steps_a_contact = 30;  ///< with fewer it may be unstable

/// Coefficients c_k of Gear's corrector (Gear 1971; Singh 2019, eq. 3.41, lacks the factor k! of the last four). The
/// corrector adds c_k D / dt^k to the k-th derivative of the position, k = 0 ... 5. D is the difference between the
/// acceleration and its prediction, times dt^2/2.
using Corrector = std::array<double, 6>;
constexpr Corrector corrected = {3.0 / 16, 251.0 / 360, 2, 11.0 / 3, 4, 2};
constexpr Corrector as_printed = {3.0 / 16, 251.0 / 360, 1, 11.0 / 18, 1.0 / 6, 1.0 / 60};

/// Gear's predictor-corrector integrator for second-order equations. Taylor polynomials predict positions and their
/// first five derivatives, and the forces at the predicted positions correct them (Singh 2019, eq. 3.37 to 3.41, with
/// powers of dt that 3.37 lacks). The order is 6 for smooth forces; contact forces are not smooth at onset and end.
class Gear final : public GasIntegrator {
 public:
  explicit Gear(const Corrector& corrector) : corrector_(corrector) {}

  double longest_step(Gas& gas, Instant& now) const override {
    return step_that_resolves_contacts(gas, now, gear_steps_a_contact);
  }

  Instant step(Gas& gas, Instant now, double end, Want) override {
    const double begin = gas.time(), dt = end - begin, half = 0.5 * dt;
    gas.drive(now, begin, half);
    if (derivative_[0].empty()) start(gas, dt);
    const std::vector<double> from = gas.bodies().position;
    const std::span<const Pair> near = gas.candidate_pairs(dt);
    predict(gas, end);
    const std::vector<double> smooth = smooth_forces(gas);
    const ContactLoad load = gas.contact_load(near);
    correct(gas, dt, smooth, load.force);
    gas.note(contacts_in_step(from, gas.bodies(), gas.contacts(), near, begin, dt), begin,
             half * (dissipation_ + load.dissipation));
    dissipation_ = load.dissipation;
    now = gas.instant();
    gas.drive(now, begin + half, half);
    add_exchange_jump(gas, now, smooth);
    return now;
  }

  void reset_history() override { derivative_ = {}; }
  void save(Checkpoint& checkpoint) const override {
    for (std::size_t n = 0; n < derivative_.size(); ++n) checkpoint.reals[names[n]] = derivative_[n];
    checkpoint.reals["gear_dissipation"] = {dissipation_};
  }
  void restore(const Checkpoint& checkpoint) override {
    const std::vector<double>& momentum = checkpoint.reals.at("momentum");
    const bool begun = checkpoint.reals.contains(names[0]) && !checkpoint.reals.at(names[0]).empty();
    for (std::size_t n = 0; n < derivative_.size(); ++n)
      derivative_[n] = reals(checkpoint, names[n], begun ? momentum.size() : 0);
    dissipation_ = reals(checkpoint, "gear_dissipation", 1).front();
  }

 private:
  /// Returns the smooth forces (all forces except contacts) on the grains, [N * d]; zeros if there are none.
  static std::vector<double> smooth_forces(Gas& gas) {
    std::vector<double> force = gas.smooth_forces();
    force.resize(gas.bodies().momentum.size());
    return force;
  }

  void start(Gas& gas, double dt) {
    const ContactLoad load = gas.contact_load(gas.candidate_pairs(dt));
    const std::vector<double> smooth = smooth_forces(gas);
    const Bodies& b = gas.bodies();
    for (auto& values : derivative_) values.assign(smooth.size(), 0);
    for (std::size_t k = 0; k < smooth.size(); ++k)
      derivative_[0][k] = (smooth[k] + load.force[k]) / b.mass[k / b.dimension];
    dissipation_ = load.dissipation;
  }

  void predict(Gas& gas, double end) {
    const double dt = end - gas.time();
    Bodies& b = gas.model().bodies;
    auto& [a, jerk, snap, crackle] = derivative_;
    std::vector<double> path;
    for (std::size_t k = 0; k < b.momentum.size(); ++k) {
      const double mass = b.mass[k / b.dimension];
      path.push_back(dt * (b.momentum[k] / mass +
                           dt / 2 * (a[k] + dt / 3 * (jerk[k] + dt / 4 * (snap[k] + dt / 5 * crackle[k])))));
      b.momentum[k] += mass * dt * (a[k] + dt / 2 * (jerk[k] + dt / 3 * (snap[k] + dt / 4 * crackle[k])));
      a[k] += dt * (jerk[k] + dt / 2 * (snap[k] + dt / 3 * crackle[k]));
      jerk[k] += dt * (snap[k] + dt / 2 * crackle[k]);
      snap[k] += dt * crackle[k];
    }
    gas.move(path, end);
  }

  void correct(Gas& gas, double dt, std::span<const double> smooth, std::span<const double> contacts) {
    Bodies& b = gas.model().bodies;
    std::vector<double> path;
    for (std::size_t k = 0; k < smooth.size(); ++k) {
      const double mass = b.mass[k / b.dimension];
      double change = 0.5 * dt * dt * ((smooth[k] + contacts[k]) / mass - derivative_[0][k]);
      path.push_back(corrector_[0] * change);
      b.momentum[k] += mass * corrector_[1] * (change /= dt);
      for (std::size_t n = 0; n < derivative_.size(); ++n) derivative_[n][k] += corrector_[n + 2] * (change /= dt);
    }
    gas.move(path, gas.time());
  }

  /// Exchanges charges, and adds the resulting jump of the accelerations to the stored derivatives. `smooth_before`:
  /// smooth forces before the exchange.
  void add_exchange_jump(Gas& gas, Instant& now, std::span<const double> smooth_before) {
    gas.exchange_charges(now);  // computes new forces if charges move
    for (std::size_t k = 0; k < now.force.size(); ++k)
      derivative_[0][k] += (now.force[k] - smooth_before[k]) / gas.bodies().mass[k / gas.bodies().dimension];
  }

  static constexpr std::array<const char*, 4> names = {"gear_acceleration", "gear_jerk", "gear_snap", "gear_crackle"};
  Corrector corrector_;
  std::array<std::vector<double>, 4> derivative_;  ///< of velocities, [N * d] each; empty: not started
  double dissipation_ = 0;
};

}  // namespace

std::unique_ptr<GasIntegrator> make_gear() { return std::make_unique<Gear>(corrected); }
std::unique_ptr<GasIntegrator> make_gear_as_printed() { return std::make_unique<Gear>(as_printed); }

}  // namespace lichtenberg::granular
