// Tests of the multigrid of resistor networks, and of the choice between it and elimination.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "solvers/network/conduction.hpp"

namespace network_multigrid_test {

using namespace lichtenberg::network;
using doctest::Approx;

namespace {

/// Cubic lattice of side^3 nodes between two electrodes with conductances from 1 to 5.
Network cubic_lattice(int side, bool positions) {
  const int bulk = side * side * side;
  Network net{.nodes = bulk + 2};
  const auto node = [&](int x, int y, int z) { return (z * side + y) * side + x; };
  for (int z = 0; z < side; ++z)
    for (int y = 0; y < side; ++y)
      for (int x = 0; x < side; ++x) {
        const double g = 1 + (x + 2 * y + 3 * z) % 5;
        if (x > 0) net.links.push_back({node(x - 1, y, z), node(x, y, z), g});
        if (y > 0) net.links.push_back({node(x, y - 1, z), node(x, y, z), g});
        net.links.push_back({z > 0 ? node(x, y, z - 1) : bulk, node(x, y, z), g});
        if (z + 1 == side) net.links.push_back({node(x, y, z), bulk + 1, g});
        if (positions) net.position.push_back({double(x), double(y), double(z)});
      }
  if (positions) net.position.insert(net.position.end(), {{0, 0, -1}, {0, 0, double(side)}});
  return net;
}

}  // namespace

TEST_CASE("network multigrid: resistance and potentials equal elimination's") {
  const Network net = cubic_lattice(16, true);
  const int low = net.nodes - 2, high = net.nodes - 1;
  const Conduction direct = conduct(net, low, high, {.method = Method::elimination, .voltage = 3});
  const Conduction iterated = conduct(net, low, high, {.method = Method::multigrid, .voltage = 3});
  CHECK(iterated.method == Method::multigrid);
  CHECK(iterated.iterations < 30);
  CHECK(iterated.resistance == Approx(direct.resistance).epsilon(1e-10));
  CHECK(iterated.power_balance < 1e-10);
  double largest = 0;
  for (int n = 0; n < net.nodes; ++n)
    largest = std::max(largest, std::abs(iterated.potential[n] - direct.potential[n]));
  CHECK(largest < 1e-8);
}

TEST_CASE("network multigrid: elimination takes over if it does not converge") {
  // A ladder whose links have random conductances over twelve decades: nearly a chain for currents.
  constexpr int rungs = 1000;
  std::mt19937_64 random(1);
  const auto conductance = [&] { return std::pow(10, -6 + 12 * (static_cast<double>(random() >> 11) * 0x1p-53)); };
  Network ladder{.nodes = 2 * rungs};
  for (int n = 2; n < ladder.nodes; ++n) ladder.links.push_back({n - 2, n, conductance()});
  for (int n = 0; n < ladder.nodes; n += 2) ladder.links.push_back({n, n + 1, conductance()});
  const Conduction direct = conduct(ladder, 0, ladder.nodes - 1, {.method = Method::elimination});
  const Conduction found = conduct(ladder, 0, ladder.nodes - 1, {.method = Method::multigrid});
  CHECK(found.method == Method::elimination);
  CHECK(found.iterations == 200);
  CHECK(found.current == direct.current);
  CHECK(found.link_current == direct.link_current);
  CHECK(found.potential == direct.potential);
}

TEST_CASE("network method: multigrid if memory is short and conductances similar") {
  Network net = cubic_lattice(6, true);
  CHECK(conduct(net, 216, 217).method == Method::elimination);
  CHECK(conduct(net, 216, 217, {.memory = 1e3}).method == Method::multigrid);
  net.links[5].conductance = 1e8;
  CHECK(conduct(net, 216, 217, {.memory = 1e3}).method == Method::elimination);
}

}  // namespace network_multigrid_test
