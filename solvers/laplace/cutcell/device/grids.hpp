#pragma once

#include "solvers/laplace/cutcell/device/discretize.hpp"
#include "solvers/laplace/cutcell/device/operator.hpp"
#include "solvers/laplace/cutcell/device/pieces.hpp"

namespace lichtenberg::laplace::device {

/// One grid on the device: its memory and how it is filled.
template <class Executor>
class DeviceGrid {
 public:
  DeviceGrid(const Executor& run, int nx, int ny, double h, LinkFormula formula, bool finest)
      : run_(run),
        outline_(run),
        present_(run),
        cell_owner_(run),
        resolved_(run),
        absorbed_(run),
        centre_(run),
        permittivity_(run),
        east_(run),
        north_(run),
        body_bin_start_(run),
        body_in_bin_(run),
        group_bin_start_(run),
        group_in_bin_(run),
        without_cells_number_(run),
        sort_key_(run),
        cover_(run),
        inverse_diagonal_(run),
        strip_start_(run),
        counts_(run),
        covered_slot_(run),
        covered_group_(run),
        link_slot_(run),
        link_group_(run),
        link_end_(run),
        conductance_(run),
        gradient_(run),
        partner_group_(run),
        partner_gradient_(run),
        boundary_slot_(run),
        boundary_link_(run),
        boundary_diagonal_(run),
        direct_link_(run),
        sorted_direct_link_(run),
        direct_link_index_(run),
        direct_link_start_(run),
        unknown_groups_(run),
        piece_start_(run),
        piece_begin_(run),
        piece_end_(run),
        group_diagonal_(run),
        group_inverse_diagonal_(run),
        v_(run),
        f_(run),
        phi_(run),
        phi_next_(run),
        charge_(run),
        flux_(run),
        partial_(run),
        partial_double_(run) {
    view_.layout = Layout(nx, ny);
    view_.h = h;
    view_.formula = formula;
    view_.finest = finest;
    const std::size_t size = view_.layout.size();
    cover_.resize(size);
    inverse_diagonal_.resize(size);
    inverse_diagonal_.zero();
    f_.resize(size);
    f_.zero();
    view_.cover = cover_.data();
    view_.inverse_diagonal = inverse_diagonal_.data();
    view_.f = f_.data();
    if (finest) return;
    v_.resize(size);
    v_.zero();
    view_.v = v_.data();
  }

  const GridView& view() const { return view_; }
  int covered() const { return covered_; }
  long fluid_cells() const { return static_cast<long>(view_.layout.nx) * view_.layout.ny - covered_; }
  /// Sums by piece, in double precision.
  double* partial() const { return partial_double_.data(); }

  /// `medium`: some bodies are smaller than this grid resolves; `finer`: the next finer grid, null for the finest.
  void build(const ProblemView& problem, bool medium, const GridView* finer) {
    view_.medium = medium;
    outline(problem, finer);
    const int strips = cover(problem);
    count(problem, strips);
    fill_strips(run_, problem, view_, strips);
    run_.fill(boundary_link_.data(), 0xff, boundary_link_.size() * sizeof(int));
    if (medium) make_permittivity(run_, problem, view_);
    make_links(run_, problem, view_);
    make_diagonals(run_, problem, view_);
    build_direct_links(problem);
    build_groups(problem);
  }

 private:
  void outline(const ProblemView& problem, const GridView* finer) {
    view_.outline = sized(outline_, problem.bodies);
    view_.present = sized(present_, problem.bodies);
    view_.cell_owner = sized(cell_owner_, problem.bodies);
    view_.resolved = sized(resolved_, problem.bodies);
    view_.thin_conductors = view_.newly_absorbed = 0;
    outline_bodies(run_, problem, view_);
    if (view_.medium) smear(problem, finer && finer->medium ? finer->absorbed : nullptr);
  }

