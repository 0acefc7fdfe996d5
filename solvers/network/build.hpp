#pragma once

#include <string>
#include <vector>

#include "solvers/network/electrode.hpp"
#include "solvers/network/network.hpp"
#include "solvers/network/packing.hpp"
#include "solvers/network/parameters.hpp"

namespace lichtenberg::network {

struct ResistorModel;

/// Resistor network of a packing of particles, with the nodes of its electrodes and the particles of its links.
struct PackingNetwork {
  Network network;
  std::vector<int> electrode;       ///< Node of each electrode
  std::vector<int> first_particle;  ///< For each link, the particle that contains it or at which it begins
  /// For each link, the particle at which it ends; -1: a wall. Equal to first_particle in a contact-centred network.
  std::vector<int> second_particle;
};

/// Makes the particle-centred resistor network of a packing: each particle is a node, each contact a link from centre
/// to centre, or from centre to wall. Nodes 0 ... N - 1 are the particles, followed by the walls that are electrodes.
/// Contacts with walls that are not electrodes are omitted.
/// `model` and `parameters` give the resistances. Throws InputError if the model supports contact-centred networks
/// only, and the exceptions of check_particles. The threads of `team` do not affect the result.
PackingNetwork particle_network(const ParticlePacking& packing, const Contacts& contacts, const ResistorModel& model,
                                const Parameters& parameters, const std::vector<PackingElectrode>& electrodes,
                                parallel::Team& team = parallel::Team::single());

/// Checks whether a contact-centred network is possible with these electrodes. Returns an error message if two
/// electrodes touch, because their contact would have two potentials; otherwise an empty text.
std::string contact_network_obstacle(const ParticlePacking& packing, const Contacts& contacts,
                                     const std::vector<PackingElectrode>& electrodes);

/// Makes the contact-centred resistor network of a packing: contacts are nodes, and links join the contacts of each
/// particle in pairs. The first nodes are the contacts between two particles that are not electrodes, in the order of
/// `contacts`. The electrodes follow; an electrode and its contacts are one node. Contacts with walls that are not
/// electrodes are omitted.
/// `model` and `parameters` give the conductances. Throws InputError with the message of contact_network_obstacle, or
/// if contacts are too wide for the model, and the exceptions of check_particles.
PackingNetwork contact_network(const ParticlePacking& packing, const Contacts& contacts, const ResistorModel& model,
                               const Parameters& parameters, const std::vector<PackingElectrode>& electrodes);

}  // namespace lichtenberg::network
