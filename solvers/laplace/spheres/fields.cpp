#include "solvers/laplace/spheres/system.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "solvers/error.hpp"
#include "solvers/stop.hpp"

namespace lichtenberg::laplace::spheres {

WallPotential::WallPotential(const SphereProblem& problem) {
  if (problem.free_space) {
    slope = -problem.uniform_field;
    return;
  }
  std::vector<int> electrode_sides;
  for (int side = 0; side < 6; ++side)
    if (problem.box.sides[side] == Boundary::electrode) electrode_sides.push_back(side);
  if (electrode_sides.empty()) return;
  constant = problem.side_potential[electrode_sides[0]];
  const bool equal = std::all_of(electrode_sides.begin(), electrode_sides.end(),
                                 [&](int s) { return problem.side_potential[s] == constant; });
  if (equal) return;
  if (electrode_sides.size() != 2 || electrode_sides[0] / 2 != electrode_sides[1] / 2)
    throw InputError(
        fmt::format("sides {} and {} have different potentials where they meet: the solver of spheres permits "
                    "different potentials only on two opposite sides",
                    side_names[electrode_sides[0]], side_names[electrode_sides[1]]));
  axis = electrode_sides[0] / 2;
  slope[axis] = (problem.side_potential[electrode_sides[1]] - constant) / problem.box.lengths[axis];
}

namespace {

constexpr int least_site_degree = 2;

/// Empirical: with degree 2, errors of forces may exceed a coarser request.
constexpr double coarsest_truncation = 0.05;

/// Returns the size of the last harmonics. Forces omit the product of the last harmonics and those beyond.
double truncation_for(double accuracy) { return truncation_share * std::min(accuracy, coarsest_truncation); }

/// Returns the accuracy for which last harmonics of this size suffice; 1: none.
double accuracy_for(double last) {
  const double accuracy = last / truncation_share;
  return accuracy <= coarsest_truncation ? accuracy : 1;
}

/// Degree that a gap requires, and the accuracy for which the largest degree suffices.
struct DegreeRequirement {
  double degree = 0, possible = 0;
};

/// Returns the requirement of a gap between different potentials: harmonics decrease like exp(-alpha l).
DegreeRequirement at_gap(double radius, double other, double gap, double accuracy) {
  if (gap <= 0) return {INFINITY, 1};
  const double alpha = bispherical_coordinate(radius, other, gap);
  return {-std::log(truncation_for(accuracy)) / alpha, accuracy_for(std::exp(-largest_degree * alpha))};
}

/// Returns the requirement of a gap at equal potential: however small the gap, harmonics decrease like exp(-sqrt(2 beta
/// l)), beta = 2 pi / (1 + R / R') (docs/numerics/multipole-plane.md).
DegreeRequirement at_contact(double radius, double other, double accuracy) {
  const double digits = std::log(truncation_for(accuracy)), share = (1 + radius / other) / (4 * std::numbers::pi);
  return {digits * digits * share, accuracy_for(std::exp(-std::sqrt(largest_degree / share)))};
}

/// Returns a bound of cosh_less_one. A gap beyond it neither needs a degree above `degree` on a sphere of this radius,
/// nor a correction. `largest`: largest radius of another sphere. The bound excludes most pairs without logarithms.
double sufficient_cosh(double degree, double radius, double largest, double accuracy) {
  const double without_correction = at_contact(radius, largest, accuracy).degree;
  return std::cosh(-std::log(truncation_for(accuracy)) /
                   std::max<double>(least_site_degree, std::min(degree, without_correction))) -
         1;
}

/// Returns the requirement next to a dielectric, for any gap. Each reflection multiplies by k = (eps - 1) / (eps + 1),
/// so the n-th image has about k^n (1 - 1/n)^l in harmonic l. The maximum, at n = sqrt(l / -ln k), is exp(-2 sqrt(l
/// (-ln k))). The first image alone, at half of the radius, contributes 2^-l.
DegreeRequirement at_dielectrics(const Sphere& one, const Sphere& other, double accuracy) {
  const auto reflected = [](const Sphere& sphere) {
    return sphere.is_conductor() ? 1 : (sphere.relative_permittivity - 1) / (sphere.relative_permittivity + 1);
  };
  const double k = std::sqrt(reflected(one) * reflected(other)), digits = -std::log(accuracy);
  return {std::max(digits / std::numbers::ln2, digits * digits / (-4 * std::log(k))),
          std::exp(-std::sqrt(-4 * std::log(k) * largest_degree))};
}

DegreeRequirement smaller_of(DegreeRequirement a, DegreeRequirement b) {
  return {std::min(a.degree, b.degree), std::min(a.possible, b.possible)};
}

DegreeRequirement requirement_of(const SphereProblem& problem, const NearPair& pair, double gap, double accuracy) {
  const Sphere &target = problem.spheres[pair.target], &source = problem.spheres[pair.source];
  const DegreeRequirement contact = target.is_conductor() && source.is_conductor()
                                        ? at_contact(target.radius, source.radius, accuracy)
                                        : at_dielectrics(target, source, accuracy);
  return smaller_of(at_gap(target.radius, source.radius, gap, accuracy), contact);
}

bool have_one_potential(const SphereProblem& problem, const NearPair& pair) {
  return problem.spheres[pair.target].group == problem.spheres[pair.source].group && pair.sign > 0;
}

double gap_of(const SphereProblem& problem, const NearPair& pair) {
  return norm(pair.displacement) - problem.spheres[pair.target].radius - problem.spheres[pair.source].radius;
}

NearPair reversed(NearPair pair) {
  std::swap(pair.target, pair.source);
  pair.displacement = pair.displacement * -1.0;
  return pair;
}

/// Returns the degree of the small sphere of a pair of very different radii; it has no correction for a potential
/// difference.
double degree_of_small(const SphereProblem& problem, const NearPair& to_small, double accuracy) {
  const double gap = gap_of(problem, to_small), r = problem.spheres[to_small.target].radius;
  if (have_one_potential(problem, to_small)) return requirement_of(problem, to_small, gap, accuracy).degree;
  return at_gap(r, problem.spheres[to_small.source].radius, gap, accuracy).degree;
}

/// Returns true if the large sphere, the source, would need too many harmonics and can reflect the small one instead.
bool is_lopsided(const SphereProblem& problem, const NearPair& pair, double accuracy) {
  constexpr double largest_of_small = 100;
  const Sphere &small = problem.spheres[pair.target], &large = problem.spheres[pair.source];
  if (small.radius >= large.radius || pair.mask != 0 || pair.sign < 0 || !small.is_conductor() ||
      !large.is_conductor() || large.radius > largest_ratio * small.radius)
    return false;
  const double gap = gap_of(problem, pair);
  return requirement_of(problem, reversed(pair), gap, accuracy).degree > largest_degree &&
         degree_of_small(problem, pair, accuracy) <= largest_of_small;
}

/// Returns the pairs for reflection, each with its small sphere as the target. A large sphere with several small
/// neighbours is excluded if harmonics beyond the largest degree matter between them.
std::vector<NearPair> lopsided_pairs(const SphereProblem& problem, const std::vector<Site>& sites,
                                     const std::vector<NearPair>& pairs, double accuracy) {
  std::vector<NearPair> found;
  for (const NearPair& pair : pairs)
    if (is_lopsided(problem, pair, accuracy)) found.push_back(pair);
  std::vector<char> too_many(sites.size());
  for (std::size_t p = 0; p < found.size(); ++p)
    for (std::size_t q = 0; q < p; ++q)
      if (found[p].source == found[q].source &&
          omitted_interaction(found[p], found[q], sites, largest_degree) > accuracy)
        too_many[found[p].source] = 1;
  std::erase_if(found, [&](const NearPair& pair) { return too_many[pair.source]; });
  return found;
}

bool contains(const std::vector<NearPair>& pairs, const NearPair& pair) {
  return std::ranges::any_of(pairs, [&](const NearPair& one) {
    return one.target == pair.target && one.source == pair.source && one.mask == pair.mask &&
           norm2(one.displacement - pair.displacement) < 1e-20 * norm2(pair.displacement);
  });
}

/// Returns the distance beyond which images of a charge are summed together, for few pairs.
double choose_range(const Mirrors& mirrors, const std::vector<Site>& sites) {
  double largest = 0;
  for (const Site& site : sites) largest = std::max(largest, site.radius);
  // Several hundred near images per sphere cost little, and reduce the number of waves.
  const double most = 400 / std::max(1.0, sites.size() / 4.0);
  const double range = std::cbrt(std::max(60.0, most) * 3 / (4 * std::numbers::pi * mirrors.density()));
  return std::max(range, 7 * largest);
}

/// Number of spheres up to which direct interactions of all pairs cost less than cells.
constexpr std::size_t direct_limit = 48;

/// Fixed degree up to which one sum over all images of a pair costs less than direct near images.
constexpr int low_degree = 8;

double largest_radius(const std::vector<Site>& sites) {
  return sites.empty() ? 0 : std::ranges::max(sites, {}, &Site::radius).radius;
}

/// Returns true for two images of one sphere in opposite directions: one of them represents both.
bool are_twins(const NearPair& a, const NearPair& b) {
  return a.target == a.source && b.target == a.target && b.source == a.source && b.mask == a.mask && a.mask == 0 &&
         norm2(a.displacement + b.displacement) < 1e-20 * norm2(a.displacement);
}

/// Returns the possible accuracy for an error message, with the keys of the scene file that set it.
std::string in_words(double possible) {
  constexpr double coarsest = 0.1, rounded_up = 1.06;  // Rounds up to two digits
  if (rounded_up * possible > coarsest) return "no field.accuracy";
  return fmt::format("field.accuracy = {:.1e}, or so large a field.tolerance and field.moving_tolerance",
                     rounded_up * possible);
}

}  // namespace

double Fields::last_harmonics() const { return truncation_for(accuracy_); }

void Fields::RequiredDegree::raise(double to, double possible_then) {
  degree = std::max(degree, to);
  possible = std::max(possible, possible_then);
}

/// Chooses the degrees for the accuracy, from the neighbours of each sphere, and the gaps that need corrections.
void Fields::choose_degrees(const SphereProblem& problem, const std::vector<NearPair>& pairs, parallel::Team& team) {
  if (fixed_degree_ > 0) {
    for (Site& site : sites_) site.degree = fixed_degree_;
    return;
  }
  std::vector<RequiredDegree> required(sites_.size(), {least_site_degree, 0});
  const std::vector<NearPair> lopsided = lopsided_pairs(problem, sites_, pairs, accuracy_);
  choose_reflecting(problem, lopsided, required);
  std::vector<NearPair> gaps = narrow_gaps(problem, pairs, lopsided, required);
  set_degrees(required);
  for (const NearPair& pair : lopsided)
    reflections_.push_back(reflection_of(pair, sites_[pair.target], sites_[pair.source]));
  std::erase_if(gaps, [&](const NearPair& pair) { return suffices_for(pair); });
  close_pairs_ = spheres::close_pairs(sites_, gaps, accuracy_, team);
  add_correction_interactions(close_pairs_, sites_, pairs, accuracy_, team);
}

/// Raises degrees for reflections. A large sphere needs the harmonics that affect other spheres, or transmit between
/// small ones.
void Fields::choose_reflecting(const SphereProblem& problem, const std::vector<NearPair>& lopsided,
                               std::vector<RequiredDegree>& required) {
  std::vector<int> small_neighbours(sites_.size());
  for (const NearPair& pair : lopsided) {
    const double small = sites_[pair.target].radius, large = sites_[pair.source].radius;
    required[pair.target].raise(degree_of_small(problem, pair, accuracy_), 0);
    const double alone = at_contact(large, large, accuracy_).degree;
    required[pair.source].raise(++small_neighbours[pair.source] > 1 ? largest_degree : alone, 0);
    if (!have_one_potential(problem, pair))
      narrowness_ = std::min(narrowness_, spheres::narrowness(small, large, gap_of(problem, pair)));
  }
}

/// Returns the gaps between different potentials for which the degrees of gaps at equal potential do not suffice, each
/// in one direction. Raises the degrees to the requirements of each pair.
std::vector<NearPair> Fields::narrow_gaps(const SphereProblem& problem, const std::vector<NearPair>& pairs,
                                          const std::vector<NearPair>& lopsided,
                                          std::vector<RequiredDegree>& required) {
  const double largest = largest_radius(sites_);
  std::vector<NearPair> gaps;
  int current = -1;
  double known = 0, sufficient = 0;  // Degree of the current target, and the bound on its gaps for that degree
  for (const NearPair& pair : pairs) {
    const Site &site = sites_[pair.target], &other = sites_[pair.source];
    if (pair.target != current || required[current].degree > known) {
      current = pair.target, known = required[current].degree;
      sufficient = sufficient_cosh(known, site.radius, largest, accuracy_);
    }
    const double gap = norm(pair.displacement) - site.radius - other.radius;
    if (gap > 0 && cosh_less_one(site.radius, other.radius, gap) > sufficient) continue;
    if (!lopsided.empty() && (contains(lopsided, pair) || contains(lopsided, reversed(pair)))) continue;
    const Sphere &target = problem.spheres[pair.target], &source = problem.spheres[pair.source];
    const bool dielectric = !target.is_conductor() || !source.is_conductor();
    const DegreeRequirement contact =
        dielectric ? at_dielectrics(target, source, accuracy_) : at_contact(site.radius, other.radius, accuracy_);
    DegreeRequirement separated = at_gap(site.radius, other.radius, gap, accuracy_);
    if (gap <= 0) separated.degree = 2 * contact.degree;
    RequiredDegree& here = required[pair.target];
    here.raise(std::min(separated.degree, contact.degree), std::min(separated.possible, contact.possible));
    if (dielectric || have_one_potential(problem, pair) || separated.degree <= contact.degree) continue;
    const double share = spheres::narrowness(site.radius, other.radius, gap);
    narrowness_ = std::min(narrowness_, share);
    const double closer = at_contact(site.radius, other.radius, share * accuracy_).degree;
    if (here.degree < largest_degree) here.degree = std::clamp<double>(closer, here.degree, largest_degree);
    const auto twin = [&](const NearPair& one) { return are_twins(pair, one); };
    if (pair.target <= pair.source && std::ranges::none_of(gaps, twin)) gaps.push_back(pair);
  }
  return gaps;
}

/// Sets the degrees. Throws InputError for a degree above the largest.
void Fields::set_degrees(const std::vector<RequiredDegree>& required) {
  for (std::size_t i = 0; i < sites_.size(); ++i) {
    const auto [degree, possible] = required[i];
    if (degree > largest_degree)
      throw InputError(
          fmt::format("the gap at sphere {} would need harmonics of degree {:.0f} for an accuracy of {:.3g}: {} is the "
                      "largest, which suffices for {}",
                      i, std::ceil(degree), accuracy_, largest_degree, in_words(possible)));
    sites_[i].degree = static_cast<int>(std::ceil(degree));
  }
}

/// Returns true if both spheres have the degrees that this gap requires, possibly because of a narrower one.
bool Fields::suffices_for(const NearPair& pair) const {
  const Site &target = sites_[pair.target], &source = sites_[pair.source];
  const double gap = norm(pair.displacement) - target.radius - source.radius;
  return at_gap(target.radius, source.radius, gap, accuracy_).degree <= target.degree &&
         at_gap(source.radius, target.radius, gap, accuracy_).degree <= source.degree;
}

Fields::Fields(const SphereProblem& problem, const Mirrors& mirrors, const SphereOptions& options, double share,
               const Fields* past, parallel::Team& team)
    : mirrors_(mirrors), accuracy_(share * options.accuracy), fixed_degree_(options.degree) {
  const double accuracy = options.accuracy;
  for (const Sphere& sphere : problem.spheres) sites_.push_back({sphere.centre, sphere.radius, 0});
  if (sites_.size() > direct_limit)
    cells_ = std::make_unique<Cells>(problem, sites_);
  else if (mirrors.bounded && !(has_fixed_degree() && fixed_degree_ <= low_degree))
    range_ = choose_range(mirrors, sites_);
  const std::vector<NearPair> pairs = near_pairs(sites_, team);
  choose_degrees(problem, pairs, team);
  stop_if_requested();
  near_ = std::make_unique<NearField>(sites_, sites_, pairs, narrowness_ * accuracy, team);
  stop_if_requested();
  if (cells_) {
    convolution_ = past && past->convolution_ && past->convolution_->fits(mirrors, *cells_, accuracy)
                       ? past->convolution_
                       : std::make_shared<const CellConvolution>(mirrors, *cells_, accuracy);
    cell_field_ = std::make_unique<CellField>(convolution_, *cells_, sites_, sites_);
  } else if (mirrors.bounded) {
    far_ =
        std::make_unique<FarField>(mirrors, sites_, sites_, far_images(largest_radius(sites_), narrowness_ * accuracy),
                                   past ? past->far_.get() : nullptr);
  }
}

FarImages Fields::far_images(double target_radius, double accuracy) const {
  const double radius = largest_radius(sites_);
  if (range_ == 0) return all_images(mirrors_, radius, fixed_degree_, accuracy);
  FarImages images = images_beyond(range_, target_radius, radius, accuracy);
  if (has_fixed_degree()) images.degree = std::min(images.degree, 2 * fixed_degree_ + 1);
  return images;
}

std::vector<NearPair> Fields::near_pairs(const std::vector<Site>& targets, parallel::Team& team) const {
  if (cells_ && mirrors_.bounded) return cells_->near_pairs(targets, sites_, team);
  if (mirrors_.bounded && range_ == 0) return {};
  if (cells_ && &targets == &sites_) return cells_->near_pairs(targets, sites_, team);
  std::vector<NearPair> pairs;
  for (std::size_t t = 0; t < targets.size(); ++t)
    for (std::size_t s = 0; s < sites_.size(); ++s)
      mirrors_.for_each_near(
          targets[t].centre, sites_[s].centre, range_, [&](const MirrorImage& image, Vec3 displacement) {
            if (norm2(displacement) > 0)
              pairs.push_back({static_cast<int>(t), static_cast<int>(s), image.mask, image.sign, displacement});
          });
  return pairs;
}

template <class T>
void Fields::add_reflections(const T* multipoles, T* local) const {
  if (reflections_.empty()) return;
  const std::vector<int> start = starts(sites_);
  for (const Reflection& reflection : reflections_)
    add_reflection(reflection, multipoles + start[reflection.small], local + start[reflection.small]);
}

void Fields::add(const double* multipoles, double* local, parallel::Team& team) const {
  near_->add(multipoles, local, team);
  if (far_) far_->add(multipoles, local, team);
  if (cell_field_) cell_field_->add(multipoles, local, team);
  add_reflections(multipoles, local);
}

void Fields::add(const Lanes* multipoles, Lanes* local, parallel::Team& team) const {
  near_->add(multipoles, local, team);
  if (far_) far_->add(multipoles, local, team);
  add_reflections(multipoles, local);
  if (!cell_field_) return;
  const std::size_t size = starts(sites_).back();
  std::vector<double> from(size), to(size);
  for (int lane = 0; lane < lanes; ++lane) {
    for (std::size_t k = 0; k < size; ++k) from[k] = multipoles[k][lane];
    std::ranges::fill(to, 0.0);
    cell_field_->add(from.data(), to.data(), team);
    for (std::size_t k = 0; k < size; ++k) local[k][lane] += to[k];
  }
}

std::vector<double> Fields::one_degree_beyond(const double* multipoles, parallel::Team& team) const {
  std::vector<Site> targets = sites_;
  for (Site& target : targets) ++target.degree;
  std::vector<double> local(starts(targets).back());
  NearField(targets, sites_, near_pairs(sites_, team), narrowness_ * accuracy_, team)
      .add(multipoles, local.data(), team);
  if (far_) far_->add(multipoles, local.data(), team, 1);
  if (cell_field_) CellField(convolution_, *cells_, targets, sites_).add(multipoles, local.data(), team);
  return local;
}

void Fields::add_at(std::span<const Vec3> points, double unit, const double* multipoles, double* local,
                    parallel::Team& team) const {
  std::vector<Site> targets;
  for (const Vec3 point : points) targets.push_back({point, unit, 1});
  NearField(targets, sites_, near_pairs(targets, team), 0.01 * accuracy_, team).add(multipoles, local, team);
  if (!mirrors_.bounded) return;
  if (cells_)
    CellField(convolution_, *cells_, targets, sites_).add(multipoles, local, team);
  else
    FarField(mirrors_, targets, sites_, far_images(unit, 0.1 * accuracy_)).add(multipoles, local, team);
}

std::shared_ptr<const ChargesAndDipoles> Fields::charges_and_dipoles(std::shared_ptr<const ChargesAndDipoles> past,
                                                                     parallel::Team& team) const {
  if (past && past->is_usable_for(sites_)) return past;
  if (!cells_ || !ChargesAndDipoles::saves_time(sites_.size())) return nullptr;
  auto made = std::make_shared<const ChargesAndDipoles>(mirrors_, *cells_, sites_, near_pairs(sites_, team), team);
  return made->is_positive() ? made : nullptr;
}

}  // namespace lichtenberg::laplace::spheres
