#include <doctest/doctest.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <random>
#include <utility>

#include "solvers/error.hpp"
#include "solvers/network/build.hpp"
#include "solvers/network/components.hpp"
#include "solvers/network/condense.hpp"
#include "solvers/network/conduction.hpp"
#include "solvers/network/elimination.hpp"
#include "solvers/network/resistor.hpp"
#include "tests/conductance_matrix.hpp"
#include "tests/dense_algebra.hpp"
#include "tests/message.hpp"

namespace network_test {

using namespace lichtenberg;
using namespace lichtenberg::network;
using doctest::Approx;

namespace {

/// particle_network as an object, with its default arguments.
constexpr auto by_particles = [](const auto&... given) { return particle_network(given...); };

double resistance(const Network& network, int low, int high) { return conduct(network, low, high).resistance; }

/// Rounding of sums of a few hundred terms.
Approx exactly(double value) { return Approx(value).epsilon(1e-13); }

Network bridge(double r1, double r2, double r3, double r4, double r5) {
  return {.nodes = 4, .links = {{0, 1, 1 / r1}, {0, 2, 1 / r2}, {1, 2, 1 / r3}, {1, 3, 1 / r4}, {2, 3, 1 / r5}}};
}

}  // namespace

TEST_CASE("resistors: series resistances add, parallel conductances add") {
  CHECK(resistance({.nodes = 3, .links = {{0, 1, 0.5}, {1, 2, 0.25}}}, 0, 2) == exactly(6));
  CHECK(resistance({.nodes = 2, .links = {{0, 1, 0.5}, {1, 0, 0.25}}}, 0, 1) == exactly(1 / 0.75));
}

TEST_CASE("Wheatstone bridge of 1 to 5 Ohm: the resistance is 61/21 Ohm") {
  // Loop equations: 1 and 2 Ohm from the source, 3 Ohm across, and 4 and 5 Ohm to ground.
  CHECK(resistance(bridge(1, 2, 3, 4, 5), 0, 3) == exactly(61.0 / 21));
}

TEST_CASE("balanced Wheatstone bridge: its cross link carries no current") {
  const Conduction c = conduct(bridge(1, 2, 3, 2, 4), 0, 3);
  CHECK(c.backbone[2]);
  CHECK(std::abs(c.link_current[2]) < 1e-15);
}

TEST_CASE("network without a path: infinite resistance, isolated potentials NaN") {
  const Conduction c = conduct({.nodes = 5, .links = {{0, 1, 1}, {2, 3, 1}}}, 0, 3, {.voltage = 2});
  CHECK(!c.connected);
  CHECK(std::isinf(c.resistance));
  CHECK(c.conductance == 0);
  CHECK(c.potential[1] == 0);  // A dead end has the electrode's potential.
  CHECK(c.potential[2] == 2);
  CHECK(std::isnan(c.potential[4]));
}

TEST_CASE("network dead ends: no current, potential of the node they start from") {
  const Conduction c =
      conduct({.nodes = 6, .links = {{0, 1, 1}, {1, 2, 1}, {1, 3, 1}, {3, 4, 1}, {3, 5, 1}, {4, 5, 1}}}, 0, 2);
  CHECK(c.resistance == exactly(2));
  CHECK(c.backbone == std::vector<char>{1, 1, 0, 0, 0, 0});
  for (const int n : {1, 3, 4, 5}) CHECK(c.potential[n] == exactly(0.5));
}

TEST_CASE("network of 1e-30 and 1e30 Ohm: exact resistance, balanced power") {
  SUBCASE("bridge: large conductances short-circuit, small ones set the result") {
    // 1e-30 Ohm from the source to both inner nodes and between them, and 1e30 Ohm to ground twice: 0.5e30.
    CHECK(resistance(bridge(1e-30, 1e-30, 1e-30, 1e30, 1e30), 0, 3) == exactly(0.5e30));
  }
  SUBCASE("cluster of large conductances: power and currents balance") {
    // 0 -1e30- 1, a square 1-2-4-3 of 1e-30 Ohm, 4 -1e30- 5: each branch of the square carries half.
    const Network n = {.nodes = 6,
                       .links = {{0, 1, 1e-30}, {1, 2, 1e30}, {1, 3, 1e30}, {2, 4, 1e30}, {3, 4, 1e30}, {4, 5, 1e-30}}};
    const Conduction c = conduct(n, 0, 5);
    CHECK(c.resistance == exactly(2e30));
    CHECK(c.power_balance < 1e-13);
    for (const int k : {1, 2, 3, 4}) CHECK(-c.link_current[k] == exactly(0.25e-30));
  }
  SUBCASE("ladder of alternating rungs and rails") {
    // R_n = rail + 1 / (1 / rung + 1 / R_{n-1}): a recursion without subtractions, exact within rounding.
    Network n{.nodes = 1};
    double expected = std::numeric_limits<double>::infinity();
    const int rungs = 40;
    for (int k = 0; k < rungs; ++k) {
      const double rung = k % 3 == 0 ? 1e-30 : 1e30, rail = k % 2 == 0 ? 1e30 : 1e-30;
      n.links.push_back({0, k + 1, 1 / rung});
      n.links.push_back({k + 1, k + 2, 1 / rail});
      expected = rail + 1 / (1 / rung + 1 / expected);
    }
    n.nodes = rungs + 2;
    const Conduction c = conduct(n, 0, rungs + 1);
    CHECK(c.resistance == exactly(expected));
    CHECK(c.power_balance < 1e-12);
  }
}

namespace {

bool contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

/// Packing of three disks of radius 1 in a column between bottom (y = 0) and top, with an overlap of 10 %, and one disk
/// next to it.
ParticlePacking column() {
  return {.position = {{0, 0.9, 0}, {0, 2.7, 0}, {0, 4.5, 0}, {3, 3, 0}},
          .radius = {1, 1, 1, 0.5},
          .walls = {{"bottom", {}, {0, 1, 0}}, {"top", {0, 5.4, 0}, {0, -1, 0}}}};
}
const std::vector<PackingElectrode> walls = {{true, 0}, {true, 1}};

}  // namespace

TEST_CASE("network: invalid nodes, links and conductances are refused") {
  const Network net = {.nodes = 3, .links = {{0, 1, 1}, {1, 2, 1}}};
  CHECK(contains(message_of<InputError>([&] { conduct(net, 1, 1); }), "node 1 is named twice"));
  CHECK(contains(message_of<InputError>([&] { conduct(net, 0, 3); }), "there is no node 3"));
  CHECK(contains(message_of<InputError>([&] { condense(net, {0, 2, 0}); }), "node 0 is named twice"));
  for (const double g : {0.0, -1.0, 1 / 0.0, std::nan("")})
    CHECK(contains(message_of<InputError>([&] {
                     conduct({.nodes = 2, .links = {{0, 1, g}}}, 0, 1);
                   }),
                   "positive, finite"));
  CHECK(contains(message_of<InputError>([&] { conduct({.nodes = 2, .links = {{0, 2, 1}}}, 0, 1); }), "nodes 0 to 1"));
}

TEST_CASE("resistor models: missing or impossible parameters are refused") {
  CHECK(contains(message_of<InputError>([&] { resistor_model("ideal"); }), "no resistor model \"ideal\""));
  CHECK(contains(message_of<InputError>([&] { check(resistor_model("constriction"), {.resistivity = 1}); }),
                 "needs contact_radius in m"));
  CHECK(contains(message_of<InputError>([&] { check(resistor_model("constant"), {.resistance = 0}); }),
                 "greater than 0"));
  CHECK(contains(message_of<InputError>([&] { check(resistor_model("constant"), {.resistance = -2}); }),
                 "greater than 0"));
  CHECK(contains(
      message_of<InputError>([&] { check(resistor_model("constant"), {.resistance = 1, .contact_radius = 1}); }),
      "does not use contact_radius"));
  const ParticlePacking packing = column();
  const Contacts contacts = find_contacts(packing);
  CHECK(contains(message_of<InputError>([&] {
                   particle_network(packing, contacts, resistor_model("disk"),
                                    {.sheet_resistance = 1, .contact_radius = 1e-3}, walls);
                 }),
                 "contact-centred"));
  CHECK(contains(message_of<InputError>([&] {
                   contact_network(packing, contacts, resistor_model("disk"),
                                   {.sheet_resistance = 1, .contact_radius = 1.5}, walls);
                 }),
                 "too large"));
  CHECK(contains(
      message_of<InputError>([&] {
        contact_network(packing, contacts, resistor_model("constant"), {.resistance = 1}, {{false, 0}, {false, 1}});
      }),
      "particles 0 and 1, touch"));
  ParticlePacking bad = packing;
  bad.radius[2] = -1;
  CHECK(contains(message_of<InputError>([&] { check(bad); }), "particle 2 has radius -1"));
}

TEST_CASE("column of disks: constant, length and constriction resistors add") {
  const ParticlePacking packing = column();
  const Contacts contacts = find_contacts(packing);
  REQUIRE(contacts.pairs.size() == 2);
  REQUIRE(contacts.walls.size() == 2);
  const Parameters p{
      .resistance = 3, .resistance_per_length = 2, .sheet_resistance = 1, .resistivity = 5, .contact_radius = 0.01};
  const auto measured = [&](auto build, const char* model) {
    const PackingNetwork net = build(packing, contacts, resistor_model(model), p, walls);
    return conduct(net.network, net.electrode[0], net.electrode[1]).resistance;
  };
  CHECK(measured(by_particles, "constant") == exactly(4 * 3));
  CHECK(measured(contact_network, "constant") == exactly(3 * 3));
  CHECK(measured(by_particles, "length") == exactly(2 * 5.4));  // The whole height in both cases.
  CHECK(measured(contact_network, "length") == exactly(2 * 5.4));
  CHECK(measured(by_particles, "constriction") == exactly(6 * 5 / 0.04));
}

TEST_CASE("constriction model, ring: contact- and particle-centred networks agree") {
  // A ring of five disks, each with two contacts, with the bottom wall under one and the top wall over another.
  ParticlePacking packing{.walls = {{"bottom", {0, -1.5, 0}, {0, 1, 0}}, {"top", {0, 1.6, 0}, {0, -1, 0}}}};
  for (int k = 0; k < 5; ++k) {
    const double angle = 2 * std::numbers::pi * (k + 0.1) / 5;
    packing.position.push_back({std::cos(angle), std::sin(angle), 0});
    packing.radius.push_back(0.65);
  }
  packing.resistivity = {1, 2, 3, 4, 5};
  const Contacts contacts = find_contacts(packing);
  REQUIRE(contacts.pairs.size() == 5);
  const Parameters p{.resistivity = 0.3, .contact_radius = 0.01};
  const auto measured = [&](auto build) {
    const PackingNetwork net = build(packing, contacts, resistor_model("constriction"), p, walls);
    return conduct(net.network, net.electrode[0], net.electrode[1]).resistance;
  };
  CHECK(measured(contact_network) == exactly(measured(by_particles)));
}

TEST_CASE("sphere resistor model, small contacts: equals a Legendre series") {
  constexpr double a = 1.5, b = 0.01, rho = 0.7, pi = std::numbers::pi;
  Particle sphere{.centre = {1, 2, 3}, .radius = a};
  const std::vector<Point> at = {{0, 0, 1}, {std::sqrt(0.75), 0, -0.5}, {0.28, 0.96, 0}};
  for (const Point& n : at) sphere.contacts.push_back({1 + a * n[0], 2 + a * n[1], 3 + a * n[2]});
  const Eigen::MatrixXd links = resistor_model("sphere").particle({.resistivity = rho, .contact_radius = b}, sphere);
  Network net{.nodes = 3, .links = {{0, 1, links(0, 1)}, {0, 2, links(0, 2)}, {1, 2, links(1, 2)}}};
  // For a current I injected at a point and collected uniformly the surface potential is rho I / (4 pi a) times sum_l
  // (2 + 1/l) P_l(cos gamma). Here sum_l P_l = 1 / (2 sin(gamma / 2)) from l = 0. The remainder after n terms is below
  // n^-1.5.
  const auto potential = [&](double cosine) {
    double sum = 2 * (1 / std::sqrt(2 - 2 * cosine) - 1), before = 1, legendre = cosine;
    for (int l = 1; l <= 20000; ++l) {
      sum += legendre / l;
      before = std::exchange(legendre, ((2 * l + 1) * cosine * legendre - l * before) / (l + 1));
    }
    return sum;
  };
  // Near the point the potential is a (2/d - ln(d / 2a) / a) - 2 plus smaller terms. For the current density of an
  // equipotential disk, 1 / (2 pi b sqrt(b^2 - r^2)), the mean of 2/d is pi / b and that of ln d is ln b + 2 ln 2 -
  // 3/2.
  const double itself = pi * a / b - (std::log(b / (2 * a)) + 2 * std::numbers::ln2 - 1.5) - 2;
  for (int j = 0; j < 3; ++j)
    for (int i = 0; i < j; ++i) {
      const double cosine = at[i][0] * at[j][0] + at[i][1] * at[j][1] + at[i][2] * at[j][2];
      CHECK(resistance(net, i, j) == Approx(2 * rho / (4 * pi * a) * (itself - potential(cosine))).epsilon(1e-8));
    }
}

TEST_CASE("find_contacts: an overlap of 4e-9 radii is a contact, 1e-9 is none") {
  ParticlePacking packing{.position = {{0, 0, 0}, {2 - 1e-9, 0, 0}}, .radius = {1, 1}};
  CHECK(find_contacts(packing).pairs.empty());
  packing.position[1][0] = 2 - 4e-9;
  CHECK(find_contacts(packing).pairs.size() == 1);
}

TEST_CASE("packing with one radius too few, or a position beyond 1e100 m: refused") {
  CHECK(contains(message_of([] { check({.position = {{0, 0, 0}, {1, 0, 0}}, .radius = {1}}); }), "2 positions, but 1"));
  for (const double far : {1e100, -double{INFINITY}, std::nan("")})
    CHECK(contains(message_of([&] { check({.position = {{0, far, 0}}, .radius = {1}}); }), "no position within"));
}

TEST_CASE("find_contacts: finds all overlaps of spheres of many sizes") {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> coordinate(-5, 5), radius(0.05, 0.9);
  for (const int dimension : {2, 3}) {
    ParticlePacking packing;
    for (int i = 0; i < 400; ++i) {
      packing.position.push_back({coordinate(random), coordinate(random), dimension == 3 ? coordinate(random) : 0});
      packing.radius.push_back(radius(random));
    }
    std::size_t expected = 0;
    for (int j = 0; j < 400; ++j)
      for (int i = 0; i < j; ++i)
        expected += distance(packing.position[i], packing.position[j]) < packing.radius[i] + packing.radius[j];
    CHECK(find_contacts(packing).pairs.size() == expected);
  }
}

TEST_CASE("condense: equals the Schur complement on the kept nodes") {
  std::mt19937_64 random(7);
  Network net{.nodes = 300};
  std::uniform_int_distribution<int> node(0, net.nodes - 1);
  for (int k = 1; k < net.nodes; ++k) net.links.push_back({k - 1, k, 1.0});
  for (int k = 0; k < 500; ++k) net.links.push_back({node(random), node(random), 0.5 + k % 7});
  const std::vector<int> kept = {17, 3, 250, 99};
  const Eigen::MatrixXd s = conductance_matrix(net);
  // Row i of the reduced matrix is the current into the kept nodes with node i at 1 V and the others at 0.
  const Eigen::MatrixXd mesh = condense(net, kept);
  std::vector<int> rest;
  for (int n = 0; n < net.nodes; ++n)
    if (std::find(kept.begin(), kept.end(), n) == kept.end()) rest.push_back(n);
  const Eigen::MatrixXd see = s(rest, rest), sek = s(rest, kept), skk = s(kept, kept);
  const Eigen::MatrixXd schur = skk - sek.transpose() * solve_dense(see, sek);
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < i; ++j) CHECK(mesh(i, j) == Approx(-schur(i, j)).epsilon(1e-12));
}

