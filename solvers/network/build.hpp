#pragma once

#include <string>
#include <vector>

#include "solvers/network/electrode.hpp"
#include "solvers/network/network.hpp"
#include "solvers/network/packing.hpp"
#include "solvers/network/parameters.hpp"

namespace lichtenberg::network {

struct ResistorModel;

/// The network of a packing, and what its nodes and links are.
struct PackingNetwork {
  Network network;
  std::vector<int> electrode;        ///< node of each electrode
  std::vector<int> first_particle;   ///< [links] the particle in which the link runs, or where it begins
  std::vector<int> second_particle;  ///< [links] where it ends; the same in a contact-centred network, -1: a wall
};

/// A node a particle, a link a contact, from centre to centre or wall. Nodes 0 ... N - 1 are the particles, then come
/// the walls that are electrodes.
/// Throws InputError if the model has no resistor for that, or as check_particles does.
PackingNetwork particle_network(const ParticlePacking& packing, const Contacts& contacts, const ResistorModel& model,
                                const Parameters& parameters, const std::vector<PackingElectrode>& electrodes);

/// Why the electrodes can have no contact-centred network: they touch each other, and their contact would have to be at
/// two potentials. Empty if they can.
std::string why_no_contact_network(const ParticlePacking& packing, const Contacts& contacts,
                                   const std::vector<PackingElectrode>& electrodes);

/// A node a contact, links between all contacts of a particle. Nodes are the contacts between particles that are no
/// electrodes, in their order, then the electrodes: contacts with one of those belong to it.
/// Throws InputError with what why_no_contact_network says, and as check_particles does.
PackingNetwork contact_network(const ParticlePacking& packing, const Contacts& contacts, const ResistorModel& model,
                               const Parameters& parameters, const std::vector<PackingElectrode>& electrodes);

}  // namespace lichtenberg::network
