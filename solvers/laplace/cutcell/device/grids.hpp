#pragma once

#include <algorithm>

#include "solvers/laplace/cutcell/device/bound.hpp"
#include "solvers/laplace/cutcell/device/conductances.hpp"
#include "solvers/laplace/cutcell/device/direct_links.hpp"
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
        extent_(run),
        permittivity_(run),
        east_(run),
        north_(run),
        point_start_(run),
        body_in_bin_(run),
        point_(run),
        points_before_(run),
        first_in_point_(run),
        group_bin_start_(run),
        group_in_bin_(run),
        smeared_bodies_(run),
        points_(run),
        smeared_groups_(run),
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
        coupling_(run),
        direct_link_(run),
        unsorted_direct_link_(run),
        direct_link_index_(run),
        direct_link_start_(run),
        is_bound_(run),
        joined_before_(run),
        link_share_(run),
        link_kept_(run),
        joined_link_(run),
        unsorted_joined_link_(run),
        joined_start_(run),
        piece_start_(run),
        piece_begin_(run),
        piece_end_(run),
        piece_segment_(run),
        pieces_done_(run),
        own_group_(run),
        group_diagonal_(run),
        cycle_diagonal_(run),
        group_inverse_diagonal_(run),
        v_(run),
        f_(run),
        phi_(run),
        phi_down_(run),
        phi_next_(run),
        charge_(run),
        flux_(run),
        partial_(run),
        partial_double_(run),
        group_rhs_(run) {
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
  /// Of so many that are covered.
  long fluid_cells(const Numbers& numbers) const {
    return static_cast<long>(view_.layout.nx) * view_.layout.ny - numbers[Of::covered];
  }
  /// Sums by piece, in double precision.
  double* partial() const { return partial_double_.data(); }

  /// What the host may know of a grid: how many of each kind there is room for. `number`, `wanted`: on the device.
  /// `medium`: some bodies are smaller than this grid resolves; `small`: its groups are listed; `clusters`: where
  /// there may be any; `finest`: the grid whose direct links this coarse one inherits, null: none. Arrays may move.
  void make_room(const ProblemView& problem, bool medium, int* number, int* wanted, bool small = false,
                 const ClusterView* clusters = nullptr, const GridView* finest = nullptr,
                 const ClusterView* exact_clusters = nullptr) {
    view_.medium = medium;
    view_.clusters = clusters;
    view_.exact_clusters = exact_clusters;
    view_.finest_link = finest ? finest->direct_link : nullptr;
    view_.finest_link_start = finest ? finest->direct_link_start : nullptr;
    const bool inherits_joined = finest && finest->may_have(Of::joined_links);
    view_.finest_joined = inherits_joined ? finest->joined_link : nullptr;
    view_.finest_joined_start = inherits_joined ? finest->joined_start : nullptr;
    view_.own_group = small ? sized(own_group_, problem.groups) : nullptr;
    if (!medium)  // what was smeared out before is in the bins still
      for (const Of::Kind kind : {Of::newly_absorbed, Of::thin_conductors, Of::floating_thin_conductors})
        view_.room[kind] = 0;
    view_.number = number;
    view_.wanted = wanted;
    make_room_for_bodies(problem);
    if (medium) make_room_for_medium(problem);
    make_room_for_lists(problem);
    make_room_for_groups(problem);
  }
  bool fits(const Numbers& wanted) const {
    for (int kind = 0; kind < Of::kinds; ++kind)
      if (wanted[kind] > view_.room[kind]) return false;
    return true;
  }
  /// For make_room(): so many and, in a scene in motion, half as many more, of all that may soon be too many: growing
  /// costs as much as ten solves. The coarsest grid's matrix is to stay small, and changes by groups alone.
  void enlarge(const ProblemView& problem, const Numbers& wanted) {
    if (view_.medium && wanted[Of::strips] > 0) {
      // Groups in motion become thin conductors on one grid after the other: there is room for all at once.
      for (const Of::Kind kind : {Of::newly_absorbed, Of::thin_conductors, Of::floating_thin_conductors})
        view_.room[kind] = std::max(view_.room[kind], problem.bodies);
      view_.room[Of::strips] = std::max(view_.room[Of::strips], wanted[Of::strips] + problem.bodies);
      view_.room[Of::links] = std::max(view_.room[Of::links], wanted[Of::links] + 4 * problem.bodies);
    }
    for (int kind = 0; kind < Of::kinds; ++kind) {
      const bool is_near = wanted[kind] + wanted[kind] / 8 > view_.room[kind];
      const int spare = kind == Of::coarse_unknowns ? 16 : wanted[kind] / 2 + 256;
      if (wanted[kind] > 0 && is_near) view_.room[kind] = wanted[kind] + spare;
    }
  }

  /// Whether the cycle is to eliminate bound cells; make_room() is to follow.
  void set_binding(bool binds) { view_.binds = binds; }
  /// Until there is one again, which enlarge() has to be told of; make_room() is to follow.
  void forget_strong_links() { view_.room[Of::strong_links] = 0; }

  /// `finer`: the next finer grid, whose outlines have been made; null for the finest.
  void outline(const ProblemView& problem, const GridView* finer) {
    outline_bodies(run_, problem, view_);
    if (view_.medium)
      absorb_groups(run_, problem, view_, finer && finer->medium ? finer->absorbed : nullptr, sort_key_.data(),
                    view_.absorbed_groups.item);
  }

  /// The rest, for which all outlines have been made.
  void build(const ProblemView& problem) {
    if (view_.medium) smear(problem);
    cover(problem);
    count(problem);
    fill_strips(run_, problem, filled());
    if (view_.medium) make_permittivity(run_, view_);
    make_links(run_, problem, view_);
    make_diagonals(run_, problem, view_);
    if (view_.binds) bind(problem);
    build_direct_links(problem);
    build_groups(problem);
  }

 private:
  void make_room_for_bodies(const ProblemView& problem) {
    view_.outline = sized(outline_, problem.bodies);
    view_.present = sized(present_, problem.bodies);
    view_.cell_owner = sized(cell_owner_, problem.bodies);
    view_.resolved = sized(resolved_, problem.bodies);
    view_.strip_start = sized(strip_start_, problem.bodies + 1);
    view_.direct_link_start = sized(direct_link_start_, problem.bodies + 1);
    sized(without_cells_number_, problem.bodies + 1);
    sized(sort_key_,
          std::max({problem.groups, problem.bodies, view_.room[Of::direct_links], view_.room[Of::joined_links]}));
    view_.joined_start = sized(joined_start_, problem.bodies + 1);
  }

  void make_room_for_medium(const ProblemView& problem) {
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
    view_.extent = problem.sets.of_group ? sized(extent_, 2L * problem.groups) : nullptr;
    const int bins = bins_of(view_.layout);
    view_.absorbed_groups = {sized(group_bin_start_, bins + 1), sized(smeared_groups_, problem.groups),
                             sized(group_in_bin_, problem.groups)};
    view_.absorbed_bodies = {sized(point_start_, 2 * bins + 1), sized(points_, problem.bodies),
                             sized(body_in_bin_, problem.bodies)};
    view_.point = sized(point_, problem.bodies);
    for (auto* array : {&points_before_, &first_in_point_}) array->resize(problem.bodies + 1);
    smeared_bodies_.resize(problem.bodies);
    view_.thin_conductors = view_.absorbed_bodies;
    view_.thin_conductors.start += bins;  // behind them
  }

  void make_room_for_lists(const ProblemView& problem) {
    const Numbers& room = view_.room;
    view_.counts = sized(counts_, room[Of::strips] + 1);
    view_.covered_slot = sized(covered_slot_, room[Of::covered]);
    view_.covered_group = sized(covered_group_, room[Of::covered]);
    view_.link_slot = sized(link_slot_, room[Of::links]);
    view_.link_end = sized(link_end_, room[Of::links]);
    view_.link_group = sized(link_group_, room[Of::links]);
    view_.conductance = sized(conductance_, room[Of::links]);
    if (view_.finest) {
      view_.gradient = sized(gradient_, room[Of::links]);
      view_.partner_group = sized(partner_group_, room[Of::links]);
      view_.partner_gradient = sized(partner_gradient_, room[Of::links]);
    }
    view_.boundary_slot = sized(boundary_slot_, room[Of::boundary]);
    view_.boundary_link = sized(boundary_link_, 4L * room[Of::boundary]);
    view_.boundary_diagonal = sized(boundary_diagonal_, room[Of::boundary]);
    view_.coupling = sized(coupling_, 4L * room[Of::boundary]);
    view_.direct_link = sized(direct_link_, room[Of::direct_links]);
    if (view_.may_have(Of::without_cells)) sized(unsorted_direct_link_, room[Of::direct_links]);
    sized(direct_link_index_, std::max(room[Of::direct_links], room[Of::joined_links]));
    if (view_.binds) {
      view_.is_bound = sized(is_bound_, room[Of::boundary]);
      sized(joined_before_, room[Of::boundary] + 1);
      view_.link_share = sized(link_share_, room[Of::links]);
      view_.link_kept = sized(link_kept_, room[Of::links]);
      view_.joined_link = sized(joined_link_, room[Of::joined_links]);
      sized(unsorted_joined_link_, room[Of::joined_links]);
    } else {
      view_.room[Of::joined_links] = 0;
    }
    view_.pieces = (room[Of::links] + room[Of::covered]) / piece_length + 2 * problem.groups;
  }

  void make_room_for_groups(const ProblemView& problem) {
    view_.piece_start = sized(piece_start_, 2 * problem.groups + 1);
    view_.piece_begin = sized(piece_begin_, view_.pieces);
    view_.piece_end = sized(piece_end_, view_.pieces);
    view_.piece_segment = sized(piece_segment_, view_.pieces);
    view_.pieces_done = sized(pieces_done_, 2 * problem.groups);
    pieces_done_.zero();
    view_.partial = sized(partial_, view_.pieces);
    sized(partial_double_, view_.pieces);
    view_.group_diagonal = sized(group_diagonal_, problem.groups);
    view_.cycle_diagonal = view_.binds ? sized(cycle_diagonal_, problem.groups) : view_.group_diagonal;
    view_.group_inverse_diagonal = sized(group_inverse_diagonal_, problem.groups);
    view_.phi = sized(phi_, problem.groups);
    view_.phi_down = sized(phi_down_, problem.groups);
    view_.phi_next = sized(phi_next_, problem.groups);
    view_.charge = sized(charge_, problem.groups);
    view_.flux = sized(flux_, problem.groups);
    view_.group_rhs = view_.clusters ? sized(group_rhs_, problem.groups) : nullptr;
  }

  /// Sorts what is smeared out by where it is.
  void smear(const ProblemView& problem) {
    const int bins = bins_of(view_.layout);
    int* key = sort_key_.data();
    run_.sort(key, view_.absorbed_groups.item, problem.groups, bins);
    start_segments(run_, key, problem.groups, bins, view_.absorbed_groups.start);
    smeared_keys(run_, problem, view_, key, view_.absorbed_bodies.item);
    run_.sort(key, view_.absorbed_bodies.item, problem.bodies, 2 * bins);
    const PointsView points{key, points_before_.data(), first_in_point_.data(), smeared_bodies_.data()};
    number_points(run_, problem, view_, points);
    start_segments(run_, key, problem.bodies, 2 * bins, view_.absorbed_bodies.start, points.before);
    share_out(run_, problem, view_, points);
  }

  void cover(const ProblemView& problem) {
    count_strips(run_, problem, view_);
    run_.exclusive_scan(view_.strip_start, problem.bodies + 1);
    settle_strips(run_, problem, view_);
    run_.fill(cover_.data(), 0xff, cover_.size() * sizeof(Cover));  // fluid
    cover_cells(run_, problem, view_);
  }

  void count(const ProblemView& problem) {
    count_in_strips(run_, problem, view_);
    run_.exclusive_scan(view_.counts, view_.room[Of::strips] + 1);
    count_without_cells(run_, problem, view_, without_cells_number_.data());
    run_.exclusive_scan(without_cells_number_.data(), problem.bodies + 1);
    settle_lists(run_, problem, view_, without_cells_number_.data());
  }

  /// With the list of direct links that is filled, which may have to be sorted.
  GridView filled() const {
    GridView view = view_;
    if (view_.may_have(Of::without_cells)) view.direct_link = unsorted_direct_link_.data();
    return view;
  }

  void build_direct_links(const ProblemView& problem) {
    const int room = view_.room[Of::direct_links];
    if (room == 0) {
      run_.fill(view_.direct_link_start, 0, direct_link_start_.size() * sizeof(int));
      return;
    }
    const GridView list = filled();
    int *key = sort_key_.data(), *index = direct_link_index_.data();
    if (view_.may_have(Of::without_cells)) list_without_cells(run_, problem, list, without_cells_number_.data());
    make_direct_links(run_, problem, list);
    direct_link_keys(run_, problem, view_, Of::direct_links, list.direct_link, key, index);
    if (view_.may_have(Of::without_cells)) {
      run_.sort(key, index, room, problem.bodies);
      sort_direct_links(run_, view_, Of::direct_links, list.direct_link, index, view_.direct_link);
    }
    start_segments(run_, key, room, problem.bodies, view_.direct_link_start);
  }

  void bind(const ProblemView& problem) {
    find_bound_cells(run_, problem, view_, joined_before_.data());
    const int room = view_.room[Of::joined_links];
    if (room == 0) return;
    DirectLink* unsorted = unsorted_joined_link_.data();
    int *key = sort_key_.data(), *index = direct_link_index_.data();
    list_joined(run_, problem, view_, joined_before_.data(), unsorted);
    direct_link_keys(run_, problem, view_, Of::joined_links, unsorted, key, index);
    run_.sort(key, index, room, problem.bodies);
    sort_direct_links(run_, view_, Of::joined_links, unsorted, index, view_.joined_link);
    start_segments(run_, key, room, problem.bodies, view_.joined_start);
  }

  void build_groups(const ProblemView& problem) {
    phi_.zero();
    phi_next_.zero();  // of groups of given potential
    if (view_.clusters) phi_down_.zero();
    count_pieces(run_, problem, view_);
    run_.exclusive_scan(view_.piece_start, 2 * problem.groups + 1);
    cut_pieces(run_, problem, view_);
    make_group_diagonals(run_, problem, view_, partial_double_.data());
    if (view_.binds) make_cycle_diagonals(run_, problem, view_, partial_double_.data());
  }

  template <class T>
  static T* sized(parallel::Array<T, Executor>& array, long size) {
    array.resize(size);
    return array.data();
  }

  const Executor& run_;
  GridView view_{};
  parallel::Array<Outline, Executor> outline_;
  parallel::Array<int, Executor> present_, cell_owner_, resolved_, absorbed_;
  parallel::Array<Vec2, Executor> centre_;
  parallel::Array<Extent, Executor> extent_;
  parallel::Array<float, Executor> permittivity_, east_, north_;
  parallel::Array<int, Executor> point_start_, body_in_bin_, point_, points_before_, first_in_point_, group_bin_start_,
      group_in_bin_;
  parallel::Array<Smeared, Executor> smeared_bodies_, points_, smeared_groups_;
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
  parallel::Array<Coupling, Executor> coupling_;
  parallel::Array<DirectLink, Executor> direct_link_, unsorted_direct_link_;
  parallel::Array<int, Executor> direct_link_index_, direct_link_start_;
  parallel::Array<int, Executor> is_bound_, joined_before_;
  parallel::Array<float, Executor> link_share_;
  parallel::Array<double, Executor> link_kept_;
  parallel::Array<DirectLink, Executor> joined_link_, unsorted_joined_link_;
  parallel::Array<int, Executor> joined_start_;
  parallel::Array<int, Executor> piece_start_, piece_begin_, piece_end_, piece_segment_, pieces_done_, own_group_;
  parallel::Array<double, Executor> group_diagonal_, cycle_diagonal_;
  parallel::Array<float, Executor> group_inverse_diagonal_, v_, f_, phi_, phi_down_, phi_next_, charge_, flux_,
      partial_;
  parallel::Array<double, Executor> partial_double_, group_rhs_;
};

}  // namespace lichtenberg::laplace::device
