#include "src/granular/restitution_check.hpp"

#include <algorithm>
#include <cmath>

#include "src/granular/pair_state.hpp"
#include "src/theory/restitution.hpp"

namespace lichtenberg::granular {
namespace {

HeadOnCollision viscoelastic(double elastic, double dissipative, double effective_mass, double speed) {
  const theory::ViscoelasticPair pair{elastic, dissipative, effective_mass};
  if (theory::dissipation_number(pair, speed) > theory::RestitutionCurve::largest) return {};
  const theory::PairCollision found = theory::collision(pair, speed);
  return {found.restitution, found.duration};
}

}  // namespace

HeadOnCollision expected_collision(const GrainContactLaw& law, double effective_mass, double scale, double speed) {
  return std::visit([&](const auto& one) { return one.collision(effective_mass, scale, speed, viscoelastic); }, law);
}

void RestitutionCheck::count(std::span<const Collision> ended, const Bodies& bodies, const GrainContactLaw& law,
                             double since) {
  for (const Collision& collision : ended) {
    const GrainContact& contact = collision.contact;
    const IsolatedCollision isolated{contact.since, collision.end - contact.since, contact.impact_speed,
                                     collision.release_speed, collision.tangential_speed};
    if (!contact.alone || !counts(isolated, since, reach(bodies, contact.pair))) continue;
    const auto [i, j] = contact.pair;
    const double scale =
        std::visit([&](const auto& one) { return one.scale(bodies.radius[i], bodies.radius[j]); }, law);
    const double error = isolated.error(
        expected_collision(law, reduced_mass(bodies, contact.pair), scale, isolated.impact_speed).restitution);
    Decade& decade = decade_[decade_of(isolated.impact_speed)];
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
