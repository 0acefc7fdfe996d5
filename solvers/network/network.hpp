#pragma once

#include <array>
#include <span>
#include <vector>

namespace lichtenberg::network {

/// Position in space (m); in the plane the third coordinate is 0.
using Point = std::array<double, 3>;
/// Returns the distance (m) between two points.
double distance(const Point& a, const Point& b);

/// Resistor of a network, between nodes a and b.
struct Link {
  int a = 0, b = 0;
  double conductance = 0;  ///< Conductance (S)
};

/// Resistor network: nodes 0 ... nodes - 1, and links (resistors) between them. The conductances of parallel links add
/// up; a link from a node to itself has no effect.
struct Network {
  int nodes = 0;
  std::vector<Link> links;
  /// Positions of the nodes (m), [nodes] or empty. They affect only the order of elimination, and thus the speed.
  std::vector<Point> position;
};

/// Checks the links of a network. Throws InputError if a link refers to a missing node, or if its conductance or
/// resistance is not a positive, normal number in double precision.
void check(const Network& network);

/// Incidence lists of a network: node n has the links link[start[n]] ... link[start[n + 1] - 1], as indices into
/// Network::links. Links from a node to itself are excluded.
struct Incidence {
  std::vector<int> start, link;

  explicit Incidence(const Network& network);
  /// Returns the links at a node, as indices into Network::links.
  std::span<const int> of(int node) const {
    return {link.data() + start[node], static_cast<std::size_t>(start[node + 1] - start[node])};
  }
};

/// Returns the end of a link other than the given node.
inline int other_end(const Link& link, int node) { return link.a == node ? link.b : link.a; }

}  // namespace lichtenberg::network
