#pragma once

#include <algorithm>
#include <limits>
#include <tuple>
#include <variant>
#include <vector>

#include "solvers/error.hpp"
#include "solvers/laplace/cutcell/device/clustering.hpp"
#include "solvers/laplace/cutcell/device/coarsest.hpp"
#include "solvers/laplace/cutcell/device/cycle.hpp"
#include "solvers/laplace/cutcell/device/grids.hpp"
#include "solvers/laplace/cutcell/device/nested_guess.hpp"
#include "solvers/laplace/cutcell/device/problem.hpp"
#include "solvers/laplace/cutcell/device/small_grids.hpp"
#include "solvers/laplace/cutcell/grid_sizes.hpp"

namespace lichtenberg::laplace::device {

/// Sizes of a problem's smallest bodies, from which follows whether a grid resolves all bodies.
class SmallestBodies {
 public:
  /// Finds the smallest disk that floats alone, the smallest of all other disks, and the shortest bar.
  explicit SmallestBodies(const LaplaceProblem& problem) {
    std::vector<int> members(problem.groups.size(), 0);
    for (const Body& body : problem.bodies) ++members[body.group];
    for (const Body& body : problem.bodies) {
      const Outline outline = outline_in_cells(body.shape, 1);
      const bool alone = problem.groups[body.group].floating && members[body.group] == 1;
      if (outline.kind == Outline::Kind::disk && outline.size < disk_[alone].size) disk_[alone] = outline;
      if (outline.kind == Outline::Kind::bar && length(outline) < length(bar_)) bar_ = outline;
    }
  }
  /// Returns true if a grid with cells of size h (m) does not resolve some body.
  bool unresolved(double h) const {
    for (const bool alone : {false, true})
      if (!is_resolved(in_cells(disk_[alone], h), alone)) return true;
    return !is_resolved(in_cells(bar_, h), false);
  }

 private:
  static constexpr double infinite = std::numeric_limits<double>::infinity();
  static double length(const Outline& bar) { return norm(bar.end - bar.centre); }
  static Outline in_cells(const Outline& body, double h) {
    return {body.kind, body.centre / h, body.end / h, body.size / h};
  }

  Outline disk_[2] = {{.size = infinite}, {.size = infinite}};  // of disks in groups; of single ones
  Outline bar_{.kind = Outline::Kind::bar, .centre = {}, .end = {infinite, 0}};
};

/// Returns the number of grids, from the finest on, whose rows `ranks` devices divide. Each device must have at least
/// `least_cells` cells of a divided grid, because the exchange of ghost rows takes longer than the cells that it saves.
inline int divided_grids(const std::vector<GridSize>& sizes, int ranks, long least_cells) {
  constexpr int least_rows = 32;
  const int last = static_cast<int>(sizes.size()) - 1;
  const auto is_large = [&](GridSize size) {
    return static_cast<long>(size.nx) * size.ny >= least_cells * ranks && size.ny >= least_rows * ranks;
  };
  int divided = 0;
  while (ranks > 1 && divided < last && is_large(sizes[divided])) ++divided;
  return divided;
}

/// Multigrid preconditioner on the device: all grids and the V-cycle on them (../multigrid.hpp). A large grid takes a
/// few kernels, all small grids together one. If conductors have direct links (gap conductances), two Jacobi sweeps
/// replace each Gauss-Seidel sweep over groups (bodies with one potential). If links are strong, the sweeps relax
/// clusters of groups together.
template <class Executor>
class DeviceMultigrid {
 public:
  /// Makes the grids, the finest of nx x ny cells, without a problem's bodies. `formula`: formula of the links'
  /// conductances; `least_cells`: of a rank, as in divided_grids().
  DeviceMultigrid(const Executor& run, const LaplaceProblem& problem, int nx, int ny, LinkFormula formula,
                  long least_cells = 0)
      : run_(run), coarsest_(run), numbers_(run), clustering_(run, static_cast<int>(grid_sizes(nx, ny).size())) {
    for (const GridSize& size : grid_sizes(nx, ny))
      grids_.emplace_back(run, size.nx, size.ny, problem.size.x / size.nx, formula, grids_.empty());
    medium_.assign(grids_.size(), false);
    divided_ = divided_grids(grid_sizes(nx, ny), run.ranks(), least_cells);
    if (divided_ == 0) return;
    for (int l = 0; l <= divided_; ++l) grids_[l].divide({run.ranks(), divided_ - l});
  }

