// Compares resistor networks with exact results: ladders, lattices and polyhedra, infinite lattices by extrapolation, a
// dense pseudo-inverse, and five networks of a reference packing. Seconds.

#include <Eigen/Core>
#include <fstream>
#include <nlohmann/json.hpp>
#include <numbers>
#include <random>

#include "solvers/error.hpp"
#include "solvers/network/build.hpp"
#include "solvers/network/components.hpp"
#include "solvers/network/conduction.hpp"
#include "solvers/network/resistor.hpp"
#include "tests/conductance_matrix.hpp"
#include "tests/dense_algebra.hpp"
#include "tests/source_folder.hpp"
#include "validation/harness.hpp"
#include "validation/program.hpp"

namespace networks_validation {

using namespace lichtenberg;
using namespace lichtenberg::validation;
using network::Link;
using network::Network;
using std::numbers::pi;

namespace {

double relative(double value, double exact) { return std::abs(value / exact - 1); }

double resistance(const Network& network, int low, int high) { return network::conduct(network, low, high).resistance; }

/// Returns the resistance by the Moore-Penrose inverse of the dense conductance matrix: (e_a - e_b)^T S^+ (e_a - e_b).
double pseudo_inverse_resistance(const Network& network, int low, int high) {
  const Eigen::MatrixXd dense = network::conductance_matrix(network);
  const Eigen::MatrixXd inverse = symmetric_pseudo_inverse(dense);
  return inverse(low, low) + inverse(high, high) - 2 * inverse(low, high);
}

// Exact values.

/// Ladder of cells with a rail and a rung of 1 Ohm each: 2, 5/3, 13/8, 34/21, ... -> the golden ratio.
Network ladder(int cells) {
  Network network{.nodes = cells + 1};
  for (int k = 0; k < cells; ++k) {
    network.links.push_back({k, k + 1, 1});
    network.links.push_back({k + 1, cells + 1, 1});
  }
  ++network.nodes;
  return network;
}

/// `columns` columns of `rows` nodes between two bars, which are the last two nodes.
Network grid_between_bars(int columns, int rows) {
  Network network{.nodes = columns * rows + 2};
  const auto node = [&](int x, int y) {
    return y < 0 ? columns * rows : y == rows ? columns * rows + 1 : y * columns + x;
  };
  for (int y = 0; y <= rows; ++y)
    for (int x = 0; x < columns; ++x) {
      network.links.push_back({node(x, y - 1), node(x, y), 1});
      if (y < rows && x + 1 < columns) network.links.push_back({node(x, y), node(x + 1, y), 1});
    }
  return network;
}

Network complete(int n) {
  Network network{.nodes = n};
  for (int a = 0; a < n; ++a)
    for (int b = 0; b < a; ++b) network.links.push_back({a, b, 1});
  return network;
}

Network cube() {
  Network network{.nodes = 8};
  for (int a = 0; a < 8; ++a)
    for (const int bit : {1, 2, 4})
      if ((a & bit) == 0) network.links.push_back({a, a | bit, 1});
  return network;
}

Network torus(int side) {
  Network network{.nodes = side * side};
  for (int y = 0; y < side; ++y)
    for (int x = 0; x < side; ++x) {
      network.links.push_back({y * side + x, y * side + (x + 1) % side, 1});
      network.links.push_back({y * side + x, (y + 1) % side * side + x, 1});
    }
  return network;
}

void exact_values(Report& report) {
  report.section("exact values, relative error");
  constexpr double rounding = 1e-13;  // of some hundred operations
  const double ladders[] = {2, 5.0 / 3, 13.0 / 8, 34.0 / 21};
  for (int cells = 1; cells <= 4; ++cells)
    report.at_most(fmt::format("ladder of {} cells", cells),
                   relative(resistance(ladder(cells), 0, cells + 1), ladders[cells - 1]), rounding);
  report.at_most("ladder of 60 cells: the golden ratio", relative(resistance(ladder(60), 0, 61), std::numbers::phi),
                 rounding);  // the next convergent differs by phi^-240
  for (const auto& [columns, rows] : {std::pair{1, 7}, std::pair{12, 5}, std::pair{150, 150}})
    report.at_most(fmt::format("grid of {} x {} between bars: (n + 1) / m", columns, rows),
                   relative(resistance(grid_between_bars(columns, rows), columns * rows, columns * rows + 1),
                            (rows + 1.0) / columns),
                   1e-12);  // rounding of thousands of operations
  for (const int n : {2, 3, 10, 60})
    report.at_most(fmt::format("complete graph of {} nodes: 2 / n", n),
                   relative(resistance(complete(n), 0, n - 1), 2.0 / n), rounding);
  report.at_most("cube, along an edge: 7/12", relative(resistance(cube(), 0, 1), 7.0 / 12), rounding);
  report.at_most("cube, across a face: 3/4", relative(resistance(cube(), 0, 3), 3.0 / 4), rounding);
  report.at_most("cube, through the middle: 5/6", relative(resistance(cube(), 0, 7), 5.0 / 6), rounding);
  for (const int side : {3, 40})
    report.at_most(fmt::format("torus of {0} x {0}, an edge: (1 - 1 / L^2) / 2 (Foster)", side),
                   relative(resistance(torus(side), 0, 1), 0.5 * (1 - 1.0 / (side * side))), 1e-12);
}

/// Returns the resistance between (0, 0) and (x, y) of the infinite square lattice, extrapolated in 1 / L^2 from tori
/// of L = 32, 64, 128. The error is O(L^-6), about 1e-10 with coefficients near (x^2 + y^2)^3.
double infinite_lattice(int x, int y) {
  const auto on_torus = [&](int side) { return resistance(torus(side), 0, y * side + x); };
  const double a = on_torus(32), b = on_torus(64), c = on_torus(128);
  const double ab = (4 * b - a) / 3, bc = (4 * c - b) / 3;
  return (16 * bc - ab) / 15;
}

void infinite_lattices(Report& report) {
  report.section("infinite square lattice by extrapolation of tori, relative error");
  report.at_most("(1, 0): 1/2", relative(infinite_lattice(1, 0), 0.5), 1e-9);
  report.at_most("(1, 1): 2/pi", relative(infinite_lattice(1, 1), 2 / pi), 1e-9);
  report.at_most("(2, 0): 2 - 4/pi", relative(infinite_lattice(2, 0), 2 - 4 / pi), 1e-8);
  report.at_most("(2, 1): 4/pi - 1/2", relative(infinite_lattice(2, 1), 4 / pi - 0.5), 1e-8);
}

// Reference packing.

nlohmann::json reference(const std::string& file) {
  const std::string path = source_folder() + "/validation/data/packing/" + file;
  std::ifstream stream(path);
  if (!stream) throw Failure("cannot read " + path);
  return nlohmann::json::parse(stream);
}

network::ParticlePacking reference_packing() {
  const nlohmann::json data = reference("n100-packing.json");
  const auto x = data["x"].get<std::vector<double>>();
  const auto box = data["box"].get<std::vector<double>>();
  network::ParticlePacking packing{.radius = data["r"].get<std::vector<double>>(),
                                   .walls = {{"left", {}, {1, 0, 0}},
                                             {"right", {box[0], 0, 0}, {-1, 0, 0}},
                                             {"bottom", {}, {0, 1, 0}},
                                             {"top", {0, box[1], 0}, {0, -1, 0}}}};
  for (std::size_t i = 0; i < packing.radius.size(); ++i) packing.position.push_back({x[2 * i], x[2 * i + 1], 0});
  return packing;
}

const std::vector<network::PackingElectrode> bottom_and_top = {{true, 2}, {true, 3}};

/// Network with contact points on the radical line, which differ from the program's if radii differ.
Network radical_network(const network::ParticlePacking& packing, const network::Contacts& contacts) {
  std::vector<std::vector<std::pair<int, network::Point>>> touching(packing.size());
  int nodes = 2;
  for (const auto& [i, j] : contacts.pairs) {
    const network::Point &a = packing.position[i], &b = packing.position[j];
    const double d = network::distance(a, b), ri = packing.radius[i], rj = packing.radius[j];
    const double t = (d * d + ri * ri - rj * rj) / (2 * d * d);
    const network::Point p = {a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1]), 0};
    touching[i].push_back({nodes, p});
    touching[j].push_back({nodes++, p});
  }
  for (const network::ParticleWallContact& c : contacts.walls)
    if (c.wall >= 2) touching[c.particle].push_back({c.wall - 2, contact_point(packing, c)});
  Network result{.nodes = nodes};
  for (const auto& all : touching)
    for (std::size_t b = 0; b < all.size(); ++b)
      for (std::size_t a = 0; a < b; ++a)
        result.links.push_back({all[a].first, all[b].first, 1 / network::distance(all[a].second, all[b].second)});
  return result;
}

