#pragma once

// Collisions that have ended, held against the restitution of their law: RestitutionCheck on an executor. Errors are
// added up in whole numbers, so that the order in which collisions end does not show.

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

/// What a law of contact leaves of the speed of impact.
struct RestitutionLaw {
  const double *node = nullptr, *loss = nullptr;  ///< of theory::RestitutionCurve
  int nodes = 0;

  LICHTENBERG_HOST_DEVICE double operator()(const ViscoelasticLaw& law, double scale, double mass, double speed) const {
    const double k = law.dissipative / law.elastic * std::pow(scale * law.elastic / mass, 0.4) * std::pow(speed, 0.2);
    const double root = std::sqrt(k), u = root / (1 + root);
    return k > theory::RestitutionCurve::largest ? 0 : 1 - k * theory::between_nodes(node, loss, nodes, u);
  }
  LICHTENBERG_HOST_DEVICE double operator()(const LinearSpringLaw& law, double, double mass, double) const {
    return linear_collision(law, mass).restitution;
  }
};

struct RestitutionDecade {
  std::int64_t collisions = 0, errors = 0;  ///< how many, and the sum of their errors in quanta
  double worst = 0;
};

struct RestitutionCount {
  static constexpr double quantum = 1.0 / (1 << 30);  // of 2^33 collisions that are off by 1 the sum is still a number

  RestitutionLaw expected;
  RestitutionDecade* decade = nullptr;  ///< [RestitutionCheck::decades]
  double since = 0;                     ///< contacts that began before were under another law

  /// A contact of a lone pair has ended at `time`. A function of its own: it is rare, and those who call it have few
  /// registers to spare.
  template <class Law>
  LICHTENBERG_HOST_DEVICE __attribute__((noinline)) void operator()(const Law& law, double scale, double mass,
                                                                    double reach, const PairState<3>& at, double began,
                                                                    double speed, double time) const {
    const double across = speed_across(at);
    if (!(speed > 0) || began < since || !RestitutionCheck::is_central(across, time - began, speed, reach)) return;
    const double error = std::abs(-closing(at) / speed - expected(law, scale, mass, speed));
    RestitutionDecade& of = decade[RestitutionCheck::decade_of(speed)];
    parallel::add_atomically(&of.collisions, std::int64_t{1});
    parallel::add_atomically(&of.errors, static_cast<std::int64_t>(error / quantum + 0.5));
    parallel::enlarge_atomically(&of.worst, error);
  }
};

/// The table of the law, and what has been counted.
template <class Executor>
class RestitutionOn {
 public:
  explicit RestitutionOn(const Executor& run) : node_(run), loss_(run), decade_(run) {
    const theory::RestitutionCurve& curve = theory::restitution_curve();
    node_.upload(curve.points());
    loss_.upload(curve.losses());
  }

  /// As RestitutionCheck has saved it.
  void load(const std::vector<double>& saved, double stage_begin) {
    std::vector<RestitutionDecade> before(RestitutionCheck::decades);
    for (std::size_t k = 0; k < before.size(); ++k)
      before[k] = {static_cast<std::int64_t>(saved.at(3 * k)),
                   std::llround(saved.at(3 * k + 1) / RestitutionCount::quantum), saved.at(3 * k + 2)};
    decade_.upload(before);
    since_ = stage_begin;
  }
  std::vector<double> saved() const {
    std::vector<double> all;
    for (const RestitutionDecade& d : decade_.download())
      all.insert(all.end(), {static_cast<double>(d.collisions),
                             RestitutionCount::quantum * static_cast<double>(d.errors), d.worst});
    return all;
  }
  RestitutionCount view() const {
    return {{node_.data(), loss_.data(), static_cast<int>(node_.size())}, decade_.data(), since_};
  }

 private:
  parallel::Array<double, Executor> node_, loss_;
  parallel::Array<RestitutionDecade, Executor> decade_;
  double since_ = 0;
};

}  // namespace lichtenberg::granular::device
