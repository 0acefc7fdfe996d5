#pragma once

#include <algorithm>
#include <vector>

#include "solvers/laplace/cutcell/agglomerates.hpp"
#include "solvers/laplace/cutcell/coarse.hpp"
#include "solvers/laplace/cutcell/device/clustering.hpp"
#include "solvers/laplace/cutcell/device/coarsest_system.hpp"
#include "solvers/laplace/cutcell/device/cycle.hpp"
#include "solvers/laplace/problem.hpp"

namespace lichtenberg::laplace::device {

/// Dense matrix of the coarsest grid's system and its inverse, as device pointers. The unknowns are cells by slot
/// (memory index), then groups (bodies with one potential).
struct CoarsestView {
  /// By slot and then by group, with one more at the end: number of unknowns before it.
  int* index;
  /// By unknown: the slot of its cell, or -1 - group.
  int* unknown;
  /// Matrix by rows.
  double* matrix;
  /// Inverse by rows in single precision; null if `precise_inverse` is used.
  float* inverse;
  /// Inverse by rows in double precision; null if `inverse` is used.
  double* precise_inverse;
  /// Becomes 1 if a pivot is not positive.
  int* is_singular;
  /// Partial sums over chunks of a group's links, by row, chunk and column.
  double* chunk;
  /// Scratch memory of invert_in_panels().
  double* scratch;

