#include "src/effects/contact_potential.hpp"

#include <algorithm>
#include <cmath>

#include "solvers/error.hpp"
#include "src/effects/contact_law.hpp"

namespace lichtenberg::effects {
namespace {

/// Calls visit(overlap) for every pair that overlaps; false, at once, if the energy is infinite.
template <int dimension, class Visit>
bool visit_pairs(const State& state, Visit visit) {
  const double* p = state.bodies.position.data();
  const std::vector<double>& radius = state.bodies.radius;
  Overlap o;
  for (const Pair pair : state.neighbours) {
    double sum = 0;
    for (int k = 0; k < dimension; ++k) {
      o.normal[k] = p[pair.i * dimension + k] - p[pair.j * dimension + k];
      sum += o.normal[k] * o.normal[k];
    }
    o.reach = radius[pair.i] + radius[pair.j];
    if (!(sum < o.reach * o.reach)) continue;
    if (sum == 0) return false;
    o.particle = pair.i, o.partner = pair.j;
    o.distance = std::sqrt(sum);
    o.q = o.distance / o.reach;
    for (int k = 0; k < dimension; ++k) o.normal[k] /= o.distance;
    if (o.q < 1) visit(o);
  }
  return true;
}

template <int dimension>
double distance_from(const Wall& wall, const double* place) {
  double distance = 0;
  for (int k = 0; k < dimension; ++k) distance += (place[k] - wall.point[k]) * wall.normal[k];
  return distance;
}

/// Whether any of the particles from `first` on up to before `end` touches the wall. Few do, and this looks at many at
/// a time.
template <int dimension>
bool any_touches(const Bodies& bodies, const Wall& wall, int first, int end) {
  int any = 0;
  for (int i = first; i < end; ++i)
    any |= distance_from<dimension>(wall, &bodies.position[i * dimension]) < bodies.radius[i];
  return any;
}

/// visit_pairs for these particles and the walls, wall by wall.
template <int dimension, class Visit>
bool visit_walls(const State& state, const std::vector<Wall>& walls, int first, int end, Visit visit) {
  Overlap o;
  for (std::size_t w = 0; w < walls.size(); ++w) {
    if (!any_touches<dimension>(state.bodies, walls[w], first, end)) continue;
    for (int i = first; i < end; ++i) {
      o.distance = distance_from<dimension>(walls[w], &state.bodies.position[i * dimension]);
      o.reach = state.bodies.radius[i];
      if (!(o.distance < o.reach)) continue;
      if (o.distance <= 0) return false;
      o.particle = i, o.partner = state.bodies.size() + static_cast<int>(w);
      o.q = o.distance / o.reach;
      o.normal = walls[w].normal;
      if (o.q < 1) visit(o);
    }
  }
  return true;
}

template <class Visit>
bool visit_pairs(const State& state, Visit visit) {
  return state.bodies.dimension == 3 ? visit_pairs<3>(state, visit) : visit_pairs<2>(state, visit);
}
template <class Visit>
bool visit_walls(const State& state, const std::vector<Wall>& walls, int first, int end, Visit visit) {
  return state.bodies.dimension == 3 ? visit_walls<3>(state, walls, first, end, visit)
                                     : visit_walls<2>(state, walls, first, end, visit);
}
template <class Visit>
bool visit_overlaps(const State& state, const std::vector<Wall>& walls, Visit visit) {
  return visit_pairs(state, visit) && visit_walls(state, walls, 0, state.bodies.size(), visit);
}

/// The pairs whose first particle is one from `first` on up to before `end`.
std::span<const Pair> pairs_of(const State& state, int first, int end) {
  const auto from = std::ranges::lower_bound(state.neighbours, first, {}, &Pair::i);
  return {from, std::ranges::lower_bound(from, state.neighbours.end(), end, {}, &Pair::i)};
}

/// Pairs that overlap, a few hundred: their laws are computed many at a time.
template <int dimension>
class Batch {
 public:
  static constexpr std::size_t most = 256;

