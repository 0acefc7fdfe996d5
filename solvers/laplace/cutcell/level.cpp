#include "solvers/laplace/cutcell/level.hpp"

#include <algorithm>
#include <atomic>
#include <numeric>

#include "solvers/laplace/cutcell/apertures.hpp"
#include "solvers/laplace/cutcell/link_batch.hpp"
#include "solvers/laplace/cutcell/sets.hpp"

namespace lichtenberg::laplace {

namespace {

/// A conductance so large that groups a unit in the last place apart in potential exchange as much charge as they have:
/// more would be rounding.
constexpr double largest_coupling = 1e15;

}  // namespace

Level::Level(const LaplaceProblem& problem, int nx, int ny)
    : layout(nx, ny), h(problem.size.x / nx), cover(layout.size()), diagonal(layout.size(), 0.0) {}

void Level::build(const LaplaceProblem& problem, LinkFormula formula, parallel::Team& team) {
  couple(problem, largest_coupling);
  if (formula == LinkFormula::aperture) return build_by_apertures(problem, *this);
  outlines_.clear();
  for (const Body& body : problem.bodies) outlines_.push_back(outline_in_cells(body.shape, h));
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
  divide();
  cover_cells(team);
  team.for_each(part_count_, [&](int k) { link_part(problem, formula, parts_[k]); });
  join_parts(team);
  sort_by_row(team);
  sum_diagonal(team);
  for (const SharedCell& cell : shared_cells_) link_shared_cell(problem, cell);
  link_sides(problem);
}

/// Parts of about equal work: a few disks, or some rows of a large body.
void Level::divide() {
  constexpr int rows_a_piece = 64, cells_a_part = 4096;
  pieces_.clear();
  part_count_ = 0;
  int cells = cells_a_part;
  for (int body = 0; body < static_cast<int>(outlines_.size()); ++body) {
    const CellRange all = cells_around(outlines_[body], layout.nx, layout.ny);
    for (int j = all.from_j; j <= all.to_j; j += rows_a_piece) {
      const CellRange range{all.from_i, all.to_i, j, std::min(j + rows_a_piece - 1, all.to_j)};
      const int piece = static_cast<int>(pieces_.size());
      pieces_.push_back({body, range});
      if (cells >= cells_a_part) {
        if (static_cast<int>(parts_.size()) == part_count_) parts_.emplace_back();
        parts_[part_count_++].from_piece = piece;
        cells = 0;
      }
      parts_[part_count_ - 1].to_piece = piece + 1;
      cells += (range.to_i - range.from_i + 1) * (range.to_j - range.from_j + 1);
    }
  }
}

/// Where bodies overlap, the first one has the cell.
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
      cell = Cover::by(body);
    else
      shared_cells_.push_back({body, cell.body()});
  }
}

