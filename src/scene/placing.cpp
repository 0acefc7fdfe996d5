#include "src/scene/placing.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "src/scene/electrodes.hpp"
#include "src/scene/radii.hpp"

namespace lichtenberg {
namespace {

/// Number of random positions after which placement of one conductor fails.
constexpr int tries_per_conductor = 100000;

/// Number of tries after which placement of a whole population fails. Without this bound, populations near the limit
/// density would need tries_per_conductor tries for many of their grains. Small populations never reach it. Other
/// populations need a few tens of tries for each conductor if they fit.
long most_tries(const PopulationDraft& population) {
  return std::max(100L * tries_per_conductor, 300L * population.count);
}

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

std::size_t count_of(const Draft& draft) {
  std::size_t count = draft.conductors.size();
  for (const PopulationDraft& p : draft.populations) count += p.count;
  return count;
}

/// Returns a grid that contains the individually given conductors and has capacity for the populations.
SphereGrid grid_of_given(const Draft& draft) {
  SphereGrid grid(2 * largest_radius(draft) + largest_gap(draft), count_of(draft), draft.scene.domain);
  for (const ConductorDraft& c : draft.conductors) grid.insert(sphere_of(c.conductor));
  return grid;
}

std::string at(Vec3 p, int dimension) {
  return dimension == 3 ? fmt::format("[{:g}, {:g}, {:g}]", p.x, p.y, p.z) : fmt::format("[{:g}, {:g}]", p.x, p.y);
}

/// Returns the largest distance (m) by which a sphere is outside the domain. Along periodic axes it is that of its
/// centre.
double outside(const Sphere& sphere, const Box<3>& box, int dimension) {
  double most = -INFINITY;
  for (int k = 0; k < dimension; ++k)
    most = std::max(
        most, (box.periodic(k) ? 0 : sphere.radius) - std::min(sphere.centre[k], box.lengths[k] - sphere.centre[k]));
  return most;
}

/// Box of the allowed positions of a conductor's centre.
struct CentreBox {
  Vec3 lower, upper;
};

/// Round region of a population: a sphere, or a cylinder (in two dimensions a disk) whose axis is along z.
struct RoundRegion {
  explicit RoundRegion(const std::vector<double>& numbers)
      : axes(static_cast<int>(numbers.size()) - 1), radius(numbers.empty() ? INFINITY : numbers.back()) {
    for (int k = 0; k < axes; ++k) centre[k] = numbers[k];
  }
  /// Returns true if a sphere with this centre and radius is inside; always true without a region.
  bool contains(Vec3 position, double sphere_radius) const {
    Vec3 away = position - centre;
    for (int k = std::max(axes, 0); k < 3; ++k) away[k] = 0;
    return axes < 0 || norm(away) + sphere_radius <= radius;
  }

