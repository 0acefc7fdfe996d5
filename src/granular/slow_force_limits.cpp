#include "src/granular/slow_force_limits.hpp"

#include <algorithm>
#include <cmath>

#include "solvers/error.hpp"
#include "src/granular/pace.hpp"
#include "src/scene/effect_kind.hpp"

namespace lichtenberg::granular {

double path_by_length(const Scene& scene) {
  const std::optional<double> length = least_in(scene, &StepLimits::force_length);
  return max_relative_path * std::min(1.0, length.value_or(1));
}

double path_by_accuracy(const Scene& scene) {
  const std::optional<double> accuracy = least_in(scene, &StepLimits::force_accuracy);
  if (!accuracy) throw Failure(scene.path + ": no effect has an accuracy of its forces, from which steps would follow");
  const double diameter = 2 * scene.smallest_radius();
  const double length = least_in(scene, &StepLimits::force_length).value_or(diameter);
  return path_for_accuracy(*accuracy, scene.conductors.size(), std::min(diameter, length));
}

double path_in_step(const Scene& scene) {
  if (!std::isinf(scene.mechanics.step)) return path_by_length(scene);
  return only_contacts_act(scene) ? path_per_search : path_by_accuracy(scene);
}

ContactAttraction contact_attraction(const Scene& scene) {
  ContactAttraction sum;
  for (const Effects::Entry& entry : scene.effects)
    if (entry.kind->steps.contact_attraction) {
      const ContactAttraction one = entry.kind->steps.contact_attraction(scene);
      sum.constant += one.constant, sum.by_charge += one.by_charge;
    }
  return sum;
}

double max_outer_step(const ContactAttraction& attraction, const GrainContactLaw& law, double charge, double lightest) {
  return std::visit([&](const auto& one) { return max_outer_step(one, attraction(charge), 0.5 * lightest); }, law);
}

}  // namespace lichtenberg::granular