TEST_CASE("Elimination::potentials: equals dense solves for four right-hand sides") {
  std::mt19937_64 random(11);
  Network net{.nodes = 120};
  std::uniform_int_distribution<int> node(0, net.nodes - 1);
  std::uniform_real_distribution<double> number(-1, 1);
  for (int k = 1; k < net.nodes; ++k) net.links.push_back({k - 1, k, 1.0});
  for (int k = 0; k < 200; ++k) net.links.push_back({node(random), node(random), 0.5 + k % 7});
  std::erase_if(net.links, [](const Link& link) { return link.a == link.b; });
  const std::vector<int> kept = {90, 4, 61};
  std::vector<int> rest;
  for (int n = 0; n < net.nodes; ++n)
    if (std::ranges::find(kept, n) == kept.end()) rest.push_back(n);
  const Eigen::MatrixXd given = Eigen::MatrixXd::NullaryExpr(3, 4, [&] { return number(random); });
  Eigen::MatrixXd fed = Eigen::MatrixXd::NullaryExpr(net.nodes, 4, [&] { return number(random); });
  const Elimination elimination(net, kept);
  const Eigen::MatrixXd s = conductance_matrix(net), sek = s(rest, kept);
  const Eigen::MatrixXd see = s(rest, rest);
  // Conductances of 0.5 to 6.5 on 120 nodes: a condition number below 1e5, and rounding of 1e-16 on either side.
  constexpr double bound = 1e-10;
  const Eigen::MatrixXd driven = elimination.potentials(given);
  CHECK((driven(kept, Eigen::all) - given).norm() == 0);
  CHECK((driven(rest, Eigen::all) - solve_dense(see, -sek * given)).cwiseAbs().maxCoeff() < bound);
  const Eigen::MatrixXd both = elimination.potentials(given, fed), fed_rest = fed(rest, Eigen::all);
  CHECK((both(kept, Eigen::all) - given).norm() == 0);
  CHECK((both(rest, Eigen::all) - solve_dense(see, fed_rest - sek * given)).cwiseAbs().maxCoeff() < bound);
}

