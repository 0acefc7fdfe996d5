#pragma once

#include <algorithm>
#include <vector>

#include "solvers/laplace/cutcell/device/grid.hpp"
#include "solvers/laplace/problem.hpp"

namespace lichtenberg::laplace::device {

/// A problem's bodies, groups and sides on the device.
template <class Executor>
class DeviceProblem {
 public:
  explicit DeviceProblem(const Executor& run)
      : side_potential_(run),
        shape_(run),
        group_of_(run),
        body_at_(run),
        rank_of_(run),
        first_rank_(run),
        floating_(run),
        charge_(run),
        potential_(run) {}

  /// nx, ny: the finest grid's, on whose faces the sides' potentials are taken.
  void upload(const LaplaceProblem& problem, int nx, int ny) {
    upload_bodies(problem);
    upload_groups(problem);
    upload_sides(problem, nx, ny);
  }

  ProblemView view() const {
    ProblemView view = view_;
    view.side_potential = side_potential_.data();
    view.shape = shape_.data();
    view.group_of = group_of_.data();
    view.body_at = body_at_.data();
    view.rank_of = rank_of_.data();
    view.first_rank = first_rank_.data();
    view.floating = floating_.data();
    view.charge = charge_.data();
    view.potential = potential_.data();
    return view;
  }

 private:
  void upload_bodies(const LaplaceProblem& problem) {
    const int bodies = static_cast<int>(problem.bodies.size()), groups = static_cast<int>(problem.groups.size());
    std::vector<Outline> shape;
    std::vector<int> group_of, body_at(bodies), rank_of(bodies), first_rank(groups + 1, 0);
    for (const Body& body : problem.bodies) {
      shape.push_back(outline_in_cells(body.shape, 1.0));
      group_of.push_back(body.group);
      ++first_rank[body.group + 1];
    }
    for (int g = 0; g < groups; ++g) first_rank[g + 1] += first_rank[g];
    std::vector<int> next(first_rank.begin(), first_rank.end() - 1);
    for (int body = 0; body < bodies; ++body) {
      rank_of[body] = next[group_of[body]]++;
      body_at[rank_of[body]] = body;
    }
    shape_.upload(shape);
    group_of_.upload(group_of);
    body_at_.upload(body_at);
    rank_of_.upload(rank_of);
    first_rank_.upload(first_rank);
    view_.bodies = bodies;
    view_.groups = groups;
    view_.size = problem.size;
    view_.permittivity = problem.permittivity;
  }

  void upload_groups(const LaplaceProblem& problem) {
    std::vector<int> floating;
    std::vector<double> charge, potential;
    for (const Group& group : problem.groups) {
      floating.push_back(group.floating);
      charge.push_back(group.floating ? group.charge : 0.0);
      potential.push_back(group.floating ? 0.0 : group.potential);
    }
    floating_.upload(floating);
    charge_.upload(charge);
    potential_.upload(potential);
  }

  void upload_sides(const LaplaceProblem& problem, int nx, int ny) {
    const double h = problem.size.x / nx;
    view_.faces = std::max(nx, ny);
    std::vector<double> potential(4 * static_cast<std::size_t>(view_.faces), 0.0);
    for (int side = 0; side < 4; ++side) {
      view_.electrode[side] = problem.sides[side].kind == Side::Kind::electrode;
      if (!view_.electrode[side]) continue;
      for (int k = 0; k < (side < 2 ? ny : nx); ++k) {
        const int far = side == right ? nx - 1 : side == top ? ny - 1 : 0;
        const Vec2 centre = side < 2 ? cell_centre(far, k) : cell_centre(k, far);
        potential[side * view_.faces + k] = problem.sides[side].potential_at(h * (centre + 0.5 * direction(side)));
      }
    }
    side_potential_.upload(potential);
  }

  ProblemView view_{};
  parallel::Array<double, Executor> side_potential_;
  parallel::Array<Outline, Executor> shape_;
  parallel::Array<int, Executor> group_of_, body_at_, rank_of_, first_rank_, floating_;
  parallel::Array<double, Executor> charge_, potential_;
};

}  // namespace lichtenberg::laplace::device
