#include "solvers/network/build.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <exception>
#include <map>
#include <mutex>

#include "solvers/error.hpp"
#include "solvers/network/resistor.hpp"
#include "solvers/parallel/ranges.hpp"

namespace lichtenberg::network {
namespace {

/// Index of the electrode of each wall and particle, or -1.
struct ElectrodeOf {
  std::vector<int> wall, particle;

  ElectrodeOf(const ParticlePacking& packing, const std::vector<PackingElectrode>& electrodes)
      : wall(packing.walls.size(), -1), particle(packing.size(), -1) {
    for (std::size_t e = 0; e < electrodes.size(); ++e)
      (electrodes[e].wall ? wall : particle)[electrodes[e].index] = static_cast<int>(e);
  }
};

/// Returns the position of an electrode for the dissection. For a wall it is arbitrary, because electrodes are not
/// eliminated.
Point electrode_position(const ParticlePacking& packing, const PackingElectrode& electrode) {
  return electrode.wall ? packing.walls[electrode.index].point : packing.position[electrode.index];
}

/// Throws InputError if the model needs forces of contacts that are not known.
void check_forces(const ParticlePacking& packing, const ResistorModel& model) {
  if (model.uses_force && !packing.force)
    throw InputError(
        fmt::format("the resistor model \"{}\" needs the forces of contacts, which only packings "
                    "(effects.soft_repulsion) have: \"overlap\" takes the overlaps of other scenes",
                    model.name));
}

/// Contacts of each particle: contact points, their mechanical states and their nodes.
struct Touching {
  std::vector<int> start, node;
  std::vector<Point> point;
  std::vector<ContactState> state;

  explicit Touching(int particles) : start(particles + 1, 0) {}
};

/// Nodes of a contact-centred network, and the contacts of each particle.
class ContactNodes {
 public:
  ContactNodes(const ParticlePacking& packing, const Contacts& contacts,
               const std::vector<PackingElectrode>& electrodes)
      : packing_(packing),
        contacts_(contacts),
        electrodes_(electrodes),
        electrode_of_(packing, electrodes),
        touching(packing.size()) {
    if (const std::string why = contact_network_obstacle(packing, contacts, electrodes); !why.empty())
      throw InputError(why);
    number();
    // One traversal serves twice: to count, then to fill the arrays.
    each([&](int particle, int, const auto&) { ++touching.start[particle + 1]; });
    for (int i = 0; i < packing.size(); ++i) touching.start[i + 1] += touching.start[i];
    touching.node.resize(touching.start.back());
    touching.point.resize(touching.start.back());
    touching.state.resize(touching.start.back());
    std::vector<int> next(touching.start.begin(), touching.start.end() - 1);
    each([&](int particle, int node, const auto& contact) {
      touching.node[next[particle]] = node;
      touching.state[next[particle]] = contact_state(packing, contact);
      touching.point[next[particle]++] = point_at(particle, contact);
    });
  }

 private:
  void number() {
    node_.resize(contacts_.pairs.size(), -1);
    for (std::size_t k = 0; k < contacts_.pairs.size(); ++k) {
      const auto [i, j] = contacts_.pairs[k];
      const int a = electrode_of_.particle[i], b = electrode_of_.particle[j];
      if (a >= 0 || b >= 0) continue;
      node_[k] = static_cast<int>(position.size());
      position.push_back(contact_point(packing_, contacts_.pairs[k]));
    }
    for (const PackingElectrode& electrode : electrodes_) {
      electrode_node.push_back(static_cast<int>(position.size()));
      position.push_back(electrode_position(packing_, electrode));
    }
    for (std::size_t k = 0; k < contacts_.pairs.size(); ++k)
      if (node_[k] < 0)
        node_[k] = electrode_node[std::max(electrode_of_.particle[contacts_.pairs[k].i],
                                           electrode_of_.particle[contacts_.pairs[k].j])];
  }

  Point point_at(int particle, const ParticleContact& contact) const {
    return contact_point(packing_, contact, particle);
  }
  Point point_at(int, const ParticleWallContact& contact) const { return contact_point(packing_, contact); }

  /// Visits every particle that is not an electrode, with each of its nodes and the contact there.
  template <class Visit>
  void each(const Visit& visit) const {
    for (std::size_t k = 0; k < contacts_.pairs.size(); ++k)
      for (const int particle : {contacts_.pairs[k].i, contacts_.pairs[k].j})
        if (electrode_of_.particle[particle] < 0) visit(particle, node_[k], contacts_.pairs[k]);
    for (const ParticleWallContact& c : contacts_.walls) {
      const int wall = electrode_of_.wall[c.wall];
      if (wall >= 0) visit(c.particle, electrode_node[wall], c);
    }
  }

  const ParticlePacking& packing_;
  const Contacts& contacts_;
  const std::vector<PackingElectrode>& electrodes_;
  ElectrodeOf electrode_of_;
  std::vector<int> node_;  // Node of each pair