double largest_difference(const std::vector<double>& a, const std::vector<double>& b) {
  double largest = a.size() == b.size() ? 0 : 1;
  for (std::size_t k = 0; k < a.size() && k < b.size(); ++k) largest = larger(largest, std::abs(a[k] - b[k]));
  return largest;
}

void reference_networks(Report& report) {
  report.section("100 disks, bottom to top: relative error against the reference, of potentials absolute");
  // Nonzero eigenvalues of these conductance matrices have ratios up to 250. Rounding, 2e-16, then gives errors of
  // 5e-14 in each of the two dense solutions. The bound adds a margin for sums over 200 to 300 nodes.
  constexpr double bound = 1e-12;
  const nlohmann::json all = reference("n100-networks.json");
  const network::ParticlePacking packing = reference_packing();
  const network::Contacts contacts = find_contacts(packing);
  const network::Parameters unit{.resistance = 1, .resistance_per_length = 1};
  const auto compare = [&](const std::string& name, const Network& net, int low, int high) {
    const nlohmann::json& expected = all["n100/" + name];
    const network::Conduction c = network::conduct(net, low, high);
    report.at_most(name + ", resistance", relative(c.resistance, expected["R"].get<double>()), bound);
    report.at_most(name + ", dense pseudo-inverse", relative(c.resistance, pseudo_inverse_resistance(net, low, high)),
                   bound);
    report.at_most(name + ", power balance", c.power_balance, bound);
    return c;
  };
  for (const auto& [name, model] : {std::pair{"particle_one", "constant"}, std::pair{"particle_dist", "length"}}) {
    const auto net = particle_network(packing, contacts, network::resistor_model(model), unit, bottom_and_top);
    const network::Conduction c = compare(name, net.network, net.electrode[0], net.electrode[1]);
    auto expected = all["n100/" + std::string(name)]["potentials"].get<std::vector<double>>();
    std::rotate(expected.begin(), expected.begin() + 2, expected.end());  // the reference begins with the electrodes
    report.at_most(std::string(name) + ", all potentials", largest_difference(c.potential, expected), bound);
  }
  for (const auto& [name, model] : {std::pair{"contact_one", "constant"}, std::pair{"contact_linear", "length"}}) {
    const auto net = contact_network(packing, contacts, network::resistor_model(model), unit, bottom_and_top);
    const network::Conduction c = compare(name, net.network, net.electrode[0], net.electrode[1]);
    auto mine = c.potential, expected = all["n100/" + std::string(name)]["potentials"].get<std::vector<double>>();
    std::ranges::sort(mine);  // contacts are numbered in another order
    std::ranges::sort(expected);
    report.at_most(std::string(name) + ", all potentials, sorted", largest_difference(mine, expected), bound);
  }
  compare("contact_radical", radical_network(packing, contacts), 0, 1);
}

