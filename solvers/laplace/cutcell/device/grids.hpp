#pragma once

#include <algorithm>
#include <tuple>
#include <utility>

#include "solvers/laplace/cutcell/device/bound.hpp"
#include "solvers/laplace/cutcell/device/conductances.hpp"
#include "solvers/laplace/cutcell/device/direct_links.hpp"
#include "solvers/laplace/cutcell/device/operator.hpp"
#include "solvers/laplace/cutcell/device/pieces.hpp"

namespace lichtenberg::laplace::device {

/// Role of a grid in the V-cycle: its features, and device pointers to its item counts and clusters (groups solved
/// together). `number`, `required`: as in GridView.
struct GridRole {
  /// True if some bodies are smaller than this grid resolves.
  bool has_medium = false;
  /// True if one kernel treats this grid with others; its groups with unknown potentials are then listed.
  bool is_small = false;
  /// True if the V-cycle eliminates near-surface cells.
  bool binds = false;
  int *number = nullptr, *required = nullptr;
  /// Clusters (groups solved together) of the V-cycle and of the finest grid's system; null: none.
  const ClusterView *clusters = nullptr, *exact_clusters = nullptr;
  /// The finest grid, whose direct links this coarse grid inherits; null: none.
  const GridView* finest = nullptr;
  /// GridView::from_ranks.
  double* from_ranks = nullptr;
};

/// One grid on the device: its memory, and its discretization (cells, conductances, matrix diagonals).
template <class Executor>
class DeviceGrid {
 public:
  DeviceGrid(const Executor& run, int nx, int ny, double h, LinkFormula formula, bool finest)
      : run_(run), arrays_(run) {
    GridView& grid = own();
    grid.layout = Layout(nx, ny);
    grid.rows = {};
    grid.h = h;
    grid.formula = formula;
    grid.finest = finest;
    resize_with_zeros(grid.layout.size(), grid.cells.inverse_diagonal, grid.cycle.f, grid.cycle.v);
    arrays_.resize(grid.layout.size(), grid.cells.owner);
  }

  /// Divides the grid's rows among several ranks. With shift 0 each rank computes all rows, but receives right-hand
  /// sides by their rows.
  void divide(const RowDivision& rows) {
    Layout& at = own().layout;
    own().rows = rows;
    if (rows.shift > 0) at.own = {rows.border(at.ny, run_.rank()), rows.border(at.ny, run_.rank() + 1)};
  }

  /// Returns the device pointers to the grid's arrays.
  const GridView& view() const { return arrays_.view.grid; }
  /// Returns the number of fluid cells: all cells of the grid minus the covered ones (inside bodies). `numbers`: number
  /// of this grid's items of each kind.
  long fluid_cells(const Numbers& numbers) const {
    return static_cast<long>(view().layout.nx) * view().layout.ny - numbers[Items::covered];
  }

  /// Sets the grid's role and reserves memory for GridView::capacity items of each kind. Arrays may move.
  void reserve(const ProblemView& problem, const GridRole& role) {
    GridView& grid = own();
    grid.has_medium = role.has_medium;
    grid.binds = role.binds;
    grid.number = role.number;
    grid.required = role.required;
    grid.from_ranks = role.from_ranks;
    grid.groups.clusters = role.clusters;
    grid.groups.exact_clusters = role.exact_clusters;
    grid.inherited = {};
    if (role.finest) {
      grid.inherited.link = role.finest->direct.link;
      grid.inherited.link_start = role.finest->direct.start;
    }
    if (role.finest && role.finest->may_have(Items::joined_links)) {
      grid.inherited.joined = role.finest->bound.joined;
      grid.inherited.joined_start = role.finest->bound.joined_start;
    }
    if (!role.has_medium)  // the bins still hold points of an earlier set-up
      for (const Items::Kind kind :
           {Items::newly_absorbed, Items::subgrid_conductors, Items::floating_subgrid_conductors})
        grid.capacity[kind] = 0;
    reserve_bodies(problem);
    if (role.has_medium) reserve_medium(problem);
    reserve_lists();
    reserve_groups(problem, role.is_small);
  }
  /// Returns true if the arrays have memory for the numbers of items in `required`.
  bool fits(const Numbers& required) const {
    for (int kind = 0; kind < Items::kinds; ++kind)
      if (required[kind] > view().capacity[kind]) return false;
    return true;
  }
  /// Raises the capacities (numbers of items that memory is reserved for) to the required numbers; call reserve()
  /// afterwards. Items of which more may soon be needed in motion get about half as many more, because growing costs as
  /// much as ten solves. The coarsest grid's matrix must stay small and changes with groups (bodies with one potential)
  /// only, so that it gets 16 more.
  void enlarge(const ProblemView& problem, const Numbers& required) {
    Numbers& capacity = own().capacity;
    if (view().has_medium && required[Items::strips] > 0) {
      // Groups in motion become subgrid conductors on one grid after the other; memory for all is reserved at once.
      for (const Items::Kind kind :
           {Items::newly_absorbed, Items::subgrid_conductors, Items::floating_subgrid_conductors})
        capacity[kind] = std::max(capacity[kind], problem.bodies);
      capacity[Items::strips] = std::max(capacity[Items::strips], required[Items::strips] + problem.bodies);
      capacity[Items::links] = std::max(capacity[Items::links], required[Items::links] + 4 * problem.bodies);
    }
    for (int kind = 0; kind < Items::kinds; ++kind) {
      const bool is_near = required[kind] + required[kind] / 8 > capacity[kind];
      const int spare = kind == Items::coarse_unknowns ? 16 : required[kind] / 2 + 256;
      if (required[kind] > 0 && is_near) capacity[kind] = required[kind] + spare;
    }
  }

