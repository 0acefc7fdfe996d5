#include "src/effects/contact_potential.hpp"

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

/// The same for particles and walls.
template <int dimension, class Visit>
bool visit_walls(const State& state, const std::vector<Wall>& walls, Visit visit) {
  const double* p = state.bodies.position.data();
  const int n = state.bodies.size();
  Overlap o;
  for (int i = 0; i < n; ++i)
    for (std::size_t w = 0; w < walls.size(); ++w) {
      o.distance = 0;
      for (int k = 0; k < dimension; ++k) o.distance += (p[i * dimension + k] - walls[w].point[k]) * walls[w].normal[k];
      o.reach = state.bodies.radius[i];
      if (!(o.distance < o.reach)) continue;
      if (o.distance <= 0) return false;
      o.particle = i, o.partner = n + static_cast<int>(w);
      o.q = o.distance / o.reach;
      o.normal = walls[w].normal;
      if (o.q < 1) visit(o);
    }
  return true;
}

template <class Visit>
bool visit_pairs(const State& state, Visit visit) {
  return state.bodies.dimension == 3 ? visit_pairs<3>(state, visit) : visit_pairs<2>(state, visit);
}
template <class Visit>
bool visit_walls(const State& state, const std::vector<Wall>& walls, Visit visit) {
  return state.bodies.dimension == 3 ? visit_walls<3>(state, walls, visit) : visit_walls<2>(state, walls, visit);
}
template <class Visit>
bool visit_overlaps(const State& state, const std::vector<Wall>& walls, Visit visit) {
  return visit_pairs(state, visit) && visit_walls(state, walls, visit);
}

}  // namespace

double ContactPotential::energy(const State& state) const {
  double sum = 0;
  const bool finite = visit_overlaps(state, walls_, [&](const Overlap& o) { sum += contact_law(o.q).energy; });
  return finite ? stiffness_ * sum : INFINITY;
}

double ContactPotential::pair_pushes(const State& state, std::vector<Push>& pushes) const {
  double sum = 0;
  const bool finite = visit_pairs(state, [&](const Overlap& o) {
    const ContactLaw w = contact_law(o.q);
    const double push = -stiffness_ * w.slope / o.reach;
    sum += w.energy;
    pushes.push_back({o.particle, o.partner, {push * o.normal[0], push * o.normal[1], push * o.normal[2]}});
  });
  return finite ? stiffness_ * sum : INFINITY;
}

double ContactPotential::wall_energy_and_forces(const State& state, std::span<double> force) const {
  const int d = state.bodies.dimension;
  double sum = 0;
  const bool finite = visit_walls(state, walls_, [&](const Overlap& o) {
    const ContactLaw w = contact_law(o.q);
    sum += w.energy;
    for (int k = 0; k < d; ++k) force[o.particle * d + k] -= stiffness_ * w.slope / o.reach * o.normal[k];
  });
  return finite ? stiffness_ * sum : INFINITY;
}

double ContactPotential::energy_and_forces(const State& state, std::span<double> force) const {
  const int d = state.bodies.dimension;
  std::vector<Push> pushes;
  const double energy = pair_pushes(state, pushes);
  for (const Push& push : pushes)
    for (int k = 0; k < d; ++k) {
      force[push.particle * d + k] += push.force[k];
      force[push.partner * d + k] -= push.force[k];
    }
  return energy + wall_energy_and_forces(state, force);
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
  std::vector<Overlap> all;
  if (!visit_overlaps(state, walls_, [&](const Overlap& o) { all.push_back(o); })) all.clear();
  return all;
}

}  // namespace lichtenberg::effects
