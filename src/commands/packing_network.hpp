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

/// A frame of a result file, as the network room sees it.
struct PackingFrame {
  std::shared_ptr<const ResultFile> file;  ///< it was read from
  int frame = 0;
  Scene scene;  ///< as the run had it
  network::ParticlePacking packing;
  network::Contacts contacts;
  std::vector<std::string> warnings;  ///< why it may be unsafe to use (Summary::warnings): a packing not at rest, say
};

/// The frame of that index, by default the last. Walls are those of the file or the sides of its domain. Throws
/// InputError if there is no such file or frame, it is damaged, or the scene's particles have no radius.
PackingFrame read_packing(const std::string& path, std::optional<int> frame);

/// One network of a packing, solved.
struct SolvedNetwork {
  NetworkModel model = NetworkModel::particle;
  NetworkOptions options;
  bool assumed = false;  ///< nobody named a resistor: it is the constant one of 1 Ohm
  network::PackingNetwork network;
  network::Conduction conduction;
  std::vector<int> backbone;   ///< particles that can carry a current
  std::vector<int> dead_ends;  ///< others with a path to an electrode
  std::vector<int> isolated;   ///< without any
};

/// Throws InputError as network::check and the two builders do.
SolvedNetwork solve_network(const PackingFrame& frame, NetworkModel model, const NetworkOptions& options,
                            double voltage);

/// Why options.between has no contact-centred network, or an empty text. Throws InputError as solve_network does.
std::string why_no_contact_network(const PackingFrame& frame, const NetworkOptions& options);

/// Effective resistances from one electrode to each particle.
struct ResistancesToAll {
  NetworkModel model = NetworkModel::particle;
  NetworkOptions options;  ///< `between`: the electrode
  bool assumed = false;    ///< as in SolvedNetwork
  /// [particles] Ohm; 0 to itself, infinite without a path, NaN to a particle that has none because it touches the
  /// electrode of a contact-centred network.
  std::vector<double> resistance;
};

/// By one elimination, of a contact-centred network by one for each particle; `count`, if any, is told how many are
/// done. options.between: the electrode's name. Throws InputError as solve_network does, and for more particles than a
/// contact-centred network may have here.
ResistancesToAll resistances_to_all(const PackingFrame& frame, NetworkModel model, const NetworkOptions& options,
                                    const std::function<void(int)>& count = {});

/// Puts the networks into the result file, one group /network/MODEL each, over those of an earlier call, and removes
/// the contact-centred one of an earlier call if `no_contact_network`; the file is replaced as a whole. Throws Failure,
/// and leaves the file alone, if it cannot be written or is no longer the one that the frame was read from (its run
/// goes on).
void save_networks(const std::string& path, const PackingFrame& frame, const std::vector<SolvedNetwork>& networks,
                   bool no_contact_network = false);

}  // namespace lichtenberg