/// Cells whose centres the body covers, unless a body before it does too. `alone`: no other thread claims cells.
void Level::claim(const Piece& piece, bool alone) {
  const Outline& outline = outlines_[piece.body];
  for (int j = piece.range.from_j; j <= piece.range.to_j; ++j)
    for (int i = piece.range.from_i; i <= piece.range.to_i; ++i) {
      if (!covers(outline, i, j)) continue;
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

bool Level::has_cell(int body) const {
  const Outline& outline = outlines_[body];
  if (cover[layout(cell_at(outline.centre.x, layout.nx), cell_at(outline.centre.y, layout.ny))].is(body)) return true;
  const CellRange range = cells_around(outline, layout.nx, layout.ny);
  for (int j = range.from_j; j <= range.to_j; ++j)
    for (int i = range.from_i; i <= range.to_i; ++i)
      if (cover[layout(i, j)].is(body)) return true;
  return false;
}

void Level::link_part(const LaplaceProblem& problem, LinkFormula formula, Part& part) {
  part.covered.clear();
  part.rim.clear();
  part.covered_body.clear();
  part.links.clear();
  part.link_row.clear();
  part.cross_gradients.clear();
  part.pairs.clear();
  for (int k = part.from_piece; k < part.to_piece; ++k) {
    const auto& [body, range] = pieces_[k];
    if (!resolves(body)) {
      link_thin_conductor(problem, body, part);
      continue;
    }
    for (int j = range.from_j; j <= range.to_j; ++j)
      for (int i = range.from_i; i <= range.to_i; ++i) {
        const std::ptrdiff_t slot = layout(i, j);
        if (!cover[slot].is(body)) continue;
        part.covered.push_back(slot);
        part.covered_body.push_back(body);
        // Most cells lie inside their body.
        const std::array<std::ptrdiff_t, 4> beside = slots_beside(i, j);
        if (std::ranges::all_of(beside, [&](std::ptrdiff_t next) { return cover[next].is(body); })) continue;
        part.rim.push_back(slot);
        link_cell(problem, formula, {i, j}, beside, body, part);
      }
    link_batches(body, part);
    squeeze_links(body, part);
  }
}

bool Level::takes_batches(int body, LinkFormula formula) const {
  const Outline& outline = outlines_[body];
  return formula == LinkFormula::log_fitted && outline.kind == Outline::Kind::disk &&
         outline.size >= least_batched_radius;
}

void Level::link_batches(int body, Part& part) const {
  const int count = static_cast<int>(part.batched.size());
  for (int from = 0; from < count; from += LinkBatch::width) {
    LinkBatch batch;
    const auto of = [&](int k) { return part.batched[std::min(from + k, count - 1)]; };  // the last one fills up
    for (int k = 0; k < LinkBatch::width; ++k) {
      const auto [link, centre, e] = of(k);
      batch.x[k] = centre.x, batch.y[k] = centre.y, batch.ex[k] = e.x, batch.ey[k] = e.y;
    }
    const BatchConductances c = log_fitted_links(batch, outlines_[body].size);
    for (int k = 0; k < std::min(LinkBatch::width, count - from); ++k) {
      FluidLink& link = part.links[part.batched[from + k].link];
      link.conductance = c.value[k];
      link.gradient = {c.gradient_x[k], c.gradient_y[k]};
    }
  }
  part.batched.clear();
}

/// By SideIndex; beyond a side of the box they are in the padding, which is fluid.
std::array<std::ptrdiff_t, 4> Level::slots_beside(int i, int j) const {
  const int colour = (i + j) & 1, number = i >> 1;
  const std::ptrdiff_t west = layout.row(1 - colour, j) + number + Layout::parity(colour, j) - 1;
  const std::ptrdiff_t south = layout.row(1 - colour, j - 1) + number;
  return {west, west + 1, south, south + 2 * layout.stride};
}

/// `beside`: slots of the cells around.
void Level::link_cell(const LaplaceProblem& problem, LinkFormula formula, Cell cell,
                      const std::array<std::ptrdiff_t, 4>& beside, int body, Part& part) {
  constexpr int step_i[4] = {-1, 1, 0, 0}, step_j[4] = {0, 0, -1, 1};
  for (int d = 0; d < 4; ++d) {
    const std::ptrdiff_t slot = beside[d];
    const Cell next{cell.i + step_i[d], cell.j + step_j[d]};
    if (cover[slot].is(body) || !inside(next)) continue;
    const Vec2 e = direction(d);
    if (cover[slot].is_fluid()) {
      const Cell beyond{next.i + step_i[d], next.j + step_j[d]};
      const Cover behind = inside(beyond) ? cover[layout(beyond.i, beyond.j)] : Cover();
      const int link = static_cast<int>(part.links.size());
      Conductance c;
      if (takes_batches(body, formula))
        part.batched.push_back({link, centre(next) - outlines_[body].centre, -e});
      else
        c = fluid_link(outlines_[body], centre(next), -e, formula);
      if (!behind.is_fluid() && problem.bodies[behind.body()].group != problem.bodies[body].group)
        part.opposite.push_back({link, cell, e, behind.body()});
      part.links.push_back({slot, body, c.value, c.gradient});
      part.link_row.push_back(next.j);
    } else if (const int other = cover[slot].body();
               other > body && problem.bodies[other].group != problem.bodies[body].group) {
      const PairConductance c = channel_between(outlines_[body], centre(cell), e, 1.0, &outlines_[other]);
      part.pairs.push_back({body, other, c.value, c.gradient_a, c.gradient_b});
    }
  }
}

/// Once the links of a body are known: where a conductor of another group lies on the other side of a link's fluid
/// cell, the channel between the two.
void Level::squeeze_links(int body, Part& part) const {
  for (const OppositeLink& at : part.opposite) {
    FluidLink& link = part.links[at.link];
    Conductance c{link.conductance, link.gradient};
    const Squeeze squeezed = squeeze(outlines_[body], centre(at.cell), at.e, outlines_[at.other], c);
    if (!squeezed.close) continue;
    link.conductance = c.value;
    link.gradient = c.gradient;
    part.cross_gradients.push_back({at.link, at.other, squeezed.partner_gradient});
  }
  part.opposite.clear();
}

/// One list after the other: the same lists for any number of threads.
void Level::join_parts(parallel::Team& team) {
  std::vector<std::size_t> first_covered(part_count_ + 1, 0), first_link(part_count_ + 1, 0);
  rim.clear();
  cross_gradients.clear();
  pairs.clear();
  for (int k = 0; k < part_count_; ++k) {
    const Part& part = parts_[k];
    rim.insert(rim.end(), part.rim.begin(), part.rim.end());
    first_covered[k + 1] = first_covered[k] + part.covered.size();
    first_link[k + 1] = first_link[k] + part.links.size();
    for (CrossGradient cross : part.cross_gradients) {
      cross.link += static_cast<int>(first_link[k]);
      cross_gradients.push_back(cross);
    }
    pairs.insert(pairs.end(), part.pairs.begin(), part.pairs.end());
  }
  covered.resize(first_covered.back());
  links.resize(first_link.back());
  link_row_.resize(first_link.back());
  fluid_cells = static_cast<long>(layout.nx) * layout.ny - static_cast<long>(covered.size());
  covered_start.assign(outlines_.size() + 1, 0);
  link_start.assign(outlines_.size() + 1, 0);
  for (int k = 0; k < part_count_; ++k) {
    for (const int body : parts_[k].covered_body) ++covered_start[body + 1];
    for (const FluidLink& link : parts_[k].links) ++link_start[link.body + 1];
  }
  std::partial_sum(covered_start.begin(), covered_start.end(), covered_start.begin());
  std::partial_sum(link_start.begin(), link_start.end(), link_start.begin());
  team.for_each(part_count_, [&](int k) {
    std::copy(parts_[k].covered.begin(), parts_[k].covered.end(), covered.begin() + first_covered[k]);
    std::copy(parts_[k].links.begin(), parts_[k].links.end(), links.begin() + first_link[k]);
    std::copy(parts_[k].link_row.begin(), parts_[k].link_row.end(), link_row_.begin() + first_link[k]);
  });
}

/// A row's links in the order of its cells, which are too few for a comparing sort to pay: each cell counts its own.
void Level::sort_row(int j, std::vector<int>& place, std::vector<int>& sorted) {
  const auto from = links_by_row.begin() + row_start[j], to = links_by_row.begin() + row_start[j + 1];
  const std::ptrdiff_t red = layout.row(0, j), black = layout.row(1, j);
  const auto number = [&](int m) {
    const std::ptrdiff_t cell = links[m].cell;
    return cell < black ? cell - red : cell - black + layout.stride;
  };
  place.assign(2 * layout.stride + 1, 0);
  for (auto m = from; m != to; ++m) ++place[number(*m) + 1];
  std::partial_sum(place.begin(), place.end(), place.begin());
  sorted.resize(to - from);
  for (auto m = from; m != to; ++m) sorted[place[number(*m)]++] = *m;
  std::copy(sorted.begin(), sorted.end(), from);
}

void Level::sort_by_row(parallel::Team& team) {
  row_start.assign(layout.ny + 1, 0);
  for (const int row : link_row_) ++row_start[row + 1];
  std::partial_sum(row_start.begin(), row_start.end(), row_start.begin());
  std::vector<int> next(row_start.begin(), row_start.end() - 1);
  links_by_row.resize(links.size());
  for (int m = 0; m < static_cast<int>(links.size()); ++m) links_by_row[next[link_row_[m]]++] = m;
  const int chunks = 4 * team.size();
  team.for_each(chunks, [&](int chunk) {
    std::vector<int> place, sorted;
    for (int j = layout.ny * chunk / chunks; j < layout.ny * (chunk + 1) / chunks; ++j) sort_row(j, place, sorted);
  });
}

void Level::sum_diagonal(parallel::Team& team) {
  const int chunks = 4 * team.size();
  team.for_each(chunks, [&](int chunk) {
    for (int j = layout.ny * chunk / chunks; j < layout.ny * (chunk + 1) / chunks; ++j) {
      for (int colour = 0; colour < 2; ++colour) {
        const std::ptrdiff_t row = layout.row(colour, j);
        for (int k = 0; k < layout.row_length(colour, j); ++k)
          diagonal[row + k] = cover[row + k].is_fluid() ? 4.0 : 0.0;
      }
      // In place of the conductance 1 to a fluid neighbour.
      for (int m = row_start[j]; m < row_start[j + 1]; ++m) {
        const FluidLink& link = links[links_by_row[m]];
        diagonal[link.cell] += link.conductance - 1.0;
      }
    }
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
    const bool vertical = side == left || side == right;
    const bool electrode = problem.sides[side].kind == Side::Kind::electrode;
    const Vec2 e = direction(side);
    for (int k = 0; k < (vertical ? layout.ny : layout.nx); ++k) {
      const Cell cell =
          vertical ? Cell{side == left ? 0 : layout.nx - 1, k} : Cell{k, side == bottom ? 0 : layout.ny - 1};
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
