#include "solvers/laplace/spheres/close_pairs.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

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

/// Largest degree of a correction. The degree and the number of images grow like sqrt(R / gap), so the work grows with
/// their product.
constexpr double largest_correction_degree = 30000;

/// Returns the degree of a pair's correction. Throws Failure for a gap that takes too long.
int correction_degree(const NearPair& gap, double width, double degree) {
  if (degree <= largest_correction_degree) return static_cast<int>(degree);
  const std::string subject = gap.source == gap.target
                                  ? fmt::format("sphere {} and its image in a side are", gap.target)
                                  : fmt::format("spheres {} and {} are", gap.target, gap.source);
  throw Failure(fmt::format(
      "{} {:.2g} m apart at different potentials, and their field needs harmonics up to degree {:.2g}, where at most "
      "{:g} is possible: connect them at a larger gap, keep them apart or reduce the accuracy",
      subject, width, degree, largest_correction_degree));
}

/// Computes the harmonic t of the field of a source's multipoles on a target, both axial about the line between them,
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
struct Truncation {
  int degree = 0;
  double left_out = 0;
};

/// Chooses the truncation. Throws the exceptions of correction_degree.
Truncation truncation_of(const std::vector<Site>& sites, const NearPair& gap, double requested_accuracy) {
  const Site &a = sites[gap.target], &b = sites[gap.source];
  const double width = norm(gap.displacement) - a.radius - b.radius;
  const double accuracy = requested_accuracy * narrowness(a.radius, b.radius, width);
  const double at_a = bispherical_coordinate(a.radius, b.radius, width),
               at_b = bispherical_coordinate(b.radius, a.radius, width), slowest = std::min(at_a, at_b);
  const int degree = correction_degree(
      gap, width, std::max(a.degree, b.degree) + 2 + std::floor(-std::log(0.01 * accuracy) / slowest));
  // A correction's energy, a divisor in the matrix, is of the order of the product of the first multipoles beyond the
  // degrees p of both spheres, exp(-alpha (p + 1)). At wide gaps and small degrees it is below the accuracy squared.
  const double energy = std::exp(-at_a * (a.degree + 1) - at_b * (b.degree + 1));
  // The charges decrease like exp(-2 alpha n), so those neglected add up to the last one over alpha.
  return {degree, std::max(0.01 * std::min(energy, accuracy * accuracy), 1e-16) * slowest};
}

/// Sets the potential on a correction's sphere, up to the sphere's degree. It is the difference between `potential`,
/// that of the exact pair, and the potential due to the multipoles of both sides. Adds the share in the pair's energy.
void set_own_potential(ClosePair& pair, PairCorrection& correction, const Site& site, double potential) {
  std::vector<double> harmonic(harmonics(site.degree));
  regular_harmonics(correction.axis, site.degree, harmonic.data());
  correction.potential.resize(harmonic.size());
  for (int l = 0; l <= site.degree; ++l) {
    const double made = correction.multipoles[l] + axial_field(correction.facing, correction.facing_degree,
                                                               correction.facing_radius / correction.distance,
                                                               site.radius / correction.distance, l);
    const double left = (l == 0 ? potential : 0) - made;
    pair.energy -= site.radius * correction.multipoles[l] * left;
    for (int m = -l; m <= l; ++m) correction.potential[at(l, m)] = correction.sign * left * harmonic[at(l, m)];
  }
}

