#pragma once

#include <span>
#include <vector>

namespace lichtenberg::analysis {

/// Computes the Strahler number of each conductor of the anti-arborescence A, the tree directed to the ground (D 7.5);
/// 0 for conductors outside it. `successor`: result of successors(), indices, `to_ground` or `unconnected`, without
/// cycles.
///
/// A conductor without predecessors (an endpoint) has the number 1. Any other conductor has the largest number among
/// its predecessors, plus one if several of them have this number. The dissertation D defines endpoints by degree 1. In
/// networks with loops, some conductors without predecessors have several contacts and would have no number by that
/// definition.
std::vector<int> strahler_numbers(std::span<const int> successor);

/// Numbers of conductors and streams of a tree by Strahler number (order): element j is for order j, element 0 is 0.
struct StrahlerDistribution {
  std::vector<int> conductors;  ///< sigma_j (D 7.17)
  /// Number of streams: longest chains of conductors of one order, each the successor of the previous one. Horton's law
  /// applies to their number, not to sigma_j.
  std::vector<int> streams;

  int highest() const { return static_cast<int>(conductors.size()) - 1; }
  /// Returns the mean number of conductors in a stream of this order.
  double stream_length(int order) const { return static_cast<double>(conductors[order]) / streams[order]; }
  /// Returns Horton's bifurcation ratio: the number of streams of this order over that of the next order. By Horton's
  /// first law it is about the same for all orders.
  double bifurcation_ratio(int order) const { return static_cast<double>(streams[order]) / streams[order + 1]; }
};

/// Counts the conductors and streams of each Strahler number. `successor`: result of successors(); `strahler`: result
/// of strahler_numbers().
StrahlerDistribution strahler_distribution(std::span<const int> successor, std::span<const int> strahler);

}  // namespace lichtenberg::analysis