  int axes;  ///< 2 or 3; -1: none
  Vec3 centre{};
  double radius;
};

CentreBox centre_box_for(double radius, const PopulationDraft& population, const Domain& domain) {
  const Box<3> box = domain.box();
  const double from_side = radius + population.min_gap;
  CentreBox centre_box{{}, box.lengths};
  const RoundRegion round(population.round_region);
  for (int k = 0; k < round.axes; ++k)
    centre_box.lower[k] = std::max(centre_box.lower[k], round.centre[k] - round.radius + radius),
    centre_box.upper[k] = std::min(centre_box.upper[k], round.centre[k] + round.radius - radius);
  for (int k = 0; k < 3; ++k) {
    if (population.region && k < population.region->axes())
      centre_box.lower[k] = std::max(centre_box.lower[k], population.region->lower.value[k] + radius),
      centre_box.upper[k] = std::min(centre_box.upper[k], population.region->upper.value[k] - radius);
    if (box.periodic(k)) continue;
    centre_box.lower[k] = std::max(centre_box.lower[k], from_side);
    centre_box.upper[k] = std::min(centre_box.upper[k], box.lengths[k] - from_side);
  }
  return centre_box;
}

/// Returns true if a sphere does not overlap its own periodic images.
bool fits(double radius, double min_gap, const Box<3>& box) {
  for (int k = 0; k < 3; ++k)
    if (box.periodic(k) && 2 * radius + min_gap > box.lengths[k]) return false;
  return true;
}

/// Bodies from which a population's conductors must be separated.
struct Obstacles {
  const std::vector<Electrode>& electrodes;
  const std::vector<Wall>& walls;
  const Domain& domain;
  const SphereGrid& placed;
};

bool clear_of(const Obstacles& obstacles, const Conductor& conductor, double min_gap) {
  return std::ranges::all_of(obstacles.electrodes,
                             [&](const Electrode& e) { return gap(conductor, e, obstacles.domain) >= min_gap; }) &&
         std::ranges::all_of(obstacles.walls, [&](const Wall& wall) {
           return distance(wall, conductor) >= conductor.radius * (1 - touching_slack) + min_gap;
         });
}

std::optional<Conductor> find_free_position(double radius, const PopulationDraft& population,
                                            const Obstacles& obstacles, UniformRandom& random, long& tries_left,
                                            const StopRequest& stop) {
  const Domain& domain = obstacles.domain;
  const int dimension = domain.dimension();
  const CentreBox centre_box = centre_box_for(radius, population, domain);
  for (int k = 0; k < dimension; ++k)
    if (centre_box.lower[k] > centre_box.upper[k]) return {};
  if (!fits(radius, population.min_gap, domain.box())) return {};
  const RoundRegion round(population.round_region);
  for (int attempt = 0; attempt < tries_per_conductor && tries_left > 0; ++attempt, --tries_left) {
    constexpr int tries_per_stop_request = 1 << 12;  // tries between two stop requests: about a millisecond
    if (attempt % tries_per_stop_request == 0 && stop && stop()) throw Stopped{};
    Conductor conductor{.radius = radius,
                        .charge = population.charge,
                        .relative_resistivity = population.relative_resistivity,
                        .material = population.material,
                        .permittivity = population.permittivity};
    conductor.position.x = random.between(centre_box.lower.x, centre_box.upper.x);
    conductor.position.y = random.between(centre_box.lower.y, centre_box.upper.y);
    if (dimension == 3) conductor.position.z = random.between(centre_box.lower.z, centre_box.upper.z);
    if (!round.contains(conductor.position, radius) || !clear_of(obstacles, conductor, population.min_gap)) continue;
    if (population.overlapping || !obstacles.placed.conflict(sphere_of(conductor), population.min_gap))
      return conductor;
  }
  return {};
}

/// Checks that a round region has three numbers, or four in space, and is inside the domain.
void check_round_region(const Draft& draft, const PopulationDraft& population) {
  if (population.round_region.empty()) return;
  const int dimension = draft.domain_size.count, count = static_cast<int>(population.round_region.size());
  const Vec3 size = draft.scene.domain.size;
  const auto refuse_it = [&](const std::string& allowed) {
    refuse(draft.scene.path, population.line,
           fmt::format("population.round_region = [{:g}] is not allowed: {}", fmt::join(population.round_region, ", "),
                       allowed));
  };
  if (count != 3 && !(count == 4 && dimension == 3))
    refuse_it(fmt::format("it must be [x, y, radius]{}", dimension == 3 ? " or [x, y, z, radius]" : ""));
  const RoundRegion round(population.round_region);
  bool inside = round.radius > 0;
  for (int k = 0; k < round.axes; ++k)
    inside &= round.centre[k] - round.radius >= 0 && round.centre[k] + round.radius <= size[k];
  if (!inside)
    refuse_it(
        fmt::format("its radius must be greater than 0, and it must be inside the domain, which goes from {} to "
                    "{} {}",
                    at(Vec3{}, dimension), at(size, dimension), draft.scene.units().length));
}

void check_population(const Draft& draft, const PopulationDraft& population) {
  constexpr int most_conductors = 1000000;
  if (!draft.scene.reference && population.count > most_conductors)
    refuse(draft.scene.path, population.line,
           fmt::format("population.count = {} is not allowed: it must be at most {}, or 1e7 of grains, with [units]",
                       population.count, most_conductors));
  check_round_region(draft, population);
  if (!population.region) return;
  const int axes = population.region->axes();
  const Vec3 lower = population.region->lower.value, upper = population.region->upper.value;
  const Vec3 size = draft.scene.domain.size;
  for (int k = 0; k < axes; ++k)
    if (lower[k] >= upper[k] || lower[k] < 0 || upper[k] > size[k])
      refuse(draft.scene.path, population.line,
             fmt::format("population.region from {} to {} is not allowed: it must be {} inside the domain, which goes "
                         "from {} to {} {}",
                         at(lower, axes), at(upper, axes),
                         axes == 3 ? "[[left, bottom, front], [right, top, back]]" : "[[left, bottom], [right, top]]",
                         at(Vec3{}, axes), at(size, axes), draft.scene.units().length));
}

/// Largest filling fractions, of an area and of a volume, that random sequential addition of one radius is assumed to
/// reach in a large box before most_tries(). The limits for unlimited tries are .547 and .384 (Feder, J. Theor. Biol.
/// 87, 237 (1980), Cooper, Phys. Rev. A 38, 522 (1988)).
constexpr double densest_area = 0.535, densest_volume = 0.35;

/// Returns the number of spheres for which random positions can be found, with the smallest radius of the population
/// plus half the gap. Infinite in a box that is small or thin.
double most_that_fit(const PopulationDraft& population, const Domain& domain) {
  const double radius = smallest_radius(population), across = 2 * radius + population.min_gap;
  const CentreBox centre_box = centre_box_for(radius, population, domain);
  constexpr double thin = 10;  // minimum extent in diameters; near walls the density differs
  const bool plane = domain.dimension() == 2;
  double most = plane ? densest_area * 4 / std::numbers::pi : densest_volume * 6 / std::numbers::pi;
  for (int k = 0; k < domain.dimension(); ++k) {
    const double length = centre_box.upper[k] - centre_box.lower[k];
    const bool bounded = !domain.box().periodic(k) || length < domain.size[k];
    if (length < thin * across) return INFINITY;
    most *= length / across + (bounded ? 1 : 0);  // spheres extend beyond the box of their centres
  }
  if (!population.round_region.empty())  // share of a disk or sphere in its bounding box
    most *= std::numbers::pi / (population.round_region.size() == 3 ? 4 : 6);
  return most;
}

/// Throws InputError early for densities that random placement would reject only after minutes.
void check_density(const Draft& draft, const PopulationDraft& population) {
  constexpr int many = 10000;
  if (population.overlapping || population.count < many) return;
  const double most = most_that_fit(population, draft.scene.domain);
  if (population.count > most)
    refuse(draft.scene.path, population.line,
           fmt::format("population.count = {} is impossible at this density: random positions exist for at most about "
                       "{:.0f} of the smallest radius {:g} {} with this min_gap in this domain or region",
                       population.count, most, smallest_radius(population), draft.scene.units().length));
}

std::string wrong_radius(std::size_t body, double radius, const std::string& key) {
  return fmt::format(
      "body {} has a radius of {:g} in the result of --from, but another one in {}: only equal bodies can start from "
      "that result",
      body, radius, key);
}

/// Returns true if the next conductor of a population can have this radius.
bool can_have_radius(const PopulationDraft& population, double radius, Radii& radii, UniformRandom& random) {
  const auto [smallest, largest] = population.radius.value_or(Interval{});
  const bool drawn = population.radii.empty() && smallest < largest;
  return drawn ? radius >= smallest && radius <= largest : radius == radii.next(random);
}

}  // namespace

SphereGrid::SphereGrid(double reach, std::size_t count, const Domain& domain) : box_(domain.box()), nearest_(box_) {
  // Limits the number of empty buckets where spheres are few.
  const double most = 64 + 8.0 * static_cast<double>(count);
  constexpr double wider = 1.25;
  buckets_ = {1, 1, 1};
  for (double side = reach, all = INFINITY; reach > 0 && all > most; side *= wider) {
    all = 1;
    for (int k = 0; k < domain.dimension(); ++k) {
      const double fit = std::isfinite(box_.lengths[k]) ? std::clamp(std::floor(box_.lengths[k] / side), 1.0, most) : 1;
      buckets_[k] = static_cast<int>(fit);
      all *= fit;
    }
  }
  latest_.assign(static_cast<std::size_t>(buckets_[0]) * buckets_[1] * buckets_[2], none);
}

/// Returns the distance (m) of nearest images. Rounding is skipped for short differences, because it would dominate the
/// cost.
double SphereGrid::distance(Vec3 a, Vec3 b) const {
  Vec3 r = a - b;
  for (int k = 0; k < 3; ++k)
    if (std::abs(r[k]) > 0.4 * nearest_.length[k]) r[k] = nearest_(r[k], k);
  return norm(r);
}

int SphereGrid::bucket_along(int axis, double coordinate) const {
  const int n = buckets_[axis];
  if (n == 1) return 0;
  const double length = box_.lengths[axis];
  if (box_.periodic(axis)) coordinate -= length * std::floor(coordinate / length);
  return static_cast<int>(std::clamp(std::floor(coordinate / length * n), 0.0, n - 1.0));
}

int SphereGrid::neighbour_bucket(int axis, int bucket, int steps) const {
  const int n = buckets_[axis], neighbour = bucket + steps;
  if (neighbour >= 0 && neighbour < n) return neighbour;
  return box_.periodic(axis) ? (neighbour + n) % n : none;
}

void SphereGrid::insert(const Sphere& sphere) {
  const Vec3 p = sphere.centre;
  int& latest =
      latest_[(static_cast<std::size_t>(bucket_along(2, p.z)) * buckets_[1] + bucket_along(1, p.y)) * buckets_[0] +
              bucket_along(0, p.x)];
  before_.push_back(latest);
  latest = static_cast<int>(spheres_.size());
  spheres_.push_back(sphere);
}

/// Searches the sphere's own bucket first, because most conflicts in dense systems are there. Finds the buckets before
/// it tests bodies, so that the processor waits for distant memory once and not for each bucket.
std::optional<std::size_t> SphereGrid::conflict(const Sphere& sphere, double clearance) const {
  const Vec3 p = sphere.centre;
  const int x = bucket_along(0, p.x), y = bucket_along(1, p.y), z = bucket_along(2, p.z);
  std::array<int, 27> latest;
  int found = 0;
  for (const int dz : {0, -1, 1}) {
    const int bz = neighbour_bucket(2, z, dz);
    if (bz == none) continue;
    for (const int dy : {0, -1, 1}) {
      const int by = neighbour_bucket(1, y, dy);
      if (by == none) continue;
      const std::size_t row = (static_cast<std::size_t>(bz) * buckets_[1] + by) * buckets_[0];
      for (const int dx : {0, -1, 1})
        if (const int bx = neighbour_bucket(0, x, dx); bx != none && latest_[row + bx] != none) {
          latest[found] = latest_[row + bx];
          __builtin_prefetch(&spheres_[latest[found]]);
          __builtin_prefetch(&before_[latest[found]]);
          ++found;
        }
    }
  }
  for (int k = 0; k < found; ++k)
    for (int other = latest[k]; other != none; other = before_[other])
      if (gap(sphere, spheres_[other]) < clearance) return other;
  return {};
}

void check_given_conductors(const Draft& draft, const std::vector<Electrode>& electrodes) {
  const Box<3> box = draft.scene.domain.box();
  const int dimension = draft.scene.dimension();
  const std::string unit = draft.scene.units().length;
  SphereGrid grid(2 * largest_radius(draft), draft.conductors.size(), draft.scene.domain);
  for (std::size_t i = 0; i < draft.conductors.size(); ++i) {
    const Conductor& conductor = draft.conductors[i].conductor;
    const Sphere sphere = sphere_of(conductor);
    const double slack = touching_slack * sphere.radius;
    const auto refuse_it = [&](const std::string& why) {
      refuse(draft.scene.path, draft.conductors[i].line,
             fmt::format("conductor.position = {} {} is not allowed: this conductor {}", at(sphere.centre, dimension),
                         unit, why));
    };
    if (const double out = outside(sphere, box, dimension); out > slack)
      refuse_it(fmt::format("reaches out of the domain by {:.3g} {}: {} must lie in {} to {} {}", out, unit,
                            box.any_periodic() ? "all of it, along periodic axes its centre,"
                            : dimension == 3   ? "the whole sphere"
                                               : "the whole disk",
                            at(Vec3{}, dimension), at(box.lengths, dimension), unit));
    if (!fits(sphere.radius, -2 * slack, box))
      refuse_it("overlaps its own image beyond a periodic side: that axis must be at least a diameter long");
    for (const Electrode& electrode : electrodes)
      if (const double overlap = -gap(conductor, electrode, draft.scene.domain); overlap > slack)
        refuse_it(fmt::format("overlaps the electrode \"{}\" by {:.3g} m: they may touch but not overlap",
                              electrode.name, overlap));
    if (const auto other = grid.conflict(sphere, -slack))
      refuse_it(fmt::format("overlaps the one at {} {} (line {}) by {:.3g} {}: conductors may touch but not overlap",
                            at(grid[*other].centre, dimension), unit, draft.conductors[*other].line,
                            -grid.gap(sphere, grid[*other]), unit));
    grid.insert(sphere);
  }
}

std::vector<Conductor> conductors_at(const Draft& draft, const std::vector<Conductor>& bodies) {
  if (bodies.size() != count_of(draft))
    throw InputError(fmt::format(
        "the scene {} has {} bodies, but the result of --from has {}: only equal bodies can start from that result",
        draft.scene.path, count_of(draft), bodies.size()));
  std::vector<Conductor> conductors;
  for (const ConductorDraft& given : draft.conductors) {
    const Conductor& body = bodies[conductors.size()];
    if (body.radius != given.conductor.radius)
      refuse(draft.scene.path, given.line, wrong_radius(conductors.size(), body.radius, "conductor.radius"));
    conductors.push_back(given.conductor);
    conductors.back().position = body.position;
  }
  UniformRandom random(static_cast<std::uint64_t>(draft.seed));
  for (const PopulationDraft& population : draft.populations) {
    check_population(draft, population);
    Radii radii(draft, population);
    for (int k = 0; k < population.count; ++k) {
      const Conductor& body = bodies[conductors.size()];
      if (!can_have_radius(population, body.radius, radii, random))
        refuse(draft.scene.path, population.line,
               wrong_radius(conductors.size(), body.radius,
                            population.radii.empty() ? "population.radius" : "population.radii"));
      conductors.push_back({.position = body.position,
                            .radius = body.radius,
                            .charge = population.charge,
                            .relative_resistivity = population.relative_resistivity,
                            .material = population.material,
                            .permittivity = population.permittivity});
    }
  }
  return conductors;
}

std::vector<Conductor> place_conductors(const Draft& draft, const std::vector<Electrode>& electrodes,
                                        const std::vector<Wall>& walls, const StopRequest& stop) {
  std::vector<Conductor> conductors;
  conductors.reserve(count_of(draft));
  for (const ConductorDraft& given : draft.conductors) conductors.push_back(given.conductor);
  SphereGrid grid = grid_of_given(draft);
  UniformRandom random(static_cast<std::uint64_t>(draft.seed));
  for (const PopulationDraft& population : draft.populations) {
    check_population(draft, population);
    Radii radii(draft, population);
    check_density(draft, population);
    long tries_left = most_tries(population);
    for (int placed = 0; placed < population.count; ++placed) {
      const double radius = radii.next(random);
      const auto conductor = find_free_position(radius, population, {electrodes, walls, draft.scene.domain, grid},
                                                random, tries_left, stop);
      if (!conductor && placed == 0)
        refuse(draft.scene.path, population.line,
               fmt::format("population.count = {0} is impossible: there is no space for even one of radius {1:g} {3} "
                           "with population.min_gap = {2:g} {3}: make them smaller, or the domain or region larger",
                           population.count, radius, population.min_gap, draft.scene.units().length));
      if (!conductor)
        refuse(draft.scene.path, population.line,
               fmt::format("population.count = {} is impossible at this density: random positions were found for {} of "
                           "them, and with this radius and min_gap at most about that number is possible",
                           population.count, placed));
      if (!population.overlapping) grid.insert(sphere_of(*conductor));
      conductors.push_back(*conductor);
    }
  }
  return conductors;
}

}  // namespace lichtenberg
