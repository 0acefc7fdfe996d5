#include "solvers/laplace/cutcell/level_builder.hpp"

#include <algorithm>
#include <numeric>
#include <utility>

#include "solvers/laplace/cutcell/apertures.hpp"
#include "solvers/laplace/cutcell/homogenize.hpp"
#include "solvers/laplace/cutcell/wavefront.hpp"

namespace lichtenberg::laplace {

namespace {

/// Upper bound of couplings (lumped capacitances per permittivity) on the finest grid. With it, groups whose potentials
/// differ in the last digit already exchange as much charge as they have. Larger values would add rounding errors only.
constexpr double largest_coupling = 1e15;

}  // namespace

void LevelBuilder::build(const LaplaceProblem& problem, LinkFormula formula, Level& level, parallel::Team& team) {
  set_couplings(problem, largest_coupling, level);
  if (formula == LinkFormula::aperture) return build_by_apertures(problem, level);
  bodies_.assign(problem, level.h);
  discretize(problem, formula, level, team);
  find_eliminated_cells(problem, bodies_, level, team, eliminated_);
}

void LevelBuilder::build_coarse(const LaplaceProblem& problem, LinkFormula formula, const Agglomerates& agglomerates,
                                const Level* finer, Level& level, parallel::Team& team) {
  bodies_.assign(problem, level.h);
  choose_unknowns(problem, agglomerates, finer, bodies_, level);
  discretize(problem, formula, level, team);
  if (finer) inherit_pairs(problem, *finer, bodies_, level);
  set_couplings(problem, largest_coarse_coupling, level);
  homogenize_fluid(problem, bodies_, level, team);
  find_eliminated_cells(problem, bodies_, level, team, eliminated_);
}

void set_couplings(const LaplaceProblem& problem, double largest, Level& level) {
  level.couplings.clear();
  level.fixed_couplings.clear();
  const double least = least_in_cycle(problem);
  for (const Coupling& coupling : problem.couplings) {
    const double conductance = std::min(coupling.capacitance / problem.permittivity, largest);
    const Group &a = problem.groups[coupling.a], &b = problem.groups[coupling.b];
    if (conductance == 0 || (a.floating && !level.has_unknown(coupling.a)) ||
        (b.floating && !level.has_unknown(coupling.b)))
      continue;
    if (a.floating && b.floating) level.couplings.push_back({coupling.a, coupling.b, conductance});
    const double in_cycle = std::max(conductance, least);
    if (a.floating && !b.floating) level.fixed_couplings.push_back({coupling.a, conductance, b.potential, in_cycle});
    if (!a.floating && b.floating) level.fixed_couplings.push_back({coupling.b, conductance, a.potential, in_cycle});
  }
}

namespace {

void sum_diagonal(Level& level, parallel::Team& team) {
  const Layout& layout = level.layout;
  for_each_row(team, layout, layout.stored, [&](int j) {
    for (int colour = 0; colour < 2; ++colour) {
      const std::ptrdiff_t row = layout.row(colour, j);
      for (int k = 0; k < layout.row_length(colour, j); ++k)
        level.diagonal[row + k] = level.owner[row + k].is_fluid() ? 4.0 : 0.0;
    }
    // Each link replaces the conductance 1 to a fluid neighbour.
    for (int m = level.row_start[j]; m < level.row_start[j + 1]; ++m)
      level.diagonal[level.row_links[m].cell] += level.row_links[m].conductance - 1.0;
  });
}

void count_fluid_cells(Level& level) {
  const Layout& at = level.layout;
  const auto is_own = [&](std::ptrdiff_t slot) { return at.owns(slot); };
  const auto covered = at.is_divided() ? std::ranges::count_if(level.covered, is_own) : std::ssize(level.covered);
  const auto fluid = static_cast<double>(static_cast<long>(at.nx) * at.own.count() - covered);
  level.fluid_cells = static_cast<long>(sum_over_slabs(at, fluid));
}

void link_shared_cell(const LaplaceProblem& problem, const GridBodies& bodies, SharedCell cell, Level& level) {
  if (problem.bodies[cell.body].group == problem.bodies[cell.owner].group || !level.layout.own.contains(cell.row))
    return;
  const PairConductance c = shared_cell_link(bodies.outlines[cell.body], bodies.outlines[cell.owner]);
  level.pairs.push_back({cell.body, cell.owner, c.value, c.gradient_a, c.gradient_b});
}

void link_sides(const LaplaceProblem& problem, const GridBodies& bodies, Level& level) {
  level.side_links.clear();
  for (int side = 0; side < 4; ++side) {
    const bool electrode = problem.sides[side].kind == Side::Kind::electrode;
    const Vec2 e = direction(side);
    for (int k = 0; k < faces_of(level.layout, side); ++k) {
      const CellIndex cell = cell_at_face(level.layout, side, k);
      if (!level.layout.stored.contains(cell.j)) continue;
      const std::ptrdiff_t slot = level.layout(cell.i, cell.j);
      const bool fluid = level.owner[slot].is_fluid();
      if (!electrode) {
        if (fluid) level.diagonal[slot] -= 1.0;
        continue;
      }
      const Vec2 centre = cell_centre(cell.i, cell.j);
      const double potential = problem.sides[side].potential_at(level.h * (centre + 0.5 * e));
      if (fluid) {
        level.diagonal[slot] += 1.0;  // half a cell to the wall: conductance 2 instead of 1
        level.side_links.push_back({slot, -1, side, 2.0, potential, {}});
      } else if (level.layout.own.contains(cell.j)) {
        const int body = level.owner[slot].body();
        const PairConductance c = conductor_link(bodies.outlines[body], centre, e, 0.5, nullptr);
        const Vec2 arm = curve_arm(bodies.outlines[body], centre, e);
        level.side_links.push_back({-1, body, side, c.value, potential, c.gradient_a, arm});
      }
    }
  }
}

}  // namespace

void LevelBuilder::discretize(const LaplaceProblem& problem, LinkFormula formula, Level& level, parallel::Team& team) {
  assignment_.assign(bodies_, level, team);
  if (static_cast<int>(parts_.size()) < assignment_.parts()) parts_.resize(assignment_.parts());
  const LinkInputs inputs{problem, formula, bodies_, assignment_, level};
  team.for_each(assignment_.parts(), [&](int part) { PartLinker(inputs, parts_[part]).link(part); });
  join_parts(level, team);
  count_fluid_cells(level);
  sort_links_by_row(link_row_, level, team);
  sum_diagonal(level, team);
  for (const SharedCell& cell : assignment_.shared_cells()) link_shared_cell(problem, bodies_, cell, level);
  gather_list(level.layout, level.pairs);
  link_sides(problem, bodies_, level);
}

/// Concatenates the parts' lists in the order of the parts, so that they do not depend on the number of threads.
void LevelBuilder::join_parts(Level& level, parallel::Team& team) {
  const int parts = assignment_.parts();
  std::vector<std::size_t> first_covered(parts + 1, 0), first_link(parts + 1, 0);
  level.cross_gradients.clear();
  level.arms.clear();
  level.pairs.clear();
  level.covered_start.assign(bodies_.outlines.size() + 1, 0);
  level.link_start.assign(bodies_.outlines.size() + 1, 0);
  for (int k = 0; k < parts; ++k) {
    const PartLinks& part = parts_[k];
    first_covered[k + 1] = first_covered[k] + part.covered.size();
    first_link[k + 1] = first_link[k] + part.links.size();
    for (CrossGradient cross : part.cross_gradients) {
      cross.link += static_cast<int>(first_link[k]);
      level.cross_gradients.push_back(cross);
    }
    for (LinkArm arm : part.arms) level.arms.push_back({arm.link + static_cast<int>(first_link[k]), arm.at});
    level.pairs.insert(level.pairs.end(), part.pairs.begin(), part.pairs.end());
    const std::span<const BodyPiece> pieces = assignment_.pieces(k);
    for (std::size_t n = 0; n < pieces.size(); ++n) {
      level.covered_start[pieces[n].body + 1] += part.counts[n].covered;
      level.link_start[pieces[n].body + 1] += part.counts[n].links;
    }
  }
  std::partial_sum(level.covered_start.begin(), level.covered_start.end(), level.covered_start.begin());
  std::partial_sum(level.link_start.begin(), level.link_start.end(), level.link_start.begin());
  if (parts == 1) {
    std::swap(level.covered, parts_[0].covered);
    std::swap(level.links, parts_[0].links);
    std::swap(link_row_, parts_[0].link_row);
    return;
  }
  level.covered.resize(first_covered.back());
  level.links.resize(first_link.back());
  link_row_.resize(first_link.back());
  team.for_each(parts, [&](int k) {
    const PartLinks& part = parts_[k];
    std::copy(part.covered.begin(), part.covered.end(), level.covered.begin() + first_covered[k]);
    std::copy(part.links.begin(), part.links.end(), level.links.begin() + first_link[k]);
    std::copy(part.link_row.begin(), part.link_row.end(), link_row_.begin() + first_link[k]);
  });
}

namespace {

/// Memory for intermediate results of sort_row().
struct RowSort {
  std::vector<int> number, first;
};

/// Writes the links of row j, sorted by cell, to `level.row_links`. `links`: their indices in `level.links`, one after
/// another by body. Counting is faster than a comparison sort for the few cells of a row.
void sort_row(int j, std::span<const int> links, Level& level, RowSort& sort) {
  if (links.empty()) return;
  const Layout& layout = level.layout;
  const std::ptrdiff_t red = layout.row(0, j), black = layout.row(1, j);
  sort.number.resize(links.size());
  sort.first.assign(2 * layout.stride + 1, 0);
  for (std::size_t k = 0; k < links.size(); ++k) {
    const std::ptrdiff_t cell = level.links[links[k]].cell;
    sort.number[k] = static_cast<int>(cell < black ? cell - red : cell - black + layout.stride);
    ++sort.first[sort.number[k] + 1];
  }
  std::partial_sum(sort.first.begin(), sort.first.end(), sort.first.begin());
  RowLink* const row = level.row_links.data() + level.row_start[j];
  for (std::size_t k = 0; k < links.size(); ++k) {
    const FluidLink& link = level.links[links[k]];
    row[sort.first[sort.number[k]]++] = {static_cast<std::int32_t>(link.cell), link.body, link.conductance, links[k]};
  }
}

}  // namespace

void sort_links_by_row(std::span<const int> link_row, Level& level, parallel::Team& team) {
  const int rows = level.layout.ny;
  level.row_start.assign(rows + 1, 0);
  for (const int row : link_row) ++level.row_start[row + 1];
  std::partial_sum(level.row_start.begin(), level.row_start.end(), level.row_start.begin());
  std::vector<int> next(level.row_start.begin(), level.row_start.end() - 1), by_row(level.links.size());
  for (int m = 0; m < static_cast<int>(level.links.size()); ++m) by_row[next[link_row[m]]++] = m;
  level.row_links.resize(level.links.size());
  const int chunks = 4 * team.size();
  team.for_each(chunks, [&](int chunk) {
    RowSort sort;
    for (int j = rows * chunk / chunks; j < rows * (chunk + 1) / chunks; ++j)
      sort_row(j, std::span(by_row).subspan(level.row_start[j], level.row_start[j + 1] - level.row_start[j]), level,
               sort);
  });
}

}  // namespace lichtenberg::laplace