  /// Sorts what is smeared out by where it is.
  void smear(const ProblemView& problem, const int* finer_absorbed) {
    const std::size_t size = view_.layout.size();
    if (permittivity_.size() == 0)
      for (auto* array : {&permittivity_, &east_, &north_}) {
        array->resize(size);
        array->zero();
      }
    view_.permittivity = permittivity_.data();
    view_.east = east_.data();
    view_.north = north_.data();
    view_.absorbed = sized(absorbed_, problem.groups);
    view_.centre = sized(centre_, problem.groups);
    const int bins = bins_of(view_.layout);
    int* key = sized(sort_key_, std::max(problem.groups, problem.bodies));
    view_.absorbed_groups = {sized(group_bin_start_, bins + 1), sized(group_in_bin_, problem.groups)};
    absorb_groups(run_, problem, view_, finer_absorbed, key, view_.absorbed_groups.item);
    run_.sort(key, view_.absorbed_groups.item, problem.groups);
    start_segments(run_, key, problem.groups, bins, view_.absorbed_groups.start);
    run_.to_host(&view_.newly_absorbed, view_.absorbed_groups.start + bins, sizeof(int));
    view_.smeared_bodies = {sized(body_bin_start_, bins + 1), sized(body_in_bin_, problem.bodies)};
    smeared_keys(run_, problem, view_, key, view_.smeared_bodies.item);
    run_.sort(key, view_.smeared_bodies.item, problem.bodies);
    start_segments(run_, key, problem.bodies, bins, view_.smeared_bodies.start);
  }

  /// Returns the number of strips.
  int cover(const ProblemView& problem) {
    view_.strip_start = sized(strip_start_, problem.bodies + 1);
    count_strips(run_, problem, view_);
    run_.exclusive_scan(view_.strip_start, problem.bodies + 1);
    int strips = 0;
    run_.to_host(&strips, view_.strip_start + problem.bodies, sizeof strips);
    run_.fill(cover_.data(), 0xff, cover_.size() * sizeof(Cover));  // fluid
    cover_cells(run_, problem, view_, strips);
    return strips;
  }

  void count(const ProblemView& problem, int strips) {
    view_.counts = sized(counts_, strips + 1);
    count_in_strips(run_, problem, view_, strips);
    run_.exclusive_scan(view_.counts, strips + 1);
    count_without_cells(run_, problem, view_, sized(without_cells_number_, problem.bodies + 1));
    run_.exclusive_scan(without_cells_number_.data(), problem.bodies + 1);
    Counts total;
    WithoutCells without_cells;
    run_.to_host(&total, view_.counts + strips, sizeof total);
    run_.to_host(&without_cells, without_cells_number_.data() + problem.bodies, sizeof without_cells);
    from_without_cells_ = without_cells.direct_links;
    view_.thin_conductors = without_cells.thin_conductors;
    view_.floating_thin_conductors = without_cells.floating_thin_conductors;
    covered_ = total.covered;
    from_strips_ = total.direct_links;
    view_.links = total.links;
    view_.boundary = total.boundary;
    view_.direct_links = total.direct_links + 2 * from_without_cells_;
    view_.covered_slot = sized(covered_slot_, total.covered);
    view_.covered_group = sized(covered_group_, total.covered);
    view_.link_slot = sized(link_slot_, total.links);
    view_.link_end = sized(link_end_, total.links);
    view_.link_group = sized(link_group_, total.links);
    view_.conductance = sized(conductance_, total.links);
    if (view_.finest) {
      view_.gradient = sized(gradient_, total.links);
      view_.partner_group = sized(partner_group_, total.links);
      view_.partner_gradient = sized(partner_gradient_, total.links);
    }
    view_.boundary_slot = sized(boundary_slot_, total.boundary);
    view_.boundary_link = sized(boundary_link_, 4 * total.boundary);
    view_.boundary_diagonal = sized(boundary_diagonal_, total.boundary);
    view_.direct_link = sized(direct_link_, view_.direct_links);
    view_.direct_link_start = sized(direct_link_start_, problem.bodies + 1);
  }

