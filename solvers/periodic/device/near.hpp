#pragma once

// The near part on an executor: each charge adds up what its partners within the cutoff do to it.

#include <cmath>

#include "solvers/neighbours/table.hpp"
#include "solvers/parallel/unroll.hpp"
#include "solvers/periodic/device/tables.hpp"

namespace lichtenberg::periodic::device {

/// A charge of a device: in units of a power of two not below the largest of all.
struct alignas(16) Charged {
  Turns at;
  float charge = 0;
};

/// Field and potential at a charge.
struct alignas(16) Felt {
  float x = 0, y = 0, z = 0, potential = 0;
};

/// The same while it is added up. Addends are multiples of 2^-31, so that the sum is exact up to 2^22 and its order
/// does not matter: neither lists nor threads show in its bits.
struct FeltSum {
  double x = 0, y = 0, z = 0, potential = 0;

  LICHTENBERG_HOST_DEVICE FeltSum& operator+=(const FeltSum& other) {
    x += other.x, y += other.y, z += other.z, potential += other.potential;
    return *this;
  }
  friend LICHTENBERG_HOST_DEVICE FeltSum operator+(FeltSum a, const FeltSum& b) { return a += b; }
};

/// Rounded to a multiple of 2^-31, small ones of 2^-30: from 2^-8 on any float is one.
LICHTENBERG_HOST_DEVICE inline float on_grid(float value) {
  constexpr float shift = 0x1.8p-7f;
  return (value + shift) - shift;
}

LICHTENBERG_HOST_DEVICE inline float reciprocal_root(float value) {
#ifdef __CUDA_ARCH__
  return rsqrtf(value);
#else
  return 1 / std::sqrt(value);
#endif
}

/// What the charge `from` does at `at`.
template <int terms, bool potential>
LICHTENBERG_HOST_DEVICE FeltSum near_felt(const NearTable& table, const Charged& at, const Charged& from) {
  const float x = table.length[0] * apart(at.at.x, from.at.x), y = table.length[1] * apart(at.at.y, from.at.y),
              z = table.length[2] * apart(at.at.z, from.at.z);
  const float r2 = x * x + y * y + z * z, turned = table.turn * r2 - 1;
  const float over = reciprocal_root(r2);
  float slope = table.slope[terms - 1], value = table.value[terms - 1];
  LICHTENBERG_UNROLL(20)
  for (int n = terms - 2; n >= 0; --n) {
    slope = slope * turned + table.slope[n];
    if constexpr (potential) value = value * turned + table.value[n];
  }
  const float charge = r2 < table.cutoff2 ? from.charge : 0;
  const float field = charge * (over * over * over + slope);
  FeltSum felt{on_grid(field * x), on_grid(field * y), on_grid(field * z), 0};
  if constexpr (potential) felt.potential = on_grid(charge * (over - value));
  return felt;
}

template <int terms, bool potential, class Executor>
void add_near(const Executor& run, int n, const NearTable& table, const TableView& partners, const Charged* charges,
              Felt* felt) {
  run.template sum_segments<8>(
      n, [=] LICHTENBERG_HOST_DEVICE(int s) { return partners.end(s) - partners.begin(s); },
      [=] LICHTENBERG_HOST_DEVICE(int s, int t) {
        return near_felt<terms, potential>(table, charges[s], charges[partners.partner[partners.begin(s) + t]]);
      },
      [=] LICHTENBERG_HOST_DEVICE(int s, FeltSum sum) {
        felt[s] = {static_cast<float>(sum.x), static_cast<float>(sum.y), static_cast<float>(sum.z),
                   static_cast<float>(sum.potential)};
      });
}

/// Overwrites `felt` with what near charges do. Partners beyond the cutoff change nothing.
template <class Executor>
void compute_near(const Executor& run, int n, const NearTable& table, bool potentials, const TableView& partners,
                  const Charged* charges, Felt* felt) {
  const auto with = [&]<int terms>() {
    potentials ? add_near<terms, true>(run, n, table, partners, charges, felt)
               : add_near<terms, false>(run, n, table, partners, charges, felt);
  };
  if (table.terms <= 9)
    with.template operator()<9>();
  else if (table.terms <= 13)
    with.template operator()<13>();
  else
    with.template operator()<most_terms>();
}

}  // namespace lichtenberg::periodic::device
