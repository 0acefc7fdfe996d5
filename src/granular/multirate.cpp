#include <fmt/format.h>

#include <cmath>
#include <limits>

#include "solvers/error.hpp"
#include "src/granular/integrator.hpp"
#include "src/granular/pace.hpp"
#include "src/granular/slow_force_limits.hpp"
#include "src/scene/effect_kind.hpp"

namespace lichtenberg::granular {
namespace {

/// Integrator with multiple time stepping (r-RESPA). Smooth forces (all forces except contacts) are constant over an
/// outer step, in which contacts have shorter substeps. At its end, momenta are corrected by half of the step times the
/// change of the smooth forces. Without contacts this is velocity Verlet, and equals impulses at both ends of a step
/// (Tuckerman, Berne and Martyna 1992). Impulses would excite the contacts of bound pairs, which dissipate this energy
/// in each step. Charges are exchanged between two steps.
class Multirate final : public GasIntegrator {
 public:
  double longest_step(Gas& gas, Instant& now) const override {
    const double requested = gas.scene().mechanics.step, stability_limit = max_outer_step(gas);
    if (!std::isinf(requested) && requested > stability_limit &&
        gas.steps == 0)  // later, as charges grow, steps become shorter
      throw InputError(
          fmt::format("{}: mechanics.step = {:g} is too long: forces that are constant over it would excite "
                      "oscillations of grains bound by their charges; at most {:.2g} is allowed",
                      gas.scene().path, requested, 0.99 * stability_limit));
    StepBounds bounds{.requested = requested,
                      .stability_limit = stability_limit,
                      .path = path_in_step(gas.scene()),
                      .speed = gas.speed_to_follow(now)};
    if (std::isinf(requested) && only_contacts_act(gas.scene()))
      bounds.requested = std::numeric_limits<double>::max();  // bounded by the path alone, also below a contact substep
    else if (std::isinf(requested))
      gas.find_forces(now), bounds.acceleration = now.acceleration;
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
    gas.exchange_charges(now);
    return now;
  }
};

}  // namespace

std::unique_ptr<GasIntegrator> make_multirate() { return std::make_unique<Multirate>(); }

}  // namespace lichtenberg::granular
