#pragma once

#include <memory>

#include "solvers/laplace/cutcell/device/coarsest_system.hpp"
#include "solvers/laplace/cutcell/device/grids.hpp"
#include "solvers/laplace/problem.hpp"

namespace lichtenberg::laplace::device {

/// The coarsest grid's solve. A small system's inverse is multiplied with on the device; a large one (a grid of an odd
/// number of cells) is factorized on the host: right-hand side down, solution up.
template <class Executor>
class Coarsest {
 public:
  explicit Coarsest(const Executor& run) : run_(run), unknown_(run), inverse_(run) {}

  void build(const LaplaceProblem& problem, const GridView& grid) {
    system_ = CoarsestSystem(download(problem, grid), !problem.has_ground());
    unknowns_ = static_cast<int>(system_.unknown().size());
    if (!on_device()) return;
    unknown_.upload(system_.unknown());
    inverse_.upload(system_.inverse());
  }

  bool on_device() const { return unknowns_ <= largest_inverse; }
  long unknowns() const { return unknowns_; }

  /// Fluid cells of v and phi from f and charge.
  void solve(const GridView& grid, float* v) {
    if (on_device())
      multiply_inverse(run_, grid, unknowns_, unknown_.data(), inverse_.data(), v);
    else
      solve_on_host(grid, v);
  }

 private:
  static constexpr int largest_inverse = 256;

  CoarsestArrays download(const LaplaceProblem& problem, const GridView& grid) {
    CoarsestArrays arrays;
    arrays.layout = grid.layout;
    const std::size_t size = grid.layout.size(), groups = problem.groups.size();
    get(arrays.inverse_diagonal, grid.inverse_diagonal, size);
    if (grid.medium) {
      get(arrays.east, grid.east, size);
      get(arrays.north, grid.north, size);
    }
    get(arrays.link_slot, grid.link_slot, grid.links);
    get(arrays.link_group, grid.link_group, grid.links);
    get(arrays.conductance, grid.conductance, grid.links);
    get(arrays.group_diagonal, grid.group_diagonal, groups);
    std::vector<DirectLink> direct_links(grid.direct_links);
    get(direct_links, grid.direct_link, grid.direct_links);
    for (const DirectLink& link : direct_links)
      if (!link.is_to_electrode())
        arrays.direct_links.push_back(
            {problem.bodies[link.own].group, problem.bodies[link.other].group, link.conductance});
    return arrays;
  }

  template <class T>
  void get(std::vector<T>& to, const T* from, std::size_t size) {
    to.resize(size);
    if (size > 0) run_.to_host(to.data(), from, size * sizeof(T));
  }

  void solve_on_host(const GridView& grid, float* v) {
    const std::size_t cells = grid.layout.size();
    get(f_, grid.f, cells);
    get(charge_, grid.charge, system_.groups());
    v_.assign(cells, 0.0f);
    phi_.assign(system_.groups(), 0.0f);
    system_.solve(f_, charge_, v_, phi_);
    run_.to_device(v, v_.data(), cells * sizeof(float));
    if (!phi_.empty()) run_.to_device(grid.phi, phi_.data(), phi_.size() * sizeof(float));
  }

  const Executor& run_;
  CoarsestSystem system_;
  int unknowns_ = 0;
  parallel::Array<int, Executor> unknown_;
  parallel::Array<float, Executor> inverse_;
  std::vector<float> f_, charge_, v_, phi_;
};

}  // namespace lichtenberg::laplace::device