TEST_CASE("Elimination: ratios of 1e60 keep their digits in large fronts") {
  // A complete network is one dense front. The reference eliminates node by node in extended precision.
  std::mt19937_64 random(17);
  std::uniform_real_distribution<double> decades(-30, 30);
  const int n = 160;
  Network net{.nodes = n};
  std::vector<std::vector<long double>> g(n, std::vector<long double>(n, 0));
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < i; ++j) {
      net.links.push_back({i, j, std::pow(10, decades(random))});
      g[i][j] = g[j][i] = net.links.back().conductance;
    }
  for (int k = n - 1; k >= 2; --k) {
    long double sum = 0;
    for (int j = 0; j < k; ++j) sum += g[k][j];
    for (int i = 0; i < k; ++i)
      for (int j = 0; j < k; ++j)
        if (i != j) g[i][j] += g[k][i] / sum * g[k][j];
  }
  // Each of n eliminations has relative errors of about n / 2 additions at most, which rarely add up.
  CHECK(conductance_between(net, 0, 1) == Approx(static_cast<double>(g[0][1])).epsilon(1e-13));
}

namespace {

/// Square lattice of side^2 nodes at their positions, with conductances from 1 to 5.
Network square_lattice(int side) {
  Network net{.nodes = side * side};
  for (int n = 0; n < net.nodes; ++n) {
    const int x = n % side, y = n / side;
    if (x > 0) net.links.push_back({n - 1, n, 1.0 + (x * y) % 5});
    if (y > 0) net.links.push_back({n - side, n, 2.0 + (x + y) % 3});
    net.position.push_back({double(x), double(y), 0});
  }
  return net;
}

}  // namespace

