// The loop over pairs of a law (src/model/pair_device.hpp) on a CUDA device against the host's: Hertz's contact and a
// screened Coulomb term of 1e5 spheres in a periodic cube. Fails unless they agree to rounding and give the same bits
// twice.

#include <cstdio>
#include <random>

#include "solvers/parallel/cuda_executor.hpp"
#include "src/effects/hertz.hpp"
#include "src/model/pair_device.hpp"
#include "src/model/pair_loop.hpp"
#include "tests/screened_coulomb.hpp"

using namespace lichtenberg;

namespace {

struct Crowd {
  Crowd(int n, double length, double gap) {
    for (int k = 0; k < 3; ++k) box.lengths[k] = length;
    box.sides.fill(Boundary::periodic);
    std::mt19937 random(1);
    std::uniform_real_distribution<double> place(0, length), size(0.3, 0.5);
    for (int i = 0; i < n; ++i) radius.push_back(size(random));
    for (int k = 0; k < 3 * n; ++k) position.push_back(place(random));
    pairs = pairs_closer_than(Spheres<3>{position, radius, box}, gap);
  }
  Box<3> box;
  std::vector<double> position, radius;
  std::vector<Pair> pairs;
};

template <class Law>
bool compare(const char* name, const Law& law, const Crowd& crowd) {
  using parallel::Array;
  using parallel::CudaExecutor;
  const int n = static_cast<int>(crowd.radius.size());
  std::vector<double> expected(crowd.position.size());
  const PairSum sum = add_pair_forces(law, Spheres<3>{crowd.position, crowd.radius, crowd.box}, crowd.pairs, expected,
                                      parallel::Team::single());
  const CudaExecutor run;
  Array<double, CudaExecutor> position(run), radius(run), force(run), energy(run);
  position.upload(crowd.position);
  radius.upload(crowd.radius);
  force.resize(3 * n);
  energy.resize(n);
  PartnerTable<CudaExecutor> table(run);
  table.set(crowd.pairs, n);
  const DeviceSpheres<3> spheres{n, position.data(), radius.data(), nullptr, crowd.box};
  const auto once = [&] {
    force.zero();
    energy.zero();
    add_pair_forces(run, law, spheres, table, force.data(), energy.data());
    return force.download();
  };
  const std::vector<double> found = once(), again = once();
  double worst = 0, largest = 0, total = 0;
  for (int k = 0; k < 3 * n; ++k) {
    worst = std::max(worst, std::abs(found[k] - expected[k]));
    largest = std::max(largest, std::abs(expected[k]));
  }
  for (const double e : energy.download()) total += e;
  const double seconds = run.seconds([&] {
    for (int k = 0; k < 10; ++k) add_pair_forces(run, law, spheres, table, force.data(), energy.data());
  });
  std::printf("%-18s %9zu pairs %8.1f us  force %.1e of the largest, energy %.1e, %s\n", name, crowd.pairs.size(),
              1e5 * seconds, worst / largest, std::abs(total / sum.energy - 1),
              found == again ? "the same bits again" : "OTHER BITS");
  // Some hundred terms in another order, each rounded at 1e-16 of the largest.
  return worst < 1e-13 * largest && std::abs(total / sum.energy - 1) < 1e-12 && found == again;
}

}  // namespace

int main() {
  try {
    const Crowd contacts(100000, 45, 0.05), charges(100000, 88, 3);
    const bool hertz = compare("Hertz", effects::HertzLaw{2}, contacts);
    const bool coulomb = compare("screened Coulomb", ScreenedCoulombLaw{1, 1.5, 3}, charges);
    return hertz && coulomb ? 0 : 1;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "device_pairs: %s\n", error.what());
    return 1;
  }
}
