// Measures Coulomb sums of charges +1 and -1 at random positions in a periodic cube: cost of a mesh evaluation by part,
// and cost of Ewald's sum. Compares requested, estimated and realised error. --dipoles: additional cost of mutual
// polarization. --sides: forces with open and grounded sides.
#include "solvers/periodic/accuracy.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <ctime>
#include <random>

#include "solvers/periodic/bounded.hpp"
#include "solvers/periodic/dipoles.hpp"
#include "solvers/periodic/ewald.hpp"
#include "solvers/periodic/mesh.hpp"
#include "validation/benchmarks/machine.hpp"

using namespace lichtenberg;
using namespace lichtenberg::periodic;

namespace {

struct Options {
  std::vector<int> sizes{1000, 8516, 50016};
  std::vector<double> accuracies{1e-3, 1e-4, 1e-6};
  std::vector<int> threads{1, 2};
  double density = 0.1458;  // charges per unit volume, at least 1 apart, as in G's gas
  int sample = 300;         // number of charges whose force is compared with Ewald sums
  int repeats = 5;
  double polarizability = 0.075, tolerance = 1e-4;  // of induced dipoles
};

/// Minimum of several runs: wall time, and processor time of all threads.
struct Milliseconds {
  double wall = INFINITY, processors = INFINITY;
};

Milliseconds milliseconds(int repeats, const auto& work) {
  Milliseconds least;
  for (int k = 0; k < repeats; ++k) {
    const auto start = std::chrono::steady_clock::now();
    const std::clock_t before = std::clock();
    work();
    least.processors = std::min(least.processors, 1e3 * static_cast<double>(std::clock() - before) / CLOCKS_PER_SEC);
    const std::chrono::duration<double, std::milli> wall = std::chrono::steady_clock::now() - start;
    least.wall = std::min(least.wall, wall.count());
  }
  return least;
}

Box<3> periodic_box(Vec3 lengths) {
  Box<3> box{lengths};
  box.sides.fill(Boundary::periodic);
  return box;
}

struct Gas {
  Vec3 lengths;
  std::vector<double> position, charge;