  /// Takes those of `pairs`, `most` of them at most, that overlap.
  void gather(const Bodies& bodies, std::span<const Pair> pairs) {
    const double *p = bodies.position.data(), *radius = bodies.radius.data();
    count_ = 0;
    for (const Pair pair : pairs) {  // no branch: which pairs overlap is hard to guess
      double sum = 0;
      for (int k = 0; k < dimension; ++k) {
        const double apart = p[pair.i * dimension + k] - p[pair.j * dimension + k];
        push_[k][count_] = apart;
        sum += apart * apart;
      }
      const double reach = radius[pair.i] + radius[pair.j];
      pair_[count_] = pair;
      squared_[count_] = sum;
      reach_[count_] = reach;
      count_ += sum < reach * reach;
    }
  }

  /// Adds their energies, in units of the stiffness, one by one: where a batch ends must not show in the sum. Infinite
  /// if two centres coincide.
  void apply_law(double stiffness, double& sum) {
    int deep = 0;
    for (int c = 0; c < count_; ++c) {
      const double distance = std::sqrt(squared_[c]), q = distance / reach_[c];
      const ContactLaw w = contact_law(q, logarithm_near_one(q));
      energy_[c] = w.energy;
      share_[c] = -stiffness * w.slope / (reach_[c] * distance);
      deep |= q < near_one;
    }
    if (deep) apply_law_to_deep(stiffness);
    for (int c = 0; c < count_; ++c) {
      sum += energy_[c];
      for (int k = 0; k < dimension; ++k) push_[k][c] *= share_[c];
    }
  }

  /// Forces on particles from `end` on are appended to `beyond`.
  void add_forces(int end, std::span<double> force, std::vector<Push>& beyond) const {
    for (int c = 0; c < count_; ++c) {
      const auto [i, j] = pair_[c];
      for (int k = 0; k < dimension; ++k) force[i * dimension + k] += push_[k][c];
      if (j < end) {
        for (int k = 0; k < dimension; ++k) force[j * dimension + k] -= push_[k][c];
      } else {
        beyond.push_back({j});
        for (int k = 0; k < dimension; ++k) beyond.back().force[k] = -push_[k][c];
      }
    }
  }

 private:
  void apply_law_to_deep(double stiffness) {
    for (int c = 0; c < count_; ++c) {
      const double distance = std::sqrt(squared_[c]), q = distance / reach_[c];
      if (q >= near_one) continue;
      const ContactLaw w = contact_law(q);
      energy_[c] = w.energy;
      share_[c] = -stiffness * w.slope / (reach_[c] * distance);
    }
  }