 public:
  Touching touching;
  std::vector<Point> position;
  std::vector<int> electrode_node;
};

Path path_between(const ParticlePacking& packing, const ParticleContact& c) {
  const double d = distance(packing, c), ri = packing.radius[c.i], rj = packing.radius[c.j];
  return {.length = {d * ri / (ri + rj), d * rj / (ri + rj)},
          .resistivity = {packing.resistivity_of(c.i), packing.resistivity_of(c.j)},
          .contact = contact_state(packing, c, d)};
}

Path path_to_wall(const ParticlePacking& packing, const ParticleWallContact& c) {
  return {.length = {distance(packing.position[c.particle], contact_point(packing, c)), 0},
          .resistivity = {packing.resistivity_of(c.particle), 0},
          .wall = true,
          .contact = contact_state(packing, c)};
}

/// Calls act(k) for k = 0 ... count - 1 on threads, and then throws the first exception of the first range with one.
template <class Act>
void for_each_checked(std::size_t count, parallel::Team& team, const Act& act) {
  std::map<std::size_t, std::exception_ptr> errors;
  std::mutex mutex;
  parallel::for_each_range(count, team, [&](std::size_t begin, std::size_t end) {
    try {
      for (std::size_t k = begin; k < end; ++k) act(k);
    } catch (...) {
      const std::lock_guard lock(mutex);
      errors[begin] = std::current_exception();
    }
  });
  if (!errors.empty()) std::rethrow_exception(errors.begin()->second);
}

}  // namespace

PackingNetwork particle_network(const ParticlePacking& packing, const Contacts& contacts, const ResistorModel& model,
                                const Parameters& parameters, const std::vector<PackingElectrode>& electrodes,
                                parallel::Team& team) {
  if (model.path == nullptr)
    throw InputError(
        fmt::format("the resistor model \"{}\" is one of contacts on a particle: a contact-centred network "
                    "has them, a particle-centred one does not",
                    model.name));
  check_particles(model, parameters, packing.radius, dimension(packing));
  check_forces(packing, model);
  PackingNetwork result;
  Network& network = result.network;
  network.position = packing.position;
  for (const PackingElectrode& electrode : electrodes) {
    result.electrode.push_back(electrode.wall ? static_cast<int>(network.position.size()) : electrode.index);
    if (electrode.wall) network.position.push_back(electrode_position(packing, electrode));
  }
  network.nodes = static_cast<int>(network.position.size());
  const ElectrodeOf electrode_of(packing, electrodes);
  std::vector<ParticleWallContact> terminals;
  for (const ParticleWallContact& c : contacts.walls)
    if (electrode_of.wall[c.wall] >= 0) terminals.push_back(c);
  const std::size_t pairs = contacts.pairs.size(), all = pairs + terminals.size();
  network.links.resize(all);
  result.first_particle.resize(all);
  result.second_particle.resize(all);
  for_each_checked(all, team, [&](std::size_t k) {
    if (k < pairs) {
      const auto [i, j] = contacts.pairs[k];
      network.links[k] = {i, j, 1 / model.path(parameters, path_between(packing, contacts.pairs[k]))};
      result.first_particle[k] = i, result.second_particle[k] = j;
    } else {
      const auto [i, wall] = terminals[k - pairs];
      network.links[k] = {i, result.electrode[electrode_of.wall[wall]],
                          1 / model.path(parameters, path_to_wall(packing, terminals[k - pairs]))};
      result.first_particle[k] = i, result.second_particle[k] = -1;
    }
  });
  return result;
}

std::string contact_network_obstacle(const ParticlePacking& packing, const Contacts& contacts,
                                     const std::vector<PackingElectrode>& electrodes) {
  const ElectrodeOf electrode_of(packing, electrodes);
  const auto touch = [](const std::string& which) {
    return fmt::format(
        "the electrodes, {}, touch: in a contact-centred network their contact would have to be at both potentials",
        which);
  };
  for (const auto [i, j] : contacts.pairs)
    if (electrode_of.particle[i] >= 0 && electrode_of.particle[j] >= 0)
      return touch(fmt::format("particles {} and {}", i, j));
  for (const ParticleWallContact& c : contacts.walls)
    if (electrode_of.particle[c.particle] >= 0 && electrode_of.wall[c.wall] >= 0)
      return touch(fmt::format("particle {} and wall {}", c.particle, packing.walls[c.wall].name));
  return "";
}

PackingNetwork contact_network(const ParticlePacking& packing, const Contacts& contacts, const ResistorModel& model,
                               const Parameters& parameters, const std::vector<PackingElectrode>& electrodes) {
  check_particles(model, parameters, packing.radius, dimension(packing));
  check_forces(packing, model);
  ContactNodes nodes(packing, contacts, electrodes);
  const Touching& touching = nodes.touching;
  PackingNetwork result;
  Network& network = result.network;
  network.nodes = static_cast<int>(nodes.position.size());
  Particle particle;
  for (int p = 0; p < packing.size(); ++p) {
    const int first = touching.start[p], n = touching.start[p + 1] - first;
    if (n < 2) continue;  // A dead end carries no current
    particle.centre = packing.position[p];
    particle.radius = packing.radius[p];
    particle.resistivity = packing.resistivity_of(p);
    particle.index = p;
    particle.contacts.assign(touching.point.begin() + first, touching.point.begin() + first + n);
    particle.states.assign(touching.state.begin() + first, touching.state.begin() + first + n);
    const Eigen::MatrixXd links = model.particle(parameters, particle);
    for (int j = 0; j < n; ++j)
      for (int i = 0; i < j; ++i)
        if (touching.node[first + i] != touching.node[first + j]) {
          network.links.push_back({touching.node[first + i], touching.node[first + j], links(i, j)});
          result.first_particle.push_back(p);
        }
  }
  result.second_particle = result.first_particle;
  result.electrode = nodes.electrode_node;
  network.position = std::move(nodes.position);
  return result;
}

}  // namespace lichtenberg::network