  void build_direct_links(const ProblemView& problem) {
    if (from_without_cells_ > 0) list_without_cells(run_, problem, view_, without_cells_number_.data(), from_strips_);
    make_direct_links(run_, problem, view_);
    int* key = sized(sort_key_, view_.direct_links);
    int* index = sized(direct_link_index_, view_.direct_links);
    direct_link_keys(run_, problem, view_, key, index);
    if (from_without_cells_ > 0) {
      run_.sort(key, index, view_.direct_links);
      sort_direct_links(run_, view_, index, sized(sorted_direct_link_, view_.direct_links));
      std::swap(direct_link_, sorted_direct_link_);
      view_.direct_link = direct_link_.data();
    }
    start_segments(run_, key, view_.direct_links, problem.bodies, view_.direct_link_start);
  }

  void build_groups(const ProblemView& problem) {
    view_.piece_start = sized(piece_start_, 2 * problem.groups + 1);
    view_.group_diagonal = sized(group_diagonal_, problem.groups);
    view_.group_inverse_diagonal = sized(group_inverse_diagonal_, problem.groups);
    view_.phi = sized(phi_, problem.groups);
    view_.phi_next = sized(phi_next_, problem.groups);
    view_.charge = sized(charge_, problem.groups);
    view_.flux = sized(flux_, problem.groups);
    phi_.zero();
    count_pieces(run_, problem, view_);
    run_.exclusive_scan(view_.piece_start, 2 * problem.groups + 1);
    run_.to_host(&view_.pieces, view_.piece_start + 2 * problem.groups, sizeof(int));
    view_.piece_begin = sized(piece_begin_, view_.pieces);
    view_.piece_end = sized(piece_end_, view_.pieces);
    view_.partial = sized(partial_, view_.pieces);
    cut_pieces(run_, problem, view_);
    make_group_diagonals(run_, problem, view_, sized(partial_double_, view_.pieces));
    count_unknown_groups(run_, problem, view_, sized(unknown_groups_, 1));
    run_.to_host(&view_.unknown_groups, unknown_groups_.data(), sizeof(int));
  }

  template <class T>
  static T* sized(parallel::Array<T, Executor>& array, long size) {
    array.resize(size);
    return array.data();
  }

  const Executor& run_;
  GridView view_{};
  int covered_ = 0, from_without_cells_ = 0, from_strips_ = 0;
  parallel::Array<Outline, Executor> outline_;
  parallel::Array<int, Executor> present_, cell_owner_, resolved_, absorbed_;
  parallel::Array<Vec2, Executor> centre_;
  parallel::Array<float, Executor> permittivity_, east_, north_;
  parallel::Array<int, Executor> body_bin_start_, body_in_bin_, group_bin_start_, group_in_bin_;
  parallel::Array<WithoutCells, Executor> without_cells_number_;
  parallel::Array<int, Executor> sort_key_;
  parallel::Array<Cover, Executor> cover_;
  parallel::Array<float, Executor> inverse_diagonal_;
  parallel::Array<int, Executor> strip_start_;
  parallel::Array<Counts, Executor> counts_;
  parallel::Array<int, Executor> covered_slot_, covered_group_, link_slot_, link_group_;
  parallel::Array<LinkEnd, Executor> link_end_;
  parallel::Array<double, Executor> conductance_;
  parallel::Array<Vec2, Executor> gradient_;
  parallel::Array<int, Executor> partner_group_;
  parallel::Array<Vec2, Executor> partner_gradient_;
  parallel::Array<int, Executor> boundary_slot_, boundary_link_;
  parallel::Array<double, Executor> boundary_diagonal_;
  parallel::Array<DirectLink, Executor> direct_link_, sorted_direct_link_;
  parallel::Array<int, Executor> direct_link_index_, direct_link_start_, unknown_groups_;
  parallel::Array<int, Executor> piece_start_, piece_begin_, piece_end_;
  parallel::Array<double, Executor> group_diagonal_;
  parallel::Array<float, Executor> group_inverse_diagonal_, v_, f_, phi_, phi_next_, charge_, flux_, partial_;
  parallel::Array<double, Executor> partial_double_;
};

}  // namespace lichtenberg::laplace::device
