#include "src/granular/integrator.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>

#include "solvers/error.hpp"
#include "src/granular/held_forces.hpp"

namespace lichtenberg::granular {

namespace {

struct Maker {
  Integrator integrator;
  std::unique_ptr<GasIntegrator> (*make)();
};

constexpr Maker makers[] = {{Integrator::multirate, make_multirate},
                            {Integrator::verlet, make_verlet},
                            {Integrator::gear, [] { return make_gear(false); }},
                            {Integrator::gear_printed, [] { return make_gear(true); }},
                            {Integrator::cvode, make_cvode}};

}  // namespace

std::unique_ptr<GasIntegrator> make_integrator(Integrator which) {
  const auto found = std::ranges::find(makers, which, &Maker::integrator);
  if (found == std::end(makers))
    throw InputError(fmt::format("mechanics.integrator = \"{}\" does not move grains: {} do", which->name,
                                 names_of(&IntegratorKind::moves_grains)));
  return found->make();
}

double step_that_resolves_contacts(const Gas& gas, double steps_a_contact) {
  const MechanicsOptions& mechanics = gas.scene().mechanics;
  constexpr double fewer = 1.5;  // than multirate has for a dashpot: restitutions need not be as good as its books
  const double impact = gas.fastest_impact(), damping = fewer * gas.time_to_resolve(impact);
  const double contact = granular::time_to_resolve(elastic(gas.law(), 1), impact, gas.grains_seen());
  const double resolved = std::min(contact, damping);
  if (mechanics.step * steps_a_contact > resolved)
    throw InputError(fmt::format(
        "{}: mechanics.step = {:g} is too long for mechanics.integrator = \"{}\": the shortest contact that there "
        "could be at t = {:.4g} lasts {:.3g}{}, and needs {:g} steps; {:.2g} would do",
        gas.scene().path, mechanics.step, name_of(mechanics.integrator), gas.time(), resolved,
        damping < contact ? " until its dashpot has slowed the grains down" : "", steps_a_contact,
        0.95 * resolved / steps_a_contact));
  return mechanics.step;
}

double longest_hold(const Gas& gas) {
  const ContactAttraction attraction = contact_attraction(gas.scene());
  const Bodies& bodies = gas.bodies();
  double charge = 0;
  for (const double q : bodies.charge) charge = std::max(charge, std::abs(q));
  return longest_hold(attraction, gas.law(), charge, *std::ranges::min_element(bodies.mass));
}

}  // namespace lichtenberg::granular
