// Compares the pair loop of a force law (src/model/pair_part.hpp) on a CUDA device with the host's. Laws: Hertz contact
// and a screened Coulomb term of 1e5 spheres in a periodic cube. Fails unless they agree to rounding and repeated runs
// are bitwise identical.

#include <cstdio>
#include <random>

#include "solvers/parallel/cuda_executor.hpp"
#include "src/effects/hertz.hpp"
#include "src/model/pair_loop.hpp"
#include "src/model/pair_part.hpp"
#include "tests/partner_table.hpp"
#include "tests/screened_coulomb.hpp"

using namespace lichtenberg;

namespace {

struct RandomSpheres {
  RandomSpheres(int n, double length, double gap) {
    for (int k = 0; k < 3; ++k) box.lengths[k] = length;
    box.sides.fill(Boundary::periodic);
    std::mt19937 random(1);
    std::uniform_real_distribution<double> coordinate(0, length), size(0.3, 0.5);
    for (int i = 0; i < n; ++i) radius.push_back(size(random));
    for (int k = 0; k < 3 * n; ++k) position.push_back(coordinate(random));
    pairs = pairs_closer_than(Spheres<3>{position, radius, box}, gap);
  }
  Box<3> box;
  std::vector<double> position, radius;
  std::vector<Pair> pairs;
};

template <class Law>
bool compare(const char* name, const Law& law, const RandomSpheres& particles) {
  using parallel::Array;
  using parallel::CudaExecutor;
  const int n = static_cast<int>(particles.radius.size());
  std::vector<double> expected(particles.position.size());
  const PairSum sum = add_pair_forces(law, Spheres<3>{particles.position, particles.radius, particles.box},
                                      particles.pairs, expected, parallel::Team::single());
  const CudaExecutor run;
  Array<double, CudaExecutor> position(run), radius(run);
  Array<FixedPointVec, CudaExecutor> force(run);
  Array<std::int64_t, CudaExecutor> energy(run);
  position.upload(particles.position);
  radius.upload(particles.radius);
  force.resize(n);
  energy.resize(1);
  const PartnerTable<CudaExecutor> table(run, particles.pairs, n);
  DeviceGrains grains;
  grains.count = n, grains.box = particles.box, grains.partners = table.view();
  grains.position = reinterpret_cast<const Vec3*>(position.data()), grains.radius = radius.data();
  const PairPart<Law, CudaExecutor> part(run, law, {});
  const PairUnits quanta{0x1p-36, 0x1p-36};
  const auto once = [&] {
    force.zero();
    energy.zero();
    part.add_forces(grains, quanta, force.data(), energy.data());
    std::vector<double> sums;
    for (const FixedPointVec& fixed_point_force : force.download())
      for (int k = 0; k < 3; ++k) sums.push_back(fixed_point_force.times(quanta.force)[k]);
    return sums;
  };
  const std::vector<double> found = once(), again = once();
  double worst = 0, largest = 0;
  for (int k = 0; k < 3 * n; ++k) {
    worst = std::max(worst, std::abs(found[k] - expected[k]));
    largest = std::max(largest, std::abs(expected[k]));
  }
  const double total = quanta.energy * static_cast<double>(energy.download().front());
  const double seconds = run.seconds([&] {
    for (int k = 0; k < 10; ++k) part.add_forces(grains, quanta, force.data(), energy.data());
  });
  std::printf("%-18s %9zu pairs %8.1f us  force %.1e of the largest, energy %.1e, %s\n", name, particles.pairs.size(),
              1e5 * seconds, worst / largest, std::abs(total / sum.energy - 1),
              found == again ? "the same bits again" : "OTHER BITS");
  // About a hundred terms, each rounded to a quantum and to 1e-16 of the largest.
  return worst < 100 * quanta.force + 1e-13 * largest && std::abs(total / sum.energy - 1) < 1e-12 && found == again;
}

}  // namespace

int main() {
  try {
    const RandomSpheres contacts(100000, 45, 0.05), charges(100000, 88, 3);
    const bool hertz = compare("Hertz", effects::HertzLaw{2}, contacts);
    const bool coulomb = compare("screened Coulomb", ScreenedCoulombLaw{1, 1.5, 3}, charges);
    return hertz && coulomb ? 0 : 1;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "device_pairs: %s\n", error.what());
    return 1;
  }
}
