#include "solvers/laplace/cutcell/level.hpp"

#include <algorithm>
#include <atomic>
#include <limits>
#include <numeric>

#include "solvers/laplace/cutcell/apertures.hpp"
#include "solvers/laplace/cutcell/sets.hpp"
#include "solvers/laplace/cutcell/wavefront.hpp"
#include "solvers/parallel/huge_pages.hpp"

namespace lichtenberg::laplace {

namespace {

/// A conductance so large that groups a unit in the last place apart in potential exchange as much charge as they have:
/// more would be rounding.
constexpr double largest_coupling = 1e15;

}  // namespace

Level::Level(const LaplaceProblem& problem, int nx, int ny) : layout(nx, ny), h(problem.size.x / nx) {
  parallel::resize_in_huge_pages(cover, layout.size());
  parallel::resize_in_huge_pages(diagonal, layout.size());
}

void Level::build(const LaplaceProblem& problem, LinkFormula formula, parallel::Team& team) {
  couple(problem, largest_coupling);
  if (formula == LinkFormula::aperture) return build_by_apertures(problem, *this);
  outlines_.clear();
  for (const Body& body : problem.bodies) outlines_.push_back(outline_in_cells(body, h));
  discretize(problem, formula, team);
  find_bound_cells(problem, team);
}

void Level::couple(const LaplaceProblem& problem, double largest) {
  couplings.clear();
  fixed_couplings.clear();
  const double least = least_in_cycle(problem);
  for (const Coupling& coupling : problem.couplings) {
    const double conductance = std::min(coupling.capacitance / problem.permittivity, largest);
    const Group &a = problem.groups[coupling.a], &b = problem.groups[coupling.b];
    if (conductance == 0 || (a.floating && !has_unknown(coupling.a)) || (b.floating && !has_unknown(coupling.b)))
      continue;
    if (a.floating && b.floating) couplings.push_back({coupling.a, coupling.b, conductance});
    const double in_cycle = std::max(conductance, least);
    if (a.floating && !b.floating) fixed_couplings.push_back({coupling.a, conductance, b.potential, in_cycle});
    if (!a.floating && b.floating) fixed_couplings.push_back({coupling.b, conductance, a.potential, in_cycle});
  }
}

void Level::discretize(const LaplaceProblem& problem, LinkFormula formula, parallel::Team& team) {
  divide(team.size());
  cover_cells(team);
  team.for_each(part_count_, [&](int k) { link_part(problem, formula, parts_[k]); });
  join_parts(team);
  sort_by_row(team);
  sum_diagonal(team);
  for (const SharedCell& cell : shared_cells_) link_shared_cell(problem, cell);
  link_sides(problem);
}

/// Parts of about equal work: a few disks, or some rows of a large body. One for a single thread. (A group's thin
/// conductors are all linked with its first, in one part: some hundredths of a set-up.)
void Level::divide(int threads) {
  constexpr int rows_a_piece = 64;
  const long cells_a_part = threads == 1 ? std::numeric_limits<long>::max() : 4096;
  pieces_.clear();
  int rows = 0;
  part_count_ = 0;
  long cells = cells_a_part;
  for (int body = 0; body < static_cast<int>(outlines_.size()); ++body) {
    const CellRange all = cells_around(outlines_[body], layout.nx, layout.ny);
    for (int j = all.from_j; j <= all.to_j; j += rows_a_piece) {
      const CellRange range{all.from_i, all.to_i, j, std::min(j + rows_a_piece - 1, all.to_j)};
      const int piece = static_cast<int>(pieces_.size());
      pieces_.push_back({body, range, rows});
      rows += range.to_j - range.from_j + 1;
      if (cells >= cells_a_part) {
        if (static_cast<int>(parts_.size()) == part_count_) parts_.emplace_back();
        parts_[part_count_++].from_piece = piece;
        cells = 0;
      }
      parts_[part_count_ - 1].to_piece = piece + 1;
      cells += (range.to_i - range.from_i + 1) * (range.to_j - range.from_j + 1);
    }
  }
  columns_.resize(rows);
}

/// Where bodies overlap, the first one in the problem's order has the cell.
void Level::cover_cells(parallel::Team& team) {
  const int chunks = 4 * team.size();
  team.for_each(chunks, [&](int k) {
    const std::ptrdiff_t size = layout.size();
    std::fill(cover.begin() + size * k / chunks, cover.begin() + size * (k + 1) / chunks, Cover());
  });
  team.for_each(part_count_, [&](int k) {
    for (int piece = parts_[k].from_piece; piece < parts_[k].to_piece; ++piece)
      if (resolves(pieces_[piece].body)) claim(pieces_[piece], team.size() == 1);
  });
  // A conductor is a conductor on every grid that resolves it: a disk that covers no cell centre takes the cell it lies
  // in, after all others. The log-fitted link stays right for it (it knows R, however small). Where that cell is taken,
  // it is linked to the conductor that has it.
  shared_cells_.clear();
  for (int body = 0; body < static_cast<int>(outlines_.size()); ++body) {
    const Outline& outline = outlines_[body];
    if (outline.kind != Outline::Kind::disk || !resolves(body) || has_cell(body)) continue;
    Cover& cell = cover[layout(cell_at(outline.centre.x, layout.nx), cell_at(outline.centre.y, layout.ny))];
    if (cell.is_fluid())
      take_cell(body);
    else
      shared_cells_.push_back({body, cell.body()});
  }
}

/// Cells whose centres the body covers, unless a body before it does too. `alone`: no other thread claims cells.
void Level::claim(const Piece& piece, bool alone) {
  const Outline& outline = outlines_[piece.body];
  const bool convex = outline.kind == Outline::Kind::disk;
  for (int j = piece.range.from_j; j <= piece.range.to_j; ++j) {
    auto& [from, to] = columns_[piece.first_row + j - piece.range.from_j];
    from = piece.range.from_i, to = piece.range.to_i;
    // Nearer to the centre a disk's row is covered throughout, rounding or not: squares grow with what is squared.
    while (convex && from <= to && !covers(outline, from, j)) ++from;
    while (convex && from <= to && !covers(outline, to, j)) --to;
    for (int i = from; i <= to; ++i) {
      if (!convex && !covers(outline, i, j)) continue;
      Cover& cell = cover[layout(i, j)];
      if (alone) {
        if (cell.is_fluid()) cell = Cover::by(piece.body);
        continue;
      }
      const std::atomic_ref<Cover> shared(cell);
      Cover current = shared.load(std::memory_order_relaxed);
      while ((current.is_fluid() || piece.body < current.body()) &&
             !shared.compare_exchange_weak(current, Cover::by(piece.body), std::memory_order_relaxed)) {
      }
    }
  }
}

/// The cell that the body's centre lies in.
void Level::take_cell(int body) {
  const Outline& outline = outlines_[body];
  const int i = cell_at(outline.centre.x, layout.nx), j = cell_at(outline.centre.y, layout.ny);
  cover[layout(i, j)] = Cover::by(body);
  const auto of_body = std::ranges::lower_bound(pieces_, body, {}, &Piece::body);
  const auto piece = std::find_if(of_body, pieces_.end(), [&](const Piece& p) { return j <= p.range.to_j; });
  auto& [from, to] = columns_[piece->first_row + j - piece->range.from_j];
  const bool is_first = from > to;
  from = is_first ? i : std::min(from, i);
  to = is_first ? i : std::max(to, i);
}

bool Level::has_cell(int body) const {
  const Outline& outline = outlines_[body];
  if (cover[layout(cell_at(outline.centre.x, layout.nx), cell_at(outline.centre.y, layout.ny))].is(body)) return true;
  const CellRange range = cells_around(outline, layout.nx, layout.ny);
  for (int j = range.from_j; j <= range.to_j; ++j)
    for (int i = range.from_i; i <= range.to_i; ++i)
      if (cover[layout(i, j)].is(body)) return true;
  return false;
}

/// A row's links in the order of its cells, which are too few for a comparing sort to pay: each cell counts its own.
void Level::sort_row(int j, std::vector<int>& place, std::vector<RowLink>& sorted) {
  const std::span<RowLink> row(row_links.begin() + row_start[j], row_links.begin() + row_start[j + 1]);
  const std::ptrdiff_t red = layout.row(0, j), black = layout.row(1, j);
  const auto number = [&](const RowLink& link) {
    return link.cell < black ? link.cell - red : link.cell - black + layout.stride;
  };
  place.assign(2 * layout.stride + 1, 0);
  for (const RowLink& link : row) ++place[number(link) + 1];
  std::partial_sum(place.begin(), place.end(), place.begin());
  sorted.resize(row.size());
  for (const RowLink& link : row) sorted[place[number(link)]++] = link;
  std::copy(sorted.begin(), sorted.end(), row.begin());
}

void Level::sort_by_row(parallel::Team& team) {
  row_start.assign(layout.ny + 1, 0);
  for (const int row : link_row_) ++row_start[row + 1];
  std::partial_sum(row_start.begin(), row_start.end(), row_start.begin());
  std::vector<int> next(row_start.begin(), row_start.end() - 1);
  row_links.resize(links.size());
  for (int m = 0; m < static_cast<int>(links.size()); ++m)
    row_links[next[link_row_[m]]++] = {static_cast<std::int32_t>(links[m].cell), links[m].body, links[m].conductance,
                                       m};
  const int chunks = 4 * team.size();
  team.for_each(chunks, [&](int chunk) {
    std::vector<int> place;
    std::vector<RowLink> sorted;
    for (int j = layout.ny * chunk / chunks; j < layout.ny * (chunk + 1) / chunks; ++j) sort_row(j, place, sorted);
  });
}

void Level::sum_diagonal(parallel::Team& team) {
  for_each_row(team, layout, [&](int j) {
    for (int colour = 0; colour < 2; ++colour) {
      const std::ptrdiff_t row = layout.row(colour, j);
      for (int k = 0; k < layout.row_length(colour, j); ++k) diagonal[row + k] = cover[row + k].is_fluid() ? 4.0 : 0.0;
    }
    // In place of the conductance 1 to a fluid neighbour.
    for (int m = row_start[j]; m < row_start[j + 1]; ++m) diagonal[row_links[m].cell] += row_links[m].conductance - 1.0;
  });
}

void Level::link_shared_cell(const LaplaceProblem& problem, SharedCell cell) {
  if (problem.bodies[cell.body].group == problem.bodies[cell.owner].group) return;
  const PairConductance c = shared_cell_link(outlines_[cell.body], outlines_[cell.owner]);
  pairs.push_back({cell.body, cell.owner, c.value, c.gradient_a, c.gradient_b});
}

void Level::link_sides(const LaplaceProblem& problem) {
  side_links.clear();
  for (int side = 0; side < 4; ++side) {
    const bool electrode = problem.sides[side].kind == Side::Kind::electrode;
    const Vec2 e = direction(side);
    for (int k = 0; k < faces_of(layout, side); ++k) {
      const Cell cell = cell_at_face(layout, side, k);
      const std::ptrdiff_t slot = layout(cell.i, cell.j);
      const bool fluid = cover[slot].is_fluid();
      if (!electrode) {
        if (fluid) diagonal[slot] -= 1.0;
        continue;
      }
      const double potential = problem.sides[side].potential_at(h * (centre(cell) + 0.5 * e));
      if (fluid) {
        diagonal[slot] += 1.0;  // half a cell to the wall: conductance 2 in place of 1
        side_links.push_back({slot, -1, side, 2.0, potential, {}});
      } else {
        const int body = cover[slot].body();
        const PairConductance c = channel_between(outlines_[body], centre(cell), e, 0.5, nullptr);
        side_links.push_back({-1, body, side, c.value, potential, c.gradient_a});
      }
    }
  }
}

}  // namespace lichtenberg::laplace