/// Tests Foster's theorem: the sum of g_e R_e over the links equals the number of nodes minus that of components.
void foster(Report& report) {
  report.section("Foster's sum of g R over all links against nodes - pieces, relative");
  const network::ParticlePacking packing = reference_packing();
  const auto contacts = find_contacts(packing);
  const network::Parameters parameters{.resistance = 1, .resistance_per_length = 1};
  for (const char* model : {"constant", "length"}) {
    const Network net =
        particle_network(packing, contacts, network::resistor_model(model), parameters, bottom_and_top).network;
    double sum = 0;
    for (const Link& link : net.links) sum += link.conductance / network::conductance_between(net, link.a, link.b);
    report.at_most(fmt::format("100 disks, {}", model), relative(sum, net.nodes - network::components(net).number),
                   1e-12);
  }
}

/// Random graphs with conductances over several decades. The error of the dense pseudo-inverse is rounding times the
/// condition number, the ratio of the nonzero eigenvalues. This is some tens without spread, some thousands over two
/// decades and below 1e5 over four: 2e-11. The bound is five times that.
void random_networks(Report& report) {
  report.section("random networks against the dense pseudo-inverse, relative error");
  std::mt19937_64 random(5);
  for (const double decades : {0.0, 2.0, 4.0}) {
    std::vector<double> errors;
    for (int sample = 0; sample < 20; ++sample) {
      Network net{.nodes = 80};
      std::uniform_int_distribution<int> node(0, net.nodes - 1);
      std::uniform_real_distribution<double> exponent(-decades / 2, decades / 2);
      for (int k = 0; k < 160; ++k) net.links.push_back({node(random), node(random), std::pow(10, exponent(random))});
      const network::Conduction c = network::conduct(net, 0, 1);
      if (c.connected) errors.push_back(relative(c.resistance, pseudo_inverse_resistance(net, 0, 1)));
    }
    // Both nodes have links with a probability of .96 per draw (with four links per node, exp(-4) have none), and
    // nearly all nodes with links are in one component.
    report.at_least(fmt::format("draws of 20 that connect, {:g} decades", decades), static_cast<double>(errors.size()),
                    15);
    report.at_most(fmt::format("80 nodes, conductances over {:g} decades", decades), spread(errors), 1e-10);
  }
}

}  // namespace

int validate(int, char**) {
  Report report("Resistor networks");
  exact_values(report);
  infinite_lattices(report);
  reference_networks(report);
  foster(report);
  random_networks(report);
  return report.exit_status();
}

const lichtenberg::validation::Program program("networks", validate);

}  // namespace networks_validation