  /// Sets the memory for strong links (large gap conductances) to 0 entries; call reserve() afterwards. enlarge() can
  /// raise it again.
  void forget_strong_links() { own().capacity[Items::strong_links] = 0; }
  /// Sets the memory for all links between groups (bodies with one potential) to 0 entries; call reserve() afterwards.
  void forget_links_of_groups() {
    for (const Items::Kind kind : {Items::strong_links, Items::direct_links, Items::joined_links})
      own().capacity[kind] = 0;
  }

  /// Computes the bodies' outlines in cells and the groups (bodies with one potential) that become part of the grid's
  /// effective medium (cells whose conductances include small bodies without unknowns). `finer`: the next finer grid,
  /// with outlines; null for the finest.
  void outline(const ProblemView& problem, const GridView* finer) {
    outline_bodies(run_, problem, view());
    if (view().has_medium)
      absorb_groups(run_, problem, view(), finer && finer->has_medium ? finer->medium.absorbed : nullptr,
                    {scratch().sort.key, view().medium.absorbed_groups.item});
  }

  /// Discretizes the grid: assigns cells to bodies, computes conductances and matrix diagonals. The outlines of all
  /// grids must exist.
  void build(const ProblemView& problem) {
    if (view().has_medium) homogenize(problem);
    assign_cells(problem);
    count(problem);
    fill_strips(run_, problem, filled());
    if (view().has_medium) make_permittivity(run_, view());
    make_links(run_, problem, view());
    make_diagonals(run_, problem, view());
    if (view().binds) bind(problem);
    build_direct_links(problem);
    build_groups(problem);
  }

 private:
  /// Arrays that only the set-up of a grid needs.
  struct Scratch {
    SortArrays sort;
    /// Points of homogenized bodies, without keys.
    PointsView points;
    /// By body: numbers of items of bodies without cells.
    WithoutCells* without_cells;
    DirectLink *unsorted_direct, *unsorted_joined;
    /// By boundary cell: number of joined links of earlier cells.
    int* joined_before;
  };
  struct All {
    GridView grid;
    Scratch scratch;
  };
  GridView& own() { return arrays_.view.grid; }
  Scratch& scratch() { return arrays_.view.scratch; }
  template <class... T>
  void resize_with_zeros(std::size_t n, T*&... pointer) {
    arrays_.resize(n, pointer...);
    arrays_.zero(pointer...);
  }

  void reserve_bodies(const ProblemView& problem) {
    GridView& grid = own();
    Scratch& scratch = this->scratch();
    arrays_.resize(problem.bodies, grid.bodies.outline, grid.bodies.present, grid.bodies.cell_owner,
                   grid.bodies.resolved);
    arrays_.resize(problem.bodies + 1, grid.strips.start, grid.direct.start, grid.bound.joined_start,
                   scratch.without_cells);
    arrays_.resize(std::max({problem.groups, problem.bodies, grid.capacity[Items::direct_links],
                             grid.capacity[Items::joined_links]}),
                   scratch.sort.key);
  }

