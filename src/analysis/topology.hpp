#pragma once

#include <optional>
#include <span>
#include <vector>

#include "src/analysis/fractal.hpp"
#include "src/analysis/network.hpp"
#include "src/analysis/spanning_tree.hpp"
#include "src/analysis/strahler.hpp"

namespace lichtenberg::analysis {

/// Statistics of a sample: quartiles, mean and standard deviation. All values are zero if it is empty.
struct Distribution {
  int count = 0;
  double least = 0, quarter = 0, median = 0, three_quarters = 0, largest = 0;
  double mean = 0, deviation = 0;  ///< standard deviation of the sample, with count - 1; 0 for one value
};

/// Computes the quartiles, mean and standard deviation of a sample. Quartiles are interpolated linearly between the
/// sorted values.
Distribution distribution(std::vector<double> sample);

/// Euclidean minimum spanning tree of the conductors' centres (D 7.4.1): N nodes, N - 1 edges, no ground.
struct SpanningTree {
  std::vector<Edge> edges;
  std::vector<int> number;  ///< number[j]: conductors with j edges
  /// Strahler numbers with the conductor nearest to the ground as root.
  StrahlerDistribution strahler;
  double length = 0;  ///< m
  int shared = 0;     ///< number of edges that also connect a conductor with its successor in A
};

/// Projects positions onto the xy plane.
std::vector<Vec2> xy_projection(std::span<const Vec3> position);

/// Computes the Euclidean minimum spanning tree of the centres of conductors in the plane: its degrees, length and
/// Strahler numbers. Also counts the edges between a conductor and its successor. `successor`: result of successors().
SpanningTree spanning_tree(std::span<const Vec2> position, std::span<const double> radius,
                           std::span<const int> successor, const Ground& ground);

/// Topology of a configuration of conductors: the quantities of chapter 7 of the dissertation D, and fractal
/// dimensions. Lengths in m. A is the tree of conductors and their successors on the path to ground.
struct Topology {
  ContactNetwork network;
  DegreeRelations relations;
  std::vector<int> strahler;       ///< by conductor, see strahler_numbers()
  StrahlerDistribution orders;     ///< Strahler numbers of A
  Distribution edge_length;        ///< centre-to-centre length of the edges of A between conductors
  double tree_length = 0;          ///< total length of these edges
  std::optional<PowerLaw> boxes;   ///< box-counting dimension of A, drawn from centre to centre
  std::optional<PowerLaw> masses;  ///< mass-radius dimension of the conductors in A
  SpanningTree minimum;            ///< spanning tree of all N conductors
};

/// Computes the topology of a contact network of disks. Fractal dimensions of the tree A of successors are fitted from
/// twice its mean edge length, below which a tree is a line. The upper limit is half (boxes) or a quarter (masses) of
/// the larger extent of A. A dimension is empty if its limits differ by less than a factor of two.
Topology topology(ContactNetwork network, std::span<const Vec2> position, std::span<const double> radius,
                  const Ground& ground);

}  // namespace lichtenberg::analysis
