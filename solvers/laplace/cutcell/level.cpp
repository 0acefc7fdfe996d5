#include "solvers/laplace/cutcell/level.hpp"

#include <algorithm>

namespace lichtenberg::laplace {

Level::Level(const LaplaceProblem& problem, int nx, int ny)
    : layout(nx, ny), h(problem.size.x / nx), cover(layout.size(), -1), diagonal(layout.size(), 0.0) {}

void Level::build(const LaplaceProblem& problem, LinkFormula formula) {
  outlines_.clear();
  for (const Body& body : problem.bodies) outlines_.push_back(outline_in_cells(body.shape, h));
  cover_cells();
  link_cells(problem, formula);
  link_sides(problem);
}

/// Where bodies overlap, the first one has the cell.
void Level::cover_cells() {
  for (const std::ptrdiff_t slot : covered) cover[slot] = -1;
  covered.clear();
  covered_cells_.clear();
  lodgers_.clear();
  std::vector<int> without_cell;
  for (int body = 0; body < static_cast<int>(outlines_.size()); ++body) {
    const std::size_t before = covered.size();
    const CellRange range = cells_around(outlines_[body], layout.nx, layout.ny);
    for (int j = range.from_j; j <= range.to_j; ++j)
      for (int i = range.from_i; i <= range.to_i; ++i)
        if (covers(outlines_[body], i, j)) claim({i, j}, body);
    if (covered.size() == before && outlines_[body].kind == Outline::Kind::disk) without_cell.push_back(body);
  }
  // A conductor is a conductor on every grid: a disk that covers no cell centre takes the cell it lies in, after all
  // others. The log-fitted link stays right for it (it knows R, however small). Where that cell is taken, it is linked
  // to the conductor that has it.
  for (const int body : without_cell) {
    const Cell own{cell_at(outlines_[body].centre.x, layout.nx), cell_at(outlines_[body].centre.y, layout.ny)};
    if (!claim(own, body)) lodgers_.push_back({body, cover[layout(own.i, own.j)]});
  }
  fluid_cells = static_cast<long>(layout.nx) * layout.ny - static_cast<long>(covered.size());
}

bool Level::claim(Cell cell, int body) {
  const std::ptrdiff_t slot = layout(cell.i, cell.j);
  if (cover[slot] >= 0) return false;
  cover[slot] = body;
  covered.push_back(slot);
  covered_cells_.push_back(cell);
  return true;
}

void Level::link_cells(const LaplaceProblem& problem, LinkFormula formula) {
  links.clear();
  cross_gradients.clear();
  pairs.clear();
  for (int colour = 0; colour < 2; ++colour)
    for (int j = 0; j < layout.ny; ++j) {
      const auto begin = diagonal.begin() + layout.row(colour, j);
      std::fill(begin, begin + layout.row_length(colour, j), 4.0);
    }
  for (const std::ptrdiff_t slot : covered) diagonal[slot] = 0;
  for (std::size_t k = 0; k < covered.size(); ++k) link_cell(problem, formula, covered_cells_[k], cover[covered[k]]);
  for (const Lodger& lodger : lodgers_) link_lodger(problem, lodger);
}

void Level::link_lodger(const LaplaceProblem& problem, Lodger lodger) {
  if (problem.bodies[lodger.body].group == problem.bodies[lodger.host].group) return;
  const PairConductance c = lodger_link(outlines_[lodger.body], outlines_[lodger.host]);
  pairs.push_back({lodger.body, lodger.host, c.value, c.gradient_a, c.gradient_b});
}

void Level::link_cell(const LaplaceProblem& problem, LinkFormula formula, Cell cell, int body) {
  for (int d = 0; d < 4; ++d) {
    const Vec2 e = direction(d);
    const Cell next{cell.i + static_cast<int>(e.x), cell.j + static_cast<int>(e.y)};
    if (!inside(next)) continue;
    const std::ptrdiff_t slot = layout(next.i, next.j);
    const int other = cover[slot];
    if (other < 0) {
      Conductance c = fluid_link(outlines_[body], centre(next), -e, formula);
      const Cell beyond{next.i + static_cast<int>(e.x), next.j + static_cast<int>(e.y)};
      if (inside(beyond)) squeeze_link(problem, cell, body, e, cover[layout(beyond.i, beyond.j)], c);
      links.push_back({slot, body, c.value, c.gradient});
      diagonal[slot] += c.value - 1.0;  // the neighbour is no fluid cell
    } else if (other > body && problem.bodies[other].group != problem.bodies[body].group) {
      const PairConductance c = channel_between(outlines_[body], centre(cell), e, 1.0, &outlines_[other]);
      pairs.push_back({body, other, c.value, c.gradient_a, c.gradient_b});
    }
  }
}

/// If body `other` lies on the other side of a body's fluid neighbour: the channel between the two.
void Level::squeeze_link(const LaplaceProblem& problem, Cell cell, int body, Vec2 e, int other, Conductance& c) {
  if (other < 0 || problem.bodies[other].group == problem.bodies[body].group) return;
  const Squeeze squeezed = squeeze(outlines_[body], centre(cell), e, outlines_[other], c);
  if (squeezed.close) cross_gradients.push_back({static_cast<int>(links.size()), other, squeezed.partner_gradient});
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
      const int body = cover[slot];
      if (!electrode) {
        if (body < 0) diagonal[slot] -= 1.0;
        continue;
      }
      const double potential = problem.sides[side].potential_at(h * (centre(cell) + 0.5 * e));
      if (body < 0) {
        diagonal[slot] += 1.0;  // half a cell to the wall: conductance 2 in place of 1
        side_links.push_back({slot, -1, side, 2.0, potential, {}});
      } else {
        const PairConductance c = channel_between(outlines_[body], centre(cell), e, 0.5, nullptr);
        side_links.push_back({-1, body, side, c.value, potential, c.gradient_a});
      }
    }
  }
}

}  // namespace lichtenberg::laplace
