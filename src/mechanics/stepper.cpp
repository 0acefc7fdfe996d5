#include "src/mechanics/stepper.hpp"

#include <algorithm>

#include "src/mechanics/euler.hpp"
#include "src/mechanics/monolithic.hpp"
#include "src/mechanics/split.hpp"

namespace lichtenberg::mechanics {

std::unique_ptr<Stepper> make_stepper(Workplace workplace) {
  const MechanicsOptions& options = workplace.scene.mechanics;
  if (options.integrator == Integrator::euler) return std::make_unique<Euler>(workplace);
  // Without a field there is nothing to split off.
  if (!workplace.electrics || options.coupling == FieldCoupling::monolithic)
    return std::make_unique<Monolithic>(workplace);
  return std::make_unique<Split>(workplace);
}

std::vector<double> drag_coefficients(const Model& model) {
  std::vector<double> coefficients;
  for (const double radius : model.bodies.radius) coefficients.push_back(model.drag_coefficient(radius));
  return coefficients;
}

Cvode make_cvode(const Scene& scene, Model& model) {
  const Bodies& bodies = model.bodies;
  const double smallest = *std::ranges::min_element(bodies.radius);
  Accuracy accuracy{.relative = scene.mechanics.relative_tolerance,
                    .position = scene.mechanics.relative_tolerance * smallest,
                    .momentum = {}};
  const std::vector<double> drag = drag_coefficients(model);
  for (int i = 0; i < bodies.size(); ++i)
    accuracy.momentum.push_back(std::max(drag[i], bodies.mass[i] / scene.mechanics.largest_step) * accuracy.position);
  return Cvode(model, accuracy);
}

void book_drag(const Workplace& at, const std::vector<double>& drag, Cvode& cvode) {
  EnergyBook* energy = at.electrics ? at.electrics->energy() : nullptr;
  if (!energy || std::ranges::all_of(drag, [](double d) { return d == 0; })) return;
  cvode.after_step = [energy, &bodies = at.model.bodies, &drag](double dt, const std::vector<double>& position,
                                                                const std::vector<double>& momentum) {
    double work = 0;
    for (std::size_t c = 0; c < position.size(); ++c) {
      const std::size_t i = c / bodies.dimension;
      const double before = momentum[c] / bodies.mass[i], after = bodies.momentum[c] / bodies.mass[i];
      const double middle = 1.5 * (bodies.position[c] - position[c]) / dt - 0.25 * (before + after);
      work += drag[i] * dt / 6 * (before * before + 4 * middle * middle + after * after);
    }
    energy->add_drag(work);
  };
}

}  // namespace lichtenberg::mechanics
