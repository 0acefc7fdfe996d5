#pragma once

#include "solvers/laplace/cutcell/layout.hpp"
#include "solvers/laplace/cutcell/surface_links.hpp"
#include "solvers/parallel/array.hpp"

namespace lichtenberg::laplace::device {

/// Agglomerates as device pointers: sets of groups (bodies with one potential) that coarse grids treat as one
/// (../agglomerates.hpp). Null pointers: each group is its own set.
struct SetsView {
  /// By group: first group of its set.
  const int* first_group;
  /// Groups sorted by set; `start`: by a set's first group, the index of its groups in `group`.
  const int *start, *group;
  /// By group. `is_alone`: whether its set is one floating body; `held`: whether its set is grounded
  /// (Agglomerates::is_grounded).
  const int *is_alone, *held;
  bool operator==(const SetsView&) const = default;
};

/// Couplings (lumped capacitances) between groups as conductances per permittivity, in a list for each floating group
/// (device pointers). A group is a set of bodies with one potential.
struct CouplingView {
  /// `start` [groups + 1]: index of a group's first entry in `other` and `conductance`; null: no couplings. `other`:
  /// group at the other end.
  const int *start, *other;
  const double* conductance;
  /// Sum of all conductances to groups of given potential (one value).
  const double* to_given;
  /// True if all given potentials are those of coupled groups, so that only couplings ground the field.
  bool only_ground;
  bool operator==(const CouplingView&) const = default;
};

/// Bodies, groups (bodies with one potential) and sides of a problem as device pointers, common to all grids. Bodies
/// are sorted by group; a body's place in this order is its rank. Lists of links and of covered cells follow this
/// order, so that the entries of a body or a group are contiguous.
struct ProblemView {
  int bodies;
  /// Number of groups that the arrays have memory for. Groups after the problem's own have no bodies and a given
  /// potential.
  int groups;
  Vec2 size;
  double permittivity;
  bool electrode[4];
  /// False if no potential is given, so that potentials are determined up to a constant.
  bool grounded;
  /// Number of entries of `side_potential` for each side.
  int faces;
  /// Potential (V) on the finest grid's faces, by side and face.
  const double* side_potential;
  /// Shape by body, lengths in metres.
  const Outline* shape;
  /// Group of each body.
  const int* group_of;
  /// Body of each rank.
  const int* body_at;
  /// Rank of each body.
  const int* rank_of;
  /// [groups + 1] rank of each group's first body.
  const int* first_rank;
  /// 1 if a group's potential is unknown (given charge), else 0.
  const int* floating;
  /// Charge (C/m) by group.
  const double* charge;
  /// Given potential (V) by group; 0 for floating groups.
  const double* potential;
  SetsView sets;
  CouplingView couplings;

  /// Returns the number of bodies of group g. A group is a set of bodies with one potential.
  LICHTENBERG_HOST_DEVICE int members(int g) const { return first_rank[g + 1] - first_rank[g]; }
  /// Returns the t-th body of group g. A group is a set of bodies with one potential.
  LICHTENBERG_HOST_DEVICE int member(int g, int t) const { return body_at[first_rank[g] + t]; }
  bool operator==(const ProblemView&) const = default;
};

}  // namespace lichtenberg::laplace::device