TEST_CASE("Elimination: same bits for any threads, and if memory is short") {
  const Network net = square_lattice(220);  // Several subtrees, as they have at most 2^14 nodes
  const std::vector<int> kept = {5, 31000};
  Eigen::MatrixXd fed = Eigen::MatrixXd::Zero(net.nodes, 1);
  fed(777) = 1;
  const Eigen::MatrixXd given = Eigen::Vector2d(0, 1);
  const Elimination alone(net, kept);
  const Eigen::MatrixXd potential = alone.potentials(given, fed);
  const Eigen::VectorXd resistance = alone.resistances();
  for (const int threads : {2, 3})
    for (const double bytes : {1e5, 1e12}) {
      parallel::Team team(threads);
      const Elimination other(net, kept, {.bytes = bytes, .required = true, .team = &team});
      CHECK(other.mesh() == alone.mesh());
      CHECK(other.potentials(given, fed) == potential);
      CHECK(other.resistances() == resistance);
      CHECK(Elimination(net, kept, {.mesh_only = true, .team = &team}).mesh() == alone.mesh());
    }
  // Kirchhoff's law at each node that is not kept: currents of a few amperes, rounded once per link.
  Eigen::VectorXd unbalanced = -fed.col(0);
  for (const Link& link : net.links) {
    const double current = link.conductance * (potential(link.a) - potential(link.b));
    unbalanced(link.a) += current;
    unbalanced(link.b) -= current;
  }
  for (const int n : kept) unbalanced(n) = 0;
  CHECK(unbalanced.cwiseAbs().maxCoeff() < 1e-13);
}

