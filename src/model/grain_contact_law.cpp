#include "src/model/grain_contact_law.hpp"

#include <cmath>

namespace lichtenberg {
namespace {

ViscoelasticLaw elastic(ViscoelasticLaw law, double stiffness) { return {law.elastic * stiffness, 0}; }
LinearSpringLaw elastic(LinearSpringLaw law, double stiffness) { return {law.stiffness * stiffness, 0}; }

// k = (D/E) (E/m_eff)^(2/5) v^(1/5) of one, B^2/A of the other are all that the restitution depends on.
ViscoelasticLaw stiffer(ViscoelasticLaw law, double stiffness) {
  return {law.elastic * stiffness, law.dissipative * std::pow(stiffness, 0.6)};
}
LinearSpringLaw stiffer(LinearSpringLaw law, double stiffness) {
  return {law.stiffness * stiffness, law.damping * std::sqrt(stiffness)};
}

}  // namespace

GrainContactLaw elastic(const GrainContactLaw& law, double stiffness) {
  return std::visit([&](const auto& one) { return GrainContactLaw(elastic(one, stiffness)); }, law);
}

GrainContactLaw stiffer(const GrainContactLaw& law, double stiffness) {
  return std::visit([&](const auto& one) { return GrainContactLaw(stiffer(one, stiffness)); }, law);
}

double shortest_contact(const GrainContactLaw& law, double speed) {
  return std::visit([&](const auto& one) { return one.shortest_contact(speed); }, law);
}

}  // namespace lichtenberg
