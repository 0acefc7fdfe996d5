#include "solvers/laplace/spheres/cells.hpp"

#include <algorithm>
#include <cmath>

namespace lichtenberg::laplace::spheres {

Cells::Cells(const SphereProblem& problem, const std::vector<Site>& sites)
    : bounded_(!problem.free_space), lengths_(problem.box.lengths) {
  double largest = 0;
  Vec3 low = sites[0].centre, high = low;
  for (const Site& site : sites) {
    largest = std::max(largest, site.radius);
    for (int k = 0; k < 3; ++k) {
      low[k] = std::min(low[k], site.centre[k]);
      high[k] = std::max(high[k], site.centre[k]);
    }
  }
  if (!bounded_) {
    origin = low;
    for (int k = 0; k < 3; ++k) lengths_[k] = std::max(high[k] - low[k], 1e-3 * largest);
  }
  // Cells with about one sphere each. Fewer spheres per cell mean more waves without fewer near pairs; more mean more
  // near pairs. Cells much smaller than spheres save nothing, because the near range depends on the reach, which is at
  // least a radius.
  const double volume = lengths_.x * lengths_.y * lengths_.z;
  double wanted = std::max(std::cbrt(volume / sites.size()), 1.5 * largest);
  for (int k = 0; k < 3; ++k) {  // A flat box has one layer
    if (lengths_[k] < wanted) wanted = std::max(std::sqrt(volume / lengths_[k] / sites.size()), 1.5 * largest);
  }
  // Edges take discrete values, like the reach below. Cells become up to 5 % longer, 2.5 % on average, and hold 8 %
  // more spheres.
  if (!bounded_) wanted = std::exp(0.05 * std::ceil(std::log(wanted) / 0.05));
  for (int k = 0; k < 3; ++k) {
    const double cells = lengths_[k] / wanted;
    count[k] = std::max(1, static_cast<int>(bounded_ ? std::lround(cells) : std::ceil(cells)));
    edge[k] = bounded_ ? lengths_[k] / count[k] : wanted;
    const bool periodic = bounded_ && problem.box.periodic(k);
    mirrored[k] = bounded_ && !periodic;
    for (int s = 0; s < 2; ++s)
      side_sign_[2 * k + s] = mirrored[k] && problem.box.sides[2 * k + s] == Boundary::electrode ? -1 : 1;
    const bool alternates = side_sign_[2 * k] != side_sign_[2 * k + 1];
    period[k] = periodic ? count[k] : alternates ? 4 * count[k] : 2 * count[k];
  }
  members.resize(cells());
  for (std::size_t i = 0; i < sites.size(); ++i) {
    const auto at = indices(sites[i].centre);
    members[number(at)].push_back(static_cast<int>(i));
    reach = std::max(reach, norm(sites[i].centre - centre(at)) + sites[i].radius);
  }
  if (bounded_) reach = std::max(reach, 0.5 * norm(edge));  // Fields may be requested at any point
  // The reach takes discrete values, so that tables of the cells remain valid while spheres move. They are recomputed
  // when the farthest sphere has moved by 5 % of a cell. The reach is at least half of a cell's diagonal, 0.87 of its
  // edge, so that it grows by 3 % on average. Near pairs grow with its cube, by 10 %.
  const double spacing = std::min({edge.x, edge.y, edge.z}), step = 0.05 * spacing;
  reach = step * std::ceil(reach / step);
  // For multipoles within the reach of a cell's centre and charges of a cell beyond three reaches, terms at least halve
  // from one degree to the next. A cell's neighbours are always near. The irrational factor keeps the range away from
  // distances between cells, so that rounding has no effect.
  range = std::max(3 * reach, 1.01 * spacing) * (1 + 1e-4 * std::sqrt(2.0));
}

std::array<int, 3> Cells::indices(Vec3 p) const {
  std::array<int, 3> at;
  for (int k = 0; k < 3; ++k)
    at[k] = std::clamp(static_cast<int>(std::floor((p[k] - origin[k]) / edge[k])), 0, count[k] - 1);
  return at;
}

Cells::ImageCell Cells::inside(int axis, int index) const {
  const int n = count[axis];
  const int block = index >= 0 ? index / n : -((n - 1 - index) / n), within = index - block * n;
  if (block == 0) return {within};
  if (!bounded_) return {};
  if (!mirrored[axis]) return {within, false, block * lengths_[axis], 1};
  const double low = side_sign_[2 * axis], high = side_sign_[2 * axis + 1];
  const bool reflected = (block & 1) != 0;
  const int periods = reflected ? (block - 1) / 2 : block / 2;
  const double sign = (periods & 1 ? low * high : 1) * (reflected ? high : 1);
  return reflected ? ImageCell{n - 1 - within, true, (block + 1) * lengths_[axis], sign}
                   : ImageCell{within, false, block * lengths_[axis], sign};
}

Cells::Neighbourhood Cells::neighbourhood() const {
  Neighbourhood near;
  for (int k = 0; k < 3; ++k) {
    near.most[k] = static_cast<int>(range / edge[k]);
    for (int index = -near.most[k]; index < count[k] + near.most[k]; ++index)
      near.inside[k].push_back(inside(k, index));
  }
  for (int x = -near.most[0]; x <= near.most[0]; ++x)
    for (int y = -near.most[1]; y <= near.most[1]; ++y)
      for (int z = -near.most[2]; z <= near.most[2]; ++z)
        if (is_near(x, y, z)) near.offsets.push_back({x, y, z});
  return near;
}

std::vector<NearPair> Cells::near_pairs(const std::vector<Site>& targets, const std::vector<Site>& sources,
                                        parallel::Team& team) const {
  constexpr int targets_a_part = 32;
  const Neighbourhood near = neighbourhood();
  const int all = static_cast<int>(targets.size());
  std::vector<std::vector<NearPair>> part((all + targets_a_part - 1) / targets_a_part);
  team.for_each(static_cast<int>(part.size()), [&](int p) {
    for (int t = p * targets_a_part; t < std::min((p + 1) * targets_a_part, all); ++t)
      add_near_pairs(t, targets[t].centre, sources, near, part[p]);
  });
  std::vector<std::size_t> start = {0};
  for (const std::vector<NearPair>& one : part) start.push_back(start.back() + one.size());
  std::vector<NearPair> pairs(start.back());
  team.for_each(static_cast<int>(part.size()), [&](int p) {
    std::copy(part[p].begin(), part[p].end(), pairs.begin() + static_cast<std::ptrdiff_t>(start[p]));
    part[p] = {};  // Pairs of many spheres take much memory
  });
  return pairs;
}

void Cells::add_near_pairs(int target, Vec3 position, const std::vector<Site>& sources, const Neighbourhood& near,
                           std::vector<NearPair>& pairs) const {
  const auto at = indices(position);
  for (const auto& offset : near.offsets) {
    const auto along = [&](int k) -> const ImageCell& { return near.inside[k][at[k] + offset[k] + near.most[k]]; };
    const ImageCell &x = along(0), &y = along(1), &z = along(2);
    if (x.index < 0 || y.index < 0 || z.index < 0) continue;
    const int mask = (x.reflected ? 1 : 0) + (y.reflected ? 2 : 0) + (z.reflected ? 4 : 0);
    const Vec3 image{x.reflected ? -1.0 : 1.0, y.reflected ? -1.0 : 1.0, z.reflected ? -1.0 : 1.0};
    for (const int s : members[number({x.index, y.index, z.index})]) {
      const Vec3 c = sources[s].centre;
      const Vec3 displacement =
          position - Vec3{image.x * c.x + x.shift, image.y * c.y + y.shift, image.z * c.z + z.shift};
      if (norm2(displacement) == 0) continue;  // The sphere itself
      pairs.push_back({target, s, mask, x.sign * y.sign * z.sign, displacement});
    }
  }
}

}  // namespace lichtenberg::laplace::spheres