  /// Number of chunks of a group's links, summed in parallel: a group of a thousand conductors has four thousand links.
  static constexpr int chunks = 32;
  /// Returns the partial sums of row a and chunk c in a system of n unknowns.
  LICHTENBERG_HOST_DEVICE double* chunk_of_row(int a, int c, int n) const { return chunk + (a * chunks + c) * n; }
};

/// Numbers the unknowns of the coarsest grid: fluid cells, then groups (bodies with one potential) that have an unknown
/// on it. Reports the required number; if it exceeds the capacity, the number of unknowns becomes zero.
template <class Executor>
void number_coarsest(const Executor& run, ProblemView problem, GridView grid, CoarsestView coarsest) {
  const int slots = static_cast<int>(grid.layout.size()), all = slots + problem.groups;
  run.for_each(all + 1, [=] LICHTENBERG_HOST_DEVICE(int k) {
    coarsest.index[k] = k == all    ? 0
                        : k < slots ? grid.cells.inverse_diagonal[k] > 0
                                    : grid.groups.diagonal[k - slots] > 0;
  });
  run.exclusive_scan(coarsest.index, all + 1);
  run.for_each(all, [=] LICHTENBERG_HOST_DEVICE(int k) {
    const int count = coarsest.index[all], capacity = grid.capacity[Items::coarse_unknowns], at = coarsest.index[k];
    if (k == 0) {
      *coarsest.is_singular = 0;
      grid.required[Items::coarse_unknowns] = count;
      grid.number[Items::coarse_unknowns] = count <= capacity ? count : 0;
    }
    if (count <= capacity && coarsest.index[k + 1] > at) coarsest.unknown[at] = k < slots ? k : -1 - (k - slots);
  });
}

/// One thread's share of a matrix row: the columns whose number is `lane` modulo `lanes`.
struct RowShare {
  static constexpr int lanes = 32;
  double* entry;
  int lane;
  /// Adds a value to the entry if this thread owns the column.
  LICHTENBERG_HOST_DEVICE void add(int column, double value) const {
    if (column % lanes == lane) entry[column] += value;
  }
};

/// Adds the couplings (lumped capacitances) of group g to row `a` of the coarsest grid's matrix, within the bounds of
/// agglomerates.hpp. `slots`: number of cell entries in CoarsestView::index before those of the groups. A group is a
/// set of bodies with one potential.
LICHTENBERG_HOST_DEVICE inline void couple_in_row(const ProblemView& problem, const CoarsestView& coarsest, int g,
                                                  int slots, int a, RowShare row) {
  const CouplingView& couplings = problem.couplings;
  for (int k = couplings.start[g]; k < couplings.start[g + 1]; ++k) {
    const int other = couplings.other[k], b = coarsest.index[slots + other];
    const bool is_given = !problem.floating[other];
    if (!is_given && coarsest.index[slots + other + 1] == b) continue;  // absorbed
    double c = couplings.conductance[k] < largest_coarse_coupling ? couplings.conductance[k] : largest_coarse_coupling;
    if (is_given && couplings.only_ground && c < least_only_ground) c = least_only_ground;
    row.add(a, c);
    if (!is_given) row.add(b, -c);
  }
}

/// Sums the conductances of one chunk of a group's links to cells, in the columns of thread `lane` (RowShare). The
/// group (bodies with one potential) is the unknown of row `a`; for a cell's row the function does nothing.
LICHTENBERG_HOST_DEVICE inline void add_chunk_of_links(const ProblemView& problem, const GridView& grid,
                                                       const CoarsestView& coarsest, int a, int chunk, int lane) {
  const int n = grid.number[Items::coarse_unknowns];
  if (a >= n || coarsest.unknown[a] >= 0) return;
  const int g = -1 - coarsest.unknown[a];
  const RowShare sum{coarsest.chunk_of_row(a, chunk, n), lane};
  for (int b = lane; b < n; b += RowShare::lanes) sum.entry[b] = 0;
  const int first = grid.link_start(problem.first_rank[g]);
  const long links = grid.link_start(problem.first_rank[g + 1]) - first;
  const auto cut = [&](int c) { return first + static_cast<int>(links * c / CoarsestView::chunks); };
  for (int link = cut(chunk); link < cut(chunk + 1); ++link)
    sum.add(coarsest.index[grid.links.slot[link]], grid.links.conductance[link]);
}

/// Computes the dense matrix of the coarsest grid. One thread fills the part of a cell's row with columns of cells.
/// Several threads fill a group's row and, by symmetry, the group's column. Sums are always in the same order. A group
/// is a set of bodies with one potential.
template <class Executor>
void fill_coarsest(const Executor& run, ProblemView problem, GridView grid, CoarsestView coarsest) {
  const int slots = static_cast<int>(grid.layout.size());
  const int capacity = grid.capacity[Items::coarse_unknowns];
  constexpr int lanes = RowShare::lanes;
  run.fill(coarsest.matrix, 0, static_cast<std::size_t>(capacity) * capacity * sizeof(double));
  run.for_each(capacity, [=] LICHTENBERG_HOST_DEVICE(int a) {
    const int n = grid.number[Items::coarse_unknowns];
    if (a >= n || coarsest.unknown[a] < 0) return;
    const int slot = coarsest.unknown[a];
    const CellIndex cell = cell_of(grid.layout, slot);
    coarsest.matrix[a * n + a] = 1.0 / grid.cells.inverse_diagonal[slot];
    for (int side = 0; side < 4; ++side) {
      const int i = cell.i + step_i(side), j = cell.j + step_j(side);
      if (!inside(grid.layout, i, j)) continue;
      const int next = slot_of(grid.layout, i, j);
      if (!(grid.cells.inverse_diagonal[next] > 0)) continue;
      const int face = side == 0 || side == 2 ? next : slot;
      coarsest.matrix[a * n + coarsest.index[next]] =
          !grid.has_medium ? -1.0 : -(side < 2 ? grid.medium.east : grid.medium.north)[face];
    }
  });
  run.for_each(capacity * CoarsestView::chunks, lanes, [=] LICHTENBERG_HOST_DEVICE(int row, int lane) {
    add_chunk_of_links(problem, grid, coarsest, row / CoarsestView::chunks, row % CoarsestView::chunks, lane);
  });
  run.for_each(capacity, lanes, [=] LICHTENBERG_HOST_DEVICE(int a, int lane) {
    const int n = grid.number[Items::coarse_unknowns];
    if (a >= n || coarsest.unknown[a] >= 0) return;
    const int g = -1 - coarsest.unknown[a];
    const RowShare row{coarsest.matrix + a * n, lane};
    row.add(a, grid.groups.diagonal[g]);
    for (int b = lane; b < n; b += lanes) {
      if (coarsest.unknown[b] < 0) continue;
      for (int chunk = 0; chunk < CoarsestView::chunks; ++chunk) row.entry[b] -= coarsest.chunk_of_row(a, chunk, n)[b];
      coarsest.matrix[b * n + a] = row.entry[b];
    }
    for (int k = 0; k < grid.direct_links_of(problem, g); ++k) {
      const DirectLink& link = grid.direct.link[grid.first_direct_link(problem, g) + k];
      if (link.is_to_electrode()) continue;
      const int other = slots + problem.group_of[link.other], b = coarsest.index[other];
      if (coarsest.index[other + 1] > b) row.add(b, -link.conductance);
    }
    if (problem.couplings.start) couple_in_row(problem, coarsest, g, slots, a, row);
  });
}

/// Inverts an n x n matrix (by rows) in the memory of one thread block, by Gauss-Jordan elimination without pivoting.
/// The matrix must be followed by 2 n entries of scratch memory. Sets *is_singular to 1 if a pivot is not positive.
template <class Block>
LICHTENBERG_HOST_DEVICE void invert_in_block(const Block& block, double* matrix, int n, int* is_singular) {
  double *row = matrix + n * n, *column = row + n;
  for (int k = 0; k < n; ++k) {
    block.each(n, [&](int a) {
      row[a] = matrix[k * n + a];
      column[a] = matrix[a * n + k];
      if (a == k && !(row[a] > 0)) *is_singular = 1;
    });
    block.each(n * n, [&](int e) {
      const int a = e / n, b = e % n;
      const double inverse_pivot = 1 / row[k];
      if (a == k)
        matrix[e] = b == k ? inverse_pivot : row[b] * inverse_pivot;
      else
        matrix[e] = b == k ? -column[a] * inverse_pivot : matrix[e] - column[a] * row[b] * inverse_pivot;
    });
  }
}

/// Inversion of the coarsest grid's matrix in the memory of one thread block, which must be large enough.
struct InvertCoarsest {
  GridView grid;
  CoarsestView coarsest;
  /// True if nothing is grounded. The last diagonal entry is then doubled, which fixes the potential of the last
  /// unknown.
  bool pin;

