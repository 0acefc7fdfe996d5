#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "solvers/network/build.hpp"
#include "solvers/network/conduction.hpp"
#include "src/record/result_file.hpp"
#include "src/scene/scene.hpp"

namespace lichtenberg {

/// One frame of a result file as input of the resistor network solver: particles, walls and contacts.
struct PackingFrame {
  std::shared_ptr<const ResultFile> file;  ///< file of the frame
  int frame = 0;
  Scene scene;  ///< scene of the run, without its conductors
  network::ParticlePacking packing;
  network::Contacts contacts;
  /// Reasons why the frame may be unreliable (Summary::warnings), such as a packing not at rest
  std::vector<std::string> warnings;
};

/// Reads a frame of a result file as a packing. `frame`: index from 0; default: the last. Walls are those of the file
/// or the sides of its domain, at their positions in that frame. Throws InputError if the file or frame does not exist
/// or is damaged. Throws InputError if the scene is no packing and has a periodic side, or if its particles have no
/// radius.
PackingFrame read_packing(const std::string& path, std::optional<int> frame);

/// State of a packing at a load: one frame of a run with [compression].
struct Load {
  int frame = 0;
  double packing_fraction = 0;
  double pressure = 0;  ///< N/m, in space Pa
};

/// Reads the loads of a result; frame 0, the start, is none. Throws InputError for a result without loads.
std::vector<Load> read_loads(const std::string& path);

/// Solved resistor network of a packing: nodes, links, currents, and the particles that can carry current.
struct SolvedNetwork {
  NetworkModel model = NetworkModel::particle;
  NetworkOptions options;
  bool assumed = false;  ///< no resistor was given: a constant one of 1 Ohm is used
  network::PackingNetwork network;
  network::Conduction conduction;
  std::vector<int> backbone;   ///< particles that can carry current
  std::vector<int> dead_ends;  ///< other particles with a path to an electrode
  std::vector<int> isolated;   ///< particles without a path to an electrode
};

/// Builds the resistor network of a packing between two electrodes (options.between) and solves it at this `voltage`
/// (V). `model`: a node is a particle or a contact. Throws InputError for invalid options and electrodes.
SolvedNetwork solve_network(const PackingFrame& frame, NetworkModel model, const NetworkOptions& options,
                            double voltage);

/// Returns the reason why the electrodes of options.between have no contact-centred network (nodes are contacts); empty
/// if they have one. Throws InputError for invalid electrodes.
std::string contact_network_obstacle(const PackingFrame& frame, const NetworkOptions& options);

/// Effective resistances of a packing from one electrode to each particle.
struct ResistancesToAll {
  NetworkModel model = NetworkModel::particle;
  NetworkOptions options;  ///< `between`: the electrode
  bool assumed = false;    ///< as in SolvedNetwork
  /// Resistance (ohm) to each particle, [N]; 0 to the electrode itself; infinite without a path; NaN to a particle that
  /// touches the electrode in a contact-centred network.
  std::vector<double> resistance;
};

/// Computes the effective resistances from the electrode options.between to each particle by one elimination. A
/// contact-centred network needs one elimination per particle; before each, `count`, if given, is called with the
/// number of finished particles. Throws InputError for invalid options and electrodes, and if a contact-centred network
/// has too many particles.
ResistancesToAll resistances_to_all(const PackingFrame& frame, NetworkModel model, const NetworkOptions& options,
                                    const std::function<void(int)>& count = {});

/// Stores solved networks in the groups /network/MODEL of the result file and replaces earlier ones. Removes an earlier
/// contact-centred network if `no_contact_network`. The file is replaced as a whole. Throws Failure, without changing
/// the file, if it cannot be written or has changed since the frame was read (its run continues).
void save_networks(const std::string& path, const PackingFrame& frame, const std::vector<SolvedNetwork>& networks,
                   bool no_contact_network = false);

}  // namespace lichtenberg
