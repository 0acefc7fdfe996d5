#include "solvers/network/network.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "solvers/error.hpp"

namespace lichtenberg::network {

double distance(const Point& a, const Point& b) {
  return std::sqrt((a[0] - b[0]) * (a[0] - b[0]) + (a[1] - b[1]) * (a[1] - b[1]) + (a[2] - b[2]) * (a[2] - b[2]));
}

void check(const Network& network) {
  for (std::size_t k = 0; k < network.links.size(); ++k) {
    const Link& link = network.links[k];
    if (std::min(link.a, link.b) < 0 || std::max(link.a, link.b) >= network.nodes)
      throw InputError(fmt::format("link {} joins nodes {} and {}, but the network has nodes 0 to {}", k, link.a,
                                   link.b, network.nodes - 1));
    if (!(link.conductance > 0) || !std::isnormal(link.conductance) || !std::isnormal(1 / link.conductance))
      throw InputError(
          fmt::format("the link between nodes {} and {} has conductance {} S: a positive, finite one is "
                      "needed",
                      link.a, link.b, link.conductance));
  }
}

Incidence::Incidence(const Network& network) : start(network.nodes + 1, 0) {
  for (const Link& l : network.links)
    if (l.a != l.b) ++start[l.a], ++start[l.b];
  int sum = 0;
  for (int& s : start) sum += s, s = sum;  // Ends of the ranges; the filling counts them down to the starts
  link.resize(sum);
  for (int k = static_cast<int>(network.links.size()) - 1; k >= 0; --k) {
    const Link& l = network.links[k];
    if (l.a == l.b) continue;
    link[--start[l.a]] = k;
    link[--start[l.b]] = k;
  }
}

}  // namespace lichtenberg::network
