#pragma once

// Near part on an executor: each charge adds up the fields of its partners within the cut-off.

#include <cmath>
#include <type_traits>

#include "solvers/neighbours/table.hpp"
#include "solvers/periodic/device/tables.hpp"

namespace lichtenberg::periodic::device {

/// Position and charge of a source on the device. The unit of charge is a power of two, at least the largest charge.
struct alignas(16) PointCharge {
  FixedPointPosition at;
  float charge = 0;
};

/// Dipole moment of a source, in the unit of charge times a length.
struct alignas(16) Moment {
  float x = 0, y = 0, z = 0, unused = 0;
};

/// Field and potential at a source.
struct alignas(16) FieldSample {
  float x = 0, y = 0, z = 0, potential = 0;
};

/// Exact accumulator of field and potential. Addends are multiples of 2^-31, so that sums up to 2^22 are exact. Results
/// therefore do not depend on the order of neighbour lists and threads.
struct FieldSum {
  double x = 0, y = 0, z = 0, potential = 0;

  LICHTENBERG_HOST_DEVICE FieldSum& operator+=(const FieldSum& other) {
    x += other.x, y += other.y, z += other.z, potential += other.potential;
    return *this;
  }
  friend LICHTENBERG_HOST_DEVICE FieldSum operator+(FieldSum a, const FieldSum& b) { return a += b; }
};

/// Rounds a number for exact sums. The result is a multiple of 2^-31, and for magnitudes below 2^-8 of 2^-30.
LICHTENBERG_HOST_DEVICE inline float on_grid(float value) {
  constexpr float shift = 0x1.8p-7f;
  return (value + shift) - shift;
}

/// Computes 1 / sqrt(value).
LICHTENBERG_HOST_DEVICE inline float reciprocal_root(float value) {
#ifdef __CUDA_ARCH__
  return rsqrtf(value);
#else
  return 1 / std::sqrt(value);
#endif
}

/// Near pair of two sources: the vector (x, y, z) from the source at `from` to the source at `at`, and the near kernels
/// B_first to B_last (../near_kernels.hpp). `near` is true within the cut-off.
template <int terms, int first, int last>
struct NearPair {
  float x, y, z;
  float b[4][1];
  bool near;

  LICHTENBERG_HOST_DEVICE NearPair(const NearTable& table, const FixedPointPosition& at, const FixedPointPosition& from)
      : x(table.length[0] * nearest_difference(at.x, from.x)),
        y(table.length[1] * nearest_difference(at.y, from.y)),
        z(table.length[2] * nearest_difference(at.z, from.z)) {
    const float r2[1] = {x * x + y * y + z * z}, over[1] = {reciprocal_root(r2[0])};
    near = r2[0] < table.cutoff2;
    screened<first, last>(table.kernels, std::integral_constant<int, terms>{}, r2, over, b);
  }
  LICHTENBERG_HOST_DEVICE float kernel(int k) const { return b[k][0]; }
  LICHTENBERG_HOST_DEVICE float along(const Moment& m) const { return m.x * x + m.y * y + m.z * z; }
};

/// Computes the near part of field and potential of the charge `from` at the charge `at`; 0 beyond the cut-off. The
/// potential is 0 unless the template argument `potential` is true.
template <int terms, bool potential>
LICHTENBERG_HOST_DEVICE FieldSum near_charge_field(const NearTable& table, const PointCharge& at,
                                                   const PointCharge& from) {
  const NearPair<terms, potential ? 0 : 1, 1> pair(table, at.at, from.at);
  const float charge = pair.near ? from.charge : 0;
  const float field = charge * pair.kernel(1);
  FieldSum sum{on_grid(field * pair.x), on_grid(field * pair.y), on_grid(field * pair.z), 0};
  if constexpr (potential) sum.potential = on_grid(charge * pair.kernel(0));
  return sum;
}

/// Exact accumulator of field, potential and force at a source (see FieldSum).
struct ForceSum {
  FieldSum field;
  double x = 0, y = 0, z = 0;

