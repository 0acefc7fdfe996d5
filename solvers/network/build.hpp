#pragma once

#include <string>
#include <vector>

#include "solvers/network/electrode.hpp"
#include "solvers/network/network.hpp"
#include "solvers/network/packing.hpp"
#include "solvers/network/parameters.hpp"

namespace lichtenberg::network {

struct ResistorModel;

/// Network of a packing, and the particles of its nodes and links.
struct PackingNetwork {
  Network network;
  std::vector<int> electrode;        ///< Node of each electrode
  std::vector<int> first_particle;   ///< [links] particle that contains the link, or at which it begins
  std::vector<int> second_particle;  ///< [links] particle at which it ends; equal to the first in a contact-centred
                                     ///< network, -1: a wall
};

/// Makes a particle-centred network: one node per particle, one link per contact, from centre to centre or wall. Nodes
/// 0 ... N - 1 are the particles, followed by the walls that are electrodes. Throws InputError if the model has no
/// resistor for it. Also throws the exceptions of check_particles.
PackingNetwork particle_network(const ParticlePacking& packing, const Contacts& contacts, const ResistorModel& model,
                                const Parameters& parameters, const std::vector<PackingElectrode>& electrodes);

/// Returns the reason why the electrodes exclude a contact-centred network: they touch each other, and their contact
/// would have two potentials. Empty if they do not.
std::string contact_network_obstacle(const ParticlePacking& packing, const Contacts& contacts,
                                     const std::vector<PackingElectrode>& electrodes);

/// Makes a contact-centred network: one node per contact, links between all contacts of a particle. Nodes are the
/// contacts between non-electrode particles, in their order, followed by the electrodes, which include their own
/// contacts. Throws InputError with the message of contact_network_obstacle. Also throws the exceptions of
/// check_particles.
PackingNetwork contact_network(const ParticlePacking& packing, const Contacts& contacts, const ResistorModel& model,
                               const Parameters& parameters, const std::vector<PackingElectrode>& electrodes);

}  // namespace lichtenberg::network