  /// Discretizes the problem on all grids and prepares the coarsest grid's solver. Whether the arrays were large enough
  /// is known after check_capacity(). Throws Failure if a factorization of the coarsest grid on the host fails. `view`:
  /// the same problem on the device.
  void build(const LaplaceProblem& problem, const ProblemView& view) {
    prepare(problem, view);
    if (fits_) {
      discretize(problem);
    } else {
      do {
        discretize(problem);
        numbers_.fetch();
      } while (enlarge());
      fits_ = true;
    }
    if (clustered()) clustering_.find_clusters(problem);
    if (coarsest_.on_device()) return;
    numbers_.fetch();
    if (!lacks_capacity()) coarsest_.factorize(problem, grids_.back().view(), required(levels() - 1));
  }

  /// Starts the transfer of the item counts that check_capacity() reads. The device must have finished it before
  /// check_capacity().
  void begin_capacity_check() { numbers_.begin_fetch(); }
  /// Returns true if the arrays were large enough; if not, enlarges them, and build() must be repeated. Throws Failure
  /// if the device could not invert the coarsest grid's matrix.
  bool check_capacity() {
    if (lacks_capacity()) {
      enlarge();
      return false;
    }
    if (coarsest_.on_device() && *singular_.host)
      throw Failure(
          "field solver: the Cholesky factorization of the coarsest grid failed (a conductor without any link?)");
    solves_without_strong_links_ = required(0)[Items::strong_links] > 0 ? 0 : solves_without_strong_links_ + 1;
    return true;
  }
  /// Discards memory for links between groups (bodies with one potential), because the relaxation of groups depends on
  /// it. The next set-up thus depends on its problem only.
  void forget() {
    for (DeviceGrid<Executor>& grid : grids_) grid.forget_links_of_groups();
    medium_.clear();  // so that prepare() reserves the arrays again
    solves_without_strong_links_ = 0;
  }
  /// Returns a number that changes when arrays move.
  int generation() const { return generation_; }
  /// Returns true if the device solves the coarsest grid's system, so that the V-cycle needs no host.
  bool on_device() const { return coarsest_.on_device(); }
  /// Returns the number of fluid cells (outside all bodies) of the finest grid.
  long fluid_cells() const { return finest().fluid_cells(required(0)); }
  /// Returns true if the host takes part in the set-up. It then computes clusters, the groups (bodies with one
  /// potential) that are relaxed together. This is so with couplings (lumped capacitances), and with memory for strong
  /// direct links (gap conductances).
  bool clustered() const { return coupled() || finest().view().may_have(Items::strong_links); }
  /// Returns true if the problem has couplings (lumped capacitances between groups). A group is a set of bodies with
  /// one potential.
  bool coupled() const { return given_problem_.couplings.start; }
  /// Returns the required numbers of items of a grid, as fetched for check_capacity().
  Numbers required(int level) const {
    Numbers numbers;
    std::copy_n(required_.host + level * Items::kinds, Items::kinds, numbers.begin());
    return numbers;
  }

  /// Returns the finest grid.
  const DeviceGrid<Executor>& finest() const { return grids_.front(); }
  /// Returns the number of grids.
  int levels() const { return static_cast<int>(grids_.size()); }
  /// Returns the number of unknowns of the coarsest grid.
  long coarse_unknowns() const { return required(levels() - 1)[Items::coarse_unknowns]; }