  int count_ = 0;
  std::array<Pair, most> pair_;
  std::array<double, most> squared_, reach_;              ///< m^2: distance of the centres; m: sum of radii
  std::array<double, most> energy_;                       ///< in units of the stiffness
  std::array<double, most> share_;                        ///< N/m: force over distance
  std::array<std::array<double, most>, dimension> push_;  ///< m, distance; then N, force on the first
};

}  // namespace

const EffectKind& ContactPotentialOptions::kind() {
  static const EffectKind kind = {
      .name = "contact_potential",
      .description = "particles and walls that overlap push each other apart until all is at rest",
      .help =
          "Particles rest where stiffness * sum of (q - 1) ln q over all pairs and walls that overlap is least; q is "
          "the distance of the centres over the sum of the radii, or of a centre from a wall over its radius. A run "
          "looks for that in place of a motion in time, so no other effect is allowed.",
      .options = ContactPotentialOptions{},
      .keys = {{.name = "stiffness",
                .place = place<&ContactPotentialOptions::stiffness>,
                .unit = "J",
                .range = ranges::positive,
                .help = "k: changes energies and forces, not where particles rest"},
               {.name = "box",
                .place = [](Draft& draft) { return &draft.scene.domain.walled; },
                .help = "the sides of the domain are walls; without them every [[wall]] must be given"}},
      .alone = "under which nothing else acts",
      .dimensions = {2, 3},
      .make = [](const Scene& scene) -> std::unique_ptr<Effect> { return std::make_unique<ContactPotential>(scene); }};
  return kind;
}

double ContactPotential::energy(const State& state) const {
  double sum = 0;
  const bool finite = visit_overlaps(state, walls_, [&](const Overlap& o) { sum += contact_law(o.q).energy; });
  return finite ? stiffness_ * sum : INFINITY;
}

double ContactPotential::energy_and_forces(const State& state, std::span<double> force) const {
  std::vector<Push> none;
  return energy_and_forces(state, 0, state.bodies.size(), force, none);
}

double ContactPotential::energy_and_forces(const State& state, int first, int end, std::span<double> force,
                                           std::vector<Push>& beyond) const {
  return state.bodies.dimension == 3 ? range_energy_and_forces<3>(state, first, end, force, beyond)
                                     : range_energy_and_forces<2>(state, first, end, force, beyond);
}

template <int dimension>
double ContactPotential::range_energy_and_forces(const State& state, int first, int end, std::span<double> force,
                                                 std::vector<Push>& beyond) const {
  double sum = 0;
  if (!add_walls<dimension>(state, first, end, force, sum)) return INFINITY;
  Batch<dimension> batch;
  for (std::span<const Pair> left = pairs_of(state, first, end); !left.empty();) {
    const std::span now = left.first(std::min(left.size(), Batch<dimension>::most));
    left = left.subspan(now.size());
    batch.gather(state.bodies, now);
    batch.apply_law(stiffness_, sum);
    batch.add_forces(end, force, beyond);
  }
  return stiffness_ * sum;
}

template <int dimension>
bool ContactPotential::add_walls(const State& state, int first, int end, std::span<double> force, double& sum) const {
  return visit_walls<dimension>(state, walls_, first, end, [&](const Overlap& o) {
    const ContactLaw w = contact_law(o.q);
    sum += w.energy;
    for (int k = 0; k < dimension; ++k)
      force[o.particle * dimension + k] -= stiffness_ * w.slope / o.reach * o.normal[k];
  });
}

void ContactPotential::add_forces(const State& state, std::span<double> force) const {
  if (std::isinf(energy_and_forces(state, force)))
    throw Failure("a particle's centre lies on another or beyond a wall: there effects.contact_potential is infinite");
}

void ContactPotential::add_jacobian(const State& state, ForceJacobian& jacobian) const {
  const int n = state.bodies.size();
  visit_overlaps(state, walls_, [&](const Overlap& o) {
    const ContactLaw w = contact_law(o.q);
    const double along = -stiffness_ * w.curvature / (o.reach * o.reach);
    // A wall's normal does not turn with the particle.
    const double across = o.partner < n ? -stiffness_ * w.slope / (o.reach * o.distance) : 0;
    jacobian.add_central(o.particle, o.particle, o.normal, along, across);
    if (o.partner >= n) return;
    jacobian.add_central(o.partner, o.partner, o.normal, along, across);
    jacobian.add_central(o.particle, o.partner, o.normal, -along, -across);
    jacobian.add_central(o.partner, o.particle, o.normal, -along, -across);
  });
}

std::vector<Overlap> ContactPotential::overlaps(const State& state) const {
  return overlaps(state, 0, state.bodies.size());
}

std::vector<Overlap> ContactPotential::overlaps(const State& state, int first, int end) const {
  std::vector<Overlap> all;
  const auto take = [&](const Overlap& o) { all.push_back(o); };
  if (!visit_pairs({state.time, state.bodies, pairs_of(state, first, end)}, take) ||
      !visit_walls(state, walls_, first, end, take))
    all.clear();
  return all;
}

}  // namespace lichtenberg::effects
