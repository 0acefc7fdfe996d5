#pragma once

// System of the finest grid in double precision, as operator.cpp, and the steps of a solve on it.

#include <cmath>

#include "solvers/laplace/cutcell/device/conductances.hpp"
#include "solvers/laplace/cutcell/device/conjugate_gradients.hpp"
#include "solvers/laplace/cutcell/device/cycle.hpp"

namespace lichtenberg::laplace::device {

/// Sums that determine the scale of the initial guess x (Iterations::set_guess_scale): b'x, x'A x without couplings
/// (lumped capacitances), largest |x|, and the couplings' part of x'A x.
struct GuessSums {
  double product = 0, energy = 0, largest = 0, coupling_part = 0;
  LICHTENBERG_HOST_DEVICE GuessSums& operator+=(const GuessSums& other) {
    product += other.product;
    energy += other.energy;
    coupling_part += other.coupling_part;
    largest = other.largest > largest ? other.largest : largest;
    return *this;
  }
};

/// Vectors of a solve on the device, by slot (memory index of a cell) and then by group, and the state of its
/// iterations. A group is a set of bodies with one potential.
struct SolveVectors {
  /// Number of entries of each vector.
  long size;
  /// Right-hand side; potentials, in units of the solver's potential unit.
  double *b, *x;
  /// Residual b - A x.
  double* r;
  /// Preconditioned residual z = M r.
  PreconditionedResidual z;
  /// Search direction; A p.
  double *p, *q;
  Iterations* iterations;
};

/// Calls finish(g, flux) for each group g (bodies with one potential) with its flux. The flux is the sum of conductance
/// times potential over its links to cells and its direct links (gaps) to floating groups. `cell`: function of a cell's
/// memory index (slot) that returns its potential; `group`: potentials by group.
template <class Executor, class Cell, class Finish>
void group_fluxes(const Executor& run, ProblemView problem, GridView grid, Cell cell, const double* group,
                  Finish finish) {
  sum_by_group(
      run, grid, links_by_group(problem, grid, grid.pieces.partial),
      [=] LICHTENBERG_HOST_DEVICE(int link) { return grid.links.conductance[link] * cell(grid.links.slot[link]); },
      DirectFluxes<double>{problem, grid, group}, finish);
}
template <class Executor, class Finish>
void group_fluxes(const Executor& run, ProblemView problem, GridView grid, const double* x, Finish finish) {
  group_fluxes(
      run, problem, grid, [=] LICHTENBERG_HOST_DEVICE(int slot) { return x[slot]; }, x + grid.layout.size(), finish);
}

/// Adds the fluxes of couplings (lumped capacitances) out of each group (bodies with one potential) to y. `x`, `y`: by
/// group. The flux that leaves one group enters the other to the last digit, however strong the coupling. Groups of
/// given potential have 0 in x.
template <class Executor>
void add_couplings(const Executor& run, ProblemView problem, const double* x, double* y) {
  const CouplingView couplings = problem.couplings;
  if (!couplings.start) return;
  run.template sum_segments<group_lanes>(
      problem.groups, [=] LICHTENBERG_HOST_DEVICE(int g) { return couplings.start[g + 1] - couplings.start[g]; },
      [=] LICHTENBERG_HOST_DEVICE(int g, int t) {
        const int k = couplings.start[g] + t;
        return couplings.conductance[k] * (x[g] - x[couplings.other[k]]);
      },
      [=] LICHTENBERG_HOST_DEVICE(int g, double sum) { y[g] += sum; });
}

/// Slot (memory index) of a grid and the cell (i, j) there, if the slot is not padding. Kernels run over `rows` times
/// `columns` slots, with both colours of a row in succession: neighbours are then read only once from memory.
struct Place {
  int slot, colour, row, column, i, j;
  bool is_cell;

