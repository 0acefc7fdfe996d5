#pragma once

#include <array>

#include "solvers/laplace/measure.hpp"
#include "solvers/laplace/problem.hpp"
#include "validation/contract.hpp"

/// Random conductors for contract_plane.cpp and contract_space.cpp.
namespace lichtenberg::validation {

constexpr double permittivity_of_oil = 4.16e-11;  ///< F/m

/// Groups of a scene: all neutral, all charged, or some of them at fixed potentials.
enum class GroupKind { neutral, charged, mixed };

/// Returns a random group. `unit`: scale of the charges.
inline laplace::Group random_group(CaseRandom& random, GroupKind kind, double unit) {
  if (kind == GroupKind::neutral) return {.charge = 0};
  const double charge = unit * random.uniform(-1, 1);
  if (kind == GroupKind::charged) return {.charge = charge};
  if (random.chance(0.3)) return {.floating = false, .potential = random.pick({0, 0, 50, -400})};
  return {.charge = random.chance(0.5) ? charge : 0};
}

/// Box of `dimension` axes. Its bodies of radii `radius` are at least `gap` apart from each other and from the sides.
struct Packing {
  int dimension;
  std::array<double, 3> size{};
  double gap = 0;
  std::vector<std::array<double, 3>> centres{};
  std::vector<double> radii{};

  double distance(const std::array<double, 3>& a, const std::array<double, 3>& b) const {
    return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
  }

  bool is_free(const std::array<double, 3>& p, double radius) const {
    for (int k = 0; k < dimension; ++k)
      if (std::min(p[k], size[k] - p[k]) < radius + gap) return false;
    for (std::size_t i = 0; i < radii.size(); ++i)
      if (distance(p, centres[i]) < radius + radii[i] + gap) return false;
    return true;
  }

  /// Adds a body at a random position, or at the gap from another one.
  void add(CaseRandom& random, double radius) {
    for (int attempt = 0; attempt < 10000; ++attempt) {
      std::array<double, 3> p{};
      for (int k = 0; k < dimension; ++k) p[k] = random.uniform(0, size[k]);
      if (!radii.empty() && random.chance(0.3)) {
        const int other = random.whole(0, static_cast<int>(radii.size()) - 1);
        const double away = distance(p, centres[other]), wanted = radius + radii[other] + 1.001 * gap;
        for (int k = 0; k < dimension; ++k) p[k] = centres[other][k] + (p[k] - centres[other][k]) * (wanted / away);
      }
      if (!is_free(p, radius)) continue;
      centres.push_back(p);
      radii.push_back(radius);
      return;
    }
  }
};

/// Returns a box with `count` bodies. `gap`: smallest gap in units of the smallest radius.
inline Packing random_packing(CaseRandom& random, int dimension, int count, double gap) {
  const double radius = random.logarithmic(3e-4, 1e-3), ratio = random.pick({1, 1, 1.4, 3});
  // In space, `count` spheres fill at most about a tenth of the box.
  const double least = dimension == 2 ? 10 + 1.5 * count : 5 + 4 * std::cbrt(count);
  Packing packing{.dimension = dimension};
  const double side = radius * random.logarithmic(least, 5 * least);
  for (int k = 0; k < dimension; ++k) packing.size[k] = side;
  if (random.chance(0.3)) packing.size[dimension - 1] = side / 2;
  packing.gap = gap * radius / ratio;
  for (int n = 0; n < count; ++n) packing.add(random, radius / random.uniform(1, ratio));
  return packing;
}

/// Adds bodies to a problem without ground and with charges that sum to zero, or with ground. About every tenth body
/// joins the group before it. `add(i, group)` adds body i.
template <class Problem, class Add>
void add_bodies(Problem& problem, const Packing& packing, CaseRandom& random, GroupKind kind, double unit,
                const Add& add) {
  for (std::size_t i = 0; i < packing.radii.size(); ++i) {
    if (i == 0 || random.chance(0.9)) problem.groups.push_back(random_group(random, kind, unit));
    add(i, static_cast<int>(problem.groups.size()) - 1);
  }
  if (problem.has_ground()) return;
  double total = 0;
  for (const laplace::Group& group : problem.groups) total += group.charge;
  for (laplace::Group& group : problem.groups) group.charge -= total / static_cast<double>(problem.groups.size());
}

/// Puts bodies of fixed groups last, as electrodes are. Returns the number of the other bodies.
template <class Body>
int free_first(std::vector<Body>& bodies, const std::vector<laplace::Group>& groups) {
  const auto held =
      std::ranges::stable_partition(bodies, [&](const Body& body) { return groups[body.group].floating; });
  return static_cast<int>(bodies.size() - held.size());
}

/// Relative errors of a field, each over the largest value of its kind (solvers/laplace/measure.hpp); energies over the
/// energy.
struct FieldErrors {
  double potential = 0, charge = 0, force = 0, energy = 0;
};

/// Guarantees of a method about the field.
struct FieldGuarantees {
  Guarantee potential, charge, force, energy, capacitance;

  FieldGuarantees(const std::string& request, const std::string& reference)
      : potential{request + ": potentials", reference},
        charge{request + ": charges", reference},
        force{request + ": forces", reference},
        energy{request + ": energies", reference},
        capacitance{request + ": capacitances", reference} {}
  void add(Contract& contract, double requested, const FieldErrors& errors) const {
    contract.add(potential, requested, errors.potential);
    contract.add(charge, requested, errors.charge);
    contract.add(force, requested, errors.force);
    if (std::isfinite(errors.energy)) contract.add(energy, requested, errors.energy);
  }
  void add_capacitances(Contract& contract, double requested, const std::vector<double>& found,
                        const std::vector<double>& exact) const {
    double error = 0, most = 0;
    for (std::size_t k = 0; k < exact.size(); ++k) {
      error = larger(error, std::abs(found[k] - exact[k]));
      most = std::max(most, std::abs(exact[k]));
    }
    contract.add(capacitance, requested, error / most);
  }
};

}  // namespace lichtenberg::validation