  LICHTENBERG_HOST_DEVICE ForceSum& operator+=(const ForceSum& other) {
    field += other.field, x += other.x, y += other.y, z += other.z;
    return *this;
  }
  friend LICHTENBERG_HOST_DEVICE ForceSum operator+(ForceSum a, const ForceSum& b) { return a += b; }
};

/// Computes the near part of the field of the dipole `moment` of source `from` at the source `at`; 0 beyond the
/// cut-off.
template <int terms>
LICHTENBERG_HOST_DEVICE FieldSum near_field(const NearTable& table, const PointCharge& at, const PointCharge& from,
                                            const Moment& moment) {
  const NearPair<terms, 1, 2> b(table, at.at, from.at);
  if (!b.near) return {};
  const float along = b.along(moment) * b.kernel(2);
  return {on_grid(along * b.x - moment.x * b.kernel(1)), on_grid(along * b.y - moment.y * b.kernel(1)),
          on_grid(along * b.z - moment.z * b.kernel(1)), 0};
}

/// Computes the near part of field and potential of the charge `from` with its dipole `moment` at the source `at`. Also
/// computes the force on that source, which has the dipole `mine`: (q + mu.grad) of the field. All are 0 beyond the
/// cut-off.
template <int terms>
LICHTENBERG_HOST_DEVICE ForceSum near_force(const NearTable& table, const PointCharge& at, const Moment& mine,
                                            const PointCharge& from, const Moment& moment) {
  const NearPair<terms, 0, 3> b(table, at.at, from.at);
  if (!b.near) return {};
  const float q = from.charge, along = b.along(moment), my_along = b.along(mine);
  const float both = mine.x * moment.x + mine.y * moment.y + mine.z * moment.z;
  const float radial = q * b.kernel(1) + along * b.kernel(2);  // Factor of the field's radial part
  const float ex = radial * b.x - moment.x * b.kernel(1), ey = radial * b.y - moment.y * b.kernel(1),
              ez = radial * b.z - moment.z * b.kernel(1);
  const float slope = (both - q * my_along) * b.kernel(2) - along * my_along * b.kernel(3);
  const float across = my_along * b.kernel(2);
  return {{on_grid(ex), on_grid(ey), on_grid(ez), on_grid(q * b.kernel(0) + along * b.kernel(1))},
          on_grid(at.charge * ex + radial * mine.x + across * moment.x + slope * b.x),
          on_grid(at.charge * ey + radial * mine.y + across * moment.y + slope * b.y),
          on_grid(at.charge * ez + radial * mine.z + across * moment.z + slope * b.z)};
}

/// Rounds a sum to single precision.
LICHTENBERG_HOST_DEVICE inline FieldSample rounded(const FieldSum& sum) {
  return {static_cast<float>(sum.x), static_cast<float>(sum.y), static_cast<float>(sum.z),
          static_cast<float>(sum.potential)};
}

/// Calls work.operator()<n>() with the smallest compiled number n of polynomial terms that is at least `terms`.
template <class Work>
void with_terms(int terms, Work&& work) {
  if (terms <= 9)
    work.template operator()<9>();
  else if (terms <= 13)
    work.template operator()<13>();
  else
    work.template operator()<most_terms>();
}

/// Arrays of the near part in device memory: sources and their partners, and the fields and forces to overwrite;
/// `moments` and `force` only with dipoles. The fields are those at n sources, from `first` on.
struct NearArrays {
  int n;
  TableView partners;
  const PointCharge* charges;
  const Moment* moments;
  FieldSample *field_at_source, *force;
  int first = 0;
};

/// Accumulator of the near part for a kind of sources: with force for charges with dipoles, otherwise without.
template <Kind kind>
using NearSum = std::conditional_t<kind == Kind::multipoles, ForceSum, FieldSum>;

/// Computes the contribution of partner j to field, potential and force at source s.
template <Kind kind, bool potential, int terms>
LICHTENBERG_HOST_DEVICE NearSum<kind> near_part(const NearTable& table, const NearArrays& of, int s, int j) {
  if constexpr (kind == Kind::charges)
    return near_charge_field<terms, potential>(table, of.charges[s], of.charges[j]);
  else if constexpr (kind == Kind::dipoles)
    return near_field<terms>(table, of.charges[s], of.charges[j], of.moments[j]);
  else
    return near_force<terms>(table, of.charges[s], of.moments[s], of.charges[j], of.moments[j]);
}
/// Stores the sums of source s, rounded to single precision, in the arrays of `to`.
LICHTENBERG_HOST_DEVICE inline void store(const NearArrays& to, int s, const FieldSum& sum) {
  to.field_at_source[s] = rounded(sum);
}
LICHTENBERG_HOST_DEVICE inline void store(const NearArrays& to, int s, const ForceSum& sum) {
  to.field_at_source[s] = rounded(sum.field);
  to.force[s] = rounded({sum.x, sum.y, sum.z, 0});
}

/// Computes the near part of all sources with a compiled number of polynomial terms.
template <Kind kind, bool potential, int terms, class Executor>
void sum_near(const Executor& run, const NearTable& table, const NearArrays& arrays) {
  run.template sum_segments<8>(
      arrays.n,
      [=] LICHTENBERG_HOST_DEVICE(int k) {
        return arrays.partners.end(arrays.first + k) - arrays.partners.begin(arrays.first + k);
      },
      [=] LICHTENBERG_HOST_DEVICE(int k, int t) {
        const int s = arrays.first + k;
        const int j = arrays.partners.partner[arrays.partners.begin(s) + t];
        return near_part<kind, potential, terms>(table, arrays, s, j);
      },
      [=] LICHTENBERG_HOST_DEVICE(int k, NearSum<kind> sum) { store(arrays, arrays.first + k, sum); });
}

/// Computes the near part (real-space sum) of charges, dipoles alone, or both, over neighbour lists; overwrites the
/// results in `arrays`. Partners beyond the cut-off do not change the result. Without `potentials`, the potentials of
/// charges without dipoles are 0.
template <Kind kind, class Executor>
void compute_near(const Executor& run, const NearTable& table, const NearArrays& arrays, bool potentials = true) {
  with_terms(table.kernels.terms, [&]<int terms>() {
    if (potentials || kind != Kind::charges)
      sum_near<kind, true, terms>(run, table, arrays);
    else
      sum_near<kind, kind != Kind::charges, terms>(run, table, arrays);
  });
}

}  // namespace lichtenberg::periodic::device
