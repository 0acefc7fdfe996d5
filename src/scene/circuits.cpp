#include "src/scene/circuits.hpp"

#include <algorithm>
#include <map>
#include <span>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "solvers/geometry/box.hpp"
#include "src/scene/effect_kind.hpp"
#include "src/scene/nearest.hpp"

namespace lichtenberg {
namespace {

/// Finds the members of circuits by name, and assigns their circuit or potential.
class Members {
 public:
  explicit Members(Draft& draft) : draft_(draft), electrodes_(names_of_electrodes(draft)) {}

  /// Assigns the members of a circuit. `index`: index into Scene::circuits; -1: they get its potential instead.
  void assign(const CircuitDraft& circuit, const std::string& name, int index) {
    for (const std::string& member : circuit.electrodes) {
      const auto refuse_it = [&](const std::string& why) {
        refuse(draft_.scene.path, circuit.line, fmt::format("the circuit \"{}\" lists \"{}\", {}", name, member, why));
      };
      const int electrode = index_of(member, electrodes_);
      const int side = index_of(member, std::span(side_names).first(2 * draft_.scene.dimension()));
      const auto named = std::ranges::find(draft_.groups, member, &GroupDraft::name);
      const bool is_group = named != draft_.groups.end();
      const int meanings = (electrode >= 0) + (side >= 0) + (is_group ? 1 : 0);
      if (meanings == 0) refuse_it(fmt::format("which is no electrode, side or group: {}", known_names(member)));
      if (meanings > 1) refuse_it("the name of more than one electrode, side or group: their names must differ");
      if (!listed_.insert(member).second) refuse_it("which is already in a circuit: list it once");
      if (electrode >= 0) assign(draft_.electrodes[electrode], circuit, index, refuse_it);
      if (side >= 0) assign(draft_.scene.domain.sides[side], circuit, index, refuse_it);
      if (is_group) assign(*named, circuit, index, refuse_it);
    }
  }

 private:
  static int index_of(const std::string& name, const auto& names) {
    const auto found = std::ranges::find(names, name);
    return found == std::ranges::end(names) ? -1 : static_cast<int>(found - std::ranges::begin(names));
  }

  std::string known_names(const std::string& name) const {
    std::vector<std::string> names = electrodes_;
    for (int s = 0; s < 2 * draft_.scene.dimension(); ++s) names.emplace_back(side_names[s]);
    for (const GroupDraft& group : draft_.groups) names.push_back(group.name);
    return fmt::format("the nearest name is \"{}\"", nearest(name, names));
  }

  static constexpr const char* own = "which has a potential or a charge of its own: leave that out";

  static void assign(ElectrodeDraft& electrode, const CircuitDraft& circuit, int index, const auto& refuse_it) {
    if (electrode.potential || electrode.charge || electrode.series_resistance) refuse_it(own);
    electrode.circuit = index;
    electrode.potential = index < 0 ? circuit.potential : Signal(0);
  }
  void assign(DomainSide& side, const CircuitDraft& circuit, int index, const auto& refuse_it) const {
    if (draft_.scene.domain.open) refuse_it("but an unbounded domain has no sides");
    if (side.electrode) refuse_it(own);
    if (side.periodic) refuse_it("which is periodic: only other sides can be electrodes");
    side.electrode = true;
    side.circuit = index;
    if (index < 0) side.potential = *circuit.potential;
  }
  static void assign(GroupDraft& group, const CircuitDraft& circuit, int index, const auto& refuse_it) {
    if (group.potential || group.charge) refuse_it(own);
    group.circuit = index;
    if (index < 0) group.potential = circuit.potential;
  }

