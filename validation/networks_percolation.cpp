// Bond percolation on the square lattice: its threshold, which is exactly 1/2, and the exponent of its conductivity.
//
//   networks_percolation          seconds
//   networks_percolation long     larger lattices: an hour on one core
//
// A lattice of L + 1 columns of L nodes between two bars is self-dual. It conducts from bar to bar if and only if its
// dual, whose bonds are open where these are closed, does not conduct across. At p = 1/2 it therefore conducts with
// probability 1/2. If bonds are opened one by one, the p of first conduction is distributed symmetrically about 1/2 for
// each L.

#include <fmt/format.h>

#include <atomic>
#include <cmath>
#include <random>
#include <thread>

#include "solvers/disjoint_sets.hpp"
#include "solvers/network/conduction.hpp"
#include "validation/harness.hpp"
#include "validation/program.hpp"

namespace networks_percolation_validation {

using namespace lichtenberg;
using namespace lichtenberg::validation;
using network::Link;
using network::Network;

namespace {

/// Conductivity exponent over that of the correlation length, t / nu; with nu = 4/3, t = 1.310(1). P. Grassberger,
/// Physica A 262, 251 (1999).
constexpr double published_exponent = 0.9825, published_error = 0.0008;

struct Lattice {
  int side;  ///< L: rows of nodes between the bars
  int columns() const { return side + 1; }
  int nodes() const { return columns() * side + 2; }
  int low() const { return columns() * side; }
  int high() const { return low() + 1; }
  int node(int x, int y) const { return y < 0 ? low() : y == side ? high() : y * columns() + x; }

  std::vector<Link> bonds() const {
    std::vector<Link> all;
    for (int y = 0; y <= side; ++y)
      for (int x = 0; x < columns(); ++x) {
        all.push_back({node(x, y - 1), node(x, y), 1});
        if (y < side && x + 1 < columns()) all.push_back({node(x, y), node(x + 1, y), 1});
      }
    return all;
  }
  std::vector<network::Point> positions() const {
    std::vector<network::Point> all;
    for (int y = 0; y < side; ++y)
      for (int x = 0; x < columns(); ++x) all.push_back({double(x), double(y), 0});
    all.insert(all.end(), {{0, -1, 0}, {0, double(side), 0}});
    return all;
  }
};

/// Returns the fraction of open bonds when the first path joins the bars.
double opening(const Lattice& lattice, std::vector<Link> bonds, std::mt19937_64& random) {
  std::shuffle(bonds.begin(), bonds.end(), random);
  DisjointSets joined(lattice.nodes());
  for (std::size_t open = 0; open < bonds.size(); ++open) {
    joined.unite(bonds[open].a, bonds[open].b);
    if (joined.find(lattice.low()) == joined.find(lattice.high()))
      // The path exists from `open + 1` bonds on; the result is the middle of that probability step.
      return (static_cast<double>(open) + 1) / (static_cast<double>(bonds.size()) + 1);
  }
  return 1;
}

struct Mean {
  double value = 0, error = 0;
};
Mean mean(const std::vector<double>& sample) {
  const auto n = static_cast<double>(sample.size());
  double sum = 0, squares = 0;
  for (const double x : sample) sum += x, squares += x * x;
  return {sum / n, std::sqrt((squares / n - sum * sum / (n * n)) / (n - 1))};
}

void threshold(Report& report) {
  report.section("p at which the lattice first conducts, less 1/2, in standard errors");
  for (const auto& [side, samples] : {std::pair{8, 40000}, std::pair{32, 10000}, std::pair{128, 2000}}) {
    const Lattice lattice{side};
    const std::vector<Link> bonds = lattice.bonds();
    std::mt19937_64 random(side);
    std::vector<double> sample;
    for (int k = 0; k < samples; ++k) sample.push_back(opening(lattice, bonds, random));
    const Mean p = mean(sample);
    report.at_most(fmt::format("L = {}: p = {:.5f} +- {:.5f}", side, p.value, p.error),
                   std::abs(p.value - 0.5) / p.error, 3);
  }
}

/// Returns the conductance between the bars at p = 1/2; 0 without a path.
double conductance(const Lattice& lattice, const std::vector<Link>& bonds, Network& open, std::mt19937_64& random) {
  open.links.clear();
  DisjointSets joined(lattice.nodes());
  std::uint64_t bits = 0;
  for (std::size_t k = 0; k < bonds.size(); ++k) {
    if (k % 64 == 0) bits = random();
    if ((bits >> (k % 64) & 1) == 0) continue;
    joined.unite(bonds[k].a, bonds[k].b);
    open.links.push_back(bonds[k]);
  }
  if (joined.find(lattice.low()) != joined.find(lattice.high())) return 0;
  return network::conduct(open, lattice.low(), lattice.high()).conductance;
}

Mean mean_conductance(int side, int samples) {
  const Lattice lattice{side};
  const std::vector<Link> bonds = lattice.bonds();
  std::vector<double> sample(samples);
  constexpr int batch = 50;  // samples per random number stream, so that the result does not depend on the threads
  std::atomic<int> next = 0;
  const auto work = [&] {
    Network open{.nodes = lattice.nodes(), .position = lattice.positions()};
    for (int b = next++; b * batch < samples; b = next++) {
      std::mt19937_64 random(1000003ull * side + b);
      for (int k = b * batch; k < std::min(samples, (b + 1) * batch); ++k)
        sample[k] = conductance(lattice, bonds, open, random);
    }
  };
  std::vector<std::jthread> threads;
  for (unsigned t = 0; t < std::max(1u, std::thread::hardware_concurrency()); ++t) threads.emplace_back(work);
  threads.clear();
  return mean(sample);
}

/// Returns x of conductance ~ (L + 1)^-x by weighted least squares of the logarithms. Paths between bars have at least
/// L + 1 bonds.
Mean exponent(const std::vector<int>& sides, int samples) {
  double w = 0, x = 0, y = 0, xx = 0, xy = 0;
  for (const int side : sides) {
    const Mean g = mean_conductance(side, samples);
    fmt::print("{:<58}\n", fmt::format("  L = {}: conductance {:.6f} +- {:.6f}", side, g.value, g.error));
    std::fflush(stdout);
    const double weight = std::pow(g.value / g.error, 2), log_side = std::log(side + 1.0), log_g = std::log(g.value);
    w += weight;
    x += weight * log_side;
    y += weight * log_g;
    xx += weight * log_side * log_side;
    xy += weight * log_side * log_g;
  }
  const double determinant = w * xx - x * x;
  return {-(w * xy - x * y) / determinant, std::sqrt(w / determinant)};
}

void conductivity(Report& report, const std::vector<int>& sides, int samples) {
  report.section("t / nu against .9825 +- .0008, in standard errors of both together");
  const Mean found = exponent(sides, samples);
  report.at_most(fmt::format("{:.4f} +- {:.4f}", found.value, found.error),
                 std::abs(found.value - published_exponent) / std::hypot(found.error, published_error), 2,
                 fmt::format("t = {:.3f} +- {:.3f}", 4.0 / 3 * found.value, 4.0 / 3 * found.error));
}

}  // namespace

int validate(int argc, char** argv) {
  Report report("Percolation on the square lattice");
  threshold(report);
  if (long_run_requested(argc, argv))
    conductivity(report, {16, 32, 64, 128, 256}, 100000);
  else
    conductivity(report, {8, 16, 32}, 20000);
  return report.exit_status();
}

const lichtenberg::validation::Program program("networks_percolation", validate);

}  // namespace networks_percolation_validation
