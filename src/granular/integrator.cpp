#include "src/granular/integrator.hpp"

#include <fmt/format.h>

#include "solvers/error.hpp"

namespace lichtenberg::granular {

std::unique_ptr<GasIntegrator> make_integrator(Integrator which) {
  using enum Integrator;
  switch (which) {
    case verlet:
      return make_verlet();
    case gear:
      return make_gear(false);
    case gear_printed:
      return make_gear(true);
    case cvode:
      return make_cvode();
    default:
      return make_multirate();
  }
}

double step_that_resolves_contacts(const Gas& gas, double steps_a_contact) {
  const MechanicsOptions& mechanics = gas.scene().mechanics;
  const double contact = shortest_contact(gas.law(), gas.fastest_impact());
  if (mechanics.step * steps_a_contact > contact)
    throw InputError(fmt::format(
        "{}: mechanics.step = {:g} is too long for mechanics.integrator = \"{}\": the shortest contact that there "
        "could be at t = {:.4g} lasts {:.3g}, and needs {:g} steps; {:.2g} would do",
        gas.scene().path, mechanics.step, name_of(mechanics.integrator), gas.time(), contact, steps_a_contact,
        0.95 * contact / steps_a_contact));
  return mechanics.step;
}

}  // namespace lichtenberg::granular