  /// Applies the preconditioner: z = M r by one V-cycle. All pointers are to device memory.
  void apply(const double* r, double* z) {
    apply(r);
    const PreconditionedResidual from = result();
    run_.for_each(from.cells + problem_.groups, [=] LICHTENBERG_HOST_DEVICE(int k) { z[k] = from[k]; });
  }
  /// Applies the preconditioner to r by one V-cycle, by a recorded graph of kernels where possible. The result is that
  /// of result().
  void apply(const double* r) {
    store_residual(run_, problem_, grids_[0].view(), r);
    if (on_device())
      run_.run(recording_, [&] { cycle(); });
    else
      cycle();
  }
  /// Returns the result z = M r of the last V-cycle; 0 in the padding between rows of cells.
  PreconditionedResidual result() const {
    const GridView& grid = grids_[0].view();
    return {grid.cycle.v, group_result_.data(), static_cast<long>(grid.layout.size())};
  }
  /// Computes z = M r from the stored residual (StoreResidual) by one V-cycle, kernel by kernel, without recording.
  void cycle() {
    if (first_solved_ > 0) down(0);
    coarse_cycle(1);
    const PreconditionedResidual z = result();
    if (first_solved_ > 0) return up(0, z.group);
    const GridView& grid = grids_[0].view();  // the only one
    complete_potentials(run_, problem_, grid, z);
    if (!grid.groups.clusters) return;
    relax_groups(run_, problem_, grid, nullptr);
    relax_direct_links(run_, problem_, grid,
                       GroupSweep{grid.cycle.flux, grid.cycle.phi, nullptr, grid.cycle.phi_next, z.group});
  }

  /// Returns true if nested_guess() computes a guess: there are coarse grids, and no groups (bodies with one potential)
  /// are clustered. The residuals of clustered groups cancel in single precision.
  bool has_nested_guess() const { return first_solved_ > 0 && !clustered(); }
  /// Computes an initial guess x by nested iteration (full multigrid, Brandt 1977), in units of `unit` (V). A V-cycle
  /// solves the problem on the finest of the small grids. On each finer grid except the finest, one V-cycle improves
  /// the interpolated solution of the coarser grid. The result is interpolated to the finest grid.
  void nested_guess(double unit, double* x) {
    bool is_absorbed = false;
    for (int l = 1; l <= first_solved_; ++l) {
      absorb_charges(run_, problem_, is_absorbed ? &grids_[l - 1].view() : nullptr, grids_[l].view(), unit);
      is_absorbed = is_absorbed || grids_[l].view().may_have(Items::newly_absorbed);
    }
    const KeptGuess kept{guess_.data(), guess_.data() + grids_[1].view().layout.size()};
    for (int l = first_solved_; l > 0; --l) {
      const GridView& grid = grids_[l].view();
      add_given(run_, problem_, grid, 1 << l, unit);
      if (l < first_solved_)
        interpolate_guess(run_, problem_, CoarsePotentials{problem_, grids_[l + 1].view(), unit}, grid, kept);
      coarse_cycle(l);
      if (l < first_solved_) add_guess(run_, problem_, grid, kept);
      exchange_ghosts(run_, grid, grid.cycle.v, ghosts_of_correction);
      interpolate_absorbed_guess(run_, problem_, CoarsePotentials{problem_, grid, unit});
    }
    interpolate_to_finest(run_, problem_, CoarsePotentials{problem_, grids_[1].view(), unit}, grids_[0].view(), x);
  }

 private:
  /// Runs the part of a V-cycle on coarse grids from number `first` on.
  void coarse_cycle(int first) {
    for (int l = first; l < first_solved_; ++l) down(l);
    solve_coarse();
    for (int l = first_solved_ - 1; l >= first; --l) up(l, nullptr);
  }

  /// Returns true if set-ups may do without the host again, after many solves without strong links (large gap
  /// conductances).
  bool may_forget_strong_links() const {
    return finest().view().may_have(Items::strong_links) && !coupled() &&
           solves_without_strong_links_ >= solves_to_forget_strong_links;
  }