  LICHTENBERG_HOST_DEVICE static int rows(const Layout& at) { return 2 * (at.ny + 2); }
  LICHTENBERG_HOST_DEVICE static int columns(const Layout& at) { return static_cast<int>(at.stride); }
  /// Returns the rows that this rank computes: of an undivided grid all, padding included.
  static Rows own_rows(const Layout& at) {
    return at.is_divided() ? Rows{2 * (at.own.begin + 1), 2 * (at.own.end + 1)} : Rows{0, rows(at)};
  }
  LICHTENBERG_HOST_DEVICE Place(const Layout& at, int row_of_colour, int column_)
      : colour(row_of_colour & 1), row(row_of_colour >> 1), column(column_) {
    slot = colour * static_cast<int>(at.colour_size()) + row * static_cast<int>(at.stride) + column;
    j = row - 1;
    i = 2 * (column - Layout::pad) + Layout::parity(colour, j);
    is_cell = column >= Layout::pad && inside(at, i, j);
  }
};

/// Returns the entry of A x of a cell, without couplings (lumped capacitances); 0 in a conductor. `Value`: double, or
/// the values of several vectors. `own`: x of the cell; `x`: function of a slot; `group`: function of a group.
template <class Value, class Cell, class Group>
LICHTENBERG_HOST_DEVICE Value field_row(const ProblemView& problem, const GridView& grid, const Place& at,
                                        const Value& own, Cell x, Group group) {
  const CellOwner owner = grid.cells.owner[at.slot];
  const Neighbours n = neighbours(grid.layout, at.colour, at.row, at.column);
  const Value around = x(n.west) + x(n.east) + x(n.south) + x(n.north);  // at once with the owner
  if (!owner.is_fluid()) return Value{};
  if (!owner.is_boundary_cell()) {
    const int diagonal = diagonal_without_links(problem, grid.layout, at.i, at.j);
    return diagonal > 0 ? static_cast<double>(diagonal) * own - around : Value{};
  }
  const int k = owner.boundary_number();
  Value value = grid.boundary.diagonal[k] * own - around;
  for (int side = 0; side < 4; ++side) {
    const int link = grid.boundary_link_of(k, side);
    if (link >= 0) value = value - grid.links.conductance[link] * group(grid.links.group[link]);
  }
  return value;
}

/// Entry of y = A x at a slot of the grid, without couplings (lumped capacitances). It stores and returns the entry.
struct ApplyToCell {
  ProblemView problem;
  GridView grid;
  const double* x;
  double* y;
  LICHTENBERG_HOST_DEVICE double operator()(const Place& at) const {
    const double *cell = x, *at_group = x + grid.layout.size();
    double value = 0;
    if (at.is_cell)
      value = field_row(
          problem, grid, at, x[at.slot], [=](int slot) { return cell[slot]; }, [=](int g) { return at_group[g]; });
    y[at.slot] = value;
    // The padding after the last row of each colour is 0, too.
    if (at.row == 0 && at.column < Layout::pad)
      y[at.colour * grid.layout.colour_size() + (grid.layout.ny + 2) * grid.layout.stride + at.column] = 0;
    return value;
  }
};

/// Computes the groups' entries of y = A x without couplings (lumped capacitances). A group is a set of bodies with one
/// potential. `cell`: function of a slot that returns x; `group`, `y`: by group.
template <class Executor, class Cell>
void apply_to_groups(const Executor& run, ProblemView problem, GridView grid, Cell cell, const double* group,
                     double* y) {
  group_fluxes(run, problem, grid, cell, group, [=] LICHTENBERG_HOST_DEVICE(int g, double sum) {
    const double diagonal = grid.groups.diagonal[g];
    y[g] = diagonal > 0 ? diagonal * group[g] - sum : 0.0;
  });
}

/// Calls finish(sum) with the sum of at_cell(Place) over all slots of the grid and of at_group(g) over all groups
/// (bodies with one potential).
template <class Executor, class OfCell, class OfGroup, class Finish>
void sum_of_entries(const Executor& run, ProblemView problem, GridView grid, OfCell at_cell, OfGroup at_group,
                    Finish finish) {
  using Sum = decltype(at_group(0));
  const int columns = Place::columns(grid.layout), groups = grid.layout.is_first() ? problem.groups : 0;
  const int first = Place::own_rows(grid.layout).begin, rows = Place::own_rows(grid.layout).count();
  const auto value = [=] LICHTENBERG_HOST_DEVICE(int row, int column) {
    if (row < rows) return at_cell(Place(grid.layout, first + row, column));
    const int g = (row - rows) * columns + column;
    return g < groups ? at_group(g) : Sum{};
  };
  const int all_rows = rows + (groups + columns - 1) / columns;
  if (!grid.layout.is_divided()) return run.sum(all_rows, columns, value, finish);
  Sum* mine = values_of_ranks<Sum>(grid) + run.rank();
  run.sum(all_rows, columns, value, [=] LICHTENBERG_HOST_DEVICE(const Sum& sum) { *mine = sum; });
  add_ranks<Sum>(run, grid, 1, [=] LICHTENBERG_HOST_DEVICE(int, const Sum& sum) { finish(sum); });
}

/// Computes the cells' part of y = A x without couplings (lumped capacitances), when the groups' part is complete.
/// Calls finish(sum) with the sum of value(k, y_k) over all entries k of y. A group is a set of bodies with one
/// potential.
template <class Executor, class Value, class Finish>
void apply_to_cells(const Executor& run, ProblemView problem, GridView grid, const double* x, double* y, Value value,
                    Finish finish) {
  const ApplyToCell apply{problem, grid, x, y};
  const int cells = static_cast<int>(grid.layout.size());
  sum_of_entries(
      run, problem, grid, [=] LICHTENBERG_HOST_DEVICE(const Place& at) { return value(at.slot, apply(at)); },
      [=] LICHTENBERG_HOST_DEVICE(int g) { return value(cells + g, y[cells + g]); }, finish);
}

/// Computes the groups' part of y = A x without couplings (lumped capacitances). A group is a set of bodies with one
/// potential.
template <class Executor>
void apply_to_groups(const Executor& run, ProblemView problem, GridView grid, const double* x, double* y) {
  const auto cells = grid.layout.size();
  apply_to_groups(
      run, problem, grid, [=] LICHTENBERG_HOST_DEVICE(int slot) { return x[slot]; }, x + cells, y + cells);
}

/// Computes y = A x, the matrix-free cut-cell system of the finest grid.
template <class Executor>
void apply_operator(const Executor& run, ProblemView problem, GridView grid, const double* x, double* y) {
  const ApplyToCell apply{problem, grid, x, y};
  const int first = Place::own_rows(grid.layout).begin, rows = Place::own_rows(grid.layout).count();
  run.for_each(rows, Place::columns(grid.layout), [=] LICHTENBERG_HOST_DEVICE(int row, int column) {
    // One colour after the other: a device takes part of all rows at a time.
    apply(Place(grid.layout, first + (row < rows / 2 ? 2 * row : 2 * row - rows + 1), column));
  });
  apply_to_groups(run, problem, grid, x, y);
  add_couplings(run, problem, x + grid.layout.size(), y + grid.layout.size());
}

/// Returns group g's share of the couplings' part of x'A x. Two floating groups (bodies with one unknown potential)
/// share the energy of a coupling (a lumped capacitance) equally.
LICHTENBERG_HOST_DEVICE inline double coupling_energy(const ProblemView& problem, const double* x_group, int g) {
  const CouplingView& couplings = problem.couplings;
  double sum = 0;
  for (int k = couplings.start[g]; k < couplings.start[g + 1]; ++k) {
    const double difference = x_group[g] - x_group[couplings.other[k]];
    sum += (problem.floating[couplings.other[k]] ? 0.5 : 1.0) * couplings.conductance[k] * difference * difference;
  }
  return sum;
}

/// Scales the initial guess x by the factor that minimizes its error in the energy norm. Computes r = b - A x and
/// stores it for the V-cycle. Overwrites q.
template <class Executor>
void scale_guess(const Executor& run, ProblemView problem, GridView grid, SolveVectors v) {
  const int cells = static_cast<int>(grid.layout.size());
  const bool is_coupled = problem.couplings.start;
  apply_to_groups(run, problem, grid, v.x, v.q);
  apply_to_cells(
      run, problem, grid, v.x, v.q,
      [=] LICHTENBERG_HOST_DEVICE(int k, double image) {
        GuessSums sums{v.b[k] * v.x[k], v.x[k] * image, std::abs(v.x[k])};
        if (is_coupled && k >= cells) sums.coupling_part = coupling_energy(problem, v.x + cells, k - cells);
        return sums;
      },
      [=] LICHTENBERG_HOST_DEVICE(const GuessSums& sums) {
        const double energy = sums.energy + sums.coupling_part;
        v.iterations->set_guess_scale(sums.product, energy, sums.largest, static_cast<double>(v.size));
        if (is_coupled) v.iterations->set_energy_of_field(sums.energy);
      });
  add_couplings(run, problem, v.x + cells, v.q + cells);
  const StoreResidual take{grid};
  for_each_entry(run, grid, problem.groups, [=] LICHTENBERG_HOST_DEVICE(int k) {
    const double factor = v.iterations->factor;
    v.x[k] *= factor;
    v.r[k] = v.b[k] - factor * v.q[k];
    take(k, v.r[k]);
  });
}

/// Returns the sum over group g's couplings (lumped capacitances) to given potentials of the conductance times
/// value(other group). A group is a set of bodies with one potential.
template <class Value>
LICHTENBERG_HOST_DEVICE double to_given(const ProblemView& problem, int g, Value value) {
  const CouplingView& couplings = problem.couplings;
  double sum = 0;
  for (int k = couplings.start[g]; k < couplings.start[g + 1]; ++k)
    if (!problem.floating[couplings.other[k]]) sum += couplings.conductance[k] * value(couplings.other[k]);
  return sum;
}

/// Shifts all potentials x such that the residual r sums to zero, updates r and stores it for the V-cycle. Only for
/// systems that couplings (lumped capacitances) alone ground (CutCellOperator::fix_potential_level). `level`: receives
/// the shift.
template <class Executor>
void fix_potential_level(const Executor& run, ProblemView problem, GridView grid, SolveVectors v, double* level) {
  const int cells = static_cast<int>(grid.layout.size());
  sum_of_vector(
      run, grid, problem.groups, [=] LICHTENBERG_HOST_DEVICE(int k) { return v.r[k]; },
      [=] LICHTENBERG_HOST_DEVICE(double sum) {
        *level = sum / *problem.couplings.to_given;
        v.iterations->raise_rounding(std::abs(*level), static_cast<double>(v.size));
      });
  const StoreResidual take{grid};
  for_each_entry(run, grid, problem.groups, [=] LICHTENBERG_HOST_DEVICE(int k) {
    if (grid.is_unknown(k)) v.x[k] += *level;
    if (k < cells) return;
    v.r[k] -= *level * to_given(problem, k - cells, [](int) { return 1.0; });
    take(k, v.r[k]);
  });
}

/// Computes the CG search direction p = z + beta p, without reading p if beta is 0.
template <class Executor>
void update_direction(const Executor& run, ProblemView problem, GridView grid, SolveVectors v) {
  for_each_entry(run, grid, problem.groups, [=] LICHTENBERG_HOST_DEVICE(int k) {
    const double beta = v.iterations->cg.beta;
    v.p[k] = beta == 0 ? v.z[k] : v.z[k] + beta * v.p[k];
  });
  exchange_ghosts(run, grid, v.p, ghosts_of_product);
}

/// Takes a CG step: x += alpha p and r -= alpha q, and stores r for the V-cycle.
template <class Executor>
void take_step(const Executor& run, ProblemView problem, GridView grid, SolveVectors v) {
  const StoreResidual take{grid};
  for_each_entry(run, grid, problem.groups, [=] LICHTENBERG_HOST_DEVICE(int k) {
    const double alpha = v.iterations->alpha;
    v.x[k] += alpha * v.p[k];
    const double residual = v.r[k] - alpha * v.q[k];
    v.r[k] = residual;
    take(k, residual);
  });
}

/// Resets the state of the iterations on the device. `tolerance`: relative error in the energy norm; `most`: maximum
/// number of iterations.
template <class Executor>
void begin_iterations(const Executor& run, double tolerance, int most, Iterations* iterations) {
  run.template for_each<32>(1, [=] LICHTENBERG_HOST_DEVICE(int) { iterations->begin(tolerance, most); });
}

/// Computes q = A p and the step length alpha along p from p'A p. Calls again(whether another iteration follows).
template <class Executor, class Continuation>
void compute_step(const Executor& run, ProblemView problem, GridView grid, SolveVectors v, Continuation again) {
  const auto cells = grid.layout.size();
  apply_to_groups(run, problem, grid, v.p, v.q);
  add_couplings(run, problem, v.p + cells, v.q + cells);
  apply_to_cells(
      run, problem, grid, v.p, v.q, [=] LICHTENBERG_HOST_DEVICE(int k, double image) { return v.p[k] * image; },
      [=] LICHTENBERG_HOST_DEVICE(double curvature) {
        v.iterations->set_step(curvature);
        again(v.iterations->go_on != 0);
      });
}

/// Tests convergence of the residual by r'z, and computes beta of the next search direction.
template <class Executor>
void test_convergence(const Executor& run, ProblemView problem, GridView grid, SolveVectors v) {
  sum_of_vector(
      run, grid, problem.groups, [=] LICHTENBERG_HOST_DEVICE(int k) { return v.r[k] * v.z[k]; },
      [=] LICHTENBERG_HOST_DEVICE(double product) { v.iterations->test_convergence(product); });
}

/// Solves each floating group's equation for its potential in x, for given potentials of the cells. In a problem with
/// couplings (lumped capacitances), linked groups are solved together. Otherwise groups with direct links (gap
/// conductances) are relaxed by a Jacobi step. `next`: scratch memory, one value per group. A group is a set of bodies
/// with one potential.
template <class Executor>
void solve_group_potentials(const Executor& run, ProblemView problem, GridView grid, const double* b, double* x,
                            double* next) {
  const int cells = static_cast<int>(grid.layout.size());
  if (grid.groups.exact_clusters) {
    sum_by_group(
        run, grid, links_by_group(problem, grid, grid.pieces.partial),
        [=] LICHTENBERG_HOST_DEVICE(int link) { return grid.links.conductance[link] * x[grid.links.slot[link]]; },
        parallel::NoAddedValues{}, [=] LICHTENBERG_HOST_DEVICE(int g, double sum) { next[g] = b[cells + g] + sum; });
    return solve_exactly(run, problem, grid, next, x + cells);
  }
  const bool direct_links = grid.may_have(Items::direct_links);
  if (!direct_links) next = x + cells;
  group_fluxes(run, problem, grid, x, [=] LICHTENBERG_HOST_DEVICE(int g, double sum) {
    const double diagonal = grid.groups.diagonal[g];
    next[g] = diagonal > 0 ? (b[cells + g] + sum) / diagonal : x[cells + g];
  });
  if (!direct_links) return;
  run.for_each(problem.groups, [=] LICHTENBERG_HOST_DEVICE(int g) { x[cells + g] = next[g]; });
}

/// Computes the right-hand side b in units of `unit` (V): charges / permittivity, and fluxes from groups (bodies with
/// one potential) and sides of given potential.
template <class Executor>
void right_hand_side(const Executor& run, ProblemView problem, GridView grid, double* b, double unit = 1) {
  run.fill(b, 0, (grid.layout.size() + problem.groups) * sizeof(double));
  const int cells = static_cast<int>(grid.layout.size());
  for_each_item(run, grid, Items::boundary, [=] LICHTENBERG_HOST_DEVICE(int k) {
    double sum = 0;
    for (int side = 0; side < 4; ++side) {
      const int link = grid.boundary_link_of(k, side);
      if (link < 0 || problem.floating[grid.links.group[link]]) continue;
      sum += grid.links.conductance[link] * problem.potential[grid.links.group[link]];
    }
    b[grid.boundary.slot[k]] = sum / unit;
  });
  // Adds left and right sides, then bottom and top: a corner cell has one of each pair.
  for (int first = 0; first < 4; first += 2)
    run.for_each(2, problem.faces, [=] LICHTENBERG_HOST_DEVICE(int row, int face) {
      const int side = first + row;
      if (!problem.electrode[side] || face >= faces_of(grid.layout, side)) return;
      const auto [i, j] = cell_at_face(grid.layout, side, face);
      const int slot = slot_of(grid.layout, i, j);
      if (grid.cells.owner[slot].is_fluid()) b[slot] += 2 * problem.side_potential[side * problem.faces + face] / unit;
    });
  run.sum_segments(
      problem.groups, [=] LICHTENBERG_HOST_DEVICE(int g) { return grid.direct_links_of(problem, g); },
      [=] LICHTENBERG_HOST_DEVICE(int g, int t) {
        const DirectLink& link = grid.direct.link[grid.first_direct_link(problem, g) + t];
        if (link.is_to_electrode()) return link.conductance * problem.side_potential[link.face()];
        const int other = problem.group_of[link.other];
        return problem.floating[other] ? 0.0 : link.conductance * problem.potential[other];
      },
      [=] LICHTENBERG_HOST_DEVICE(int g, double sum) {
        if (problem.floating[g] && problem.couplings.start)
          sum += to_given(problem, g, [&](int other) { return problem.potential[other]; });
        b[cells + g] = problem.floating[g] ? (problem.charge[g] / problem.permittivity + sum) / unit : 0.0;
      });
}

/// Sets v to 1 for every unknown and to 0 elsewhere.
template <class Executor>
void mark_unknowns(const Executor& run, ProblemView problem, GridView grid, double* v) {
  run.for_each(static_cast<long>(grid.layout.size()) + problem.groups,
               [=] LICHTENBERG_HOST_DEVICE(int k) { v[k] = grid.is_unknown(k) ? 1.0 : 0.0; });
}

/// Sum and number of its terms, for a mean value.
struct Mean {
  double sum = 0, count = 0;
  LICHTENBERG_HOST_DEVICE Mean& operator+=(const Mean& other) {
    sum += other.sum;
    count += other.count;
    return *this;
  }
  /// Returns the mean value; 0 without terms.
  LICHTENBERG_HOST_DEVICE double value() const { return count > 0 ? sum / count : 0.0; }
};

/// Subtracts *mean from every unknown in x.
template <class Executor>
void subtract(const Executor& run, ProblemView problem, GridView grid, const double* mean, double* x) {
  for_each_entry(run, grid, problem.groups, [=] LICHTENBERG_HOST_DEVICE(int k) {
    if (grid.is_unknown(k)) x[k] -= *mean;
  });
}

/// Subtracts from z its mean over all unknowns, its component in the null space if no potential is given. `mean`:
/// receives the mean.
template <class Executor>
void remove_mean(const Executor& run, ProblemView problem, GridView grid, PreconditionedResidual z, double* mean) {
  sum_of_vector(
      run, grid, problem.groups,
      [=] LICHTENBERG_HOST_DEVICE(int k) {
        return grid.is_unknown(k) ? Mean{z[k], 1} : Mean{};
      },
      [=] LICHTENBERG_HOST_DEVICE(const Mean& all) { *mean = all.value(); });
  for_each_entry(run, grid, problem.groups, [=] LICHTENBERG_HOST_DEVICE(int k) {
    if (!grid.is_unknown(k)) return;
    if (k < z.cells)
      z.cell[k] = static_cast<float>(z.cell[k] - *mean);
    else
      z.group[k - z.cells] -= *mean;
  });
}

/// Shifts all unknown potentials x so that the mean potential of all bodies is zero. `mean`: receives the mean before
/// the shift.
template <class Executor>
void fix_mean(const Executor& run, ProblemView problem, GridView grid, double* x, double* mean) {
  const int cells = static_cast<int>(grid.layout.size());
  run.sum(
      problem.bodies,
      [=] LICHTENBERG_HOST_DEVICE(int body) {
        return Mean{x[cells + problem.group_of[body]], 1};
      },
      [=] LICHTENBERG_HOST_DEVICE(const Mean& all) { *mean = all.value(); });
  subtract(run, problem, grid, mean, x);
}

/// Computes the potentials (V) of all groups (bodies with one potential) from x, which is in units of `unit` (V).
template <class Executor>
void group_potentials(const Executor& run, ProblemView problem, GridView grid, const double* x, double unit,
                      double* potential) {
  const int cells = static_cast<int>(grid.layout.size());
  run.for_each(problem.groups, [=] LICHTENBERG_HOST_DEVICE(int g) {
    potential[g] = problem.floating[g] ? unit * x[cells + g] : problem.potential[g];
  });
}

/// Stored solution on the device: potentials by slot (memory index), with their conductor's potential in covered cells
/// (inside conductors), and by body.
struct SolutionView {
  double* cell;
  double* body;
};

/// Sets x of each floating group (bodies with one unknown potential) to the mean of value(body) over its bodies, and to
/// 0 for other groups.
template <class Executor, class Value>
void average_bodies(const Executor& run, ProblemView problem, GridView grid, double* x, Value value) {
  run.sum_segments(
      problem.groups, [=] LICHTENBERG_HOST_DEVICE(int g) { return problem.members(g); },
      [=] LICHTENBERG_HOST_DEVICE(int g, int t) { return value(problem.member(g, t)); },
      [=] LICHTENBERG_HOST_DEVICE(int g, double sum) {
        x[g] = grid.groups.diagonal[g] > 0 ? sum / problem.members(g) : 0.0;
      });
}

}  // namespace lichtenberg::laplace::device
