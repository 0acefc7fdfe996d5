#pragma once

#include <string>
#include <vector>

namespace lichtenberg::network {

/// In place of a second electrode: each of the particles, one after the other.
constexpr const char* all_particles = "all";

/// A wall or a particle that is held at a potential; it is one node of the network. Other walls insulate.
struct PackingElectrode {
  bool wall = false;
  int index = 0;

  friend bool operator==(const PackingElectrode&, const PackingElectrode&) = default;
};

/// The two electrodes of a text such as "bottom,top" or "0, top": walls by name, particles by number. Throws InputError
/// unless it names two of them, different ones.
std::vector<PackingElectrode> read_electrodes(const std::string& between, const std::vector<std::string>& walls,
                                              int particles);

/// One electrode of such a text. Throws InputError unless there is one of that name.
PackingElectrode read_electrode(const std::string& name, const std::vector<std::string>& walls, int particles);

/// Whether an electrode can be called so: not empty, no number, not all_particles, no comma in it and no blank at its
/// ends.
bool is_electrode_name(const std::string& name);

}  // namespace lichtenberg::network
