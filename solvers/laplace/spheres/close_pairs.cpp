#include "solvers/laplace/spheres/close_pairs.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "solvers/error.hpp"
#include "solvers/laplace/spheres/harmonics.hpp"
#include "solvers/laplace/spheres/images.hpp"
#include "solvers/laplace/spheres/results.hpp"
#include "solvers/parallel/team.hpp"

namespace lichtenberg::laplace::spheres {

double cosh_less_one(double radius, double other, double gap) {
  return gap * (gap + 2 * other) / (2 * (gap + radius + other) * radius);
}

double bispherical_coordinate(double radius, double other, double gap) {
  const double cosh_minus_one = cosh_less_one(radius, other, gap);
  return std::log1p(cosh_minus_one + std::sqrt(cosh_minus_one * (2 + cosh_minus_one)));
}

double narrowness(double radius, double other, double gap) {
  return std::min(1.0, std::sqrt(30 * gap / std::min(radius, other)));
}

namespace {

/// Adds image charges for one sphere at potential 1 and the other at 0, as multipoles of both spheres.
void add_images(double first, double second, double distance, double accuracy, std::vector<double>& of_first,
                std::vector<double>& of_second) {
  double charge = first, place = 0, own = first, other = second;
  std::vector<double>*here = &of_first, *there = &of_second;
  const auto add = [&] {
    double term = charge / own;
    const double ratio = place / own;
    for (double& value : *here) value += term, term *= ratio;
  };
  for (add(); std::abs(charge) > accuracy * first; add()) {
    const double away = distance - place;
    charge *= -other / away;
    place = other * other / away;
    std::swap(here, there);
    std::swap(own, other);
  }
}

/// Largest degree of a correction. The degree and the number of images grow like sqrt(R / gap), so the work grows with
/// their product.
constexpr double largest_tail = 30000;

/// Returns the degree of a pair's correction. Throws Failure for a gap that takes too long.
int tail_degree(const NearPair& gap, double width, double degree) {
  if (degree <= largest_tail) return static_cast<int>(degree);
  const std::string who = gap.source == gap.target ? fmt::format("sphere {} and its image in a side are", gap.target)
                                                   : fmt::format("spheres {} and {} are", gap.target, gap.source);
  throw Failure(fmt::format(
      "{} {:.2g} m apart at different potentials, and their field needs harmonics up to degree {:.2g}, where at most "
      "{:g} is possible: connect them at a larger gap, keep them apart or reduce the accuracy",
      who, width, degree, largest_tail));
}

/// Returns the harmonic t of the field of a source's multipoles on a target, both axial about the line between them,
/// where all signs are plus. The factor C(l+t, l) (R_s/d)^(l+1) (R_t/d)^t is updated from one l to the next.
double axial_field(const std::vector<double>& source, int source_degree, double source_ratio, double target_ratio,
                   int t) {
  double sum = 0, factor = source_ratio;
  for (int k = 0; k < t; ++k) factor *= target_ratio;
  for (int l = 0; l <= source_degree; ++l) {
    sum += factor * source[l];
    factor *= source_ratio * (l + 1 + t) / (l + 1);
  }
  return sum;
}

/// Truncation of the exact pair's multipoles and image charges.
struct Followed {
  int degree = 0;
  double left_out = 0;
};

/// Chooses the truncation. Throws the exceptions of tail_degree.
Followed followed(const std::vector<Site>& sites, const NearPair& gap, double asked) {
  const Site &a = sites[gap.target], &b = sites[gap.source];
  const double width = norm(gap.way) - a.radius - b.radius;
  const double accuracy = asked * narrowness(a.radius, b.radius, width);
  const double slowest =
      std::min(bispherical_coordinate(a.radius, b.radius, width), bispherical_coordinate(b.radius, a.radius, width));
  const int degree =
      tail_degree(gap, width, std::max(a.degree, b.degree) + 2 + std::floor(-std::log(0.01 * accuracy) / slowest));
  // The charges decrease like exp(-2 alpha n), so those neglected add up to the last one over alpha. A correction
  // begins where multipoles have decreased to the accuracy. Its energy, a divisor in the matrix, is of the order of the
  // accuracy squared.
  return {degree, std::max(0.01 * accuracy * accuracy, 1e-16) * slowest};
}

/// Sets the potential on a correction's sphere, up to the sphere's degree. It is the difference between `potential`,
/// that of the exact pair, and the potential due to the multipoles of both sides. Adds the share in the pair's energy.
void add_own(ClosePair& pair, Tail& tail, const Site& site, double potential) {
  std::vector<double> harmonic(harmonics(site.degree));
  regular_harmonics(tail.axis, site.degree, harmonic.data());
  tail.potential.resize(harmonic.size());
  for (int l = 0; l <= site.degree; ++l) {
    const double made =
        tail.multipoles[l] + axial_field(tail.facing, tail.facing_degree, tail.facing_radius / tail.distance,
                                         site.radius / tail.distance, l);
    const double left = (l == 0 ? potential : 0) - made;
    pair.energy -= site.radius * tail.multipoles[l] * left;
    for (int m = -l; m <= l; ++m) tail.potential[at(l, m)] = tail.sign * left * harmonic[at(l, m)];
  }
}

ClosePair close_pair(const std::vector<Site>& sites, const NearPair& gap, const Followed& how) {
  const Site &a = sites[gap.target], &b = sites[gap.source];
  const double distance = norm(gap.way), width = distance - a.radius - b.radius;
  const auto solution = pair_solution(a.radius, b.radius, width, how.degree, how.left_out);
  const bool image = gap.mask != 0 || norm2(a.centre - b.centre - gap.way) > 1e-20 * norm2(gap.way);
  const auto tail = [&](int sphere, double sign, Vec3 axis, int own, const Site& facing) {
    return Tail{.sphere = sphere,
                .sign = sign,
                .axis = axis,
                .multipoles = solution[own].multipoles,
                .potential = {},
                .faces_image = image,
                .facing = solution[1 - own].multipoles,
                .facing_radius = facing.radius,
                .distance = distance,
                .facing_degree = facing.degree};
  };
  const Vec3 to_source = gap.way * (-1 / distance);
  ClosePair pair;
  pair.tails.push_back(tail(gap.target, 1, to_source, 0, b));
  // The image's harmonics are those of the sphere itself, mirrored and with the sign of the image.
  const bool alone = gap.target == gap.source && gap.mask != 0;
  if (!alone) pair.tails.push_back(tail(gap.source, gap.sign, mirrored(to_source * -1.0, gap.mask), 1, a));
  for (std::size_t k = 0; k < pair.tails.size(); ++k)
    add_own(pair, pair.tails[k], sites[pair.tails[k].sphere], solution[k].potential);
  return pair;
}

/// Legendre polynomials of increasing degree at u, and their slopes.
struct Legendre {
  explicit Legendre(double cosine) : u(cosine) {}
  double u, value = 1, slope = 0;