  Draft& draft_;
  std::vector<std::string> electrodes_;
  std::set<std::string> listed_;
};

void check_sources(const Draft& draft, const CircuitDraft& circuit, const std::string& name) {
  const auto refuse_it = [&](const std::string& why) {
    refuse(draft.scene.path, circuit.line, fmt::format("the circuit \"{}\" {}", name, why));
  };
  if (circuit.resistance && !circuit.potential)
    refuse_it("has a resistance without a voltage source: circuit.potential is missing");
  if (!circuit.potential || circuit.resistance) return;
  if (circuit.current || circuit.capacitance || circuit.charge)
    refuse_it(
        fmt::format("has circuit.{} and a potential without circuit.resistance, which fixes the potential: give "
                    "the resistance, or leave one of the two out",
                    circuit.current       ? "current"
                    : circuit.capacitance ? "capacitance"
                                          : "charge"));
}

/// Gives circuits of their own to floating electrodes, and to sides that float or have a resistor.
void make_single_circuits(Draft& draft) {
  std::vector<Circuit>& circuits = draft.scene.circuits;
  const std::vector<std::string> names = names_of_electrodes(draft);
  for (std::size_t e = 0; e < draft.electrodes.size(); ++e) {
    ElectrodeDraft& electrode = draft.electrodes[e];
    if (electrode.circuit >= 0) continue;
    const auto refuse_it = [&](const std::string& why) {
      refuse(draft.scene.path, electrode.line, fmt::format("the electrode \"{}\" {}", names[e], why));
    };
    if (electrode.potential && electrode.charge) refuse_it("has both a potential and a charge: leave one of them out");
    if (!electrode.potential && !electrode.charge)
      refuse(draft.scene.path, electrode.line,
             fmt::format("electrode.potential is missing: the electrode \"{}\" needs it (a number in V), or "
                         "electrode.charge in C if it "
                         "floats, or a [[circuit]] that lists it",
                         names[e]));
    if (electrode.charge && electrode.series_resistance)
      refuse_it("has a charge and a series_resistance, which is for a voltage source: leave one of them out");
    if (!electrode.charge) continue;
    electrode.circuit = static_cast<int>(circuits.size());
    circuits.push_back({.name = names[e], .charge = *electrode.charge});
  }
  for (std::size_t s = 0; s < draft.scene.domain.sides.size(); ++s) {
    DomainSide& side = draft.scene.domain.sides[s];
    if (!side.charge && !side.series_resistance) continue;
    side.circuit = static_cast<int>(circuits.size());
    circuits.push_back({.name = std::string(side_names[s]),
                        .resistance = side.series_resistance.value_or(0),
                        .potential = side.potential,
                        .charge = side.charge.value_or(0)});
  }
}

/// Checks that a side whose potential floats can be solved for: a ground elsewhere, and no edges to other electrodes.
void check_sides_in_circuits(const Draft& draft) {
  const Scene& scene = draft.scene;
  const auto& sides = scene.domain.sides;
  for (std::size_t s = 0; s < sides.size(); ++s) {
    if (sides[s].circuit < 0) continue;
    const auto refuse_it = [&](const std::string& why) {
      refuse(scene.path, std::max(draft.line("domain"), draft.line("circuit")),
             fmt::format("the {} side of the domain is in a circuit, {}", side_names[s], why));
    };
    for (std::size_t other = 0; scene.dimension() == 3 && other < sides.size(); ++other)
      if (other / 2 != s / 2 && sides[other].electrode)
        refuse_it(
            fmt::format("which in three dimensions is not allowed with the {} side, an electrode that it meets at "
                        "an edge",
                        side_names[other]));
    const bool ground =
        scene.circuits[sides[s].circuit].capacitance > 0 ||
        std::ranges::any_of(sides, [](const DomainSide& side) { return side.electrode && side.circuit < 0; }) ||
        std::ranges::any_of(draft.electrodes,
                            [](const ElectrodeDraft& e) { return e.circuit < 0 && !e.series_resistance; }) ||
        std::ranges::any_of(draft.groups, [](const GroupDraft& group) { return group.potential.has_value(); });
    if (!ground)
      refuse_it(
          "and nothing has a given potential: another side, an [[electrode]] or a [[group]] must have one without "
          "a resistor, or the circuit a capacitance");
    if (draft.field.accuracy)
      refuse(scene.path, draft.line("field.accuracy"),
             fmt::format("field.accuracy is not allowed with the {} side of the domain in a circuit: give field.cells "
                         "or field.tolerance",
                         side_names[s]));
  }
}

/// Checks tables against the duration of the run, and that the scene has a field.
void check_signals(const Draft& draft) {
  const Scene& scene = draft.scene;
  struct Source {
    std::string key;
    int line;
    Signal signal;
  };
  std::vector<Source> all;
  // Circuits first: their members may have the circuit's potential, and then have no line of their own.
  for (const CircuitDraft& circuit : draft.circuits) {
    const auto line = [&](const char* key) { return draft.circuits.size() == 1 ? draft.line(key) : circuit.line; };
    if (circuit.potential) all.push_back({"circuit.potential", line("circuit.potential"), *circuit.potential});
    if (circuit.current) all.push_back({"circuit.current", line("circuit.current"), *circuit.current});
  }
  const auto add = [&](const std::string& key, const Signal& signal) { all.push_back({key, draft.line(key), signal}); };
  for (const ElectrodeDraft& electrode : draft.electrodes)
    if (electrode.potential) add("electrode.potential", *electrode.potential);
  for (std::size_t s = 0; s < scene.domain.sides.size(); ++s)
    add(fmt::format("domain.{}", side_names[s]), scene.domain.sides[s].potential);
  for (const GroupDraft& group : draft.groups)
    if (group.potential) add("group.potential", *group.potential);
  for (const auto& [key, line, signal] : all) {
    if (!signal.varies()) continue;
    if (!scene.effects.has(&EffectKind::field))
      refuse(scene.path, line,
             key +
                 " is a function of time, which needs the table [effects.floating_conductors]: add it, or give a "
                 "number");
    const Waveform& wave = *signal.waveform;
    constexpr double most = 1e7;
    if (wave.shape != Waveform::Shape::points && wave.frequency * scene.stop.time > most)
      refuse(
          scene.path, line,
          fmt::format("{} has frequency = {:g} Hz, which makes {:.2g} periods up to stop.time = {:g} s: at most {:g} "
                      "are allowed",
                      key, wave.frequency, wave.frequency * scene.stop.time, scene.stop.time, most));
    if (wave.covers_run && (wave.points.front().x > 0 || wave.points.back().x < scene.stop.time))
      refuse(scene.path, line,
             fmt::format("{} has a table from {:g} to {:g} s, which leaves a gap in the run from 0 to stop.time = {:g} "
                         "s: it must cover the run",
                         key, wave.points.front().x, wave.points.back().x, scene.stop.time));
  }
}

}  // namespace

std::vector<std::string> names_of_electrodes(const Draft& draft) {
  std::vector<std::string> names;
  std::map<std::string, int> nameless;
  for (const ElectrodeDraft& written : draft.electrodes)
    names.push_back(written.name ? *written.name : fmt::format("{} {}", written.shape, ++nameless[written.shape]));
  return names;
}

void connect_circuits(Draft& draft) {
  if (!draft.circuits.empty() && !draft.scene.effects.has(&EffectKind::field))
    refuse(draft.scene.path, draft.circuits.front().line,
           "[[circuit]] needs the table [effects.floating_conductors]: add it, or leave the circuit out");
  Members members(draft);
  int nameless = 0;
  std::set<std::string> names;
  for (const CircuitDraft& circuit : draft.circuits) {
    const std::string name = circuit.name ? *circuit.name : fmt::format("circuit {}", ++nameless);
    if (!names.insert(name).second)
      refuse(draft.scene.path, circuit.line, fmt::format("circuit.name = \"{}\" is taken: names must differ", name));
    check_sources(draft, circuit, name);
    const bool direct = circuit.potential && !circuit.resistance;
    members.assign(circuit, name, direct ? -1 : static_cast<int>(draft.scene.circuits.size()));
    if (!direct)
      draft.scene.circuits.push_back({.name = name,
                                      .resistance = circuit.resistance.value_or(0),
                                      .potential = circuit.potential.value_or(0),
                                      .current = circuit.current,
                                      .capacitance = circuit.capacitance.value_or(0),
                                      .charge = circuit.charge.value_or(0)});
  }
  make_single_circuits(draft);
  if (!draft.scene.circuits.empty() && !draft.scene.effects.has(&EffectKind::field))
    refuse(draft.scene.path, std::max(draft.line("electrode.charge"), draft.line("domain")),
           "a charge of an electrode or a side, and a resistor before a side, need the table "
           "[effects.floating_conductors]: add it, or leave the key out");
  check_sides_in_circuits(draft);
  check_signals(draft);
}

std::vector<Signal> varying_signals(const Scene& scene) {
  std::vector<Signal> varying;
  const auto add = [&](const Signal& signal) {
    if (signal.varies()) varying.push_back(signal);
  };
  for (const Electrode& electrode : scene.electrodes) add(electrode.potential);
  for (const DomainSide& side : scene.domain.sides) add(side.potential);
  for (const PrescribedGroup& group : scene.groups)
    if (group.potential) add(*group.potential);
  for (const Circuit& circuit : scene.circuits) {
    add(circuit.potential);
    if (circuit.current) add(*circuit.current);
  }
  return varying;
}

std::string in_words(const Signal& potential) {
  return fmt::format("{:g} V{}", potential.value, potential.varies() ? " at the start, varying in time" : "");
}

bool has_side_in_circuit(const Scene& scene) {
  return std::ranges::any_of(scene.domain.sides, [](const DomainSide& side) { return side.circuit >= 0; });
}

}  // namespace lichtenberg
