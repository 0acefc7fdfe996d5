// Periodic Coulomb sums on a CUDA device: times of their parts, and force errors relative to Ewald's sum (for many
// charges, relative to the CPU's mesh at 1e-6). Charges are +1 and -1 at random positions with density .1458, at least
// 1 apart, and the same charges in one dense ball.
//
//   device_charges [--sizes 50016,1000000] [--accuracies 1e-3,1e-4] [--skin 0.5] [--cutoffs 4,5 --orders 5,6]
//   [--no-error] [--splines] [--host]

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <random>
#include <thread>

#include "solvers/error.hpp"
#include "solvers/periodic/accuracy.hpp"
#include "solvers/periodic/device/device.hpp"
#include "solvers/periodic/ewald.hpp"
#include "solvers/periodic/mesh.hpp"

using namespace lichtenberg;
using namespace lichtenberg::periodic;

namespace {

struct Gas {
  Vec3 lengths;
  std::vector<double> position, charge;

  operator Sources() const { return {lengths, position, charge}; }
  std::vector<Pair> pairs(double within, parallel::Team& team) const {
    Box<3> box{lengths};
    box.sides.fill(Boundary::periodic);
    const std::vector<double> radius(charge.size());
    return pairs_closer_than(Spheres<3>{position, radius, box}, within, team);
  }
};

/// Draws positions and redraws those closer than 1 to another until none remains.
Gas random_gas(int count, parallel::Team& team) {
  const double length = std::cbrt(count / 0.1458);
  Gas gas{{length, length, length}};
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> coordinate(0, length);
  for (int i = 0; i < count; ++i) {
    for (int k = 0; k < 3; ++k) gas.position.push_back(coordinate(random));
    gas.charge.push_back(i % 2 == 0 ? 1 : -1);
  }
  for (std::vector<Pair> close; !(close = gas.pairs(1, team)).empty();)
    for (const Pair pair : close)
      for (int k = 0; k < 3; ++k) gas.position[3 * pair.j + k] = coordinate(random);
  return gas;
}

/// Returns a dense ball in the same box: sites of a cubic lattice of spacing 1, displaced by up to .01.
Gas cluster(int count) {
  const double length = std::cbrt(count / 0.1458);
  Gas gas{{length, length, length}};
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> shift(-0.01, 0.01);
  const int a_side = static_cast<int>(std::ceil(std::cbrt(count)));
  for (int i = 0; i < count; ++i) {
    for (const int k : {i / (a_side * a_side), i / a_side % a_side, i % a_side})
      gas.position.push_back(k + shift(random));
    gas.charge.push_back(random() % 2 ? 1 : -1);
  }
  return gas;
}

double relative_error(const Response& found, const Response& exact, std::span<const int> sample, bool exact_on_sample) {
  double error = 0, size = 0;
  for (std::size_t s = 0; s < sample.size(); ++s)
    for (int k = 0; k < 3; ++k) {
      const double force = exact.force[3 * (exact_on_sample ? s : sample[s]) + k];
      error += std::pow(found.force[3 * sample[s] + k] - force, 2);
      size += force * force;
    }
  return std::sqrt(error / size);
}

double error_of(const Gas& gas, const Response& found, parallel::Team& team) {
  const int count = static_cast<int>(gas.charge.size());
  std::vector<int> sample;
  for (int s = 0; s < 200; ++s) sample.push_back(static_cast<int>(static_cast<long>(s) * count / 200));
  Response exact;
  if (count <= 60000) {
    const Ewald ewald(splitting_for(gas, 1e-9));
    ewald.evaluate_at(sample, gas, team, exact);
    return relative_error(found, exact, sample, true);
  }
  const MeshChoice choice = choose_mesh(1e-6, count, gas.lengths, 1);
  ParticleMesh mesh(choice.mesh, prolate_cloud(choice.band_limit, choice.cutoff));
  mesh.evaluate(gas, gas.pairs(choice.cutoff, team), team, exact);
  return relative_error(found, exact, sample, false);
}

/// Measures one sum. `by_hand`: parameters that are given instead of chosen.
void measure(const Gas& gas, const char* name, double accuracy, const FixedParameters& by_hand, double skin, bool host,
             bool error, bool splines, parallel::Team& team) {
  const int count = static_cast<int>(gas.charge.size());
  const MeshChoice choice = choose_quick_mesh({.accuracy = accuracy,
                                               .charges = count,
                                               .lengths = gas.lengths,
                                               .fixed = by_hand,
                                               .on_device = true,
                                               .splines = splines});
  const Cloud cloud = prolate_cloud(choice.band_limit, choice.cutoff);
  const auto mesh = host ? device::make_host_mesh(choice.mesh, cloud) : device::make_cuda_mesh(choice.mesh, cloud);
  Response found, again;
  mesh->evaluate(gas, {}, team, found);
  mesh->evaluate(gas, {}, team, again);
  const device::Profile p = mesh->profile(gas, skin, host ? 1 : 50);
  fmt::print("{:7d} {:<8} {:.0e}  {:.2f} {} {:3d}^3  {:5.0f} {:8.1f} {:8.1f} {:8.1f} {:8.1f} {:8.1f} {:8.1f} {:8.1f}",
             count, name, accuracy, choice.cutoff, choice.mesh.order, choice.mesh.points[0], p.partners, 1e6 * p.lists,
             1e6 * p.near, 1e6 * p.spread, 1e6 * p.transforms, 1e6 * p.gather, 1e6 * p.forces, 1e6 * p.with_potentials);
  fmt::print("  {:.2e}  {}\n", error ? error_of(gas, found, team) : NAN,
             found.force == again.force ? "same bits" : "OTHER BITS");
  std::fflush(stdout);
}

}  // namespace

