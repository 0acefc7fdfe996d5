#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <new>
#include <numeric>
#include <tuple>
#include <vector>

#include "solvers/laplace/cutcell/device/grid.hpp"
#include "solvers/laplace/problem.hpp"

namespace lichtenberg::laplace::device {

/// Bodies, groups (bodies with one potential), sides and couplings (lumped capacitances) of a problem in device memory.
/// Arrays may move if the number of bodies changes or the reserved memory does not suffice.
template <class Executor>
class DeviceProblem {
 public:
  explicit DeviceProblem(const Executor& run) : parcel_(run), couplings_(run), side_potential_(run) {}

  /// Uploads a problem to the device. `nx`, `ny`: size of the finest grid, whose faces sample the sides' potentials.
  void upload(const LaplaceProblem& problem, int nx, int ny) {
    reserve(problem);
    send_sides(problem, nx, ny);
    write_bodies(problem);
    write_groups(problem);
    parcel_.send();
    send_couplings(problem);
  }

  /// Returns the device pointers to the problem's arrays.
  const ProblemView& view() const { return view_; }

 private:
  template <class T>
  using Transferred = typename parallel::PackedTransfer<Executor>::template MirroredArray<T>;

  void reserve(const LaplaceProblem& problem) {
    const std::size_t bodies = problem.bodies.size(), groups = problem.groups.size();
    view_.size = problem.size;
    view_.permittivity = problem.permittivity;
    view_.grounded = problem.has_ground();
    if (view_.shape && static_cast<int>(bodies) == view_.bodies && static_cast<int>(groups) <= view_.groups) return;
    // In motion the number of groups grows; reserving memory again takes as long as a hundred solves, so that the
    // second reservation is for as many groups as bodies.
    const std::size_t capacity = view_.shape ? std::max(groups, bodies) : groups;
    view_.bodies = static_cast<int>(bodies);
    view_.groups = static_cast<int>(capacity);
    std::tie(shape_, group_of_, body_at_, rank_of_, first_rank_, floating_, charge_, potential_) =
        parcel_.template divide<Outline, int, int, int, int, int, double, double>(
            {bodies, bodies, bodies, bodies, capacity + 1, capacity, capacity, capacity});
    view_.shape = shape_.device;
    view_.group_of = group_of_.device;
    view_.body_at = body_at_.device;
    view_.rank_of = rank_of_.device;
    view_.first_rank = first_rank_.device;
    view_.floating = floating_.device;
    view_.charge = charge_.device;
    view_.potential = potential_.device;
  }

  void write_bodies(const LaplaceProblem& problem) {
    const int bodies = view_.bodies, groups = view_.groups;
    int* first_rank = first_rank_.host;
    std::fill(first_rank, first_rank + groups + 1, 0);
    for (int body = 0; body < bodies; ++body) {
      new (shape_.host + body) Outline(outline_in_cells(problem.bodies[body], 1.0));
      group_of_.host[body] = problem.bodies[body].group;
      ++first_rank[problem.bodies[body].group + 1];
    }
    for (int g = 0; g < groups; ++g) first_rank[g + 1] += first_rank[g];
    next_.assign(first_rank, first_rank + groups);
    for (int body = 0; body < bodies; ++body) {
      rank_of_.host[body] = next_[group_of_.host[body]]++;
      body_at_.host[rank_of_.host[body]] = body;
    }
  }

  void write_groups(const LaplaceProblem& problem) {
    for (int g = 0; g < view_.groups; ++g) {
      const Group group = g < static_cast<int>(problem.groups.size()) ? problem.groups[g] : Group{.floating = false};
      floating_.host[g] = group.floating;
      charge_.host[g] = group.floating ? group.charge : 0.0;
      potential_.host[g] = group.floating ? 0.0 : group.potential;
    }
  }

  void send_couplings(const LaplaceProblem& problem) {
    view_.couplings = {};
    if (problem.couplings.empty()) return;
    const auto groups = static_cast<std::size_t>(view_.groups), entries = 2 * problem.couplings.size();
    if (entries > coupling_capacity_ || groups != coupling_groups_) {
      coupling_capacity_ = entries + entries / 2;
      coupling_groups_ = groups;
      std::tie(coupling_start_, coupled_to_, coupling_, to_given_) =
          couplings_.template divide<int, int, double, double>({groups + 1, coupling_capacity_, coupling_capacity_, 1});
    }
    const auto is_listed = [&](const laplace::Coupling& coupling, int own) {
      return problem.groups[own].floating && coupling.capacitance > 0;
    };
    int* start = coupling_start_.host;
    std::fill_n(start, groups + 1, 0);
    for (const laplace::Coupling& coupling : problem.couplings)
      for (const int own : {coupling.a, coupling.b}) start[own + 1] += is_listed(coupling, own);
    std::partial_sum(start, start + groups + 1, start);
    next_.assign(start, start + groups);
    *to_given_.host = 0;
    for (const laplace::Coupling& coupling : problem.couplings)
      for (const int own : {coupling.a, coupling.b}) {
        if (!is_listed(coupling, own)) continue;
        const int other = own == coupling.a ? coupling.b : coupling.a;
        coupled_to_.host[next_[own]] = other;
        coupling_.host[next_[own]++] = coupling.capacitance / problem.permittivity;
        if (!problem.groups[other].floating) *to_given_.host += coupling.capacitance / problem.permittivity;
      }
    couplings_.send();
    view_.couplings = {coupling_start_.device, coupled_to_.device, coupling_.device, to_given_.device,
                       problem.has_ground() && !problem.has_fixed_conductor()};
  }

  /// Uploads the potentials of the sides, unless the sides are unchanged.
  void send_sides(const LaplaceProblem& problem, int nx, int ny) {
    const int faces = std::max(nx, ny);
    bool same = view_.faces == faces;
    for (int side = 0; side < 4; ++side) {
      const Side& s = problem.sides[side];
      same = same && !s.profile && view_.electrode[side] == (s.kind == Side::Kind::electrode) &&
             constant_[side] == s.potential;
      constant_[side] = s.profile ? std::numeric_limits<double>::quiet_NaN() : s.potential;
      view_.electrode[side] = s.kind == Side::Kind::electrode;
    }
    if (same) return;
    view_.faces = faces;
    const double h = problem.size.x / nx;
    const Layout finest(nx, ny);
    std::vector<double> potential(4 * static_cast<std::size_t>(faces), 0.0);
    for (int side = 0; side < 4; ++side) {
      if (!view_.electrode[side]) continue;
      for (int k = 0; k < faces_of(finest, side); ++k) {
        const auto [i, j] = cell_at_face(finest, side, k);
        const Vec2 centre = cell_centre(i, j);
        potential[side * faces + k] = problem.sides[side].potential_at(h * (centre + 0.5 * direction(side)));
      }
    }
    side_potential_.upload(potential);
    view_.side_potential = side_potential_.data();
  }

  ProblemView view_{};
  parallel::PackedTransfer<Executor> parcel_;
  Transferred<Outline> shape_;
  Transferred<int> group_of_, body_at_, rank_of_, first_rank_, floating_;
  Transferred<double> charge_, potential_;
  parallel::PackedTransfer<Executor> couplings_;
  Transferred<int> coupling_start_, coupled_to_;
  Transferred<double> coupling_, to_given_;
  std::size_t coupling_capacity_ = 0, coupling_groups_ = 0;
  parallel::Array<double, Executor> side_potential_;
  /// Uniform potential of each side (V); NaN if it varies.
  std::array<double, 4> constant_{};
  std::vector<int> next_;
};

}  // namespace lichtenberg::laplace::device
