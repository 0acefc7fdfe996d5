#include "src/scene/placing.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "src/scene/radii.hpp"

namespace lichtenberg {
namespace {

/// A conductor for which so many random places were taken finds none. A hundred times as many tries fit 1 to 3 % more
/// disks into a box of about 324 (five seeds).
constexpr int tries_per_conductor = 100000;

double largest_radius(const Draft& draft) {
  double largest = 0;
  for (const ConductorDraft& c : draft.conductors) largest = std::max(largest, c.conductor.radius);
  for (const PopulationDraft& p : draft.populations) largest = std::max(largest, largest_radius(p));
  return largest;
}

double largest_gap(const Draft& draft) {
  double largest = 0;
  for (const PopulationDraft& p : draft.populations) largest = std::max(largest, p.min_gap);
  return largest;
}

/// A grid that holds the conductors given one by one and can take the populations.
DiskGrid grid_of_given(const Draft& draft) {
  DiskGrid grid(2 * largest_radius(draft) + largest_gap(draft));
  for (const ConductorDraft& c : draft.conductors) grid.insert({c.conductor.position, c.conductor.radius});
  return grid;
}

std::string at(Vec2 p) { return fmt::format("[{:g}, {:g}]", p.x, p.y); }

/// Where the centre of a disk can be.
Rectangle room_for(double radius, const PopulationDraft& population, Vec2 size) {
  const double from_side = radius + population.min_gap;
  const Rectangle region = population.region.value_or(Rectangle{{0, 0}, size});
  return {
      {std::max(region.lower.x + radius, from_side), std::max(region.lower.y + radius, from_side)},
      {std::min(region.upper.x - radius, size.x - from_side), std::min(region.upper.y - radius, size.y - from_side)}};
}

/// What a population's conductors must stay clear of.
struct Obstacles {
  const std::vector<Electrode>& electrodes;
  const std::vector<Wall>& walls;
};

bool clear_of(const Obstacles& obstacles, const Conductor& conductor, double min_gap) {
  const Disk disk{conductor.position, conductor.radius};
  return std::ranges::all_of(obstacles.electrodes,
                             [&](const Electrode& electrode) { return gap(disk, electrode.shape) >= min_gap; }) &&
         std::ranges::all_of(obstacles.walls, [&](const Wall& wall) {
           return distance(wall, conductor) >= conductor.radius * (1 - touching_slack) + min_gap;
         });
}

std::optional<Conductor> find_place(double radius, const PopulationDraft& population, const Draft& draft,
                                    const Obstacles& obstacles, const DiskGrid& grid, UniformRandom& random) {
  const Rectangle room = room_for(radius, population, draft.scene.domain.size);
  const double height = draft.scene.domain.height, from_side = radius + population.min_gap;
  if (room.lower.x > room.upper.x || room.lower.y > room.upper.y || (height > 0 && 2 * from_side > height)) return {};
  for (int attempt = 0; attempt < tries_per_conductor; ++attempt) {
    Conductor conductor{.radius = radius,
                        .charge = population.charge,
                        .relative_resistivity = population.relative_resistivity};
    conductor.position.x = random.between(room.lower.x, room.upper.x);
    conductor.position.y = random.between(room.lower.y, room.upper.y);
    if (height > 0) conductor.z = random.between(from_side, height - from_side);
    if (!clear_of(obstacles, conductor, population.min_gap)) continue;
    if (population.overlapping || !grid.conflict({conductor.position, radius}, population.min_gap)) return conductor;
  }
  return {};
}

void check_population(const Draft& draft, const PopulationDraft& population) {
  const auto refuse_it = [&](const std::string& why) { refuse(draft.scene.path, population.line, why); };
  if (!population.region) return;
  const Vec2 lower = population.region->lower, upper = population.region->upper, size = draft.scene.domain.size;
  if (lower.x >= upper.x || lower.y >= upper.y || lower.x < 0 || lower.y < 0 || upper.x > size.x || upper.y > size.y)
    refuse_it(
        fmt::format("population.region from {} to {} is not allowed: it must be [[left, bottom], [right, top]] inside "
                    "the domain, which goes from [0, 0] to {} m",
                    at(lower), at(upper), at(size)));
}

}  // namespace

void DiskGrid::insert(const Disk& disk) {
  buckets_[bucket_of(disk.centre)].push_back(disks_.size());
  disks_.push_back(disk);
}

std::optional<std::size_t> DiskGrid::conflict(const Disk& disk, double clearance) const {
  const Bucket centre = bucket_of(disk.centre);
  for (std::int64_t y = centre.y - 1; y <= centre.y + 1; ++y)
    for (std::int64_t x = centre.x - 1; x <= centre.x + 1; ++x) {
      const auto bucket = buckets_.find({x, y});
      if (bucket == buckets_.end()) continue;
      for (const std::size_t other : bucket->second)
        if (gap(disk, disks_[other]) < clearance) return other;
    }
  return {};
}

DiskGrid::Bucket DiskGrid::bucket_of(Vec2 p) const {
  return {static_cast<std::int64_t>(std::floor(p.x / side_)), static_cast<std::int64_t>(std::floor(p.y / side_))};
}

std::size_t DiskGrid::Hash::operator()(const Bucket& bucket) const {
  return static_cast<std::size_t>(bucket.x) * 0x9E3779B97F4A7C15u ^ static_cast<std::size_t>(bucket.y);
}

void check_given_conductors(const Draft& draft, const std::vector<Electrode>& electrodes) {
  const Vec2 size = draft.scene.domain.size;
  DiskGrid grid(2 * largest_radius(draft));
  for (std::size_t i = 0; i < draft.conductors.size(); ++i) {
    const Disk disk{draft.conductors[i].conductor.position, draft.conductors[i].conductor.radius};
    const double slack = touching_slack * disk.radius;
    const auto refuse_it = [&](const std::string& why) {
      refuse(draft.scene.path, draft.conductors[i].line,
             fmt::format("conductor.position = {} m is not allowed: this conductor {}", at(disk.centre), why));
    };
    const double outside =
        disk.radius - std::min({disk.centre.x, disk.centre.y, size.x - disk.centre.x, size.y - disk.centre.y});
    if (outside > slack)
      refuse_it(fmt::format("reaches out of the domain by {:.3g} m: the whole disk must lie in [0, 0] to {} m", outside,
                            at(size)));
    for (const Electrode& electrode : electrodes)
      if (const double overlap = -gap(disk, electrode.shape); overlap > slack)
        refuse_it(fmt::format("overlaps the electrode \"{}\" by {:.3g} m: they may touch but not overlap",
                              electrode.name, overlap));
    if (const auto other = grid.conflict(disk, -slack))
      refuse_it(fmt::format("overlaps the one at {} m (line {}) by {:.3g} m: conductors may touch but not overlap",
                            at(grid[*other].centre), draft.conductors[*other].line, -gap(disk, grid[*other])));
    grid.insert(disk);
  }
}

std::vector<Conductor> place_conductors(const Draft& draft, const std::vector<Electrode>& electrodes,
                                        const std::vector<Wall>& walls) {
  std::vector<Conductor> conductors;
  for (const ConductorDraft& given : draft.conductors) conductors.push_back(given.conductor);
  DiskGrid grid = grid_of_given(draft);
  UniformRandom random(static_cast<std::uint64_t>(draft.seed));
  for (const PopulationDraft& population : draft.populations) {
    check_population(draft, population);
    Radii radii(draft, population);
    for (int placed = 0; placed < population.count; ++placed) {
      const double radius = radii.next(random);
      const auto place = find_place(radius, population, draft, {electrodes, walls}, grid, random);
      if (!place && placed == 0)
        refuse(draft.scene.path, population.line,
               fmt::format("population.count = {} is impossible: there is no room for even one of radius {:g} m with "
                           "population.min_gap = {:g} m; smaller ones or a larger domain or region are allowed",
                           population.count, radius, population.min_gap));
      if (!place)
        refuse(
            draft.scene.path, population.line,
            fmt::format("population.count = {} is impossible at this density: random places were found for {} of them, "
                        "and with this radius and min_gap at most about that many are allowed",
                        population.count, placed));
      if (!population.overlapping) grid.insert({place->position, radius});
      conductors.push_back(*place);
    }
  }
  return conductors;
}

}  // namespace lichtenberg