  /// Returns the block memory (bytes) for a system with this number of unknowns.
  static constexpr std::size_t bytes(std::size_t unknowns) { return (unknowns + 2) * unknowns * sizeof(double); }

  /// Computes the inverse matrix: in single precision, symmetric to the last bit, in `inverse`, or in double precision
  /// in `precise_inverse`.
  template <class Block>
  LICHTENBERG_HOST_DEVICE void operator()(const Block& block, int) const {
    const int n = grid.number[Items::coarse_unknowns];
    double* matrix = block.template memory<double>();
    block.each(n * n, [&](int e) { matrix[e] = coarsest.matrix[e] * (pin && e == n * n - 1 ? 2 : 1); });
    invert_in_block(block, matrix, n, coarsest.is_singular);
    if (!coarsest.inverse) {
      block.each(n * n, [&](int e) { coarsest.precise_inverse[e] = matrix[e]; });
      return;
    }
    block.each(n * n, [&](int e) {  // symmetric to the last bit
      coarsest.inverse[e] = static_cast<float>(0.5 * (matrix[e] + matrix[e % n * n + e / n]));
    });
  }
};

/// Inversion of a matrix too large for one block's memory, in place, by Gauss-Jordan elimination for panels of rows and
/// columns. A panel begins at row `from`. One thread block inverts the panel's diagonal square, and the whole device
/// updates the rest of the matrix.
struct Panel {
  static constexpr int width = 32;
  GridView grid;
  CoarsestView coarsest;
  int from;

