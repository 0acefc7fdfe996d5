#pragma once

#include <algorithm>
#include <vector>

#include "solvers/laplace/cutcell/layout.hpp"
#include "solvers/laplace/cutcell/slabs.hpp"
#include "solvers/parallel/team.hpp"

namespace lichtenberg::laplace {

/// Minimum number of a grid's cells per band (range of rows, task of a parallel loop), unless the whole grid is one
/// band. Waking the other threads takes less time than a loop over this many cells.
constexpr long cells_a_band = 8192;

/// Returns the number of bands (ranges of rows) into which a parallel loop over `rows` of a grid is divided.
inline int bands(const Layout& layout, Rows rows, const parallel::Team& team) {
  constexpr int rows_a_band = 16;  // sufficient for the stages of any wavefront
  const long most =
      std::min<long>(static_cast<long>(layout.nx) * rows.count() / cells_a_band, rows.count() / rows_a_band);
  return team.size() == 1 ? 1 : static_cast<int>(std::clamp<long>(most, 1, 4 * team.size()));
}

/// Calls row(j) for the given rows of the grid, in bands of rows on the threads of the team.
template <class Row>
void for_each_row(parallel::Team& team, const Layout& layout, Rows rows, const Row& row) {
  const int count = bands(layout, rows, team), n = rows.count();
  team.for_each(count, [&](int band) {
    for (int j = rows.begin + n * band / count; j < rows.begin + n * (band + 1) / count; ++j) row(j);
  });
}

/// Calls row(j) for all rows of the grid that this process owns, in bands of rows on the threads of the team.
template <class Row>
void for_each_row(parallel::Team& team, const Layout& layout, const Row& row) {
  for_each_row(team, layout, layout.own, row);
}

/// Runs several passes over a grid (stages) in one pass over memory, each one row behind the previous. Calls row(stage,
/// j) for stages 0 ... stages - 1 and all own rows. Stage s of row j comes after stage s - 1 of rows j - 1, j and j
/// + 1. It comes before stage s + 1 of these rows. Each band of rows first does the part that does not depend on other
/// bands. The triangles between bands follow. The last stage also runs on `more` ghost rows on either side. Each stage
/// before it runs on one row more, so that no exchange of ghost rows is necessary between the stages.
template <class Row>
void wavefront(parallel::Team& team, const Layout& layout, int stages, int more, const Row& row) {
  const Rows all = layout.extended(more + stages - 1);
  const int count = bands(layout, all, team);
  const auto first_row = [&](int band) { return all.begin + all.count() * band / count; };
  team.for_each(count, [&](int band) {
    const int from = first_row(band), to = first_row(band + 1);
    for (int j = from; j < to + stages - 1; ++j)
      for (int s = 0; s < stages; ++s) {
        const Rows ends = layout.extended(more + stages - 1 - s);
        const int low = from == all.begin ? ends.begin : from + s, high = to == all.end ? ends.end : to - s;
        if (j - s >= low && j - s < high) row(s, j - s);
      }
  });
  if (count == 1) return;
  team.for_each(count - 1, [&](int band) {
    const int at = first_row(band + 1);
    for (int s = 1; s < stages; ++s)
      for (int j = at - s; j < at + s; ++j) row(s, j);
  });
}

/// Returns the scalar product of a and b, n entries each, with 16 partial sums in vector registers if n is at least 16.
/// The partial sums start as the first products and are added pairwise, because zeroing and sequential addition would
/// dominate the cost of short rows.
template <class Real>
double row_dot(int n, const double* __restrict a, const Real* __restrict b) {
  constexpr int width = 16;
  double sum = 0;
  int k = 0;
  if (n >= width) {
    double part[width];
    for (int l = 0; l < width; ++l) part[l] = a[l] * static_cast<double>(b[l]);
    for (k = width; k + width <= n; k += width)
      for (int l = 0; l < width; ++l) part[l] += a[k + l] * static_cast<double>(b[k + l]);
    for (int half = width / 2; half > 0; half /= 2)
      for (int l = 0; l < half; ++l) part[l] += part[l + half];
    sum = part[0];
  }
  for (; k < n; ++k) sum += a[k] * static_cast<double>(b[k]);
  return sum;
}

/// Returns the sum of one value per row in the order of the rows, bitwise identical for any number of threads. If the
/// grid is divided among processes, own rows count and the sum is that of all processes.
inline double ordered_sum(const Layout& layout, const std::vector<double>& row_value) {
  double sum = 0;
  for (int j = layout.own.begin; j < layout.own.end; ++j) sum += row_value[j];
  return sum_over_slabs(layout, sum);
}

}  // namespace lichtenberg::laplace