  void step() {
    const double above = ((2 * degree + 1) * u * value - degree * below) / (degree + 1);
    slope = (degree + 1) * value + u * slope;
    below = value, value = above, ++degree;
  }

 private:
  int degree = 0;
  double below = 0;
};

/// Returns the potential of the corrections at a gap on a sphere, in harmonics beyond the sphere's degree, up to `size`
/// of them. Together with the harmonics up to the degrees these vanish, so they are the negative of those due to the
/// other side's multipoles.
std::vector<double> potential_beyond(const Tail& tail, const Site& site, std::size_t size) {
  std::vector<double> potential(size);
  double largest = 0;
  for (std::size_t l = site.degree + 1; l < size; ++l) {
    potential[l] = -axial_field(tail.facing, tail.facing_degree, tail.facing_radius / tail.distance,
                                site.radius / tail.distance, static_cast<int>(l));
    largest = std::max(largest, std::abs(potential[l]));
    if (std::abs(potential[l]) < 1e-17 * largest) break;  // Beyond its largest value it decreases
  }
  return potential;
}

/// Returns the energy of two corrections of one sphere, including those on the facing sides: p (q + T q') + q T p'. The
/// sums q + T q' and p + T p' follow from potential_beyond.
double meeting(const Tail& p, const Tail& q, const Site& site, const std::vector<double>& on_p,
               const std::vector<double>& on_q) {
  const std::size_t size = std::min(p.multipoles.size(), q.multipoles.size());
  Legendre legendre(std::clamp(dot(p.axis, q.axis), -1.0, 1.0));
  double sum = 0;
  for (std::size_t l = 0; l < size; ++l, legendre.step())
    if (static_cast<int>(l) > site.degree)
      sum +=
          legendre.value * (p.multipoles[l] * on_q[l] + on_p[l] * q.multipoles[l] - p.multipoles[l] * q.multipoles[l]);
  return site.radius * p.sign * q.sign * sum;
}

/// Returns the displacement from the source to the target, in the source's own frame.
Vec3 way_of_source(const NearPair& pair) { return mirrored(pair.way, pair.mask); }

bool leads_across(const Tail& tail, Vec3 way) {
  return norm2(tail.axis * tail.distance - way) < 1e-20 * tail.distance * tail.distance;
}

/// Returns true if harmonics beyond either sphere's degree affect the other: interactions of corrections are mutual.
bool reaches(const NearPair& pair, const std::vector<Site>& sites, double accuracy) {
  const auto reach = [&](const Site& source, const Site& target) {
    const double closest = norm(pair.way) - target.radius;
    return closest < source.radius || std::pow(source.radius / closest, source.degree + 1) > accuracy;
  };
  const Site &source = sites[pair.source], &target = sites[pair.target];
  return reach(source, target) || reach(target, source);
}

/// Returns the degree l up to which a correction affects harmonics up to t of a nearby sphere. The factor C(l+t, l)
/// (R_s/d)^l (R_t/d)^t rises up to (l+t)/l = d/R_s, and is followed until it is below the accuracy.
int degree_felt(const NearPair& pair, const std::vector<Site>& sites, double accuracy) {
  const Site &source = sites[pair.source], &target = sites[pair.target];
  const double distance = norm(pair.way), ratio = source.radius / distance;
  double log_term = target.degree * std::log(target.radius / distance);
  int l = 0;
  do {
    ++l;
    const double step = ratio * (l + target.degree) / l;
    log_term += std::log(step);
    if (step < 1 && log_term < std::log(accuracy)) break;
  } while (l < largest_degree);
  return std::max(l, source.degree + 1);
}

struct TailOfPair {
  int pair = 0;
  const Tail* tail = nullptr;
};

/// Returns the ratio of successive harmonics of the most slowly decreasing of these corrections, without those across
/// this gap; 0 if there is none.
double slowest_ratio(const std::vector<TailOfPair>& tails, Vec3 way, const std::vector<Site>& sites) {
  double ratio = 0;
  for (const auto& [pair, tail] : tails) {
    if (leads_across(*tail, way)) continue;
    const double radius = sites[tail->sphere].radius, other = tail->facing_radius;
    ratio = std::max(ratio, std::exp(-bispherical_coordinate(radius, other, tail->distance - radius - other)));
  }
  return ratio;
}

/// Returns the degree up to which the corrections of two nearby spheres interact. Terms C(l+t, l) x^l y^t of l + t = n
/// add up to (x + y)^n, mostly near l / t = x / y; x and y are radii over the distance times the ratios of the
/// corrections.
int degree_of_tails(const NearPair& pair, const std::vector<std::vector<TailOfPair>>& tails,
                    const std::vector<Site>& sites, double accuracy) {
  const double distance = norm(pair.way);
  const double x = slowest_ratio(tails[pair.source], way_of_source(pair), sites) * sites[pair.source].radius / distance;
  const double y = slowest_ratio(tails[pair.target], pair.way * -1.0, sites) * sites[pair.target].radius / distance;
  if (x == 0 || y == 0) return 0;
  const double share = std::max(x, y) / (x + y);
  return x + y < 1 ? static_cast<int>(std::min<double>(largest_degree, share * std::log(accuracy) / std::log(x + y)))
                   : largest_degree;
}

/// Effects of a correction beyond its gap: on spheres, and on the corrections of other pairs.
struct Beyond {
  std::vector<ClosePair::Elsewhere> elsewhere;
  struct Met {
    int pair = 0;
    double energy = 0;
  };
  std::vector<Met> met;
};

/// Returns the correction's multipoles beyond its sphere's degree, up to `degree`.
std::vector<double> tail_alone(const Tail& tail, int own_degree, int degree) {
  std::vector<double> multipoles(harmonics(degree));
  regular_harmonics(tail.axis, degree, multipoles.data());
  for (int l = 0; l <= degree; ++l)
    for (int m = -l; m <= l; ++m)
      multipoles[at(l, m)] *=
          l > own_degree && l < static_cast<int>(tail.multipoles.size()) ? tail.sign * tail.multipoles[l] : 0;
  return multipoles;
}

/// Returns the energy of a correction in a potential `made` on its sphere, in harmonics up to `degree`.
double energy_in(const Tail& tail, const Site& site, const double* made, int degree) {
  std::vector<double> harmonic(harmonics(degree));
  regular_harmonics(tail.axis, degree, harmonic.data());
  double energy = 0;
  for (int l = site.degree + 1; l <= std::min<int>(degree, tail.multipoles.size() - 1); ++l)
    for (int m = -l; m <= l; ++m) energy += tail.multipoles[l] * harmonic[at(l, m)] * made[at(l, m)];
  return site.radius * tail.sign * energy;
}

/// Computes the effects of a correction on the spheres near its own, without the one across its gap, as harmonics up to
/// `degree`.
Beyond beyond(const Tail& tail, const std::vector<std::vector<TailOfPair>>& tails, const std::vector<Site>& sites,
              const std::vector<NearPair>& beside, int degree) {
  std::vector<NearPair> pairs, ways;
  std::vector<Site> targets;
  for (const NearPair& pair : beside) {
    if (leads_across(tail, way_of_source(pair))) continue;
    ways.push_back(pair);
    pairs.push_back(pair);
    pairs.back().target = static_cast<int>(targets.size()), pairs.back().source = 0;
    targets.push_back({sites[pair.target].centre, sites[pair.target].radius, degree});
  }
  Beyond result;
  if (pairs.empty()) return result;
  Site source = sites[tail.sphere];
  const std::vector<double> multipoles = tail_alone(tail, source.degree, degree);
  std::vector<double> local(targets.size() * multipoles.size());
  source.degree = degree;
  // No distant terms are neglected: that would differ between the two directions of an interaction.
  NearField(targets, {source}, pairs, 1e-300, parallel::Team::single())
      .add(multipoles.data(), local.data(), parallel::Team::single());
  for (std::size_t k = 0; k < ways.size(); ++k) {
    const double* made = local.data() + k * multipoles.size();
    const int sphere = ways[k].target;
    result.elsewhere.push_back({sphere, {made, made + harmonics(sites[sphere].degree)}});
    for (const TailOfPair& other : tails[sphere])
      if (!leads_across(*other.tail, ways[k].way * -1.0))  // Otherwise included where both have a correction
        result.met.push_back({other.pair, energy_in(*other.tail, sites[sphere], made, degree)});
  }
  return result;
}

/// Adds the interactions between the corrections of one sphere.
void add_meetings(std::vector<ClosePair>& close, const std::vector<TailOfPair>& tails, const Site& site) {
  std::vector<std::vector<double>> potential;
  if (tails.size() < 2) return;
  for (const TailOfPair& of : tails) potential.push_back(potential_beyond(*of.tail, site, of.tail->multipoles.size()));
  for (std::size_t p = 0; p < tails.size(); ++p)
    for (std::size_t q = 0; q < p; ++q) {
      const double energy = meeting(*tails[p].tail, *tails[q].tail, site, potential[p], potential[q]);
      close[tails[p].pair].meetings.push_back({tails[q].pair, energy});
      close[tails[q].pair].meetings.push_back({tails[p].pair, energy});
    }
}

/// Multipoles about an axis; only those above the degree count.
struct AxialTail {
  const std::vector<double>& multipoles;
  int degree;
  double radius;
  Vec3 axis;
};

/// Adds `scale` times the potential sum over l > degree of a_l (R/r)^(l+1) P_l, and subtracts its gradient from the
/// field.
void add_axial(const AxialTail& tail, double scale, Vec3 r, double& potential, Vec3& field) {
  const auto [multipoles, degree, radius, axis] = tail;
  const double distance = norm(r), ratio = radius / distance, u = std::clamp(dot(r, axis) / distance, -1.0, 1.0);
  double power = ratio, below = 0, legendre = 1, slope = 0, value = 0, radial = 0, polar = 0;
  for (std::size_t l = 0; l < multipoles.size(); ++l, power *= ratio) {
    if (static_cast<int>(l) > degree) {
      const double term = scale * multipoles[l] * power;
      value += term * legendre;
      radial -= (l + 1) * term * legendre / distance;
      polar += term * slope / distance;
    }
    const double above = ((2 * l + 1) * u * legendre - l * below) / (l + 1);
    const double above_slope = (l + 1) * legendre + u * slope;
    below = legendre, legendre = above;
    slope = above_slope;
    if (static_cast<int>(l) > degree && power < 1e-18) break;
  }
  const Vec3 outward = r * (1 / distance);
  potential += value;
  field -= outward * radial + (axis - outward * u) * polar;
}

}  // namespace

std::array<PairSolution, 2> pair_solution(double radius, double other, double gap, int degree, double accuracy) {
  const double distance = gap + radius + other;
  const std::vector<double> none(degree + 1);
  std::array<std::vector<double>, 2> first{none, none}, second{none, none};  // Either sphere at potential 1
  add_images(radius, other, distance, accuracy, first[0], first[1]);
  add_images(other, radius, distance, accuracy, second[1], second[0]);
  const auto charge = [&](const std::array<std::vector<double>, 2>& of) {
    return radius * of[0][0] + other * of[1][0];
  };
  const double a = charge(first), b = charge(second);
  const double potential = b / (a + b);  // Potential of the first sphere; that of the second is lower by 1
  std::array<PairSolution, 2> result;
  for (int k = 0; k < 2; ++k) {
    result[k].multipoles.resize(degree + 1);
    result[k].potential = potential - k;
    for (int l = 0; l <= degree; ++l)
      result[k].multipoles[l] = potential * first[k][l] + (potential - 1) * second[k][l];
  }
  return result;
}

std::vector<ClosePair> close_pairs(const std::vector<Site>& sites, const std::vector<NearPair>& gaps, double accuracy,
                                   parallel::Team& team) {
  std::vector<Followed> how;
  for (const NearPair& gap : gaps) how.push_back(followed(sites, gap, accuracy));
  std::vector<ClosePair> pairs(gaps.size());
  team.for_each(static_cast<int>(gaps.size()), [&](int k) { pairs[k] = close_pair(sites, gaps[k], how[k]); });
  std::erase_if(pairs, [&](const ClosePair& pair) {  // Energies at the level of rounding: the harmonics suffice
    const Tail& tail = pair.tails[0];
    return !(pair.energy > 1e-13 * sites[tail.sphere].radius * tail.multipoles[0] * tail.multipoles[0]);
  });
  return pairs;
}

void let_tails_meet(std::vector<ClosePair>& close, const std::vector<Site>& sites, const std::vector<NearPair>& pairs,
                    double accuracy, parallel::Team& team) {
  if (close.empty()) return;
  std::vector<std::vector<TailOfPair>> tails(sites.size());
  for (std::size_t p = 0; p < close.size(); ++p)
    for (const Tail& tail : close[p].tails) tails[tail.sphere].push_back({static_cast<int>(p), &tail});
  std::vector<std::vector<NearPair>> beside(sites.size());
  int degree = 0;
  for (const NearPair& pair : pairs) {
    if (tails[pair.source].empty() || !reaches(pair, sites, accuracy)) continue;
    beside[pair.source].push_back(pair);
    degree = std::max({degree, degree_felt(pair, sites, accuracy), degree_of_tails(pair, tails, sites, accuracy)});
  }
  std::vector<TailOfPair> all;
  for (const auto& of_sphere : tails) all.insert(all.end(), of_sphere.begin(), of_sphere.end());
  std::vector<Beyond> found(all.size());
  team.for_each(static_cast<int>(all.size()), [&](int k) {
    const Tail& tail = *all[k].tail;
    found[k] = beyond(tail, tails, sites, beside[tail.sphere], degree);
  });
  const Beyond* next = found.data();
  for (std::size_t i = 0; i < sites.size(); ++i) {
    add_meetings(close, tails[i], sites[i]);
    for (const TailOfPair& of : tails[i]) {
      auto& elsewhere = close[of.pair].elsewhere;
      elsewhere.insert(elsewhere.end(), next->elsewhere.begin(), next->elsewhere.end());
      for (const Beyond::Met& met : next->met) close[met.pair].meetings.push_back({of.pair, met.energy});
      ++next;
    }
  }
}

Vec3 tail_force(const Tail& tail, double amplitude, int degree, const double* multipoles) {
  const double scale = tail.sign * amplitude;
  const int next = degree + 1;
  if (next >= static_cast<int>(tail.multipoles.size())) return {};
  std::vector<double> last(harmonics(next)), first(harmonics(next)), harmonic(harmonics(next));
  std::copy(multipoles + harmonics(degree - 1), multipoles + harmonics(degree), last.begin() + harmonics(degree - 1));
  regular_harmonics(tail.axis, next, harmonic.data());
  for (int m = -next; m <= next; ++m) first[at(next, m)] = scale * tail.multipoles[next] * harmonic[at(next, m)];
  double sum = 0;
  for (std::size_t l = next + 1; l < tail.multipoles.size(); ++l)
    sum += l * tail.multipoles[l - 1] * tail.multipoles[l];
  return force(last.data(), next, first.data(), next) + tail.axis * (scale * scale * sum);
}

Vec3 force_between(const Tail& one, const Tail& other, int degree) {
  Legendre legendre(std::clamp(dot(one.axis, other.axis), -1.0, 1.0));
  const std::size_t size = std::min(one.multipoles.size(), other.multipoles.size());
  Vec3 force;
  // Gradients of r^l P_l about the axis of the higher harmonic, at the axis of the lower one.
  const auto add = [&](double product, std::size_t l, Vec3 lower, Vec3 higher) {
    force += (lower * (l * legendre.value) + (higher - lower * legendre.u) * legendre.slope) * product;
  };
  for (std::size_t l = 0; l < size; ++l, legendre.step()) {
    if (static_cast<int>(l) <= degree + 1) continue;
    add(one.multipoles[l - 1] * other.multipoles[l], l, one.axis, other.axis);
    add(other.multipoles[l - 1] * one.multipoles[l], l, other.axis, one.axis);
  }
  return force * (one.sign * other.sign);
}

void add_tail(const Tail& tail, const Site& site, double amplitude, Vec3 point, double& potential, Vec3& field) {
  const double scale = tail.sign * amplitude;
  add_axial({tail.multipoles, site.degree, site.radius, tail.axis}, scale, point - site.centre, potential, field);
  if (tail.faces_image)
    add_axial({tail.facing, tail.facing_degree, tail.facing_radius, tail.axis * -1.0}, scale,
              point - site.centre - tail.axis * tail.distance, potential, field);
}

}  // namespace lichtenberg::laplace::spheres
