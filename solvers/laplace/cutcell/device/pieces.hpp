#pragma once

#include "solvers/laplace/cutcell/device/grid.hpp"

// Pieces of the groups' links and covered cells, over which sums run; and the groups' diagonals.

namespace lichtenberg::laplace::device {

/// Returns the start of a segment in its list. Segment s < groups is the links (conductances) of group s; segment
/// groups + s is its covered cells (inside conductors). A group is a set of bodies with one potential.
LICHTENBERG_HOST_DEVICE inline int piece_segment(const ProblemView& problem, const GridView& grid, int segment) {
  if (segment < problem.groups) return grid.link_start(problem.first_rank[segment]);
  return grid.covered_start(problem.first_rank[segment - problem.groups]);
}
/// Returns the end of a segment, a group's links (conductances) or covered cells (inside conductors), in its list.
/// Groups of given potential have an empty segment, because their sums are unused; at the end of a run they contain
/// most bodies. A group is a set of bodies with one potential.
LICHTENBERG_HOST_DEVICE inline int piece_segment_end(const ProblemView& problem, const GridView& grid, int segment) {
  const int group = segment < problem.groups ? segment : segment - problem.groups;
  if (!problem.floating[group]) return piece_segment(problem, grid, segment);
  return segment < problem.groups ? grid.link_start(problem.first_rank[group + 1])
                                  : grid.covered_start(problem.first_rank[group + 1]);
}

/// Computes the number of pieces (units of a parallel sum) of each segment. A segment is a group's links (conductances)
/// or covered cells (inside conductors). A group is a set of bodies with one potential.
template <class Executor>
void count_pieces(const Executor& run, ProblemView problem, GridView grid) {
  run.for_each(2 * problem.groups + 1, [=] LICHTENBERG_HOST_DEVICE(int segment) {
    int length = 0;
    if (segment < 2 * problem.groups)
      length = piece_segment_end(problem, grid, segment) - piece_segment(problem, grid, segment);
    grid.pieces.start[segment] = (length + piece_length - 1) / piece_length;
  });
}

/// Computes the range of each piece (unit of a parallel sum) in the list of links or of covered cells (inside
/// conductors).
template <class Executor>
void cut_pieces(const Executor& run, ProblemView problem, GridView grid) {
  run.for_each(grid.pieces.capacity, [=] LICHTENBERG_HOST_DEVICE(int piece) {
    if (piece >= grid.pieces.start[2 * problem.groups]) return;
    const int segment = segment_of(grid.pieces.start, 2 * problem.groups, piece);
    const int begin = piece_segment(problem, grid, segment) + (piece - grid.pieces.start[segment]) * piece_length;
    const int end = piece_segment_end(problem, grid, segment);
    grid.pieces.begin[piece] = begin;
    grid.pieces.end[piece] = begin + piece_length < end ? begin + piece_length : end;
    grid.pieces.segment[piece] = segment;
  });
}

/// Conductances of a group's direct links (gaps to other conductors), as additional terms of a sum over its links to
/// cells.
struct DirectConductances {
  ProblemView problem;
  GridView grid;
  LICHTENBERG_HOST_DEVICE int count(int g) const { return grid.direct_links_of(problem, g); }
  LICHTENBERG_HOST_DEVICE double value(int g, int t) const {
    return grid.direct.link[grid.first_direct_link(problem, g) + t].conductance;
  }
};

/// Computes the diagonal of each group's equation (sum of conductances without couplings), and finds the groups (bodies
/// with one potential) with unknown potentials. A coupling is a lumped capacitance between groups.
template <class Executor>
void make_group_diagonals(const Executor& run, ProblemView problem, GridView grid) {
  run.sum_pieces(
      grid.link_pieces(problem), grid.pieces.partial,
      [=] LICHTENBERG_HOST_DEVICE(int link) { return grid.links.conductance[link]; }, DirectConductances{problem, grid},
      [=] LICHTENBERG_HOST_DEVICE(int g, double sum) {
        const bool unknown = problem.floating[g] && sum > 0;
        grid.groups.diagonal[g] = unknown ? sum : 0.0;
        grid.groups.inverse_diagonal[g] = unknown ? static_cast<float>(1.0 / sum) : 0.0f;
        if (!unknown) return;
        grid.number[Items::unknown_groups] = grid.required[Items::unknown_groups] = 1;  // all write the same
        if (grid.groups.own) grid.groups.own[parallel::take_index(grid.number + Items::own_groups)] = g;
      });
}

}  // namespace lichtenberg::laplace::device
