#pragma once

#include <string>
#include <vector>

#include "src/scene/draft.hpp"

namespace lichtenberg {

/// Returns the names of the file's [[electrode]]s, by default the shape and a number.
std::vector<std::string> names_of_electrodes(const Draft& draft);

/// Makes the circuits of a scene: those of the file's [[circuit]]s, those of electrodes with a charge, and those of
/// sides with a charge or a series resistance. Assigns electrodes, sides and groups to them. A circuit whose voltage
/// source is connected directly only gives its potential to its members. Throws InputError for a name that is unknown,
/// ambiguous or listed twice, and for a member with a potential or a charge of its own. Throws InputError for an
/// electrode with neither or both of potential and charge, and for sources that cannot be combined. Throws InputError
/// for circuits and functions of time in a scene without a field, and for a table that does not cover the run.
void connect_circuits(Draft& draft);

/// Returns the functions of time among the potentials and currents of a scene's sources.
std::vector<Signal> varying_signals(const Scene& scene);

/// Describes the potential of a source.
std::string in_words(const Signal& potential);

/// Returns true if the scene has a side of the domain in a circuit.
bool has_side_in_circuit(const Scene& scene);

}  // namespace lichtenberg
