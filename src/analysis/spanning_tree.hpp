#pragma once

#include <span>
#include <vector>

#include "solvers/geometry/vec.hpp"
#include "src/analysis/edge.hpp"

namespace lichtenberg::analysis {

/// Computes the edges of a Delaunay triangulation of points in the plane, in ascending order, each once. Except for
/// rounding, they contain a Euclidean minimum spanning tree.
///
/// Points are rounded to a square lattice of 2^30 sites across their extent, for which the triangulation is exact. Of
/// several points on one site, the first is joined to each of the others. If all points are on a line, neighbours are
/// joined. Where four or more points are on a circle, some diagonals are missing; a minimum spanning tree of the same
/// length exists without them. Rounding can make each edge of the minimum spanning tree longer by at most 4e-9 of the
/// extent. Throws InputError if a coordinate is not finite.
std::vector<Edge> delaunay_edges(std::span<const Vec2> point);

/// Computes a minimum spanning forest of the graph of the nodes 0 ... nodes - 1 and the edges `edge`, by Kruskal's
/// algorithm (D 7.4.1). It is a tree with the smallest sum of `weight` for each connected component. Returns its edges
/// in ascending order of weight; of equal weights, edges in ascending order of node numbers.
std::vector<Edge> minimum_spanning_forest(int nodes, std::span<const Edge> edge, std::span<const double> weight);

/// Computes the edges of a Euclidean minimum spanning tree of points in the plane (D 7.4.1, weights 7.15), with the
/// rounding of delaunay_edges(). Throws InputError if a coordinate is not finite.
std::vector<Edge> euclidean_minimum_spanning_tree(std::span<const Vec2> point);

/// Computes the degree distribution of a graph: number[j] is the number of nodes with j edges.
std::vector<int> degree_numbers(int nodes, std::span<const Edge> edge);

/// Computes the total length (m) of all edges between these points (m).
double total_length(std::span<const Vec2> point, std::span<const Edge> edge);

}  // namespace lichtenberg::analysis