  /// Detects changes of the problem's arrays and features since the last build; if there are any, reserves memory.
  void prepare(const LaplaceProblem& problem, const ProblemView& view) {
    const SmallestBodies bodies(problem);
    std::vector<bool> medium;
    for (const DeviceGrid<Executor>& grid : grids_)
      medium.push_back(!medium.empty() && bodies.unresolved(grid.view().h));
    const bool forgets = may_forget_strong_links();
    if (generation_ > 0 && given_problem_ == view && medium_ == medium && !forgets) return;
    if (forgets) grids_[0].forget_strong_links();
    given_problem_ = view;
    medium_ = medium;
    fits_ = false;
    const std::size_t numbers = grids_.size() * Items::kinds;
    std::tie(required_, singular_) = numbers_.template divide<int, int>({numbers, 1});
    number_.resize(numbers);
    run_.fill(number_.data(), 0, numbers * sizeof(int));
    run_.fill(required_.device, 0, numbers * sizeof(int));
    reserve();
  }

  void reserve() {
    problem_ = given_problem_;
    if (clustered()) problem_.sets = clustering_.reserve_sets(problem_.groups);
    const int first_small = this->first_small();
    // By group, or three values by body, or two by part of a side.
    if (divided_ > 0) from_ranks_.resize(run_.ranks() * (3L * problem_.bodies + 2L * problem_.groups + 1024));
    std::vector<GridView> views;
    for (int l = 0; l < levels(); ++l) {
      GridRole role;
      role.has_medium = medium_[l];
      role.is_small = l >= first_small;
      role.binds = l < first_small && l + 1 < levels();
      role.from_ranks = from_ranks_.data();
      role.number = number_.data() + l * Items::kinds;
      role.required = required_.device + l * Items::kinds;
      if (clustered()) role.clusters = clustering_.clusters(l);
      if (clustered() && l > 0) role.finest = &grids_[0].view();
      if (coupled() && l == 0) role.exact_clusters = clustering_.exact_clusters();
      grids_[l].reserve(problem_, role);
      views.push_back(grids_[l].view());
    }
    if (clustered()) clustering_.reserve_links(problem_.groups, views);
    views_.upload(views);
    coarsest_.reserve(problem_, grids_.back().view(), clustered());
    first_solved_ = on_device() ? first_small : levels() - 1;
    if (first_solved_ > 0) guess_.resize(grids_[1].view().layout.size() + problem_.groups);
    group_result_.resize(problem_.groups);
    recording_.clear();
    building_.clear();
    building_finest_.clear();
    ++generation_;
  }

  bool lacks_capacity() const {
    for (int l = 0; l < levels(); ++l)
      if (!grids_[l].fits(required(l))) return true;
    return false;
  }
  /// Enlarges arrays that were too small. Returns true if there was one.
  bool enlarge() {
    if (!lacks_capacity()) return false;
    for (int l = 0; l < levels(); ++l) grids_[l].enlarge(problem_, required(l));
    reserve();
    fits_ = false;
    return true;
  }

  /// Discretizes all grids at once. Where groups are clustered, the finest grid is first, because the host computes the
  /// coarse grids' sets of groups from its direct links (gap conductances). A group is a set of bodies with one
  /// potential.
  void discretize(const LaplaceProblem& problem) {
    if (!clustered()) return record(building_, [&] { build_from(0); });
    record(building_finest_, [&] {
      grids_[0].outline(problem_, nullptr);
      grids_[0].build(problem_);
      clustering_.list_links(problem_, grids_[0].view(), 0);
      if (levels() == 1) build_coarsest();
    });
    if (levels() == 1) return;
    clustering_.find_sets(problem, grids_.back().view().h);
    record(building_, [&] { build_from(1); });
  }
  template <class F>
  void record(typename Executor::Recording& recording, F f) {
    if (fits_)
      run_.run(recording, f);
    else
      f();
  }
  void build_from(int first) {
    for (int l = first; l < levels(); ++l) grids_[l].outline(problem_, l > 0 ? &grids_[l - 1].view() : nullptr);
    run_.for_each_concurrently(levels() - first, [&](int k) {
      const int l = first + k;
      grids_[l].build(problem_);
      if (clustered()) clustering_.list_links(problem_, grids_[l].view(), l);
      if (l + 1 == levels()) build_coarsest();
    });
  }
  void build_coarsest() {
    coarsest_.build(problem_, grids_.back().view());
    run_.copy(singular_.device, coarsest_.is_singular(), sizeof(int));
  }

