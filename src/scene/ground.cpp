#include "src/scene/ground.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace lichtenberg {

void check_ground(const Draft& draft, const Scene& scene, const std::string& source) {
  const bool grounded =
      scene.domain.open ||
      std::ranges::any_of(scene.electrodes,
                          [](const Electrode& e) { return e.series_resistance == 0 && e.circuit < 0; }) ||
      std::ranges::any_of(scene.domain.sides,
                          [](const DomainSide& side) { return side.electrode && side.circuit < 0; }) ||
      std::ranges::any_of(scene.circuits, [](const Circuit& circuit) { return circuit.capacitance > 0; }) ||
      std::ranges::any_of(scene.groups, [](const PrescribedGroup& group) { return group.potential.has_value(); });
  if (grounded) return;
  const std::string remedy =
      fmt::format("a side of the domain, an [[electrode]] or a [[group]] must have a potential{}",
                  scene.electrodes.empty() ? "" : " without a resistor");
  const bool resistor =
      std::ranges::any_of(scene.electrodes, [](const Electrode& e) { return e.series_resistance > 0; }) ||
      std::ranges::any_of(scene.circuits, [](const Circuit& circuit) { return circuit.resistance > 0; });
  if (!resistor && !source.empty())
    refuse(draft.scene.path, draft.line(source),
           source + " feeds charge into an insulated box without any ground: " + remedy);
  double net = 0, total = 0;
  const auto add = [&](double charge) { net += charge, total += std::abs(charge); };
  for (const Conductor& conductor : scene.conductors) add(conductor.charge);
  for (const PrescribedGroup& group : scene.groups) add(group.charge);
  for (const Circuit& circuit : scene.circuits) add(circuit.charge);
  constexpr double rounding = 1e-12;  // rounding of charges that are meant to cancel
  if (std::abs(net) > rounding * total)
    refuse(draft.scene.path, draft.line("domain"),
           fmt::format(
               "a net charge of {:.3g} C is in an insulated box without any ground: {}, or the charges must cancel",
               net, remedy));
}

}  // namespace lichtenberg
