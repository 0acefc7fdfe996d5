#include "solvers/laplace/cutcell/part_links.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "solvers/laplace/cutcell/medium.hpp"

namespace lichtenberg::laplace {

namespace {

Vec2 centre_of(CellIndex cell) { return cell_centre(cell.i, cell.j); }

CellIndex next_cell(CellIndex cell, int side) { return {cell.i + step_i(side), cell.j + step_j(side)}; }

/// Returns the slots (memory indices) of the four neighbours of a cell: left, right, bottom, top. Beyond a side of the
/// box they are in the padding, which is fluid.
std::array<std::ptrdiff_t, 4> neighbours_of(const Layout& layout, int i, int j) {
  const int colour = (i + j) & 1, number = i >> 1;
  const std::ptrdiff_t west = layout.row(1 - colour, j) + number + Layout::parity(colour, j) - 1;
  const std::ptrdiff_t south = layout.row(1 - colour, j - 1) + number;
  return {west, west + 1, south, south + 2 * layout.stride};
}

}  // namespace

void PartLinks::clear() {
  counts.clear();
  covered.clear();
  links.clear();
  link_row.clear();
  cross_gradients.clear();
  arms.clear();
  pairs.clear();
}

PartLinker::PartLinker(const LinkInputs& inputs, PartLinks& links)
    : problem_(inputs.problem),
      formula_(inputs.formula),
      bodies_(inputs.bodies),
      assignment_(inputs.assignment),
      owner_(inputs.level.owner),
      layout_(inputs.level.layout),
      links_(links) {}

void PartLinker::link(int part) {
  links_.clear();
  for (const BodyPiece& piece : assignment_.pieces(part)) {
    const std::size_t covered_before = links_.covered.size(), links_before = links_.links.size();
    body_ = piece.body;
    in_batches_ = uses_batches();
    if (bodies_.resolves(body_)) {
      link_piece(piece);
    } else if (const auto subgrid = bodies_.subgrid_of_group(group_of(body_));
               !subgrid.empty() && subgrid.front() == body_) {
      link_subgrid_conductors(group_of(body_));
    }
    links_.counts.push_back({static_cast<int>(links_.covered.size() - covered_before),
                             static_cast<int>(links_.links.size() - links_before)});
  }
  compute_pending();
  couple_opposed_surfaces();
}

/// Returns the columns of row j whose cells and neighbours all belong to the piece's disk. The disk must have all cells
/// whose centres it covers.
Columns PartLinker::inner_columns(const BodyPiece& piece, int j) const {
  if (bodies_.outlines[piece.body].kind != Outline::Kind::disk) return {};
  const Columns own = assignment_.columns(piece, j);
  const Columns below = assignment_.columns(piece, j - 1), above = assignment_.columns(piece, j + 1);
  return {std::max({own.from + 1, below.from, above.from}), std::min({own.to - 1, below.to, above.to})};
}

void PartLinker::link_piece(const BodyPiece& piece) {
  int cells = 0;
  const std::size_t before = links_.covered.size();
  for (int j = piece.range.from_j; j <= piece.range.to_j; ++j) {
    const auto [from, to] = assignment_.columns(piece, j);
    cells += std::max(0, to - from + 1);
    for (int i = from; i <= to; ++i)
      if (const std::ptrdiff_t slot = layout_(i, j); owner_[slot].is(body_)) links_.covered.push_back(slot);
  }
  const bool has_all = static_cast<int>(links_.covered.size() - before) == cells;
  for (int j = piece.range.from_j; j <= piece.range.to_j; ++j) {
    const auto [from, to] = assignment_.columns(piece, j);
    const Columns inner = has_all ? inner_columns(piece, j) : Columns{};
    const bool has_inner = inner.from <= inner.to;
    link_columns(j, {from, has_inner ? inner.from - 1 : to});
    if (has_inner) link_columns(j, {inner.to + 1, to});
  }
}

/// Computes the links of the body's cells in these columns of row j that have a neighbour outside the body.
void PartLinker::link_columns(int j, Columns columns) {
  for (int i = columns.from; i <= columns.to; ++i) {
    const std::ptrdiff_t slot = layout_(i, j);
    if (!owner_[slot].is(body_)) continue;
    const std::array<std::ptrdiff_t, 4> neighbours = neighbours_of(layout_, i, j);
    if (std::ranges::all_of(neighbours, [&](std::ptrdiff_t next) { return owner_[next].is(body_); })) continue;
    link_cell({i, j}, slot, neighbours);
  }
}

bool PartLinker::uses_batches() const {
  const Outline& outline = bodies_.outlines[body_];
  return formula_ == LinkFormula::log_fitted && outline.kind == Outline::Kind::disk && !outline.link &&
         outline.size >= least_batched_radius;
}

/// Computes the links of a cell that the body covers to its neighbours. `slot`, `neighbours`: slots (memory indices) of
/// the cell and of its neighbours, left, right, bottom, top.
void PartLinker::link_cell(CellIndex cell, std::ptrdiff_t slot, const std::array<std::ptrdiff_t, 4>& neighbours) {
  // The second cell on a side has the same colour, so that its slot is one entry or two rows away. Outside the box it
  // is in the padding, which is fluid.
  const std::array<std::ptrdiff_t, 4> to_second{-1, 1, -2 * layout_.stride, 2 * layout_.stride};
  for (int side = 0; side < 4; ++side) {
    const CellOwner owner = owner_[neighbours[side]];
    if (owner.is(body_) || !is_inside(next_cell(cell, side))) continue;
    if (owner.is_fluid())
      link_fluid_cell(cell, side, neighbours[side], owner_[slot + to_second[side]]);
    else if (const int other = owner.body();
             other > body_ && group_of(other) != group_of(body_) && layout_.own.contains(cell.j))
      link_conductor(cell, direction(side), other);
  }
}

/// Computes the link between the body's cell and the fluid cell at `slot` (memory index) on one of its sides.
/// `opposed`: owner of the cell beyond the fluid cell.
void PartLinker::link_fluid_cell(CellIndex cell, int side, std::ptrdiff_t slot, CellOwner opposed) {
  const Outline& outline = bodies_.outlines[body_];
  const Vec2 e = direction(side);
  const CellIndex fluid = next_cell(cell, side);
  const int link = static_cast<int>(links_.links.size());
  if (!opposed.is_fluid() && group_of(opposed.body()) != group_of(body_))
    opposed_.push_back({link, cell, e, opposed.body()});
  links_.link_row.push_back(fluid.j);
  const Conductance c = in_batches_ ? Conductance{} : fluid_link(outline, centre_of(fluid), -e, formula_);
  links_.links.push_back({slot, body_, c.value, c.gradient});
  if (outline.kind == Outline::Kind::curve) links_.arms.push_back({link, curve_arm(outline, centre_of(cell), e)});
  if (in_batches_) add_pending(link, outline, centre_of(fluid), -e);
}

void PartLinker::link_conductor(CellIndex cell, Vec2 e, int other) {
  const PairConductance c = conductor_link(bodies_.outlines[body_], centre_of(cell), e, 1.0, &bodies_.outlines[other]);
  const Vec2 arm = curve_arm(bodies_.outlines[body_], centre_of(cell), e);
  const Vec2 arm_of_other = curve_arm(bodies_.outlines[other], centre_of(cell) + e, -e);
  links_.pairs.push_back({body_, other, c.value, c.gradient_a, c.gradient_b, arm, arm_of_other});
}

/// Adds a link to the batch of pending ones. `centre`: of the fluid cell; e: direction from it to the disk's cell.
void PartLinker::add_pending(int link, const Outline& disk, Vec2 centre, Vec2 e) {
  auto& [batch, of, count] = pending_;
  const Vec2 d = centre - disk.centre;
  batch.x[count] = d.x, batch.y[count] = d.y, batch.ex[count] = e.x, batch.ey[count] = e.y;
  batch.radius[count] = disk.size, batch.radius2[count] = disk.size * disk.size;
  of[count] = link;
  if (++count < LinkBatch::width) return;
  compute_pending();
}

void PartLinker::compute_pending() {
  auto& [batch, of, count] = pending_;
  if (count == 0) return;
  for (int k = count; k < LinkBatch::width; ++k) {  // copies of the last link fill the batch
    batch.x[k] = batch.x[count - 1], batch.y[k] = batch.y[count - 1];
    batch.ex[k] = batch.ex[count - 1], batch.ey[k] = batch.ey[count - 1];
    batch.radius[k] = batch.radius[count - 1], batch.radius2[k] = batch.radius2[count - 1];
  }
  const BatchConductances c = log_fitted_links(batch);
  for (int k = 0; k < count; ++k) {
    FluidLink& link = links_.links[of[k]];
    link.conductance = c.value[k];
    link.gradient = {c.gradient_x[k], c.gradient_y[k]};
  }
  count = 0;
}

/// Corrects the conductances of links across a gap of one fluid cell to a conductor of another group (integral over the
/// gap).
void PartLinker::couple_opposed_surfaces() {
  for (const OpposedLink& opposed : opposed_) {
    FluidLink& link = links_.links[opposed.link];
    Conductance c{link.conductance, link.gradient};
    const OpposedSurfaceCorrection squeezed = correct_for_opposed_surface(
        bodies_.outlines[link.body], centre_of(opposed.cell), opposed.e, bodies_.outlines[opposed.other], c);
    if (!squeezed.close) continue;
    link.conductance = c.value;
    link.gradient = c.gradient;
    const Vec2 arm = curve_arm(bodies_.outlines[opposed.other], centre_of(opposed.cell) + 2.0 * opposed.e, -opposed.e);
    links_.cross_gradients.push_back({opposed.link, opposed.other, squeezed.partner_gradient, arm});
  }
  opposed_.clear();
}

/// Computes the links of a group's subgrid conductors (disks too small for the grid) to the four cells around each. All
/// links of the group to one cell become one link, of the group's first subgrid conductor. On the coarsest grids a
/// large group has dozens of conductors per cell.
void PartLinker::link_subgrid_conductors(int group) {
  // By slot: index of a cell's link among the group's links. An entry is valid only if that link is the cell's, so that
  // entries of other groups need not be erased.
  thread_local std::vector<std::uint32_t> index_of;
  if (static_cast<std::ptrdiff_t>(index_of.size()) < layout_.size()) index_of.resize(layout_.size());
  const std::array<bool, 4> is_electrode = electrodes(problem_);
  const std::span<const int> subgrid = bodies_.subgrid_of_group(group);
  const std::size_t before = links_.links.size();
  const auto add_to_cell = [&](std::ptrdiff_t slot, int row, double c) {
    const std::size_t known = before + index_of[slot];
    if (known < links_.links.size() && links_.links[known].cell == slot) {
      links_.links[known].conductance += c;
      return;
    }
    index_of[slot] = static_cast<std::uint32_t>(links_.links.size() - before);
    links_.links.push_back({slot, subgrid.front(), c, {}});
    links_.link_row.push_back(row);
  };
  for (const int body : subgrid) {
    const Outline& disk = bodies_.outlines[body];
    const double whole = subgrid_conductance(disk, layout_);
    const Interpolation around = interpolate(layout_, disk.centre, is_electrode.data());
    for (int n = 0; n < 4; ++n) {
      const std::ptrdiff_t slot = around.cell[n];
      const double c = std::abs(around.weight[n]) * whole;
      if (c == 0 || !layout_.stored.contains(around.row[n])) continue;
      if (owner_[slot].is_fluid())
        add_to_cell(slot, around.row[n], c);
      else if (const int other = owner_[slot].body(); group_of(other) != group && layout_.own.contains(around.row[n]))
        links_.pairs.push_back({body, other, c, {}, {}});
    }
  }
}

}  // namespace lichtenberg::laplace
