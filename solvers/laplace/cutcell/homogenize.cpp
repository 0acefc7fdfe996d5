// Coarse grids of the preconditioner, and what they make of conductors that they do not resolve (medium.hpp).

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>

#include "solvers/laplace/cutcell/level.hpp"
#include "solvers/laplace/cutcell/medium.hpp"
#include "solvers/laplace/cutcell/sets.hpp"
#include "solvers/laplace/cutcell/wavefront.hpp"

namespace lichtenberg::laplace {

namespace {

/// The rectangle around a group's disks.
struct Extent {
  Vec2 low{std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()}, high = -low;
  double size() const { return std::max(high.x - low.x, high.y - low.y); }
  Vec2 centre() const { return 0.5 * (low + high); }
};

}  // namespace

Sets strongly_coupled(const LaplaceProblem& problem, const std::vector<NetworkLink>& direct_links) {
  constexpr double least = 0.05;
  const int groups = static_cast<int>(problem.groups.size());
  std::vector<Coupling> couplings = problem.couplings;
  for (const auto& [a, b, conductance] : direct_links)
    if (conductance > least_joining) couplings.push_back({a, b, conductance * problem.permittivity});
  Sets sets{coupled_sets(groups, couplings, least * problem.permittivity), std::vector<char>(groups, 0)};
  const auto hold = [&](int group) { sets.is_held[sets.of_group[group]] = 1; };
  for (int g = 0; g < groups; ++g)
    if (!problem.groups[g].floating) hold(g);
  if (problem.has_fixed_conductor()) return sets;
  for (const Coupling& coupling : problem.couplings) {
    if (coupling.capacitance == 0) continue;
    if (!problem.groups[coupling.a].floating) hold(coupling.b);
    if (!problem.groups[coupling.b].floating) hold(coupling.a);
  }
  return sets;
}

void Level::build_coarse(const LaplaceProblem& problem, LinkFormula formula, const Sets& sets, const Level* finer,
                         parallel::Team& team) {
  outlines_.clear();
  for (const Body& body : problem.bodies) outlines_.push_back(outline_in_cells(body, h));
  east.clear();
  north.clear();
  choose_resolved(problem, sets);
  absorb_groups(problem, sets, finer);
  list_thin_conductors(problem);
  discretize(problem, formula, team);
  if (finer) inherit_pairs(problem, *finer);
  couple(problem, largest_coarse_coupling);
  if (!is_resolved_.empty()) fill_fluid(effective_permittivity(problem), team);
  find_bound_cells(problem, team);
}

/// What conductors that all but touch exchange does not pass through cells: where one of them is thin here, the finer
/// grid's direct links stay what they are, also those through bound cells. Conductances do not depend on the size of
/// cells.
void Level::inherit_pairs(const LaplaceProblem& problem, const Level& finer) {
  const auto is_unknown = [&](int body) {
    const int group = problem.bodies[body].group;
    return !problem.groups[group].floating || has_unknown(group);
  };
  const auto inherit = [&](const PairLink& pair) {
    if (resolves(pair.body_a) && resolves(pair.body_b)) return;
    if (is_unknown(pair.body_a) && is_unknown(pair.body_b)) pairs.push_back(pair);
  };
  for (const PairLink& pair : finer.pairs) inherit(pair);
  finer.bound.for_each_joined([&](const BoundCells::Link& a, const BoundCells::Link& b, double conductance) {
    inherit({a.body, b.body, conductance, {}, {}});
  });
}

void Level::choose_resolved(const LaplaceProblem& problem, const Sets& sets) {
  std::vector<int> members(problem.groups.size(), 0);
  for (const Body& body : problem.bodies) ++members[sets.of_group[body.group]];
  is_resolved_.assign(problem.bodies.size(), 1);
  for (std::size_t body = 0; body < outlines_.size(); ++body) {
    const int set = sets.of_group[problem.bodies[body].group];
    is_resolved_[body] = is_resolved(outlines_[body], members[set] == 1 && !sets.is_held[set]);
  }
  if (std::find(is_resolved_.begin(), is_resolved_.end(), 0) == is_resolved_.end()) is_resolved_.clear();
}

void Level::absorb_groups(const LaplaceProblem& problem, const Sets& sets, const Level* finer) {
  absorbed.clear();
  newly_absorbed = 0;
  is_absorbed_.clear();
  if (is_resolved_.empty()) return;
  std::vector<Extent> extent(problem.groups.size());  // of sets
  std::vector<char> is_kept = sets.is_held;
  for (std::size_t body = 0; body < outlines_.size(); ++body) {
    const int set = sets.of_group[problem.bodies[body].group];
    if (is_resolved_[body]) {
      is_kept[set] = 1;
      continue;
    }
    const Vec2 centre = outlines_[body].centre;
    const double r = outlines_[body].size;
    extent[set].low = {std::min(extent[set].low.x, centre.x - r), std::min(extent[set].low.y, centre.y - r)};
    extent[set].high = {std::max(extent[set].high.x, centre.x + r), std::max(extent[set].high.y, centre.y + r)};
  }
  is_absorbed_.assign(problem.groups.size(), 0);
  for (std::size_t g = 0; g < problem.groups.size(); ++g) {
    const int set = sets.of_group[g];
    const Extent& around = extent[set];
    is_absorbed_[g] = !is_kept[set] && around.size() <= least_extent;
    if (!is_absorbed_[g]) continue;
    const Interpolation at_centre = interpolate(layout, around.centre(), electrodes(problem).data());
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
void Level::fill_fluid(const std::vector<float>& permittivity, parallel::Team& team) {
  east.assign(layout.size(), 0.0f);
  north.assign(layout.size(), 0.0f);
  const auto face = [&](std::ptrdiff_t a, int i, int j) {
    if (!inside({i, j})) return 0.0f;
    const std::ptrdiff_t b = layout(i, j);
    return !cover[b].is_fluid() ? 0.0f : face_conductance(permittivity[a], permittivity[b]);
  };
  for_each_row(team, layout, [&](int j) {
    for (int i = 0; i < layout.nx; ++i) {
      const std::ptrdiff_t slot = layout(i, j);
      diagonal[slot] = 0;
      if (!cover[slot].is_fluid()) continue;
      east[slot] = face(slot, i + 1, j);
      north[slot] = face(slot, i, j + 1);
      diagonal[slot] = east[slot] + north[slot] + face(slot, i - 1, j) + face(slot, i, j - 1);
    }
    for (int m = row_start[j]; m < row_start[j + 1]; ++m) {
      RowLink& link = row_links[m];
      if (resolves(link.body)) links[link.link].conductance = link.conductance *= permittivity[link.cell];
      diagonal[link.cell] += link.conductance;
    }
  });
  for (SideLink& link : side_links)
    if (link.cell >= 0) diagonal[link.cell] += link.conductance *= permittivity[link.cell];
}

void Level::list_thin_conductors(const LaplaceProblem& problem) {
  thin_.clear();
  thin_start_.assign(problem.groups.size() + 1, 0);
  if (is_resolved_.empty()) return;
  const auto is_thin = [&](std::size_t body) {
    return !is_resolved_[body] && !is_absorbed_[problem.bodies[body].group];
  };
  for (std::size_t body = 0; body < outlines_.size(); ++body)
    if (is_thin(body)) ++thin_start_[problem.bodies[body].group + 1];
  std::partial_sum(thin_start_.begin(), thin_start_.end(), thin_start_.begin());
  thin_.resize(thin_start_.back());
  std::vector<int> next(thin_start_.begin(), thin_start_.end() - 1);
  for (std::size_t body = 0; body < outlines_.size(); ++body)
    if (is_thin(body)) thin_[next[problem.bodies[body].group]++] = static_cast<int>(body);
}

/// A thin conductor exchanges flux with the four cells around it. What those of a group exchange with the same cell is
/// one link, of the group's first: on the coarsest grids a cell lies beside a large group's by the dozen.
void Level::link_thin_conductors(const LaplaceProblem& problem, int group, Part& part) const {
  // By slot: a cell's place among this group's links, if there it is found. What others have left here does no harm.
  thread_local std::vector<std::uint32_t> place_of;
  if (static_cast<std::ptrdiff_t>(place_of.size()) < layout.size()) place_of.resize(layout.size());
  const std::array<bool, 4> is_electrode = electrodes(problem);
  const int first = thin_[thin_start_[group]];
  const std::size_t before = part.links.size();
  const auto add_to_cell = [&](std::ptrdiff_t slot, int row, double c) {
    const std::size_t known = before + place_of[slot];
    if (known < part.links.size() && part.links[known].cell == slot) {
      part.links[known].conductance += c;
      return;
    }
    place_of[slot] = static_cast<std::uint32_t>(part.links.size() - before);
    part.links.push_back({slot, first, c, {}});
    part.link_row.push_back(row);
  };
  for (int k = thin_start_[group]; k < thin_start_[group + 1]; ++k) {
    const Outline& disk = outlines_[thin_[k]];
    const double whole = thin_conductance(disk, layout);
    const Interpolation around = interpolate(layout, disk.centre, is_electrode.data());
    for (int n = 0; n < 4; ++n) {
      const std::ptrdiff_t slot = around.cell[n];
      const double c = std::abs(around.weight[n]) * whole;
      if (c == 0) continue;
      if (cover[slot].is_fluid())
        add_to_cell(slot, around.row[n], c);
      else if (const int other = cover[slot].body(); problem.bodies[other].group != group)
        part.pairs.push_back({thin_[k], other, c, {}, {}});
    }
  }
}

}  // namespace lichtenberg::laplace
