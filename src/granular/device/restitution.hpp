#pragma once

// RestitutionCheck on an executor: compares ended collisions with the restitution of their law. Errors are integer
// sums, so that results do not depend on the order of collisions.

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "solvers/parallel/array.hpp"
#include "solvers/parallel/host_executor.hpp"
#include "src/granular/pair_state.hpp"
#include "src/granular/restitution_check.hpp"
#include "src/theory/chebyshev.hpp"
#include "src/theory/restitution.hpp"

namespace lichtenberg::granular::device {

/// Function that returns the restitution coefficient of a head-on collision of viscoelastic grains, interpolated in the
/// table of theory::RestitutionCurve; 0 beyond the table. The duration is not computed (0). Arguments are the elastic
/// and the dissipative constant E and D, effective mass and impact speed, in reduced units.
struct TabulatedCollision {
  const double *node = nullptr, *loss = nullptr;
  int nodes = 0;

  LICHTENBERG_HOST_DEVICE HeadOnCollision operator()(double elastic, double dissipative, double effective_mass,
                                                     double speed) const {
    const double k = theory::dissipation_number({elastic, dissipative, effective_mass}, speed);
    const double root = std::sqrt(k), u = root / (1 + root);
    return {k > theory::RestitutionCurve::largest ? 0 : 1 - k * theory::between_nodes(node, loss, nodes, u), 0};
  }
};

/// Errors of the restitution coefficient of collisions in one decade of the impact speed, with a fixed-point sum.
struct RestitutionDecade {
  std::int64_t collisions = 0, errors = 0;  ///< number of collisions, and sum of errors in quanta
  double worst = 0;                         ///< largest error
};

/// An ended contact of two grains that no third grain touched in the meantime. `lower` and `higher` are the sorted
/// indices of the two grains.
struct EndedContact : RestitutionCheck::IsolatedCollision {
  int lower = 0, higher = 0;
};

/// Statistics of the errors of the restitution coefficient (RestitutionCheck) in device memory, for kernels.
struct RestitutionCount {
  static constexpr double quantum = 1.0 / (1 << 30);  // 2^33 collisions with errors of 1 do not overflow the sum

  TabulatedCollision viscoelastic;
  RestitutionDecade* decade = nullptr;  ///< [RestitutionCheck::decades]
  double since = 0;                     ///< time since which the contact law applies (t0)
  EndedContact* ended = nullptr;        ///< [capacity], contacts that ended in an outer step
  int capacity = 0;

  /// Stores an ended contact for count(), which a later kernel calls, because kernels of pairs have no registers left.
  /// *count: number of ended contacts, increased; contacts beyond `capacity` are not stored.
  LICHTENBERG_HOST_DEVICE void note(int* count, const EndedContact& contact) const {
    const int index = parallel::take_index(count);
    if (index < capacity) ended[index] = contact;
  }
  /// Adds the error of the restitution coefficient of an ended contact to the statistics, if it counts
  /// (RestitutionCheck::counts). `scale`: factor of the law for the radii; `mass`: effective mass; `reach`: sum of the
  /// radii.
  template <class Law>
  LICHTENBERG_HOST_DEVICE void count(const Law& law, double scale, double mass, double reach,
                                     const EndedContact& contact) const {
    if (!RestitutionCheck::counts(contact, since, reach)) return;
    const double speed = contact.impact_speed;
    const double error = contact.error(law.collision(mass, scale, speed, viscoelastic).restitution);
    RestitutionDecade& of = decade[RestitutionCheck::decade_of(speed)];
    parallel::add_atomically(&of.collisions, std::int64_t{1});
    parallel::add_atomically(&of.errors, static_cast<std::int64_t>(error / quantum + 0.5));
    parallel::max_atomically(&of.worst, error);
  }
};

/// RestitutionCheck on an executor (CPU or CUDA device): table of the restitution curve and statistics of the errors,
/// in device memory.
template <class Executor>
class RestitutionOn {
 public:
  explicit RestitutionOn(const Executor& run) : run_(&run), node_(run), loss_(run), decade_(run), ended_(run) {
    const theory::RestitutionCurve& curve = theory::restitution_curve();
    node_.upload(curve.points());
    loss_.upload(curve.losses());
  }

  /// Restores the statistics `saved` in the form of RestitutionCheck::save(). `stage_begin`: time since which the
  /// contact law applies (t0); `grains`: number of grains.
  void load(const std::vector<double>& saved, double stage_begin, int grains) {
    std::vector<RestitutionDecade> before(RestitutionCheck::decades);
    for (std::size_t k = 0; k < before.size(); ++k)
      before[k] = {static_cast<std::int64_t>(saved.at(3 * k)),
                   std::llround(saved.at(3 * k + 1) / RestitutionCount::quantum), saved.at(3 * k + 2)};
    decade_.upload(before);
    since_ = stage_begin;
    ended_.resize(std::max(grains / 2, 1));  // each grain has at most one isolated contact
  }
  /// Returns the statistics of all ranks in the form that RestitutionCheck saves.
  std::vector<double> saved() const {
    std::vector<double> all;
    std::vector<RestitutionDecade> sums(RestitutionCheck::decades);
    for (const std::vector<RestitutionDecade>& one : run_->from_all(decade_.download()))
      for (std::size_t k = 0; k < sums.size(); ++k)
        sums[k] = {sums[k].collisions + one[k].collisions, sums[k].errors + one[k].errors,
                   std::max(sums[k].worst, one[k].worst)};
    for (const RestitutionDecade& d : sums)
      all.insert(all.end(), {static_cast<double>(d.collisions),
                             RestitutionCount::quantum * static_cast<double>(d.errors), d.worst});
    return all;
  }
  RestitutionCount view() const {
    return {{node_.data(), loss_.data(), static_cast<int>(node_.size())},
            decade_.data(),
            since_,
            ended_.data(),
            static_cast<int>(ended_.size())};
  }

 private:
  const Executor* run_;
  parallel::Array<double, Executor> node_, loss_;
  parallel::Array<RestitutionDecade, Executor> decade_;
  parallel::Array<EndedContact, Executor> ended_;
  double since_ = 0;
};

}  // namespace lichtenberg::granular::device
