#pragma once

// The loop over pairs of particles, for any law (pair_law.hpp), on an executor (solvers/parallel).

#include <cmath>
#include <span>
#include <vector>

#include "solvers/neighbours/pairs.hpp"
#include "solvers/neighbours/table.hpp"
#include "solvers/parallel/array.hpp"
#include "src/model/pair_law.hpp"

namespace lichtenberg {

/// Every particle's partners in ascending order, each pair from both its ends.
template <class Executor>
class PartnerTable {
 public:
  explicit PartnerTable(const Executor& run) : start_(run), partner_(run) {}

  /// `pairs`: in ascending order, of n particles.
  void set(std::span<const Pair> pairs, int n) {
    std::vector<int> start(n + 1, 0), partner(2 * pairs.size());
    for (const Pair pair : pairs) ++start[pair.i + 1], ++start[pair.j + 1];
    for (int i = 0; i < n; ++i) start[i + 1] += start[i];
    std::vector<int> next(start.begin(), start.end() - 1);
    for (const Pair pair : pairs) partner[next[pair.i]++] = pair.j, partner[next[pair.j]++] = pair.i;
    start_.upload(start);
    partner_.upload(partner);
  }
  TableView view() const { return {start_.data(), partner_.data()}; }

 private:
  parallel::Array<int, Executor> start_, partner_;
};

/// Spheres on a device.
template <int d>
struct DeviceSpheres {
  int count = 0;
  const double* position = nullptr;  ///< m, [N * d]
  const double* radius = nullptr;    ///< m, [N]
  const double* velocity = nullptr;  ///< m/s, [N * d]; for a law that is damped
  Box<d> box;
  const double* charge = nullptr;  ///< C, [N]; for a law that is charged
};

/// Calls use(PairForce, force over distance (N/m), vector from the partner (m)) for each partner of i within the law's
/// reach, in the order of the row.
template <int d, class Law, class Use>
LICHTENBERG_HOST_DEVICE void for_each_partner(const Law& law, const DeviceSpheres<d>& spheres,
                                              const NearestImage<d>& nearest, const TableView& partners, int i,
                                              const Use& use) {
  const double *p = spheres.position, *v = spheres.velocity;
  for (int e = partners.begin(i); e < partners.end(i); ++e) {
    const int j = partners.partner[e];
    Vec<d> apart;
    double approach = 0;
    for (int k = 0; k < d; ++k) {
      apart[k] = nearest(p[i * d + k] - p[j * d + k], k);
      if constexpr (Law::damped) approach -= apart[k] * (v[i * d + k] - v[j * d + k]);
    }
    const double distance = norm(apart), reach = law.reach(spheres.radius[i], spheres.radius[j]);
    if (!(distance < reach)) continue;
    PairSeen seen{distance, reach, spheres.radius[i], spheres.radius[j], approach / distance};
    if constexpr (NeedsCharges<Law>) seen.charge_i = spheres.charge[i], seen.charge_j = spheres.charge[j];
    const PairForce of = law(seen);
    use(of, over_distance<Law>(of, distance), apart);
  }
}

/// Adds each particle's force (N, [N * d]) and half its pairs' energies (in the law's units, [N]). One sum a particle,
/// over its partners in ascending order: the same bits each time. The law is computed twice a pair, which costs a
/// device less than to add at two places.
template <int d, class Law, class Executor>
void add_pair_forces(const Executor& run, const Law& law, const DeviceSpheres<d>& spheres,
                     const PartnerTable<Executor>& table, double* force, double* energy) {
  const TableView partners = table.view();
  const NearestImage<d> nearest(spheres.box);
  run.for_each(spheres.count, [=] LICHTENBERG_HOST_DEVICE(int i) {
    Vec<d> sum;
    double half = 0;
    for_each_partner(law, spheres, nearest, partners, i, [&](const PairForce& of, double over, const Vec<d>& apart) {
      sum += over * apart;
      half += 0.5 * of.energy;
    });
    for (int k = 0; k < d; ++k) force[i * d + k] += sum[k];
    energy[i] += half;
  });
}

}  // namespace lichtenberg
