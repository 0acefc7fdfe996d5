#pragma once

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
};

/// The frame of that index, by default the last. Walls are those of the file or the sides of its domain. Throws
/// InputError if there is no such file or frame, it is damaged, or the scene's particles have no radius.
PackingFrame read_packing(const std::string& path, std::optional<int> frame);

/// One network of a packing, solved.
struct SolvedNetwork {
  NetworkModel model = NetworkModel::particle;
  NetworkOptions options;
  network::PackingNetwork network;
  network::Conduction conduction;
  std::vector<int> backbone;   ///< particles that can carry a current
  std::vector<int> dead_ends;  ///< others with a path to an electrode
  std::vector<int> isolated;   ///< without any
};

/// Throws InputError as network::check and the two builders do.
SolvedNetwork solve_network(const PackingFrame& frame, NetworkModel model, const NetworkOptions& options,
                            double voltage);

/// Puts the networks into the result file, one group /network/MODEL each, over those of an earlier call; the file is
/// replaced as a whole. Throws Failure, and leaves the file alone, if it cannot be written or is no longer the one that
/// the frame was read from (its run goes on).
void save_networks(const std::string& path, const PackingFrame& frame, const std::vector<SolvedNetwork>& networks);

}  // namespace lichtenberg
