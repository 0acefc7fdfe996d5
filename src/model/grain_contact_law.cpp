#include "src/model/grain_contact_law.hpp"

#include <cmath>
#include <numbers>

namespace lichtenberg {
namespace {

ViscoelasticLaw elastic(ViscoelasticLaw law, double stiffness) { return {law.elastic * stiffness, 0}; }
LinearSpringLaw elastic(LinearSpringLaw law, double stiffness) { return {law.stiffness * stiffness, 0}; }

constexpr double effective_mass = 0.5;

double shortest(const ViscoelasticLaw& law, double speed) {
  return 3.21806 * std::pow(effective_mass * effective_mass / (law.elastic * law.elastic * speed), 0.2);
}
double shortest(const LinearSpringLaw& law, double) {
  return std::numbers::pi * std::sqrt(effective_mass / law.stiffness);
}

}  // namespace

GrainContactLaw elastic(const GrainContactLaw& law, double stiffness) {
  return std::visit([&](const auto& one) { return GrainContactLaw(elastic(one, stiffness)); }, law);
}

double shortest_contact(const GrainContactLaw& law, double speed) {
  return std::visit([&](const auto& one) { return shortest(one, speed); }, law);
}

}  // namespace lichtenberg
