#pragma once

// Initial guesses from the change of a solution on a coarser grid, as ../follow.hpp.

#include "solvers/laplace/cutcell/device/operator.hpp"

namespace lichtenberg::laplace::device {

/// Last solution of a solver on a coarser grid, by slot (memory index) of its finest grid and by body, in units of
/// `scale` (V). If `bodies` is 0, there is no solution.
struct CoarseSolution {
  Layout layout;
  int bodies = 0;
  SolutionView potentials{};
  double scale = 1;

  /// Returns the potential (V) of the cell at slot k or, for k beyond the slots, of a body. A slot is the memory index
  /// of a cell.
  LICHTENBERG_HOST_DEVICE double potential(int k) const {
    const int cells = static_cast<int>(layout.size());
    return scale * (k < cells ? potentials.cell[k] : potentials.body[k - cells]);
  }
};

/// Change of the potentials on a coarser grid between two solves, by slot (memory index) of its layout and by body. The
/// unit is that of the call of Follower::compare().
struct ChangeView {
  Layout layout;
  const double *cell, *body;
};

/// Stored solution of the solver on a coarser grid that this solver follows, and the change of that solver's
/// potentials. The arrays move only if the number of bodies or the coarser grid changes.
template <class Executor>
class Follower {
 public:
  explicit Follower(const Executor& run) : run_(run), then_(run), change_(run) {}

  /// Stores the potentials of `now`; compare() compares later potentials with them.
  void keep(const CoarseSolution& now) {
    layout_ = now.layout;
    bodies_ = now.bodies;
    if (bodies_ == 0) return;
    for (auto* array : {&then_, &change_}) array->resize(size());
    double* then = then_.data();
    run_.for_each(size(), [=] LICHTENBERG_HOST_DEVICE(int k) { then[k] = now.potential(k); });
  }
  /// Returns true if the stored solution has the grid and the number of bodies of `now`.
  bool is_comparable(const CoarseSolution& now) const {
    return now.bodies > 0 && now.bodies == bodies_ && now.layout.nx == layout_.nx && now.layout.ny == layout_.ny;
  }
  /// Computes the change from the stored solution to `now`, in units of `scale` (V).
  void compare(const CoarseSolution& now, double scale) {
    const double* then = then_.data();
    double* change = change_.data();
    run_.for_each(size(), [=] LICHTENBERG_HOST_DEVICE(int k) { change[k] = (now.potential(k) - then[k]) / scale; });
  }
  /// Returns device pointers to the change of potentials between two solves that compare() has computed.
  ChangeView change() const { return {layout_, change_.data(), change_.data() + layout_.size()}; }

 private:
  long size() const { return layout_.size() + bodies_; }

  const Executor& run_;
  Layout layout_;
  int bodies_ = 0;
  parallel::Array<double, Executor> then_, change_;  ///< cells, then bodies; `then_` in V
};

/// Computes an initial guess x: the newest solution plus the change on the coarser grid (add_change). The change is
/// interpolated bilinearly between cell centres. A floating group (bodies with one unknown potential) gets the mean of
/// its bodies, other groups 0. The change is even about an insulating side and odd about an electrode, whose potential
/// does not change.
template <class Executor>
void follow_change(const Executor& run, ProblemView problem, GridView grid, SolutionView newest, ChangeView change,
                   double* x) {
  const int cells = static_cast<int>(grid.layout.size());
  const double ratio = static_cast<double>(change.layout.nx) / grid.layout.nx;
  run.for_each(cells, [=] LICHTENBERG_HOST_DEVICE(int slot) {
    double value = 0;
    if (grid.cells.inverse_diagonal[slot] > 0) {
      const CellIndex cell = cell_of(grid.layout, slot);
      const Interpolation around =
          interpolate(change.layout, {ratio * (cell.i + 0.5), ratio * (cell.j + 0.5)}, problem.electrode);
      value = newest.cell[slot];
      for (int k = 0; k < 4; ++k) value += around.weight[k] * change.cell[around.cell[k]];
    }
    x[slot] = value;
  });
  average_bodies(run, problem, grid, x + cells,
                 [=] LICHTENBERG_HOST_DEVICE(int body) { return newest.body[body] + change.body[body]; });
}

}  // namespace lichtenberg::laplace::device