  operator Sources() const { return {lengths, position, charge}; }
  Sources with(std::span<const double> dipole) const { return {lengths, position, charge, dipole}; }
  std::vector<Pair> pairs(double within, parallel::Team& team) const {
    const std::vector<double> radius(charge.size());
    return pairs_closer_than(Spheres<3>{position, radius, periodic_box(lengths)}, within, team);
  }
};

/// Draws positions and redraws those closer than 1 to another until none remains.
Gas gas(int count, double density) {
  const double length = std::cbrt(count / density);
  Gas gas{{length, length, length}};
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> coordinate(0, length);
  for (int i = 0; i < count; ++i) {
    for (int k = 0; k < 3; ++k) gas.position.push_back(coordinate(random));
    gas.charge.push_back(i % 2 == 0 ? 1 : -1);
  }
  for (std::vector<Pair> close; !(close = gas.pairs(1, parallel::Team::single())).empty();)
    for (const Pair pair : close)
      for (int k = 0; k < 3; ++k) gas.position[3 * pair.j + k] = coordinate(random);
  return gas;
}

/// Returns the rms force error over the rms of the exact forces.
double force_error(const Response& found, const Response& exact, std::span<const int> sample) {
  double error = 0, size = 0;
  for (std::size_t s = 0; s < sample.size(); ++s)
    for (int k = 0; k < 3; ++k) {
      error += std::pow(found.force[3 * sample[s] + k] - exact.force[3 * s + k], 2);
      size += std::pow(exact.force[3 * s + k], 2);
    }
  return std::sqrt(error / size);
}

double net_force(const Response& response) {
  Vec3 net;
  double all = 0;
  for (std::size_t i = 0; i < response.force.size(); ++i) {
    net[static_cast<int>(i % 3)] += response.force[i];
    all += std::abs(response.force[i]);
  }
  return norm(net) / all;
}

struct Case {
  Gas of;
  std::vector<int> sample;
  Response exact;
};

Case prepare(int count, const Options& options) {
  Case now{gas(count, options.density)};
  for (int s = 0; s < std::min(options.sample, count); ++s)
    now.sample.push_back(static_cast<int>(static_cast<long>(s) * count / std::min(options.sample, count)));
  parallel::Team team(2);
  const Ewald ewald(splitting_for(now.of, 1e-11));
  const double time = milliseconds(1, [&] { ewald.evaluate_at(now.sample, now.of, team, now.exact); }).processors;
  fmt::print("\n{} charges, L = {:.3f}; Ewald at 1e-11: {:.0f} ms for {} of them on two threads\n", count,
             now.of.lengths.x, time, now.sample.size());
  return now;
}

template <class Real>
void measure(const Case& now, const Mesh& mesh, const Cloud& cloud, std::string_view name, const Options& options) {
  const Sources sources = now.of;
  MeshSum<Real> sum(mesh, cloud);
  const Near<Real> near(mesh.lengths, cloud);
  ChargeMesh<Real> charges(mesh, cloud);
  Columns<Real> columns(mesh.lengths, near.layout(charges.reach()));
  std::vector<Real> parts(4 * now.of.charge.size());
  const FieldSums<Real> sums{parts};
  for (const int threads : options.threads) {
    parallel::Team team(threads);
    Response response;
    const auto time = [&](auto&& work) { return milliseconds(options.repeats, work); };
    const Milliseconds all = time([&] { sum.evaluate(sources, {}, team, response); });
    std::vector<double> force;
    const double forces = time([&] { sum.forces(sources, {}, team, force); }).processors;
    const double made = milliseconds(1, [&] { MeshSum<Real>(mesh, cloud); }).processors;
    const double sorted = time([&] { columns.sort(sources, team); }).processors;
    const double by_pairs = time([&] { near.compute(columns, Kind::charges, true, sums, team); }).processors;
    const double spread = time([&] { charges.spread(columns, Kind::charges, team); }).processors;
    const double solved = time([&] { charges.solve(team); }).processors;
    const double taken = time([&] { charges.add(columns, Kind::charges, sums, team); }).processors;
    fmt::print(
        "{:>8} {:>7.3f} {:>3} {:>4} {:>4} {:>8} {:>8.1f} {:>8.2f} {:>8.2f} {:>8.2f} {:>8.2f} {:>8.2f} {:>8.2f} "
        "{:>8.2f} {:>9.1e} {:>9.1e} {:>8.0e} {:>8.2f}\n",
        name, cloud.cutoff, mesh.order, mesh.points[0], near.degree(Kind::charges), threads, made, sorted, by_pairs,
        spread, solved, taken, all.processors, all.wall, relative_error(mesh, cloud, 1),
        force_error(response, now.exact, now.sample), net_force(response), forces);
  }
}

/// Evaluations of the dipoles' field per step, from a zero initial guess and from the predictor's (from the fifth step
/// on), for freely moving charges. Steps are random with an rms of .005 per axis, as of grains at temperature 1.
struct Iterations {
  int cold = 0;
  double predicted = 0;
  std::vector<double> dipole;
};

Iterations iterations(Gas moving, const InducedDipoles& induced, parallel::Team& team) {
  constexpr int steps = 10, first = 4;
  std::mt19937_64 random(2);
  std::normal_distribution<double> normal(0, 0.005);
  std::vector<double> step(moving.position.size());
  std::ranges::generate(step, [&] { return normal(random); });
  DipolePredictor predictor;
  Iterations found;
  Response response;
  for (int n = 0; n < steps; ++n) {
    std::vector<double> dipole = predictor.predict();
    const int fields = induced.evaluate(moving, {}, team, dipole, response);
    if (n == 0) found.cold = fields, found.dipole = dipole;
    if (n >= first) found.predicted += static_cast<double>(fields) / (steps - first);
    predictor.keep(std::move(dipole));
    for (std::size_t k = 0; k < step.size(); ++k) moving.position[k] += step[k];
  }
  return found;
}

void measure_dipoles(const Gas& gas, double accuracy, const Options& options) {
  const int size = static_cast<int>(gas.charge.size());
  const MeshChoice choice = choose_mesh(accuracy, size, gas.lengths, 1, lowest_dipole_order);
  const Cloud cloud = prolate_cloud(choice.band_limit, choice.cutoff);
  ParticleMesh sum(choice.mesh, cloud);
  const InducedDipoles induced(sum, DipoleSum::ewald, options.polarizability, options.tolerance);
  std::vector<int> sample;
  for (int s = 0; s < std::min(options.sample, size); ++s)
    sample.push_back(static_cast<int>(static_cast<long>(s) * size / std::min(options.sample, size)));
  for (const int threads : options.threads) {
    parallel::Team team(threads);
    const Iterations found = iterations(gas, induced, team);
    const Sources polarized = gas.with(found.dipole);
    Response response, exact;
    std::vector<double> field(gas.position.size()), dipole;
    const auto time = [&](auto&& work) { return milliseconds(options.repeats, work); };
    const Milliseconds charges_time = time([&] { sum.evaluate(gas, {}, team, response); });
    const Milliseconds dipoles_time = time([&] { sum.dipole_field(polarized, {}, team, field); });
    const Milliseconds cold = time([&] {
      dipole.clear();
      induced.evaluate(gas, {}, team, dipole, response);
    });
    const Milliseconds both = time([&] { sum.evaluate(polarized, {}, team, response); });
    Ewald(splitting_for(gas, 1e-9)).evaluate_at(sample, polarized, team, exact);
    fmt::print(
        "{:>8} {:>8.0e} {:>7.3f} {:>3} {:>4} {:>8} {:>8.2f} {:>8.2f} {:>8.2f} {:>8} {:>9.2f} {:>9.2f} {:>9.1e}\n", size,
        accuracy, choice.cutoff, choice.mesh.order, choice.mesh.points[0], threads, charges_time.processors,
        dipoles_time.processors, both.processors, found.cold, found.predicted, cold.processors,
        force_error(response, exact, sample));
  }
}

void measure_dipoles(const Options& options) {
  fmt::print(
      "A = {}, tolerance {}; ms of processors: a field of charges, of dipoles, of both with forces; fields of "
      "dipoles without a start and with the predictor's; all without a start\n",
      options.polarizability, options.tolerance);
  fmt::print("{:>8} {:>8} {:>7} {:>3} {:>4} {:>8} {:>8} {:>8} {:>8} {:>8} {:>9} {:>9} {:>9}\n", "charges", "asked",
             "cutoff", "p", "mesh", "threads", "charges", "dipoles", "both", "cold", "predicted", "all, ms", "error");
  for (const int size : options.sizes)
    for (const double accuracy : options.accuracies) measure_dipoles(gas(size, options.density), accuracy, options);
}

void measure_sides(const Options& options) {
  constexpr Side p = Side::periodic, o = Side::open, g = Side::grounded;
  const std::vector<std::pair<std::string, Enclosure>> kinds = {{"periodic", {.sides = {p, p, p, p, p, p}}},
                                                                {"open along z", {.sides = {p, p, p, p, o, o}}},
                                                                {"grounded along z", {.sides = {p, p, p, p, g, g}}},
                                                                {"grounded at z = 0", {.sides = {p, p, p, p, g, o}}},
                                                                {"open", {.sides = {o, o, o, o, o, o}}}};
  fmt::print("{:>8} {:>8} {:>18} {:>8} {:>12} {:>10}\n", "charges", "request", "sides", "cutoff", "mesh", "forces, ms");
  for (const int size : options.sizes)
    for (const double accuracy : options.accuracies) {
      const Gas of = gas(size, options.density);
      for (auto [name, enclosure] : kinds) {
        enclosure.lengths = of.lengths;
        const MeshRequest request{.accuracy = accuracy, .charges = size, .lengths = of.lengths};
        const MeshChoice choice = choose_quick_mesh(enclosure.request(request));
        BoundedSum sum(request, enclosure, choice);
        std::vector<double> force;
        const Milliseconds time =
            milliseconds(options.repeats, [&] { sum.forces(of, {}, parallel::Team::single(), force); });
        fmt::print("{:>8} {:>8.0e} {:>18} {:>8.3f} {:>12} {:>10.2f}\n", size, accuracy, name, choice.cutoff,
                   fmt::format("{}x{}x{}", choice.mesh.points[0], choice.mesh.points[1], choice.mesh.points[2]),
                   time.processors);
      }
    }
}

void header() {
  fmt::print(
      "{:>8} {:>7} {:>3} {:>4} {:>4} {:>8} {:>8} {:>8} {:>8} {:>8} {:>8} {:>8} {:>8} {:>8} {:>9} {:>9} {:>8} {:>8}\n",
      "asked", "cutoff", "p", "mesh", "deg", "threads", "set-up", "sort", "near", "spread", "solve", "add", "CPU ms",
      "wall ms", "estimate", "error", "net", "forces");
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  double gauss = 0;
  std::vector<double> by_hand;
  CLI::App program("Coulomb sums on a mesh, timed.");
  program.add_option("--sizes", options.sizes)->delimiter(',');
  program.add_option("--accuracies", options.accuracies)->delimiter(',');
  program.add_option("--threads", options.threads)->delimiter(',');
  program.add_option("--sample", options.sample, "charges whose force is compared");
  program.add_option("--repeats", options.repeats);
  program.add_option("--gauss", gauss, "alpha, with --mesh");
  program.add_option("--mesh", by_hand, "cutoff, order, points a side, band limit")->delimiter(',');
  bool dipoles = false;
  program.add_flag("--dipoles", dipoles, "induced dipoles instead of charges alone");
  bool sides = false;
  program.add_flag("--sides", sides, "open and grounded sides");
  CLI11_PARSE(program, argc, argv);
  fmt::print("{}\n", benchmarks::machine());
  if (dipoles) {
    measure_dipoles(options);
    return 0;
  }
  if (sides) {
    measure_sides(options);
    return 0;
  }
  for (const int size : options.sizes) {
    const Case now = prepare(size, options);
    header();
    if (!by_hand.empty()) {
      const int points = static_cast<int>(by_hand[2]);
      const Mesh mesh{now.of.lengths, {points, points, points}, static_cast<int>(by_hand[1])};
      measure<float>(now, mesh, gauss > 0 ? gauss_cloud(gauss, by_hand[0]) : prolate_cloud(by_hand[3], by_hand[0]),
                     "single", options);
      if (mesh.order > 7) continue;
      measure<double>(now, mesh, gauss > 0 ? gauss_cloud(gauss, by_hand[0]) : prolate_cloud(by_hand[3], by_hand[0]),
                      "by hand", options);
      continue;
    }
    for (const double accuracy : options.accuracies) {
      try {
        MeshChoice choice;
        const double took =
            milliseconds(1, [&] { choice = choose_mesh(accuracy, size, now.of.lengths, 1); }).processors;
        measure<double>(now, choice.mesh, prolate_cloud(choice.band_limit, choice.cutoff),
                        fmt::format("{:.0e}", accuracy), options);
        const MeshChoice quick = choose_quick_mesh({accuracy, size, now.of.lengths});
        if (quick.single) measure<float>(now, quick.mesh, quick.cloud(), "single", options);
        fmt::print("band limit {}, chosen in {:.0f} ms\n", choice.band_limit, took);
      } catch (const std::exception& e) {
        fmt::print("{:.0e}: {}\n", accuracy, e.what());
      }
    }
  }
}
