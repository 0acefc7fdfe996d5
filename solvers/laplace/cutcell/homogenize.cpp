#include "solvers/laplace/cutcell/homogenize.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>

#include "solvers/laplace/cutcell/medium.hpp"
#include "solvers/laplace/cutcell/wavefront.hpp"

namespace lichtenberg::laplace {

namespace {

/// Smallest rectangle around a set of disks (cells).
struct Extent {
  Vec2 low{std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()}, high = -low;

  void add(const Outline& disk) {
    const Vec2 centre = disk.centre;
    const double r = disk.size;
    low = {std::min(low.x, centre.x - r), std::min(low.y, centre.y - r)};
    high = {std::max(high.x, centre.x + r), std::max(high.y, centre.y + r)};
  }
  double size() const { return std::max(high.x - low.x, high.y - low.y); }
  Vec2 centre() const { return 0.5 * (low + high); }
};

/// Sets `is_resolved`, which stays empty if the grid resolves all bodies. Replaces unresolved bars by disks.
void choose_resolved(const LaplaceProblem& problem, const Agglomerates& agglomerates, GridBodies& bodies) {
  std::vector<int> members(problem.groups.size(), 0);
  for (const Body& body : problem.bodies) ++members[agglomerates.first_group[body.group]];
  bodies.is_resolved.assign(problem.bodies.size(), 1);
  for (std::size_t body = 0; body < problem.bodies.size(); ++body) {
    const int set = agglomerates.first_group[problem.bodies[body].group];
    Outline& outline = bodies.outlines[body];
    bodies.is_resolved[body] = is_resolved(outline, members[set] == 1 && !agglomerates.is_grounded[set]);
    if (!bodies.is_resolved[body] && outline.kind != Outline::Kind::disk) outline = unresolved_disk(outline);
  }
  if (std::ranges::find(bodies.is_resolved, 0) == bodies.is_resolved.end()) bodies.is_resolved.clear();
}

/// Finds the groups that the medium absorbs: those of a set without a resolved body and without a given potential. The
/// set must lie within `least_extent` cells.
void absorb_groups(const LaplaceProblem& problem, const Agglomerates& agglomerates, const Level* finer,
                   const GridBodies& bodies, Level& level) {
  level.absorbed.clear();
  level.newly_absorbed = 0;
  level.is_absorbed.clear();
  if (bodies.is_resolved.empty()) return;
  std::vector<Extent> extent(problem.groups.size());  // of sets
  std::vector<char> is_kept = agglomerates.is_grounded;
  for (std::size_t body = 0; body < problem.bodies.size(); ++body) {
    const int set = agglomerates.first_group[problem.bodies[body].group];
    if (bodies.is_resolved[body])
      is_kept[set] = 1;
    else
      extent[set].add(bodies.outlines[body]);
  }
  level.is_absorbed.assign(problem.groups.size(), 0);
  for (std::size_t g = 0; g < problem.groups.size(); ++g) {
    const int set = agglomerates.first_group[g];
    level.is_absorbed[g] = !is_kept[set] && extent[set].size() <= least_extent;
    if (!level.is_absorbed[g]) continue;
    const Interpolation at_centre = interpolate(level.layout, extent[set].centre(), electrodes(problem).data());
    AbsorbedGroup absorbed{static_cast<int>(g), std::to_array(at_centre.cell), std::to_array(at_centre.weight)};
    for (int k = 0; k < 4; ++k)
      if (!level.layout.own.contains(at_centre.row[k])) absorbed.cell[k] = 0, absorbed.weight[k] = 0;
    level.absorbed.push_back(absorbed);
  }
  const auto is_new = [&](const AbsorbedGroup& group) { return !finer || finer->has_unknown(group.group); };
  const auto first_old = std::stable_partition(level.absorbed.begin(), level.absorbed.end(), is_new);
  level.newly_absorbed = static_cast<int>(first_old - level.absorbed.begin());
}

/// Lists the subgrid conductors: bodies that the grid does not resolve, of groups that the medium does not absorb.
void list_subgrid_conductors(const LaplaceProblem& problem, const Level& level, GridBodies& bodies) {
  std::vector<int>&start = bodies.subgrid_start, &subgrid = bodies.subgrid;
  subgrid.clear();
  start.assign(problem.groups.size() + 1, 0);
  if (bodies.is_resolved.empty()) return;
  const auto is_subgrid = [&](std::size_t body) {
    return !bodies.is_resolved[body] && !level.is_absorbed[problem.bodies[body].group];
  };
  for (std::size_t body = 0; body < problem.bodies.size(); ++body)
    if (is_subgrid(body)) ++start[problem.bodies[body].group + 1];
  std::partial_sum(start.begin(), start.end(), start.begin());
  subgrid.resize(start.back());
  std::vector<int> next(start.begin(), start.end() - 1);
  for (std::size_t body = 0; body < problem.bodies.size(); ++body)
    if (is_subgrid(body)) subgrid[next[problem.bodies[body].group]++] = static_cast<int>(body);
}

/// Computes the effective relative permittivity by slot (memory index) from the area of the absorbed disks in each
/// cell.
std::vector<float> cell_permittivity(const LaplaceProblem& problem, const GridBodies& bodies, const Level& level) {
  std::vector<float> permittivity(level.layout.size(), 0.0f);
  for (std::size_t body = 0; body < problem.bodies.size(); ++body) {
    if (bodies.is_resolved[body] || !level.is_absorbed[problem.bodies[body].group]) continue;
    const Outline& disk = bodies.outlines[body];
    const double area = std::numbers::pi * disk.size * disk.size;
    const Interpolation around = interpolate(level.layout, disk.centre, electrodes(problem).data());
    for (int k = 0; k < 4; ++k)
      if (level.layout.stored.contains(around.row[k]))
        permittivity[around.cell[k]] += static_cast<float>(area) * std::abs(around.weight[k]);
  }
  for (float& value : permittivity) value = effective_permittivity(value);
  return permittivity;
}

/// Computes the face conductances and the diagonal of row j in the medium, and multiplies the links' conductances by
/// the permittivity.
void fill_row(int j, const std::vector<float>& permittivity, const GridBodies& bodies, Level& level) {
  const Layout& layout = level.layout;
  const auto face = [&](std::ptrdiff_t a, int i_b, int j_b) {
    if (!inside(layout, i_b, j_b)) return 0.0f;
    const std::ptrdiff_t b = layout(i_b, j_b);
    return !level.owner[b].is_fluid() ? 0.0f : face_conductance(permittivity[a], permittivity[b]);
  };
  std::vector<float>&east = level.faces.east, &north = level.faces.north;
  for (int i = 0; i < layout.nx; ++i) {
    const std::ptrdiff_t slot = layout(i, j);
    level.diagonal[slot] = 0;
    if (!level.owner[slot].is_fluid()) continue;
    east[slot] = face(slot, i + 1, j);
    north[slot] = face(slot, i, j + 1);
    level.diagonal[slot] = east[slot] + north[slot] + face(slot, i - 1, j) + face(slot, i, j - 1);
  }
  for (int m = level.row_start[j]; m < level.row_start[j + 1]; ++m) {
    RowLink& link = level.row_links[m];
    if (bodies.resolves(link.body)) level.links[link.link].conductance = link.conductance *= permittivity[link.cell];
    level.diagonal[link.cell] += link.conductance;
  }
}

}  // namespace

void choose_unknowns(const LaplaceProblem& problem, const Agglomerates& agglomerates, const Level* finer,
                     GridBodies& bodies, Level& level) {
  choose_resolved(problem, agglomerates, bodies);
  absorb_groups(problem, agglomerates, finer, bodies, level);
  list_subgrid_conductors(problem, level, bodies);
}

void inherit_pairs(const LaplaceProblem& problem, const Level& finer, const GridBodies& bodies, Level& level) {
  const auto is_kept = [&](int body) {
    const int group = problem.bodies[body].group;
    return !problem.groups[group].floating || level.has_unknown(group);
  };
  const auto inherit = [&](const PairLink& pair) {
    if (bodies.resolves(pair.body_a) && bodies.resolves(pair.body_b)) return;
    if (is_kept(pair.body_a) && is_kept(pair.body_b)) level.pairs.push_back(pair);
  };
  for (const PairLink& pair : finer.pairs) inherit(pair);
  for (const PairLink& pair : finer.eliminated_pairs) inherit(pair);
}

void homogenize_fluid(const LaplaceProblem& problem, const GridBodies& bodies, Level& level, parallel::Team& team) {
  level.faces.east.clear();
  level.faces.north.clear();
  if (bodies.is_resolved.empty()) return;
  const std::vector<float> permittivity = cell_permittivity(problem, bodies, level);
  level.faces.east.assign(level.layout.size(), 0.0f);
  level.faces.north.assign(level.layout.size(), 0.0f);
  for_each_row(team, level.layout, level.layout.stored, [&](int j) { fill_row(j, permittivity, bodies, level); });
  for (SideLink& link : level.side_links)
    if (link.cell >= 0) level.diagonal[link.cell] += link.conductance *= permittivity[link.cell];
}

}  // namespace lichtenberg::laplace