  /// Returns the size of the scratch memory of the inversion (number of doubles).
  static constexpr std::size_t scratch(std::size_t unknowns) { return width * (2 * unknowns + width); }

  /// Returns the number of unknowns of the coarsest grid, the rows of the matrix.
  LICHTENBERG_HOST_DEVICE int all() const { return grid.number[Items::coarse_unknowns]; }
  /// Returns the number of rows of the panel (successive rows and columns that are eliminated together).
  LICHTENBERG_HOST_DEVICE int own() const { return all() - from < width ? all() - from : width; }
  /// Returns true if row a belongs to the panel (rows that are eliminated together).
  LICHTENBERG_HOST_DEVICE bool has(int a) const { return a >= from && a < from + width; }
  /// Returns a pointer to the matrix entry in row a and column b.
  LICHTENBERG_HOST_DEVICE double* entry(int a, int b) const {
    return coarsest.precise_inverse + static_cast<std::ptrdiff_t>(a) * all() + b;
  }
  /// Returns a pointer to the inverse of the square submatrix in which the rows of the panel (rows and columns that are
  /// eliminated together) cross its columns. It is stored by rows.
  LICHTENBERG_HOST_DEVICE double* square() const { return coarsest.scratch; }
  /// Returns a pointer to row p of the product of square() and the rows of the panel (rows that are eliminated
  /// together).
  LICHTENBERG_HOST_DEVICE double* row(int p) const { return square() + width * width + p * all(); }
  /// Returns a pointer to column p of the panel (columns that are eliminated together) before the elimination.
  LICHTENBERG_HOST_DEVICE double* column(int p) const { return row(width) + p * all(); }

  /// Inverts the square submatrix on the diagonal that belongs to the panel (rows and columns that are eliminated
  /// together). One thread block does so in its fast memory.
  template <class Block>
  LICHTENBERG_HOST_DEVICE void operator()(const Block& block, int) const {
    const int n = own();
    if (n <= 0) return;
    double* matrix = block.template memory<double>();
    block.each(n, n, [&](int a, int b) { matrix[a * n + b] = *entry(from + a, from + b); });
    invert_in_block(block, matrix, n, coarsest.is_singular);
    block.each(n, n, [&](int a, int b) { square()[a * width + b] = matrix[a * n + b]; });
  }
  static constexpr std::size_t bytes = (width + 2) * width * sizeof(double);

  /// Computes entry b of row(p) and of column(p).
  LICHTENBERG_HOST_DEVICE void take(int p, int b) const {
    if (p >= own() || b >= all()) return;
    double sum = 0;
    if (has(b))
      sum = square()[p * width + b - from];
    else
      for (int q = 0; q < own(); ++q) sum += square()[p * width + q] * *entry(from + q, b);
    row(p)[b] = sum;
    column(p)[b] = *entry(b, from + p);
  }
  /// Computes the matrix entry (a, b) after the elimination of the panel (a set of successive rows and columns).
  LICHTENBERG_HOST_DEVICE void eliminate(int a, int b) const {
    if (a >= all() || b >= all() || own() <= 0) return;
    if (has(a)) {
      *entry(a, b) = row(a - from)[b];
      return;
    }
    double sum = has(b) ? 0.0 : *entry(a, b);
    for (int p = 0; p < own(); ++p) sum -= column(p)[a] * row(p)[b];
    *entry(a, b) = sum;
  }
};

/// Computes the inverse in double precision of a matrix of at most `capacity` rows by Gauss-Jordan elimination in
/// panels. `pin`: nothing is grounded; the potential of the last unknown is then fixed.
template <class Executor>
void invert_in_panels(const Executor& run, GridView grid, CoarsestView coarsest, int capacity, bool pin) {
  run.for_each(capacity, capacity, [=] LICHTENBERG_HOST_DEVICE(int a, int b) {
    const int n = grid.number[Items::coarse_unknowns];
    if (a < n && b < n)
      coarsest.precise_inverse[a * n + b] = coarsest.matrix[a * n + b] * (pin && a == n - 1 && b == n - 1 ? 2 : 1);
  });
  for (int from = 0; from < capacity; from += Panel::width) {
    const Panel panel{grid, coarsest, from};
    run.template for_each_block<1024>(1, Panel::bytes, panel);
    run.for_each(Panel::width, capacity, [=] LICHTENBERG_HOST_DEVICE(int p, int b) { panel.take(p, b); });
    run.for_each(capacity, capacity, [=] LICHTENBERG_HOST_DEVICE(int a, int b) { panel.eliminate(a, b); });
  }
}

/// Direct solver of the coarsest grid's system. A small matrix is inverted on the device, and small_grids.hpp
/// multiplies with the inverse. The host factorizes a large matrix and takes part in each V-cycle, as for a grid with a
/// large odd number of cells.
template <class Executor>
class Coarsest {
 public:
  explicit Coarsest(const Executor& run) : run_(run), arrays_(run) {
    arrays_.resize(1, view().is_singular);
    arrays_.zero(view().is_singular);
  }

