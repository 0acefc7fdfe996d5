#pragma once

#include <cstdint>
#include <vector>

#include "solvers/laplace/cutcell/level.hpp"
#include "solvers/parallel/team.hpp"

namespace lichtenberg::laplace {

/// List of the covered cells of one grid (cells inside conductors), by body. The class transfers values between these
/// cells and the groups (bodies with one potential).
class CoveredCells {
 public:
  /// Lists the covered cells (inside conductors) of `level` in own rows and the group (bodies with one potential) of
  /// each body.
  void build(const LaplaceProblem& problem, const Level& level) {
    if (level.layout.is_divided()) {
      list_own_cells(level);
    } else {
      cell_.assign(level.covered.begin(), level.covered.end());
      start_ = level.covered_start;
    }
    group_.clear();
    for (const Body& body : problem.bodies) group_.push_back(body.group);
  }

  /// Sets each covered cell (inside a conductor) in v (by slot, the memory index) to the potential of its group (bodies
  /// with one potential). `potential` [groups]. The thread team divides the bodies into `chunks` tasks.
  void fill(const std::vector<float>& potential, parallel::Team& team, int chunks, std::vector<float>& v) const {
    const int bodies = static_cast<int>(group_.size());
    team.for_each(chunks, [&](int chunk) {
      for (int body = bodies * chunk / chunks; body < bodies * (chunk + 1) / chunks; ++body)
        for (int m = start_[body]; m < start_[body + 1]; ++m) v[cell_[m]] = potential[group_[body]];
    });
  }

  /// Adds the values of covered cells (inside conductors) in f (by slot, the memory index) to their groups (bodies with
  /// one potential) in `group_value` [groups].
  void add_to_groups(const std::vector<float>& f, float* group_value) const {
    const int bodies = static_cast<int>(group_.size());
    for (int body = 0; body < bodies; ++body) {
      float sum = 0;
      for (int m = start_[body]; m < start_[body + 1]; ++m) sum += f[cell_[m]];
      group_value[group_[body]] += sum;
    }
  }

 private:
  void list_own_cells(const Level& level) {
    cell_.clear();
    start_.assign(1, 0);
    for (std::size_t body = 0; body + 1 < level.covered_start.size(); ++body) {
      for (int m = level.covered_start[body]; m < level.covered_start[body + 1]; ++m)
        if (level.layout.owns(level.covered[m])) cell_.push_back(static_cast<std::int32_t>(level.covered[m]));
      start_.push_back(static_cast<int>(cell_.size()));
    }
  }

  // Slots by body; [bodies + 1] a body's first in them; its group.
  std::vector<std::int32_t> cell_;
  std::vector<int> start_, group_;
};

}  // namespace lichtenberg::laplace
