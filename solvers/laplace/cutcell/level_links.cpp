// The links of a grid's conductors, body by body and joined in one list.

#include <algorithm>
#include <numeric>
#include <utility>

#include "solvers/laplace/cutcell/level.hpp"
#include "solvers/laplace/cutcell/link_batch.hpp"

namespace lichtenberg::laplace {

void Level::link_part(const LaplaceProblem& problem, LinkFormula formula, Part& part) {
  part.covered.clear();
  part.rim.clear();
  part.links.clear();
  part.link_row.clear();
  part.cross_gradients.clear();
  part.pairs.clear();
  for (int k = part.from_piece; k < part.to_piece; ++k) {
    Piece& piece = pieces_[k];
    const std::size_t covered_before = part.covered.size(), links_before = part.links.size();
    if (resolves(piece.body)) {
      link_piece(problem, formula, piece, part);
      link_batch(piece.body, part);
      squeeze_links(piece.body, part);
    } else {
      const int group = problem.bodies[piece.body].group, first = thin_start_[group];
      if (first < thin_start_[group + 1] && thin_[first] == piece.body) link_thin_conductors(problem, group, part);
    }
    piece.covered = static_cast<int>(part.covered.size() - covered_before);
    piece.links = static_cast<int>(part.links.size() - links_before);
  }
}

Level::Columns Level::columns_of(const Piece& piece, int j) const {
  if (j < piece.range.from_j || j > piece.range.to_j) return {};
  return columns_[piece.first_row + j - piece.range.from_j];
}

/// Columns of row j whose cells lie inside their disk, as do those around them, if no other body has taken any of them.
Level::Columns Level::inner_columns(const Piece& piece, int j) const {
  if (outlines_[piece.body].kind != Outline::Kind::disk) return {};
  const Columns own = columns_of(piece, j), below = columns_of(piece, j - 1), above = columns_of(piece, j + 1);
  return {std::max({own.from + 1, below.from, above.from}), std::min({own.to - 1, below.to, above.to})};
}

void Level::link_piece(const LaplaceProblem& problem, LinkFormula formula, const Piece& piece, Part& part) {
  const int body = piece.body;
  int cells = 0;
  const std::size_t before = part.covered.size();
  for (int j = piece.range.from_j; j <= piece.range.to_j; ++j) {
    const auto [from, to] = columns_of(piece, j);
    cells += std::max(0, to - from + 1);
    for (int i = from; i <= to; ++i)
      if (const std::ptrdiff_t slot = layout(i, j); cover[slot].is(body)) part.covered.push_back(slot);
  }
  const bool has_all = static_cast<int>(part.covered.size() - before) == cells;
  for (int j = piece.range.from_j; j <= piece.range.to_j; ++j) {
    const auto [from, to] = columns_of(piece, j);
    const Columns inner = has_all ? inner_columns(piece, j) : Columns{};
    const bool has_inner = inner.from <= inner.to;
    link_columns(problem, formula, j, {from, has_inner ? inner.from - 1 : to}, body, part);
    if (has_inner) link_columns(problem, formula, j, {inner.to + 1, to}, body, part);
  }
}

/// Some of a row's cells: those of the body that another is beside.
void Level::link_columns(const LaplaceProblem& problem, LinkFormula formula, int j, Columns columns, int body,
                         Part& part) {
  for (int i = columns.from; i <= columns.to; ++i) {
    const std::ptrdiff_t slot = layout(i, j);
    if (!cover[slot].is(body)) continue;
    const std::array<std::ptrdiff_t, 4> beside = slots_beside(i, j);
    if (std::ranges::all_of(beside, [&](std::ptrdiff_t next) { return cover[next].is(body); })) continue;
    part.rim.push_back(slot);
    link_cell(problem, formula, {i, j}, beside, body, part);
  }
}

bool Level::takes_batches(int body, LinkFormula formula) const {
  const Outline& outline = outlines_[body];
  return formula == LinkFormula::log_fitted && outline.kind == Outline::Kind::disk && !outline.link &&
         outline.size >= least_batched_radius;
}

/// A link gets its conductance with others of its body: its cell's centre is `centre` from the body's, and e points to
/// the body's cell.
void Level::add_pending(int link, Vec2 centre, Vec2 e, int body, Part& part) const {
  auto& [batch, of, count] = part.pending;
  batch.x[count] = centre.x, batch.y[count] = centre.y, batch.ex[count] = e.x, batch.ey[count] = e.y;
  of[count] = link;
  if (++count < LinkBatch::width) return;
  link_batch(body, part);
}

void Level::link_batch(int body, Part& part) const {
  auto& [batch, of, count] = part.pending;
  if (count == 0) return;
  for (int k = count; k < LinkBatch::width; ++k) {  // the last one fills up
    batch.x[k] = batch.x[count - 1], batch.y[k] = batch.y[count - 1];
    batch.ex[k] = batch.ex[count - 1], batch.ey[k] = batch.ey[count - 1];
  }
  const BatchConductances c = log_fitted_links(batch, outlines_[body].size);
  for (int k = 0; k < count; ++k) {
    FluidLink& link = part.links[of[k]];
    link.conductance = c.value[k];
    link.gradient = {c.gradient_x[k], c.gradient_y[k]};
  }
  count = 0;
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
  const bool in_batches = takes_batches(body, formula);
  for (int d = 0; d < 4; ++d) {
    const std::ptrdiff_t slot = beside[d];
    const Cell next{cell.i + step_i(d), cell.j + step_j(d)};
    if (cover[slot].is(body) || !inside(next)) continue;
    const Vec2 e = direction(d);
    if (cover[slot].is_fluid()) {
      const Cell beyond{next.i + step_i(d), next.j + step_j(d)};
      const Cover behind = inside(beyond) ? cover[layout(beyond.i, beyond.j)] : Cover();
      const int link = static_cast<int>(part.links.size());
      if (!behind.is_fluid() && problem.bodies[behind.body()].group != problem.bodies[body].group)
        part.opposite.push_back({link, cell, e, behind.body()});
      part.link_row.push_back(next.j);
      const Conductance c = in_batches ? Conductance{} : fluid_link(outlines_[body], centre(next), -e, formula);
      part.links.push_back({slot, body, c.value, c.gradient});
      if (in_batches) add_pending(link, centre(next) - outlines_[body].centre, -e, body, part);
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
  fluid_cells = static_cast<long>(layout.nx) * layout.ny - static_cast<long>(first_covered.back());
  covered_start.assign(outlines_.size() + 1, 0);
  link_start.assign(outlines_.size() + 1, 0);
  for (const Piece& piece : pieces_) {
    covered_start[piece.body + 1] += piece.covered;
    link_start[piece.body + 1] += piece.links;
  }
  std::partial_sum(covered_start.begin(), covered_start.end(), covered_start.begin());
  std::partial_sum(link_start.begin(), link_start.end(), link_start.begin());
  if (part_count_ == 1) {
    std::swap(covered, parts_[0].covered);
    std::swap(links, parts_[0].links);
    std::swap(link_row_, parts_[0].link_row);
    return;
  }
  covered.resize(first_covered.back());
  links.resize(first_link.back());
  link_row_.resize(first_link.back());
  team.for_each(part_count_, [&](int k) {
    std::copy(parts_[k].covered.begin(), parts_[k].covered.end(), covered.begin() + first_covered[k]);
    std::copy(parts_[k].links.begin(), parts_[k].links.end(), links.begin() + first_link[k]);
    std::copy(parts_[k].link_row.begin(), parts_[k].link_row.end(), link_row_.begin() + first_link[k]);
  });
}

}  // namespace lichtenberg::laplace
