#pragma once

#include <string>
#include <vector>

namespace lichtenberg::network {

/// Name that selects all particles as second electrodes, one per case: the program computes one case for each particle.
constexpr const char* all_particles = "all";

/// Electrode of a packing: a wall or particle at a fixed potential, one node of the network. Walls that are not
/// electrodes insulate.
struct PackingElectrode {
  bool wall = false;  ///< True for a wall, false for a particle
  int index = 0;      ///< Index of the wall or particle

  friend bool operator==(const PackingElectrode&, const PackingElectrode&) = default;
};

/// Parses two electrodes from the text `between`, such as "bottom,top" or "0, top": walls by name, particles by number.
/// `walls`: names of the walls; `particles`: number of particles. Throws InputError unless the text names two different
/// electrodes.
std::vector<PackingElectrode> read_electrodes(const std::string& between, const std::vector<std::string>& walls,
                                              int particles);

/// Parses one electrode: the name of a wall or the number of a particle, from 0 to `particles` - 1. Throws InputError
/// if there is no such wall or particle.
PackingElectrode read_electrode(const std::string& name, const std::vector<std::string>& walls, int particles);

/// Checks the name of a wall that can be an electrode. Returns true if it is not empty, not an integer, not "all", and
/// has no commas and no blanks at its ends.
bool is_electrode_name(const std::string& name);

}  // namespace lichtenberg::network