  /// Returns the number of the finest grid that fits into one block's memory together with all coarser ones. Grid 0
  /// counts only if it is the only grid.
  int first_small() const {
    int first = levels() - 1;
    while (first > std::max(1, divided_) && levels() - first < SmallGrids::most &&
           small_grids(first - 1).bytes() <= run_.most_block_memory())
      --first;
    return first;
  }
  SmallGrids small_grids(int first) const {
    SmallGrids all{problem_,
                   views_.data(),
                   first,
                   levels() - 1,
                   coarsest_.unknown(),
                   coarsest_.inverse(),
                   coarsest_.precise_inverse(),
                   {}};
    for (int l = first; l < levels(); ++l)
      all.small[l - first] =
          SmallGrid(grids_[l].view().layout, medium_[l], l == first ? 0 : all.small[l - first - 1].end());
    return all;
  }

  void down(int l) {
    const GridView &grid = grids_[l].view(), &coarse = grids_[l + 1].view();
    if (l > 0) collect(run_, problem_, grid);
    exchange_ghosts(run_, grid, grid.cycle.f, ghosts_of_rhs);
    descend(run_, problem_, grid, coarse);
    if (l + 1 == divided_) exchange_rows(run_, coarse, coarse.cycle.f, coarse.layout.ny);
  }
  void up(int l, double* z_of_groups) {
    const GridView& coarse = grids_[l + 1].view();
    exchange_ghosts(run_, coarse, coarse.cycle.v, ghosts_of_correction);
    const bool was_small = on_device() && l + 1 == first_solved_;
    if (!was_small && coarse.may_have(Items::newly_absorbed))
      interpolate_absorbed(run_, problem_, coarse, PotentialInCell{problem_, coarse});
    ascend(run_, problem_, grids_[l].view(), coarse, z_of_groups);
  }

  /// Computes the part of the V-cycle on the small grids by one kernel, or solves on the coarsest grid by the host.
  void solve_coarse() {
    const GridView& grid = grids_.back().view();
    if (!on_device()) {
      if (levels() > 1) collect(run_, problem_, grid);
      return coarsest_.solve(grid, grid.cycle.v);
    }
    const SmallGrids all = small_grids(first_solved_);
    run_.template for_each_block<SmallGrids::threads>(1, all.bytes(), all);
  }

  const Executor& run_;
  std::vector<DeviceGrid<Executor>> grids_;
  std::vector<bool> medium_;                 // by grid
  ProblemView given_problem_{}, problem_{};  // problem_: with sets of groups
  Coarsest<Executor> coarsest_;
  parallel::Array<GridView, Executor> views_{run_};
  /// First of the grids that one kernel or the host solves.
  int first_solved_ = 0;
  parallel::Array<int, Executor> number_{run_};
  parallel::PackedTransfer<Executor> numbers_;
  typename parallel::PackedTransfer<Executor>::template MirroredArray<int> required_, singular_;
  bool fits_ = false;  // as far as is known
  int generation_ = 0;
  int solves_without_strong_links_ = 0;  // in a row
  typename Executor::Recording building_, building_finest_;
  typename Executor::Recording recording_;
  Clustering<Executor> clustering_;
  parallel::Array<double, Executor> group_result_{run_};  // PreconditionedResidual::group
  parallel::Array<float, Executor> guess_{run_};          // KeptGuess of all coarse grids
  int divided_ = 0;                                       // grids with rows divided among ranks
  parallel::Array<double, Executor> from_ranks_{run_};    // GridView::from_ranks
};

}  // namespace lichtenberg::laplace::device
