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

/// The dipole that goes with a charge, in that unit times a length.
struct alignas(16) Moment {
  float x = 0, y = 0, z = 0, unused = 0;
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

/// Field, potential, and the force on who feels them, while they are added up: as FeltSum.
struct ForceSum {
  FeltSum felt;
  double x = 0, y = 0, z = 0;

  LICHTENBERG_HOST_DEVICE ForceSum& operator+=(const ForceSum& other) {
    felt += other.felt, x += other.x, y += other.y, z += other.z;
    return *this;
  }
  friend LICHTENBERG_HOST_DEVICE ForceSum operator+(ForceSum a, const ForceSum& b) { return a += b; }
};

/// What turns the polynomials into B_1 ... B_3.
template <int terms>
struct Screened {
  float x, y, z;
  float value = 0, first = 0, second = 0, third = 0, over = 0;
  bool near;

  LICHTENBERG_HOST_DEVICE Screened(const MultipoleTable& table, const Turns& at, const Turns& from, bool all)
      : x(table.charges.length[0] * apart(at.x, from.x)),
        y(table.charges.length[1] * apart(at.y, from.y)),
        z(table.charges.length[2] * apart(at.z, from.z)) {
    const float r2 = x * x + y * y + z * z, turned = table.charges.turn * r2 - 1;
    near = r2 < table.charges.cutoff2;
    over = reciprocal_root(r2);
    LICHTENBERG_UNROLL(20)
    for (int n = terms - 1; n >= 0; --n) {
      first = first * turned + table.charges.slope[n];
      second = second * turned + table.second[n];
      if (all) value = value * turned + table.charges.value[n], third = third * turned + table.third[n];
    }
    const float over2 = over * over, over3 = over2 * over;
    first += over3, second += 3 * over3 * over2, third += 15 * over3 * over2 * over2;
    value = over - value;
  }
  LICHTENBERG_HOST_DEVICE float along(const Moment& m) const { return m.x * x + m.y * y + m.z * z; }
};

/// The field of a dipole at another's place.
template <int terms>
LICHTENBERG_HOST_DEVICE FeltSum near_field(const MultipoleTable& table, const Charged& at, const Charged& from,
                                           const Moment& moment) {
  const Screened<terms> b(table, at.at, from.at, false);
  if (!b.near) return {};
  const float along = b.along(moment) * b.second;
  return {on_grid(along * b.x - moment.x * b.first), on_grid(along * b.y - moment.y * b.first),
          on_grid(along * b.z - moment.z * b.first), 0};
}

/// What a charge with its dipole does to another with its own: field, potential, and (q + mu.grad) of the field.
template <int terms>
LICHTENBERG_HOST_DEVICE ForceSum near_force(const MultipoleTable& table, const Charged& at, const Moment& mine,
                                            const Charged& from, const Moment& moment) {
  const Screened<terms> b(table, at.at, from.at, true);
  if (!b.near) return {};
  const float q = from.charge, along = b.along(moment), my_along = b.along(mine);
  const float both = mine.x * moment.x + mine.y * moment.y + mine.z * moment.z;
  const float radial = q * b.first + along * b.second;  // of the field, beside its part along the dipole
  const float ex = radial * b.x - moment.x * b.first, ey = radial * b.y - moment.y * b.first,
              ez = radial * b.z - moment.z * b.first;
  const float slope = (both - q * my_along) * b.second - along * my_along * b.third;
  const float across = my_along * b.second;
  return {{on_grid(ex), on_grid(ey), on_grid(ez), on_grid(q * b.value + along * b.first)},
          on_grid(at.charge * ex + radial * mine.x + across * moment.x + slope * b.x),
          on_grid(at.charge * ey + radial * mine.y + across * moment.y + slope * b.y),
          on_grid(at.charge * ez + radial * mine.z + across * moment.z + slope * b.z)};
}

LICHTENBERG_HOST_DEVICE inline Felt rounded(const FeltSum& sum) {
  return {static_cast<float>(sum.x), static_cast<float>(sum.y), static_cast<float>(sum.z),
          static_cast<float>(sum.potential)};
}

/// work(number of terms as a constant).
template <class Work>
void with_terms(int terms, Work&& work) {
  if (terms <= 9)
    work.template operator()<9>();
  else if (terms <= 13)
    work.template operator()<13>();
  else
    work.template operator()<most_terms>();
}

template <int terms, class Executor>
void add_near_field(const Executor& run, int n, const MultipoleTable& table, const TableView& partners,
                    const Charged* charges, const Moment* moments, Felt* field) {
  run.template sum_segments<8>(
      n, [=] LICHTENBERG_HOST_DEVICE(int s) { return partners.end(s) - partners.begin(s); },
      [=] LICHTENBERG_HOST_DEVICE(int s, int t) {
        const int j = partners.partner[partners.begin(s) + t];
        return near_field<terms>(table, charges[s], charges[j], moments[j]);
      },
      [=] LICHTENBERG_HOST_DEVICE(int s, FeltSum sum) { field[s] = rounded(sum); });
}
template <int terms, class Executor>
void add_near_force(const Executor& run, int n, const MultipoleTable& table, const TableView& partners,
                    const Charged* charges, const Moment* moments, Felt* felt, Felt* force) {
  run.template sum_segments<8>(
      n, [=] LICHTENBERG_HOST_DEVICE(int s) { return partners.end(s) - partners.begin(s); },
      [=] LICHTENBERG_HOST_DEVICE(int s, int t) {
        const int j = partners.partner[partners.begin(s) + t];
        return near_force<terms>(table, charges[s], moments[s], charges[j], moments[j]);
      },
      [=] LICHTENBERG_HOST_DEVICE(int s, ForceSum sum) {
        felt[s] = rounded(sum.felt);
        force[s] = rounded({sum.x, sum.y, sum.z, 0});
      });
}

/// Overwrites `field` with that of near dipoles.
template <class Executor>
void compute_near_field(const Executor& run, int n, const MultipoleTable& table, const TableView& partners,
                        const Charged* charges, const Moment* moments, Felt* field) {
  with_terms(table.charges.terms,
             [&]<int terms>() { add_near_field<terms>(run, n, table, partners, charges, moments, field); });
}
/// Overwrites `felt` and `force` with what near charges and dipoles do.
template <class Executor>
void compute_near_force(const Executor& run, int n, const MultipoleTable& table, const TableView& partners,
                        const Charged* charges, const Moment* moments, Felt* felt, Felt* force) {
  with_terms(table.charges.terms,
             [&]<int terms>() { add_near_force<terms>(run, n, table, partners, charges, moments, felt, force); });
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
  with_terms(table.terms, with);
}

}  // namespace lichtenberg::periodic::device