  void reserve_medium(const ProblemView& problem) {
    MediumArrays& medium = own().medium;
    const Layout& at = view().layout;
    if (!medium.permittivity) resize_with_zeros(at.size(), medium.permittivity, medium.east, medium.north);
    arrays_.resize(problem.groups, medium.absorbed, medium.centre, medium.absorbed_groups.points,
                   medium.absorbed_groups.item);
    medium.extent = nullptr;
    if (problem.sets.first_group) arrays_.resize(2L * problem.groups, medium.extent);
    const int bins = bins_of(at);
    arrays_.resize(bins + 1, medium.absorbed_groups.start);
    arrays_.resize(2 * bins + 1, medium.absorbed_bodies.start);
    PointsView& points = scratch().points;
    arrays_.resize(problem.bodies, medium.absorbed_bodies.points, medium.absorbed_bodies.item, medium.point,
                   points.share);
    arrays_.resize(problem.bodies + 1, points.before, points.first);
    medium.subgrid_conductors = medium.absorbed_bodies;
    medium.subgrid_conductors.start += bins;  // behind them
  }

  void reserve_lists() {
    GridView& grid = own();
    Scratch& scratch = this->scratch();
    if (!grid.binds) grid.capacity[Items::joined_links] = 0;
    const Numbers& capacity = grid.capacity;
    arrays_.resize(capacity[Items::strips] + 1, grid.strips.counts);
    arrays_.resize(capacity[Items::covered], grid.covered.slot, grid.covered.group);
    arrays_.resize(capacity[Items::links], grid.links.slot, grid.links.end, grid.links.group, grid.links.conductance);
    if (grid.finest)
      arrays_.resize(capacity[Items::links], grid.links.gradient, grid.links.partner_group,
                     grid.links.partner_gradient);
    arrays_.resize(capacity[Items::boundary], grid.boundary.slot, grid.boundary.diagonal);
    arrays_.resize(4L * capacity[Items::boundary], grid.boundary.link, grid.boundary.coupling);
    arrays_.resize(capacity[Items::direct_links], grid.direct.link);
    if (grid.may_have(Items::without_cells)) arrays_.resize(capacity[Items::direct_links], scratch.unsorted_direct);
    arrays_.resize(std::max(capacity[Items::direct_links], capacity[Items::joined_links]), scratch.sort.index);
    if (!grid.binds) return;
    arrays_.resize(capacity[Items::boundary], grid.bound.is_eliminated);
    arrays_.resize(capacity[Items::boundary] + 1, scratch.joined_before);
    arrays_.resize(capacity[Items::links], grid.bound.share, grid.bound.kept);
    arrays_.resize(capacity[Items::joined_links], grid.bound.joined, scratch.unsorted_joined);
  }

  void reserve_groups(const ProblemView& problem, bool is_small) {
    GridView& grid = own();
    auto [pieces, groups, cycle] = std::tie(grid.pieces, grid.groups, grid.cycle);
    pieces.capacity = (grid.capacity[Items::links] + grid.capacity[Items::covered]) / piece_length + 2 * problem.groups;
    arrays_.resize(2 * problem.groups + 1, pieces.start);
    arrays_.resize(pieces.capacity, pieces.begin, pieces.end, pieces.segment, pieces.partial, cycle.partial);
    resize_with_zeros(2 * problem.groups, pieces.done);
    arrays_.resize(problem.groups, groups.diagonal, groups.inverse_diagonal, cycle.phi, cycle.phi_down, cycle.phi_next,
                   cycle.charge, cycle.flux);
    groups.own = nullptr;
    if (is_small) arrays_.resize(problem.groups, groups.own);
    groups.cycle_diagonal = groups.diagonal;
    if (grid.binds) arrays_.resize(problem.groups, groups.cycle_diagonal);
    cycle.group_rhs = nullptr;
    if (groups.clusters) arrays_.resize(problem.groups, cycle.group_rhs);
  }