TEST_CASE("find_contacts: finds all pairs, in one order for any threads") {
  std::mt19937_64 random(23);
  std::uniform_real_distribution<double> coordinate(0, 60);
  ParticlePacking packing;
  for (int k = 0; k < 5000; ++k) {
    packing.position.push_back({coordinate(random), coordinate(random), 0});
    packing.radius.push_back(0.3 + coordinate(random) / 300);
  }
  parallel::Team team(3);
  const auto pairs_of = [](const Contacts& contacts) {
    std::vector<std::pair<int, int>> pairs;
    for (const auto [i, j] : contacts.pairs) pairs.emplace_back(i, j);
    return pairs;
  };
  auto pairs = pairs_of(find_contacts(packing));
  CHECK(pairs_of(find_contacts(packing, team)) == pairs);
  std::vector<std::pair<int, int>> expected;
  for (int i = 0; i < packing.size(); ++i)
    for (int j = i + 1; j < packing.size(); ++j)
      if (distance(packing.position[i], packing.position[j]) < (1 - 1e-9) * (packing.radius[i] + packing.radius[j]))
        expected.emplace_back(i, j);
  std::ranges::sort(pairs);
  CHECK(pairs == expected);
}

TEST_CASE("resistances_from one node: equal those of individual pairs") {
  std::mt19937_64 random(13);
  std::uniform_real_distribution<double> decades(-8, 8), coordinate(0, 1);
  for (const bool positions : {false, true}) {
    CAPTURE(positions);
    Network net{.nodes = 200};
    std::uniform_int_distribution<int> node(0, net.nodes - 1);
    for (int k = 1; k < net.nodes; ++k) net.links.push_back({k - 1, k, std::pow(10, decades(random))});
    for (int k = 0; k < 300; ++k) net.links.push_back({node(random), node(random), std::pow(10, decades(random))});
    net.nodes += 2;  // Isolated nodes.
    if (positions)
      for (int n = 0; n < net.nodes; ++n) net.position.push_back({coordinate(random), coordinate(random), 0});
    const std::vector<double> found = resistances_from(net, 77);
    REQUIRE(found.size() == 202);
    for (int n = 0; n < 200; ++n)
      if (n != 77) CHECK(found[n] == exactly(1 / conductance_between(net, 77, n)));
    CHECK(found[77] == 0);
    for (const int n : {200, 201}) CHECK(std::isinf(found[n]));
  }
}

TEST_CASE("resistances_from: k (n - k) / n to node k in a ring of n unit resistors") {
  const int n = 1001;
  Network ring{.nodes = n};
  for (int k = 0; k < n; ++k) ring.links.push_back({k, (k + 1) % n, 1});
  const std::vector<double> found = resistances_from(ring, 0);
  // Two paths in parallel; sums of up to 1000 terms.
  for (int k = 1; k < n; ++k) CHECK(found[k] == Approx(k * double(n - k) / n).epsilon(1e-12));
}

TEST_CASE("network with node positions: resistance equals that without positions") {
  const int side = 40;
  Network net = square_lattice(side);
  const std::vector<Point> position = std::exchange(net.position, {});
  const double without = resistance(net, 0, side * side - 1);
  net.position = position;
  CHECK(resistance(net, 0, side * side - 1) == exactly(without));
}

}  // namespace network_test
