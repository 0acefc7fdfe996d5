// Coarse grids of the preconditioner, and what they make of conductors that they do not resolve (medium.hpp).

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "solvers/laplace/cutcell/level.hpp"
#include "solvers/laplace/cutcell/medium.hpp"

namespace lichtenberg::laplace {

namespace {

/// The rectangle around a group's disks.
struct Extent {
  Vec2 low{std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()}, high = -low;
  double size() const { return std::max(high.x - low.x, high.y - low.y); }
  Vec2 centre() const { return 0.5 * (low + high); }
};

std::array<bool, 4> electrodes(const LaplaceProblem& problem) {
  std::array<bool, 4> result;
  for (int side = 0; side < 4; ++side) result[side] = problem.sides[side].kind == Side::Kind::electrode;
  return result;
}

}  // namespace

void Level::build_coarse(const LaplaceProblem& problem, LinkFormula formula, const Level* finer, Team& team) {
  outlines_.clear();
  for (const Body& body : problem.bodies) outlines_.push_back(outline_in_cells(body.shape, h));
  east.clear();
  north.clear();
  choose_resolved(problem);
  absorb_groups(problem, finer);
  discretize(problem, formula, team);
  if (!is_resolved_.empty()) fill_fluid(effective_permittivity(problem), team);
}

void Level::choose_resolved(const LaplaceProblem& problem) {
  std::vector<int> members(problem.groups.size(), 0);
  for (const Body& body : problem.bodies) ++members[body.group];
  is_resolved_.assign(problem.bodies.size(), 1);
  for (std::size_t body = 0; body < outlines_.size(); ++body) {
    const int g = problem.bodies[body].group;
    const bool alone = problem.groups[g].floating && members[g] == 1;
    is_resolved_[body] = is_resolved(outlines_[body], alone);
  }
  if (std::find(is_resolved_.begin(), is_resolved_.end(), 0) == is_resolved_.end()) is_resolved_.clear();
}

void Level::absorb_groups(const LaplaceProblem& problem, const Level* finer) {
  absorbed.clear();
  newly_absorbed = 0;
  is_absorbed_.clear();
  if (is_resolved_.empty()) return;
  std::vector<Extent> extent(problem.groups.size());
  is_absorbed_.assign(problem.groups.size(), 0);
  for (std::size_t g = 0; g < problem.groups.size(); ++g) is_absorbed_[g] = problem.groups[g].floating;
  for (std::size_t body = 0; body < outlines_.size(); ++body) {
    const int g = problem.bodies[body].group;
    if (is_resolved_[body]) {
      is_absorbed_[g] = 0;
      continue;
    }
    const Vec2 centre = outlines_[body].centre;
    const double r = outlines_[body].size;
    extent[g].low = {std::min(extent[g].low.x, centre.x - r), std::min(extent[g].low.y, centre.y - r)};
    extent[g].high = {std::max(extent[g].high.x, centre.x + r), std::max(extent[g].high.y, centre.y + r)};
  }
  for (std::size_t g = 0; g < problem.groups.size(); ++g) {
    if (!is_absorbed_[g]) continue;
    is_absorbed_[g] = extent[g].size() <= least_extent;
    if (!is_absorbed_[g]) continue;
    const Interpolation at_centre = interpolate(layout, extent[g].centre(), electrodes(problem).data());
    absorbed.push_back({static_cast<int>(g), std::to_array(at_centre.cell), std::to_array(at_centre.weight)});
  }
  const auto is_new = [&](const AbsorbedGroup& group) { return !finer || finer->has_unknown(group.group); };
  newly_absorbed = static_cast<int>(std::stable_partition(absorbed.begin(), absorbed.end(), is_new) - absorbed.begin());
}

std::vector<float> Level::effective_permittivity(const LaplaceProblem& problem) const {
  std::vector<float> permittivity(layout.size(), 0.0f);
  for (std::size_t body = 0; body < outlines_.size(); ++body) {
    if (is_resolved_[body] || !is_absorbed_[problem.bodies[body].group]) continue;
    const double area = std::numbers::pi * outlines_[body].size * outlines_[body].size;
    const Interpolation around = interpolate(layout, outlines_[body].centre, electrodes(problem).data());
    for (int k = 0; k < 4; ++k) permittivity[around.cell[k]] += static_cast<float>(area) * std::abs(around.weight[k]);
  }
  for (float& value : permittivity) value = laplace::effective_permittivity(value);
  return permittivity;
}

/// Conductances of faces, links and sides in a medium that is not the same everywhere: between two cells that of the
/// two halves in series.
void Level::fill_fluid(const std::vector<float>& permittivity, Team& team) {
  east.assign(layout.size(), 0.0f);
  north.assign(layout.size(), 0.0f);
  const auto face = [&](std::ptrdiff_t a, int i, int j) {
    if (!inside({i, j})) return 0.0f;
    const std::ptrdiff_t b = layout(i, j);
    return cover[b] >= 0 ? 0.0f : face_conductance(permittivity[a], permittivity[b]);
  };
  const int chunks = 4 * team.size();
  team.for_each(chunks, [&](int chunk) {
    for (int j = layout.ny * chunk / chunks; j < layout.ny * (chunk + 1) / chunks; ++j) {
      for (int i = 0; i < layout.nx; ++i) {
        const std::ptrdiff_t slot = layout(i, j);
        diagonal[slot] = 0;
        if (cover[slot] >= 0) continue;
        east[slot] = face(slot, i + 1, j);
        north[slot] = face(slot, i, j + 1);
        diagonal[slot] = east[slot] + north[slot] + face(slot, i - 1, j) + face(slot, i, j - 1);
      }
      for (int m = row_start[j]; m < row_start[j + 1]; ++m) {
        Link& link = links[links_by_row[m]];
        if (resolves(link.body)) link.conductance *= permittivity[link.cell];
        diagonal[link.cell] += link.conductance;
      }
    }
  });
  for (SideLink& link : side_links)
    if (link.cell >= 0) diagonal[link.cell] += link.conductance *= permittivity[link.cell];
}

/// A well draws from the four cells around it.
void Level::link_well(const LaplaceProblem& problem, int body, Part& part) const {
  const int g = problem.bodies[body].group;
  if (is_absorbed_[g]) return;
  const double whole = well_conductance(outlines_[body].size);
  const Interpolation around = interpolate(layout, outlines_[body].centre, electrodes(problem).data());
  for (int k = 0; k < 4; ++k) {
    const std::ptrdiff_t slot = around.cell[k];
    const double c = std::abs(around.weight[k]) * whole;
    if (c == 0) continue;
    if (cover[slot] < 0) {
      part.links.push_back({slot, body, c, {}});
      part.link_row.push_back(around.row[k]);
    } else if (problem.bodies[cover[slot]].group != g) {
      part.pairs.push_back({body, cover[slot], c, {}, {}});
    }
  }
}

}  // namespace lichtenberg::laplace