ClosePair close_pair(const std::vector<Site>& sites, const NearPair& gap, const Truncation& truncation) {
  const Site &a = sites[gap.target], &b = sites[gap.source];
  const double distance = norm(gap.displacement), width = distance - a.radius - b.radius;
  const auto solution = pair_solution(a.radius, b.radius, width, truncation.degree, truncation.left_out);
  const bool image = gap.mask != 0 || norm2(a.centre - b.centre - gap.displacement) > 1e-20 * norm2(gap.displacement);
  const auto make_correction = [&](int sphere, double sign, Vec3 axis, int own, const Site& facing) {
    return PairCorrection{.sphere = sphere,
                          .sign = sign,
                          .axis = axis,
                          .multipoles = solution[own].multipoles,
                          .charges = condensed(solution[own].charges, sites[sphere].radius),
                          .potential = {},
                          .faces_image = image,
                          .facing = solution[1 - own].multipoles,
                          .facing_radius = facing.radius,
                          .distance = distance,
                          .facing_degree = facing.degree};
  };
  const Vec3 to_source = gap.displacement * (-1 / distance);
  ClosePair pair;
  pair.corrections.push_back(make_correction(gap.target, 1, to_source, 0, b));
  // The image's harmonics are those of the sphere itself, mirrored and with the sign of the image.
  const bool alone = gap.target == gap.source && gap.mask != 0;
  if (!alone)
    pair.corrections.push_back(make_correction(gap.source, gap.sign, mirrored(to_source * -1.0, gap.mask), 1, a));
  for (std::size_t k = 0; k < pair.corrections.size(); ++k)
    set_own_potential(pair, pair.corrections[k], sites[pair.corrections[k].sphere], solution[k].potential);
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
std::vector<double> potential_above_degree(const PairCorrection& correction, const Site& site, std::size_t size) {
  std::vector<double> potential(size);
  double largest = 0;
  for (std::size_t l = site.degree + 1; l < size; ++l) {
    potential[l] =
        -axial_field(correction.facing, correction.facing_degree, correction.facing_radius / correction.distance,
                     site.radius / correction.distance, static_cast<int>(l));
    largest = std::max(largest, std::abs(potential[l]));
    if (std::abs(potential[l]) < 1e-17 * largest) break;  // Beyond its largest value it decreases
  }
  return potential;
}

/// Returns the energy of two corrections of one sphere, including those on the facing sides: p (q + T q') + q T p'. The
/// sums q + T q' and p + T p' follow from potential_above_degree.
double interaction_energy(const PairCorrection& p, const PairCorrection& q, const Site& site,
                          const std::vector<double>& on_p, const std::vector<double>& on_q) {
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
Vec3 displacement_at_source(const NearPair& pair) { return mirrored(pair.displacement, pair.mask); }

bool is_across_gap(const PairCorrection& correction, Vec3 displacement) {
  return norm2(correction.axis * correction.distance - displacement) <
         1e-20 * correction.distance * correction.distance;
}

/// Returns true if harmonics beyond either sphere's degree affect the other: interactions of corrections are mutual.
bool interacts(const NearPair& pair, const std::vector<Site>& sites, double accuracy) {
  const auto reach = [&](const Site& source, const Site& target) {
    const double closest = norm(pair.displacement) - target.radius;
    return closest < source.radius || std::pow(source.radius / closest, source.degree + 1) > accuracy;
  };
  const Site &source = sites[pair.source], &target = sites[pair.target];
  return reach(source, target) || reach(target, source);
}

struct CorrectionOfPair {
  int pair = 0;
  const PairCorrection* correction = nullptr;
};

/// Effects of a correction beyond its gap: on spheres, and on the corrections of other pairs.
struct OuterEffects {
  std::vector<ClosePair::OtherSphere> other_spheres;
  struct Interaction {
    int pair = 0;
    double energy = 0;
  };
  std::vector<Interaction> interactions;
};

/// A correction at a near sphere: its charges, or those of its mirror image, in coordinates about that sphere's centre.
struct NearCorrection {
  NearCorrection(const PairCorrection& correction, const Site& site, const NearPair& pair)
      : correction(correction),
        site(site),
        sign(correction.sign * pair.sign),
        centre(pair.displacement * -1.0),
        axis(mirrored(correction.axis, pair.mask)) {}

  /// Returns the potential at r, without the harmonics up to the correction's sphere's degree.
  double potential(Vec3 r) const {
    double sum = 0;
    for (const AxialCharge& one : correction.charges) sum += one.charge / norm(r - centre - axis * one.position);
    const Vec3 from_centre = r - centre;
    const double distance = norm(from_centre);
    Legendre legendre(dot(from_centre, axis) / distance);
    double power = site.radius / distance;
    for (int l = 0; l <= site.degree; ++l, power *= site.radius / distance, legendre.step())
      sum -= correction.multipoles[l] * power * legendre.value;
    return sign * sum;
  }
  /// Adds the potential of the charges to local coefficients on the near sphere.
  void add_charges(const Site& target, std::vector<double>& local) const {
    std::vector<double> harmonic(local.size());
    for (const AxialCharge& one : correction.charges) {
      const Vec3 r = centre + axis * one.position;
      const double distance = norm(r);
      regular_harmonics(r * (target.radius / (distance * distance)), target.degree, harmonic.data());
      for (std::size_t k = 0; k < local.size(); ++k) local[k] += sign * one.charge / distance * harmonic[k];
    }
  }

  const PairCorrection& correction;
  const Site& site;
  double sign;
  Vec3 centre, axis;
};

/// Returns the correction's multipoles up to its sphere's degree.
std::vector<double> low_multipoles(const PairCorrection& correction, int degree) {
  std::vector<double> multipoles(harmonics(degree));
  regular_harmonics(correction.axis, degree, multipoles.data());
  for (int l = 0; l <= degree; ++l)
    for (int m = -l; m <= l; ++m) multipoles[at(l, m)] *= correction.sign * correction.multipoles[l];
  return multipoles;
}

/// Returns the energy of a correction in the potential of another one: that of its charges, without that of its
/// multipoles up to its sphere's degree. `made`: harmonics of the potential on its sphere.
double energy_in(const PairCorrection& correction, const Site& site, const NearCorrection& other,
                 const std::vector<double>& made) {
  double energy = 0;
  for (const AxialCharge& one : correction.charges)
    energy += one.charge * other.potential(correction.axis * one.position);
  std::vector<double> harmonic(made.size());
  regular_harmonics(correction.axis, site.degree, harmonic.data());
  for (int l = 0; l <= site.degree; ++l)
    for (int m = -l; m <= l; ++m)
      energy -= site.radius * correction.multipoles[l] * harmonic[at(l, m)] * made[at(l, m)];
  return correction.sign * energy;
}

/// Computes the effects of a correction on the spheres near its own, without the one across its gap. They are those of
/// all its image charges, without those of the harmonics up to its sphere's degree. A sum of harmonics beyond it would
/// need a degree of up to sqrt(R / gap), for corrections on the far sides of two spheres with a gap.
OuterEffects outer_effects(const PairCorrection& correction,
                           const std::vector<std::vector<CorrectionOfPair>>& corrections,
                           const std::vector<Site>& sites, const std::vector<NearPair>& near_pairs) {
  std::vector<NearPair> pairs, original_pairs;
  std::vector<Site> targets;
  for (const NearPair& pair : near_pairs) {
    if (is_across_gap(correction, displacement_at_source(pair))) continue;
    original_pairs.push_back(pair);
    pairs.push_back(pair);
    pairs.back().target = static_cast<int>(targets.size()), pairs.back().source = 0;
    targets.push_back(sites[pair.target]);
  }
  OuterEffects result;
  if (pairs.empty()) return result;
  const Site& source = sites[correction.sphere];
  const std::vector<int> start = starts(targets);
  std::vector<double> low(start.back());
  // No distant terms are neglected: that would differ between the two directions of an interaction.
  NearField(targets, {source}, pairs, 1e-300, parallel::Team::single())
      .add(low_multipoles(correction, source.degree).data(), low.data(), parallel::Team::single());
  for (std::size_t k = 0; k < original_pairs.size(); ++k) {
    const int sphere = original_pairs[k].target;
    const NearCorrection near(correction, source, original_pairs[k]);
    std::vector<double> made(low.begin() + start[k], low.begin() + start[k + 1]);
    for (double& value : made) value = -value;
    near.add_charges(targets[k], made);
    for (const CorrectionOfPair& other : corrections[sphere])
      if (!is_across_gap(*other.correction,
                         original_pairs[k].displacement * -1.0))  // Otherwise included where both have a correction
        result.interactions.push_back({other.pair, energy_in(*other.correction, targets[k], near, made)});
    result.other_spheres.push_back({sphere, std::move(made)});
  }
  return result;
}

/// Adds the interactions between the corrections of one sphere.
void add_interactions_on(std::vector<ClosePair>& close, const std::vector<CorrectionOfPair>& corrections,
                         const Site& site) {
  std::vector<std::vector<double>> potential;
  if (corrections.size() < 2) return;
  for (const CorrectionOfPair& one : corrections)
    potential.push_back(potential_above_degree(*one.correction, site, one.correction->multipoles.size()));
  for (std::size_t p = 0; p < corrections.size(); ++p)
    for (std::size_t q = 0; q < p; ++q) {
      const double energy =
          interaction_energy(*corrections[p].correction, *corrections[q].correction, site, potential[p], potential[q]);
      close[corrections[p].pair].interactions.push_back({corrections[q].pair, energy});
      close[corrections[q].pair].interactions.push_back({corrections[p].pair, energy});
    }
}

/// Multipoles about an axis; only those above the degree count.
struct AxialMultipoles {
  const std::vector<double>& multipoles;
  int degree;
  double radius;
  Vec3 axis;
};

/// Adds `scale` times the potential sum over l > degree of a_l (R/r)^(l+1) P_l, and subtracts its gradient from the
/// field.
void add_axial(const AxialMultipoles& correction, double scale, Vec3 r, double& potential, Vec3& field) {
  const auto [multipoles, degree, radius, axis] = correction;
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

std::vector<ClosePair> close_pairs(const std::vector<Site>& sites, const std::vector<NearPair>& gaps, double accuracy,
                                   parallel::Team& team) {
  std::vector<Truncation> truncations;
  for (const NearPair& gap : gaps) truncations.push_back(truncation_of(sites, gap, accuracy));
  std::vector<ClosePair> pairs(gaps.size());
  team.for_each(static_cast<int>(gaps.size()), [&](int k) { pairs[k] = close_pair(sites, gaps[k], truncations[k]); });
  std::erase_if(pairs, [&](const ClosePair& pair) {  // Energies at the level of rounding: the harmonics suffice
    const PairCorrection& correction = pair.corrections[0];
    return !(pair.energy >
             1e-13 * sites[correction.sphere].radius * correction.multipoles[0] * correction.multipoles[0]);
  });
  return pairs;
}

void add_correction_interactions(std::vector<ClosePair>& close, const std::vector<Site>& sites,
                                 const std::vector<NearPair>& pairs, double accuracy, parallel::Team& team) {
  if (close.empty()) return;
  std::vector<std::vector<CorrectionOfPair>> corrections(sites.size());
  for (std::size_t p = 0; p < close.size(); ++p)
    for (const PairCorrection& correction : close[p].corrections)
      corrections[correction.sphere].push_back({static_cast<int>(p), &correction});
  std::vector<std::vector<NearPair>> near_pairs(sites.size());
  for (const NearPair& pair : pairs)
    if (!corrections[pair.source].empty() && interacts(pair, sites, accuracy)) near_pairs[pair.source].push_back(pair);
  std::vector<CorrectionOfPair> all;
  for (const auto& sphere_corrections : corrections)
    all.insert(all.end(), sphere_corrections.begin(), sphere_corrections.end());
  std::vector<OuterEffects> found(all.size());
  team.for_each(static_cast<int>(all.size()), [&](int k) {
    const PairCorrection& correction = *all[k].correction;
    found[k] = outer_effects(correction, corrections, sites, near_pairs[correction.sphere]);
  });
  const OuterEffects* next = found.data();
  for (std::size_t i = 0; i < sites.size(); ++i) {
    add_interactions_on(close, corrections[i], sites[i]);
    for (const CorrectionOfPair& one : corrections[i]) {
      auto& other_spheres = close[one.pair].other_spheres;
      other_spheres.insert(other_spheres.end(), next->other_spheres.begin(), next->other_spheres.end());
      for (const OuterEffects::Interaction& interaction : next->interactions)
        close[interaction.pair].interactions.push_back({one.pair, interaction.energy});
      ++next;
    }
  }
}

Vec3 correction_force(const PairCorrection& correction, double amplitude, int degree, const double* multipoles) {
  const double scale = correction.sign * amplitude;
  const int next = degree + 1;
  if (next >= static_cast<int>(correction.multipoles.size())) return {};
  std::vector<double> last(harmonics(next)), first(harmonics(next)), harmonic(harmonics(next));
  std::copy(multipoles + harmonics(degree - 1), multipoles + harmonics(degree), last.begin() + harmonics(degree - 1));
  regular_harmonics(correction.axis, next, harmonic.data());
  for (int m = -next; m <= next; ++m) first[at(next, m)] = scale * correction.multipoles[next] * harmonic[at(next, m)];
  double sum = 0;
  for (std::size_t l = next + 1; l < correction.multipoles.size(); ++l)
    sum += l * correction.multipoles[l - 1] * correction.multipoles[l];
  return force(last.data(), next, first.data(), next) + correction.axis * (scale * scale * sum);
}

Vec3 force_between(const PairCorrection& one, const PairCorrection& other, int degree) {
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

void add_correction(const PairCorrection& correction, const Site& site, double amplitude, Vec3 point, double& potential,
                    Vec3& field) {
  const double scale = correction.sign * amplitude;
  add_axial({correction.multipoles, site.degree, site.radius, correction.axis}, scale, point - site.centre, potential,
            field);
  if (correction.faces_image)
    add_axial({correction.facing, correction.facing_degree, correction.facing_radius, correction.axis * -1.0}, scale,
              point - site.centre - correction.axis * correction.distance, potential, field);
}

}  // namespace lichtenberg::laplace::spheres
