#include "src/granular/integrator.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <utility>

#include "solvers/error.hpp"
#include "src/granular/slow_force_limits.hpp"

namespace lichtenberg::granular {

namespace {

using Maker = std::unique_ptr<GasIntegrator> (*)();

constexpr std::pair<const IntegratorKind*, Maker> built_in[] = {{&integrators::multirate, make_multirate},
                                                                {&integrators::verlet, make_verlet},
                                                                {&integrators::gear, make_gear},
                                                                {&integrators::gear_printed, make_gear_as_printed},
                                                                {&integrators::cvode, make_cvode}};
static_assert(integrators::have_all(built_in, &IntegratorKind::moves_grains));

std::map<const IntegratorKind*, Maker>& makers() {
  static std::map<const IntegratorKind*, Maker> all(std::begin(built_in), std::end(built_in));
  return all;
}

}  // namespace

void add_integrator(const IntegratorKind& kind, Maker make) {
  if (!kind.moves_grains || !(kind.usual_step > 0))
    throw InputError(
        fmt::format("the integrator \"{}\" must set moves_grains = true and a usual_step greater than 0, in t0, the "
                    "default of mechanics.step",
                    kind.name));
  list_integrator(kind);
  makers()[&kind] = make;
}

std::unique_ptr<GasIntegrator> make_integrator(Integrator which) {
  const auto found = makers().find(&which.kind());
  if (found != makers().end()) return found->second();
  throw InputError(fmt::format("mechanics.integrator = \"{}\" does not move grains: the integrators {} do", which->name,
                               names_of(&IntegratorKind::moves_grains)));
}

double step_that_resolves_contacts(const Gas& gas, const Instant& now, double steps_a_contact) {
  const MechanicsOptions& mechanics = gas.scene().mechanics;
  // Ratio to the substeps of multirate: restitutions tolerate larger errors than the energy budget.
  constexpr double fewer = 1.5;
  const double impact = gas.fastest_impact(now), damping = fewer * gas.time_to_resolve(impact);
  const double contact = granular::time_to_resolve(elastic(gas.law(), 1), impact, gas.grain_properties());
  const double resolved = std::min(contact, damping);
  if (mechanics.step * steps_a_contact > resolved)
    throw InputError(
        fmt::format("{}: mechanics.step = {:g} is too long for mechanics.integrator = \"{}\": {} at t = {:.4g} "
                    "is {:.3g} t0, which needs {:g} steps; a step of {:.2g} would do",
                    gas.scene().path, mechanics.step, name_of(mechanics.integrator),
                    damping < contact ? "1.5 times the damping time of a typical contact"
                                      : "the shortest possible duration of a contact",
                    gas.time(), resolved, steps_a_contact, 0.95 * resolved / steps_a_contact));
  return mechanics.step;
}

double max_outer_step(const Gas& gas) {
  const ContactAttraction attraction = contact_attraction(gas.scene());
  const Bodies& bodies = gas.bodies();
  double charge = 0;
  for (const double q : bodies.charge) charge = std::max(charge, std::abs(q));
  return max_outer_step(attraction, gas.law(), charge, *std::ranges::min_element(bodies.mass));
}

}  // namespace lichtenberg::granular
