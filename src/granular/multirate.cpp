#include <fmt/format.h>

#include <cmath>

#include "solvers/error.hpp"
#include "src/granular/held_forces.hpp"
#include "src/granular/integrator.hpp"
#include "src/granular/pace.hpp"

namespace lichtenberg::granular {
namespace {

/// Multiple time stepping. Smooth forces are constant over a step, within which contacts have substeps of their own. At
/// its end momenta are corrected by half of the change of the forces, which is velocity Verlet for smooth forces.
/// Without contacts this equals impulses at both ends of a step (Tuckerman, Berne and Martyna 1992). Impulses would
/// excite the contacts of bound pairs, which dissipate that energy in each step. Charges are exchanged between two
/// steps.
class Multirate final : public GasIntegrator {
 public:
  double longest_step(Gas& gas, Instant& now) const override {
    const double asked = gas.scene().mechanics.step, hold = longest_hold(gas);
    if (!std::isinf(asked) && asked > hold && gas.steps == 0)  // later, as charges grow, steps become shorter
      throw InputError(
          fmt::format("{}: mechanics.step = {:g} is too long: forces that are constant over it would excite "
                      "oscillations of grains bound by their charges; at most {:.2g} is allowed",
                      gas.scene().path, asked, 0.99 * hold));
    const double way = std::isinf(asked) ? way_by_accuracy(gas.scene()) : way_by_length(gas.scene());
    StepBounds bounds{.asked = asked, .hold = hold, .way = way, .speed = now.survey.fastest};
    if (std::isinf(asked)) gas.find_forces(now), bounds.acceleration = now.acceleration;
    return longest_step_within(bounds, [&](double gain) {
      return gas.time_to_resolve(gas.fastest_impact(now) + gain) / gas.scene().mechanics.contact_steps;
    });
  }

  Instant step(Gas& gas, Instant now, double end, Want want) override {
    const double begin = gas.time(), half = 0.5 * (end - begin);
    gas.find_forces(now);
    gas.drive(now, begin, half);
    now = gas.follow_contacts(now, end, want);
    gas.drive(now, begin + half, half);
    gas.settle_contacts(now);
    return now;
  }
};

}  // namespace

std::unique_ptr<GasIntegrator> make_multirate() { return std::make_unique<Multirate>(); }

}  // namespace lichtenberg::granular
