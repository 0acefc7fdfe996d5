#pragma once

#include <optional>
#include <span>
#include <vector>

#include "src/analysis/fractal.hpp"
#include "src/analysis/network.hpp"
#include "src/analysis/spanning_tree.hpp"
#include "src/analysis/strahler.hpp"

namespace lichtenberg::analysis {

/// Distribution of a sample; all values are zero if it is empty.
struct Distribution {
  int count = 0;
  double least = 0, quarter = 0, median = 0, three_quarters = 0, largest = 0;
  double mean = 0, deviation = 0;  ///< standard deviation of the sample, with count - 1; 0 for one value
};

/// Returns the distribution; quantiles are interpolated linearly between the sorted values.
Distribution distribution(std::vector<double> sample);

/// Euclidean minimum spanning tree of the conductors' centres (D 7.4.1): N nodes, N - 1 edges, no ground.
struct SpanningTree {
  std::vector<Edge> edges;
  std::vector<int> number;  ///< number[j]: conductors with j edges
  /// Orders with the conductor nearest to the ground as root.
  StrahlerDistribution strahler;
  double length = 0;  ///< m
  int shared = 0;     ///< number of edges that also connect a conductor with its successor in A
};

/// Returns x and y of each position.
std::vector<Vec2> xy_projection(std::span<const Vec3> position);

SpanningTree spanning_tree(std::span<const Vec2> position, std::span<const double> radius,
                           std::span<const int> successor, const Ground& ground);

/// All quantities of D chapter 7 for a configuration, and more. Lengths in m.
struct Topology {
  ContactNetwork network;
  DegreeRelations relations;
  std::vector<int> strahler;       ///< by conductor, see strahler_numbers()
  StrahlerDistribution orders;     ///< orders of A
  Distribution edge_length;        ///< centre-to-centre length of the edges of A between conductors
  double tree_length = 0;          ///< total length of these edges
  std::optional<PowerLaw> boxes;   ///< box-counting dimension of A, drawn from centre to centre
  std::optional<PowerLaw> masses;  ///< mass-radius dimension of the conductors in A
  SpanningTree minimum;            ///< spanning tree of all N conductors
};

/// Computes the topology. Dimensions are fitted from twice the mean edge of A, below which a tree is a line. The upper
/// limit is half (boxes) or a quarter (masses) of its larger extent. They are empty if these limits differ by less than
/// a factor of two.
Topology topology(ContactNetwork network, std::span<const Vec2> position, std::span<const double> radius,
                  const Ground& ground);

}  // namespace lichtenberg::analysis