  /// Reserves memory for the matrix and its inverse, and decides whether the device or the host solves. `precise`: use
  /// double precision, because conductances may be very large.
  void reserve(const ProblemView& problem, const GridView& grid, bool precise) {
    const std::size_t capacity = grid.capacity[Items::coarse_unknowns];
    // The host factorizes larger systems. Beyond one block's memory the device keeps only systems with strong links,
    // which the host's solver cannot treat without cancellation.
    constexpr std::size_t most = 480;
    const std::size_t bytes = InvertCoarsest::bytes(capacity);
    block_bytes_ = bytes <= run_.most_block_memory() ? bytes : 0;
    on_device_ = block_bytes_ > 0 || (precise && capacity <= most);
    const bool in_double = precise || block_bytes_ == 0;
    const std::size_t entries = on_device_ ? capacity * capacity : 0;
    CoarsestView& coarsest = view();
    arrays_.resize(grid.layout.size() + problem.groups + 1, coarsest.index);
    arrays_.resize(capacity, coarsest.unknown);
    arrays_.resize(entries, coarsest.matrix);
    arrays_.resize(CoarsestView::chunks * entries, coarsest.chunk);
    arrays_.resize(on_device_ && block_bytes_ == 0 ? Panel::scratch(capacity) : 0, coarsest.scratch);
    coarsest.inverse = nullptr;
    coarsest.precise_inverse = nullptr;
    if (in_double)
      arrays_.resize(entries, coarsest.precise_inverse);
    else
      arrays_.resize(entries, coarsest.inverse);
  }
  /// Returns true if the device inverts the matrix; otherwise the host factorizes it.
  bool on_device() const { return on_device_; }
  /// Returns a device pointer to a value that is 1 if the inversion on the device met a pivot that is not positive,
  /// else 0.
  const int* is_singular() const { return view().is_singular; }

  /// Numbers the unknowns; on the device, also computes the matrix and its inverse.
  void build(const ProblemView& problem, const GridView& grid) {
    number_coarsest(run_, problem, grid, view());
    if (!on_device_) return;
    fill_coarsest(run_, problem, grid, view());
    if (block_bytes_ > 0)
      run_.template for_each_block<1024>(1, block_bytes_, InvertCoarsest{grid, view(), !problem.grounded});
    else
      invert_in_panels(run_, grid, view(), grid.capacity[Items::coarse_unknowns], !problem.grounded);
  }
  /// Factorizes the system on the host (sparse Cholesky factorization); for a matrix that the device does not invert.
  /// Throws Failure if the factorization fails. `numbers`: numbers of the grid's items.
  void factorize(const LaplaceProblem& problem, const GridView& grid, const Numbers& numbers) {
    solver_.factorize(assemble(download(problem, grid, numbers), !problem.has_ground()));
    phi_.resize(problem.groups.size());
  }

