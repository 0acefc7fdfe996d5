#pragma once

#include <array>
#include <span>
#include <vector>

namespace lichtenberg::network {

/// Position in space (m); in the plane the third coordinate is 0.
using Point = std::array<double, 3>;
double distance(const Point& a, const Point& b);

/// Resistor between nodes a and b.
struct Link {
  int a = 0, b = 0;
  double conductance = 0;  ///< Conductance (S)
};

/// Nodes and the resistors between them. Parallel links add up; a link from a node to itself has no effect.
struct Network {
  int nodes = 0;
  std::vector<Link> links;
  /// Positions of the nodes, [nodes] or empty. They affect only the speed.
  std::vector<Point> position;
};

/// Throws InputError if a link refers to a missing node or its conductance is not positive and finite.
void check(const Network& network);

/// Links at each node: link[start[n]] ... link[start[n + 1] - 1], as indices into Network::links. Links from a node to
/// itself are excluded.
struct Incidence {
  std::vector<int> start, link;

  explicit Incidence(const Network& network);
  std::span<const int> of(int node) const {
    return {link.data() + start[node], static_cast<std::size_t>(start[node + 1] - start[node])};
  }
};

inline int other_end(const Link& link, int node) { return link.a == node ? link.b : link.a; }

}  // namespace lichtenberg::network
