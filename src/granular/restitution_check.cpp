#include "src/granular/restitution_check.hpp"

#include <algorithm>
#include <cmath>

#include "src/theory/restitution.hpp"

namespace lichtenberg::granular {
namespace {

ExpectedCollision collision_by(const ViscoelasticLaw& law, double effective_mass, double scale, double speed) {
  const theory::ViscoelasticPair pair{scale * law.elastic, scale * law.dissipative, effective_mass};
  if (theory::dissipation_number(pair, speed) > theory::RestitutionCurve::largest) return {};
  const theory::PairCollision found = theory::collision(pair, speed);
  return {found.restitution, found.duration};
}

ExpectedCollision collision_by(const LinearSpringLaw& law, double effective_mass, double, double) {
  const LinearCollision found = linear_collision(law, effective_mass);
  return {found.restitution, found.duration};
}

}  // namespace

ExpectedCollision expected_collision(const GrainContactLaw& law, double effective_mass, double scale, double speed) {
  return std::visit([&](const auto& one) { return collision_by(one, effective_mass, scale, speed); }, law);
}

void RestitutionCheck::count(std::span<const Collision> ended, const Bodies& bodies, const GrainContactLaw& law,
                             double since) {
  for (const Collision& collision : ended) {
    const auto [i, j] = collision.contact.pair;
    const double speed = collision.contact.impact_speed;
    if (!collision.contact.alone || !(speed > 0) || collision.contact.since < since ||
        !is_central(collision.tangential_speed, collision.end - collision.contact.since, speed,
                    bodies.radius[i] + bodies.radius[j]))
      continue;
    const double mass = bodies.mass[i] * bodies.mass[j] / (bodies.mass[i] + bodies.mass[j]);
    const double scale =
        std::visit([&](const auto& one) { return one.scale(bodies.radius[i], bodies.radius[j]); }, law);
    const double error =
        std::abs(collision.release_speed / speed - expected_collision(law, mass, scale, speed).restitution);
    Decade& decade = decade_[decade_of(speed)];
    ++decade.collisions;
    decade.sum += error;
    decade.worst = std::max(decade.worst, error);
  }
}

RestitutionCheck::Decade RestitutionCheck::all() const {
  Decade all;
  for (const Decade& decade : decade_) {
    all.collisions += decade.collisions;
    all.sum += decade.sum;
    all.worst = std::max(all.worst, decade.worst);
  }
  return all;
}

void RestitutionCheck::save(Checkpoint& checkpoint) const {
  std::vector<double>& saved = checkpoint.reals["restitution_check"];
  for (const Decade& decade : decade_)
    saved.insert(saved.end(), {static_cast<double>(decade.collisions), decade.sum, decade.worst});
}

void RestitutionCheck::restore(const Checkpoint& checkpoint) {
  const std::vector<double>& saved = reals(checkpoint, "restitution_check", 3 * decades);
  for (int k = 0; k < decades; ++k)
    decade_[k] = {static_cast<std::int64_t>(saved[3 * k]), saved[3 * k + 1], saved[3 * k + 2]};
}

}  // namespace lichtenberg::granular