int main(int argc, char** argv) {
  std::vector<int> sizes{50016, 1000000};
  std::vector<double> accuracies{1e-3, 1e-4, 1e-6}, cutoffs;
  std::vector<int> orders;
  double skin = 0.5;
  bool host = false, no_error = false, splines = false;
  CLI::App app("Times periodic Coulomb sums on a CUDA device and compares them with the CPU's");
  app.add_option("--sizes", sizes, "numbers of charges")->delimiter(',');
  app.add_option("--accuracies", accuracies, "rms error of a force over rms force")->delimiter(',');
  app.add_option("--cutoffs", cutoffs, "in place of the one that is chosen")->delimiter(',');
  app.add_option("--orders", orders, "likewise, of windows")->delimiter(',');
  app.add_option("--skin", skin, "of the lists of partners");
  app.add_flag("--no-error", no_error, "compare with nothing");
  app.add_flag("--splines", splines, "for windows, in place of prolate ones");
  app.add_flag("--host", host, "run the device's algorithms on the CPU");
  CLI11_PARSE(app, argc, argv);
  try {
    parallel::Team team(static_cast<int>(std::max(1u, std::thread::hardware_concurrency())));
    fmt::print("microseconds; cut-off, order, points; partners in a list\n");
    fmt::print("{:>7} {:<8} {:>5}  {:<12} {:>6} {:>8} {:>8} {:>8} {:>8} {:>8} {:>8} {:>8}  {}\n", "charges", "",
               "asked", "", "list", "lists", "near", "spread", "fft", "gather", "forces", "+energy", "error");
    for (const int count : sizes) {
      const Gas gas = random_gas(count, team), dense = cluster(count);
      for (const double accuracy : accuracies) {
        if (cutoffs.empty() && orders.empty()) {
          measure(gas, "random", accuracy, {}, skin, host, !no_error, splines, team);
          measure(dense, "cluster", accuracy, {}, skin, host, !no_error, splines, team);
        }
        for (const double cutoff : cutoffs)
          for (const int order : orders)
            measure(gas, "random", accuracy, {.cutoff = cutoff, .order = order}, skin, host, !no_error, splines, team);
      }
    }
  } catch (const std::exception& error) {
    fmt::print(stderr, "device_charges: {}\n", error.what());
    return 1;
  }
}