  /// Solves the coarsest grid's system on the host. The right-hand sides are the grid's `cycle.f` (of cells) and
  /// `cycle.charge` (of groups). Writes the potentials of fluid cells to `v` and those of groups to `cycle.phi`;
  /// entries without an unknown become 0. A group is a set of bodies with one potential.
  void solve(const GridView& grid, float* v) {
    const std::size_t cells = grid.layout.size();
    get(f_, grid.cycle.f, cells);
    get(charge_, grid.cycle.charge, phi_.size());
    v_.assign(cells, 0.0f);
    std::fill(phi_.begin(), phi_.end(), 0.0f);
    solver_.solve(f_.data(), charge_.data(), v_.data(), phi_.data());
    run_.to_device(v, v_.data(), cells * sizeof(float));
    if (!phi_.empty()) run_.to_device(grid.cycle.phi, phi_.data(), phi_.size() * sizeof(float));
  }
  /// Returns a device pointer: by unknown, the slot (memory index) of its cell or -1 - group (bodies with one
  /// potential).
  const int* unknown() const { return view().unknown; }
  /// Returns a device pointer to the inverse matrix by rows in single precision, or null.
  const float* inverse() const { return view().inverse; }
  /// Returns a device pointer to the inverse matrix by rows in double precision, or null.
  const double* precise_inverse() const { return view().precise_inverse; }

 private:
  CoarsestView& view() { return arrays_.view; }
  const CoarsestView& view() const { return arrays_.view; }
  CoarsestArrays download(const LaplaceProblem& problem, const GridView& grid, const Numbers& numbers) {
    CoarsestArrays arrays;
    arrays.layout = grid.layout;
    const std::size_t size = grid.layout.size(), groups = problem.groups.size();
    get(arrays.inverse_diagonal, grid.cells.inverse_diagonal, size);
    if (grid.has_medium) {
      get(arrays.east, grid.medium.east, size);
      get(arrays.north, grid.medium.north, size);
    }
    get(arrays.link_slot, grid.links.slot, numbers[Items::links]);
    get(arrays.link_group, grid.links.group, numbers[Items::links]);
    get(arrays.conductance, grid.links.conductance, numbers[Items::links]);
    get(arrays.group_diagonal, grid.groups.diagonal, groups);
    std::vector<DirectLink> direct_links;
    get(direct_links, grid.direct.link, numbers[Items::direct_links]);
    for (const DirectLink& link : direct_links)
      if (!link.is_to_electrode())
        arrays.direct_links.push_back(
            {problem.bodies[link.own].group, problem.bodies[link.other].group, link.conductance});
    GroupNetwork network{.diagonal = arrays.group_diagonal};
    couple(problem, largest_coarse_coupling, least_in_cycle(problem), network);
    for (const auto& [a, b, conductance] : network.couplings) {
      arrays.direct_links.push_back({std::min(a, b), std::max(a, b), conductance});
      for (const int g : {a, b}) arrays.group_diagonal[g] += conductance;
    }
    for (std::size_t g = 0; g < groups; ++g) arrays.group_diagonal[g] += network.hold[g];
    return arrays;
  }

  template <class T>
  void get(std::vector<T>& to, const T* from, std::size_t size) {
    to.resize(size);
    if (size > 0) run_.to_host(to.data(), from, size * sizeof(T));
  }

  const Executor& run_;
  bool on_device_ = true;
  std::size_t block_bytes_ = 0;  // 0: the elimination is in the device's memory
  parallel::Arrays<CoarsestView, Executor> arrays_;
  CoarseSolver solver_;
  std::vector<float> f_, charge_, v_, phi_;
};

}  // namespace lichtenberg::laplace::device
