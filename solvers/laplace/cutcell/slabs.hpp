#pragma once

#include <cstddef>
#include <vector>

#include "solvers/laplace/cutcell/layout.hpp"

// Sums, ghost rows and lists of a grid whose rows are divided among MPI processes (slabs). All functions are collective
// over PETSC_COMM_WORLD if the grid is divided; otherwise they have no effect. Sums have the same bits in all
// processes.

namespace lichtenberg::laplace {

/// Adds n values over the processes, in place. `at`: layout of the grid to which the values belong.
void add_over_slabs(const Layout& at, double* values, std::ptrdiff_t n);
void add_over_slabs(const Layout& at, float* values, std::ptrdiff_t n);
/// Returns the sum of a value over the processes.
double sum_over_slabs(const Layout& at, double value);
/// Returns the largest of the processes' values.
double largest_of_slabs(const Layout& at, double value);

/// Adds sums over own rows to `sum` in all processes. `add(part)` adds this process's part to an array as long as
/// `sum`.
template <class Real, class Add>
void add_sums(const Layout& at, std::ptrdiff_t n, Real* sum, const Add& add) {
  if (!at.is_divided()) return add(sum);
  std::vector<Real> part(n, Real{0});
  add(part.data());
  add_over_slabs(at, part.data(), n);
  for (std::ptrdiff_t k = 0; k < n; ++k) sum[k] += part[k];
}

/// Copies the own rows of neighbouring processes to `rows` ghost rows of v (by slot, the memory index) on either side.
void exchange_ghosts(const Layout& at, double* v, int rows);
void exchange_ghosts(const Layout& at, float* v, int rows);

/// Copies rows of v (by slot, the memory index) that other processes have computed to all processes, for a grid `at`
/// that is not divided. `own`: rows that this process has computed; those of all processes make up the grid.
void gather_rows(const Layout& at, Rows own, float* v);

/// Returns the values of all rows of the grid from those of the own rows, in the first process or, if `everywhere` is
/// true, in all. Other processes get their own rows.
std::vector<double> gather_field(const Layout& at, std::vector<double> own, bool everywhere);
std::vector<int> gather_field(const Layout& at, std::vector<int> own, bool everywhere);

/// Concatenates the lists of all processes, in the order of the processes. `bytes`: the entries of this process.
std::vector<char> gather_bytes(const std::vector<char>& bytes);
/// Replaces a list by the concatenation of all processes' lists, in the order of the rows. `Entry` must be trivially
/// copyable.
template <class Entry>
void gather_list(const Layout& at, std::vector<Entry>& list) {
  if (!at.is_divided()) return;
  const char* first = reinterpret_cast<const char*>(list.data());
  const std::vector<char> all = gather_bytes({first, first + list.size() * sizeof(Entry)});
  const Entry* entries = reinterpret_cast<const Entry*>(all.data());
  list.assign(entries, entries + all.size() / sizeof(Entry));
}

}  // namespace lichtenberg::laplace
