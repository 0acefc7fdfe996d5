#pragma once

#include <string>
#include <vector>

namespace lichtenberg::network {

/// Name of a set: every particle as the second electrode, one by one.
constexpr const char* all_particles = "all";

/// Wall or particle at a fixed potential: one node of the network. Other walls are insulating.
struct PackingElectrode {
  bool wall = false;
  int index = 0;

  friend bool operator==(const PackingElectrode&, const PackingElectrode&) = default;
};

/// Reads two electrodes from a text such as "bottom,top" or "0, top": walls by name, particles by number. Throws
/// InputError unless it names two different electrodes.
std::vector<PackingElectrode> read_electrodes(const std::string& between, const std::vector<std::string>& walls,
                                              int particles);

/// Reads one electrode. Throws InputError if none has this name.
PackingElectrode read_electrode(const std::string& name, const std::vector<std::string>& walls, int particles);

/// Returns true for a valid electrode name: not empty, not a number, not all_particles, without commas and without
/// blanks at its ends.
bool is_electrode_name(const std::string& name);

}  // namespace lichtenberg::network
