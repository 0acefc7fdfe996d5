#pragma once

#include <span>
#include <vector>

namespace lichtenberg::analysis {

/// Strahler number of each conductor of the anti-arborescence A (D 7.5), 0 for those that are not in it. `successor` as
/// successors() returns it: indices, `to_ground` or `unconnected`; no cycles.
///
/// An endpoint has 1; any other conductor has the largest number among those whose successor it is, plus one if more
/// than one of them has it. D calls endpoints those of degree 1; with loops a conductor may be nobody's successor and
/// still touch several others, and D's rule would leave it and all behind it without a number: here it has 1.
std::vector<int> strahler_numbers(std::span<const int> successor);

/// What Strahler numbers say of a tree as a whole. Index j is order j; index 0 is empty.
struct StrahlerDistribution {
  std::vector<int> conductors;  ///< sigma_j (D 7.17)
  /// Streams: longest chains of conductors of one order, each the successor of the one before. Horton's law is about
  /// their number, not about sigma_j.
  std::vector<int> streams;

  int highest() const { return static_cast<int>(conductors.size()) - 1; }
  /// Conductors a stream of order j has on average.
  double stream_length(int order) const { return static_cast<double>(conductors[order]) / streams[order]; }
  /// Streams of order j for one of order j + 1; Horton's first law says that it is the same for all j.
  double bifurcation_ratio(int order) const { return static_cast<double>(streams[order]) / streams[order + 1]; }
};

StrahlerDistribution strahler_distribution(std::span<const int> successor, std::span<const int> strahler);

}  // namespace lichtenberg::analysis
