#pragma once

#include <span>
#include <vector>

#include "solvers/geometry/vec.hpp"
#include "src/analysis/edge.hpp"

namespace lichtenberg::analysis {

/// The edges of a Delaunay triangulation, in ascending order, each once. They hold a Euclidean minimum spanning tree.
///
/// The triangulation is exact for the points rounded to a square lattice of 2^30 sites across their extent, so that no
/// input is degenerate for it: points on one site are joined to the first of them, points on a line to the next on it,
/// and where four or more lie on a circle some diagonals are left out (none of which is in a minimum spanning tree but
/// as a tie). Rounding can make that tree longer by at most 4e-9 of the extent an edge.
/// Throws InputError if a coordinate is not finite.
std::vector<Edge> delaunay_edges(std::span<const Vec2> point);

/// Kruskal's algorithm (D 7.4.1): of `edge`, those of a spanning forest of the nodes 0 ... nodes - 1 with the least sum
/// of `weight`, in ascending order of weight. Of equal weights the smaller edge comes first.
std::vector<Edge> minimum_spanning_forest(int nodes, std::span<const Edge> edge, std::span<const double> weight);

/// The Euclidean minimum spanning tree of D 7.4.1 (weights 7.15): points - 1 edges.
std::vector<Edge> euclidean_minimum_spanning_tree(std::span<const Vec2> point);

/// number[j]: how many of the nodes have j edges.
std::vector<int> degree_numbers(int nodes, std::span<const Edge> edge);

/// m, of all edges together.
double total_length(std::span<const Vec2> point, std::span<const Edge> edge);

}  // namespace lichtenberg::analysis
