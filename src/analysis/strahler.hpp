#pragma once

#include <span>
#include <vector>

namespace lichtenberg::analysis {

/// Computes the Strahler number of each conductor of the anti-arborescence A, the tree directed to the ground (D 7.5);
/// 0 for conductors outside it. `successor`: result of successors(), indices, `to_ground` or `unconnected`, without
/// cycles.
///
/// An endpoint has the number 1. Any other conductor has the largest number among its predecessors, plus one if several
/// of them have it. The dissertation D defines endpoints by degree 1. With loops, a conductor without predecessors may
/// have several contacts, and by that rule neither it nor its successors would have a number. Here it has the number 1.
std::vector<int> strahler_numbers(std::span<const int> successor);

/// Distribution of Strahler numbers over a tree, and its streams. Index j is order j; index 0 is empty.
struct StrahlerDistribution {
  std::vector<int> conductors;  ///< sigma_j (D 7.17)
  /// Number of streams: longest chains of conductors of one order, each the successor of the previous one. Horton's law
  /// applies to their number, not to sigma_j.
  std::vector<int> streams;

  int highest() const { return static_cast<int>(conductors.size()) - 1; }
  /// Returns the mean number of conductors in a stream of order j.
  double stream_length(int order) const { return static_cast<double>(conductors[order]) / streams[order]; }
  /// Returns Horton's bifurcation ratio, of the numbers of streams of orders j and j + 1. By Horton's first law it is
  /// the same for all j.
  double bifurcation_ratio(int order) const { return static_cast<double>(streams[order]) / streams[order + 1]; }
};

/// Counts the conductors and streams of each Strahler number. `successor`, `strahler`: see strahler_numbers().
StrahlerDistribution strahler_distribution(std::span<const int> successor, std::span<const int> strahler);

}  // namespace lichtenberg::analysis