  /// Sorts the groups and bodies that are smaller than the grid resolves by bin (the four cells around each), and
  /// computes their shares in cells. A group is a set of bodies with one potential.
  void homogenize(const ProblemView& problem) {
    const GridView& grid = view();
    const int bins = bins_of(grid.layout);
    const Bins &groups = grid.medium.absorbed_groups, &bodies = grid.medium.absorbed_bodies;
    int* key = scratch().sort.key;
    run_.sort(key, groups.item, problem.groups, bins);
    start_segments(run_, key, problem.groups, bins, groups.start);
    homogenized_keys(run_, problem, grid, {key, bodies.item});
    run_.sort(key, bodies.item, problem.bodies, 2 * bins);
    PointsView points = scratch().points;
    points.key = key;
    number_points(run_, problem, grid, points);
    start_segments(run_, key, problem.bodies, 2 * bins, bodies.start, points.before);
    distribute_points(run_, problem, grid, points);
  }

  void assign_cells(const ProblemView& problem) {
    const GridView& grid = view();
    count_strips(run_, problem, grid);
    run_.exclusive_scan(grid.strips.start, problem.bodies + 1);
    finalize_strip_count(run_, problem, grid);
    run_.fill(grid.cells.owner, 0xff, grid.layout.size() * sizeof(CellOwner));  // fluid
    cover_cells(run_, problem, grid);
  }

  void count(const ProblemView& problem) {
    const GridView& grid = view();
    WithoutCells* without_cells = scratch().without_cells;
    count_in_strips(run_, problem, grid);
    run_.exclusive_scan(grid.strips.counts, grid.capacity[Items::strips] + 1);
    count_without_cells(run_, problem, grid, without_cells);
    run_.exclusive_scan(without_cells, problem.bodies + 1);
    finalize_list_counts(run_, problem, grid, without_cells);
  }

  /// Returns the view for the kernels that fill the list of direct links (gap conductances). It points to the unsorted
  /// list if the links are sorted afterwards, otherwise to the final list.
  GridView filled() const {
    GridView grid = view();
    if (grid.may_have(Items::without_cells)) grid.direct.link = arrays_.view.scratch.unsorted_direct;
    return grid;
  }

  void build_direct_links(const ProblemView& problem) {
    const GridView &grid = view(), list = filled();
    const int capacity = grid.capacity[Items::direct_links];
    if (capacity == 0) return run_.fill(grid.direct.start, 0, (problem.bodies + 1) * sizeof(int));
    const SortArrays& sort = scratch().sort;
    if (grid.may_have(Items::without_cells)) list_without_cells(run_, problem, list, scratch().without_cells);
    make_direct_links(run_, problem, list);
    direct_link_keys(run_, problem, grid, Items::direct_links, list.direct.link, sort);
    if (grid.may_have(Items::without_cells)) {
      run_.sort(sort.key, sort.index, capacity, problem.bodies);
      sort_direct_links(run_, grid, Items::direct_links, list.direct.link, sort.index, grid.direct.link);
    }
    start_segments(run_, sort.key, capacity, problem.bodies, grid.direct.start);
  }

  void bind(const ProblemView& problem) {
    const GridView& grid = view();
    const SortArrays& sort = scratch().sort;
    DirectLink* unsorted = scratch().unsorted_joined;
    find_bound_cells(run_, problem, grid, scratch().joined_before);
    const int capacity = grid.capacity[Items::joined_links];
    if (capacity == 0) return;
    list_joined(run_, problem, grid, scratch().joined_before, unsorted);
    direct_link_keys(run_, problem, grid, Items::joined_links, unsorted, sort);
    run_.sort(sort.key, sort.index, capacity, problem.bodies);
    sort_direct_links(run_, grid, Items::joined_links, unsorted, sort.index, grid.bound.joined);
    start_segments(run_, sort.key, capacity, problem.bodies, grid.bound.joined_start);
  }

  void build_groups(const ProblemView& problem) {
    const GridView& grid = view();
    CycleArrays& cycle = own().cycle;
    arrays_.zero(cycle.phi, cycle.phi_next);  // of groups of given potential
    if (grid.groups.clusters) arrays_.zero(cycle.phi_down);
    count_pieces(run_, problem, grid);
    run_.exclusive_scan(grid.pieces.start, 2 * problem.groups + 1);
    cut_pieces(run_, problem, grid);
    make_group_diagonals(run_, problem, grid);
    if (grid.binds) make_cycle_diagonals(run_, problem, grid);
  }

  const Executor& run_;
  parallel::Arrays<All, Executor> arrays_;
};

}  // namespace lichtenberg::laplace::device
