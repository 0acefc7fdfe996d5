#pragma once

// Induced dipoles on an executor: prediction from earlier steps (DipolePredictor), then conjugate gradients
// (../dipoles.hpp). Sums over all grains are sums of integers, so that their order does not matter.

#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "solvers/periodic/device/charges.hpp"

namespace lichtenberg::periodic::device {

/// Sum of numbers, each rounded to a multiple of 2^-60: exact for up to 2^23 numbers with a total below 2^43.
struct ExactSum {
  std::int64_t high = 0, low = 0;  ///< Units 2^-20 and 2^-60

  static LICHTENBERG_HOST_DEVICE ExactSum of(double value) {
    const double scaled = value * 0x1p20, whole = std::floor(scaled);
    return {static_cast<std::int64_t>(whole), static_cast<std::int64_t>((scaled - whole) * 0x1p40)};
  }
  LICHTENBERG_HOST_DEVICE double value() const {
    return (static_cast<double>(high) + static_cast<double>(low) * 0x1p-40) * 0x1p-20;
  }
  LICHTENBERG_HOST_DEVICE ExactSum& operator+=(const ExactSum& other) {
    high += other.high, low += other.low;
    return *this;
  }
  friend LICHTENBERG_HOST_DEVICE ExactSum operator+(ExactSum a, const ExactSum& b) { return a += b; }
};

/// Two exact sums.
struct ExactPair {
  ExactSum first, second;

  LICHTENBERG_HOST_DEVICE ExactPair& operator+=(const ExactPair& other) {
    first += other.first, second += other.second;
    return *this;
  }
  friend LICHTENBERG_HOST_DEVICE ExactPair operator+(ExactPair a, const ExactPair& b) { return a += b; }
};

/// State of the dipole solver.
struct DipoleSolve {
  double goal = 0,
         square = 0;  ///< Squared norm of the residual; during sweeps over near dipoles, of the last change over A
  double step = 0, beta = 0;
  double before = INFINITY;       ///< Squared norm of the residual at the last evaluation of this solve
  std::int64_t applications = 0;  ///< Total number of applications of T in the run
  int go = 0, correct = 0, changed = 0;
  int iterations = 0, sweeps = 0;
  int unstable = 0, unsolved = 0;  ///< Flags: 1 if found so in any step
  int known = 0;                   ///< Number of steps of the history
};

constexpr int dipole_history = 4;

/// Per-grain data that move with a grain when grains are sorted.
struct DipoleGrain {
  Vec3 dipole;
  Vec3 earlier[dipole_history];
  FieldSample force;
};

/// Device pointers to the arrays of DipoleGrain.
struct DipoleArrays {
  Vec3* dipole;
  Vec3* earlier[dipole_history];
  FieldSample* force;

  LICHTENBERG_HOST_DEVICE DipoleGrain take(int i) const {
    DipoleGrain grain{.dipole = dipole[i], .earlier = {}, .force = force[i]};
    for (int k = 0; k < dipole_history; ++k) grain.earlier[k] = earlier[k][i];
    return grain;
  }
  LICHTENBERG_HOST_DEVICE void put(int s, const DipoleGrain& grain) const {
    dipole[s] = grain.dipole;
    for (int k = 0; k < dipole_history; ++k) earlier[k][s] = grain.earlier[k];
    force[s] = grain.force;
  }
};

/// Number of elements in part p of n elements.
struct PartSizes {
  static constexpr int a_part = 256;
  int n;
  LICHTENBERG_HOST_DEVICE int operator()(int p) const { return n - p * a_part < a_part ? n - p * a_part : a_part; }
};

struct OneSum {
  double value = 0;

  LICHTENBERG_HOST_DEVICE OneSum& operator+=(const OneSum& other) {
    value += other.value;
    return *this;
  }
  friend LICHTENBERG_HOST_DEVICE OneSum operator+(OneSum a, const OneSum& b) { return a += b; }
};

LICHTENBERG_HOST_DEVICE inline Moment moment(Vec3 v) {
  return {static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)};
}

/// Solver for the induced dipoles of charges that ChargeSums evaluates. Dipoles are in units of charge times length;
/// only within the solver they are scaled by a power of two.
template <class Executor>
class InducedDipolesOn {
  template <class T>
  using Array = parallel::Array<T, Executor>;

 public:
  InducedDipolesOn(const Executor& run, ChargeSums<Executor>& sums, double polarizability, double tolerance)
      : run_(&run), sums_(&sums), polarizability_(polarizability), tolerance_(tolerance) {
    solve_.resize(1);
  }

  /// Loads dipoles of earlier steps, the last one first, each [3 N]; the first are the present dipoles. `applications`:
  /// number of applications of T so far.
  void load(int n, const std::vector<std::vector<double>>& history, std::int64_t applications) {
    n_ = n;
    const auto make = [&](auto&... arrays) { (arrays.resize(n), ...); };
    make(dipole_, scaled_, residual_, direction_, field_, moments_, spare_);
    DipoleSolve solve;
    solve.known = static_cast<int>(history.size());
    solve.applications = applications;
    for (int k = 0; k < dipole_history; ++k) {
      earlier_[k].resize(n);
      if (k < solve.known)
        upload(earlier_[k], history[k]);
      else
        earlier_[k].zero();
    }
    if (solve.known > 0)
      upload(dipole_, history[0]);
    else
      dipole_.zero();
    solve_.upload({solve});
  }
  bool known() const { return download().known > 0; }
  DipoleSolve download() const { return solve_.download().front(); }
  const DipoleSolve* state() const { return solve_.data(); }
  const int* unstable() const { return &solve_.data()->unstable; }
  std::vector<Vec3> dipoles() const { return dipole_.download(); }
  std::vector<std::vector<Vec3>> history() const {
    std::vector<std::vector<Vec3>> all;
    for (int k = 0; k < download().known; ++k) all.push_back(earlier_[k].download());
    return all;
  }
  /// Address of the dipoles, for recorded kernels.
  const void* address() const { return dipole_.data(); }

  /// Computes the dipoles of the next step, from the predictor's initial guess; `scale`: of `charges`. If *go is 0
  /// there is no next step, and the dipoles stay unchanged.
  void follow(const PointCharge* charges, const double* scale, const TableView& partners, const int* go) {
    predict(go);
    solve(charges, scale, partners, go);
    finish(scale, dipole_history, go);
  }
  /// Computes the dipoles of the same step again, with other charges.
  void follow_charges(const PointCharge* charges, const double* scale, const TableView& partners) {
    solve(charges, scale, partners, nullptr);
    finish(scale, 1, nullptr);
  }
  /// Computes fields and forces for the present dipoles, without solving.
  void evaluate(const PointCharge* charges, const double* scale, const TableView& partners) {
    take(scale);
    sums_->evaluate(charges, moments_.data(), partners);
    finish(scale, 0, nullptr);
  }

  // The following functions contain kernels, which nvcc requires to be public.

  void permute(const int* order) {
    DipoleGrain* spare = spare_.data();
    const DipoleArrays all = arrays();
    run_->for_each(n_, [=] LICHTENBERG_HOST_DEVICE(int s) { spare[s] = all.take(order[s]); });
    run_->for_each(n_, [=] LICHTENBERG_HOST_DEVICE(int s) { all.put(s, spare[s]); });
  }

  void predict(const int* go) {
    const DipoleArrays all = arrays();
    DipoleSolve* solve = solve_.data();
    run_->for_each(n_, [=] LICHTENBERG_HOST_DEVICE(int s) {
      // Kolafa's always stable predictor for the number of steps known (DipolePredictor).
      if (!*go) return;
      constexpr double weight[dipole_history + 1][dipole_history] = {
          {}, {1}, {2, -1}, {2.5, -2, 0.5}, {2.8, -2.8, 1.2, -0.2}};
      Vec3 sum;
      for (int k = 0; k < dipole_history; ++k) sum += weight[solve->known][k] * all.earlier[k][s];
      for (int k = dipole_history - 1; k > 0; --k) all.earlier[k][s] = all.earlier[k - 1][s];
      all.dipole[s] = sum;
    });
  }
  void take(const double* scale) {
    const Vec3* dipole = dipole_.data();
    Vec3* scaled = scaled_.data();
    Moment* moments = moments_.data();
    DipoleSolve* solve = solve_.data();
    run_->for_each(n_, [=] LICHTENBERG_HOST_DEVICE(int s) {
      scaled[s] = *scale * dipole[s];
      moments[s] = moment(scaled[s]);
      if (s == 0) solve->before = INFINITY;
    });
  }

  /// Solves for the dipoles and computes fields and forces. Evaluates charges and initial guess; this suffices if the
  /// residual is within the tolerance. Otherwise sweeps over near dipoles correct most of the residual, and the
  /// evaluation is repeated while this reduces it considerably. If it does not, conjugate gradients follow, with 1/A as
  /// the inverse preconditioner. The tolerance is relative to the field of charges and dipoles. If *go is 0 the initial
  /// guess is accepted.
  void solve(const PointCharge* charges, const double* scale, const TableView& partners, const int* go) {
    take(scale);
    sums_->evaluate(charges, moments_.data(), partners);
    begin(go);
    DipoleSolve* solve = solve_.data();
    run_->repeat_while(&solve->correct, [&] {
      run_->repeat_while(&solve->go, [&] { sweep(charges, partners); });
      correct();
      sums_->evaluate(charges, moments_.data(), partners);
      begin(go);
    });
    run_->repeat_while(&solve->go, [&] {
      sums_->dipole_field(charges, moments_.data(), partners, field_.data());
      find_step();
      go_on();
    });
    run_->when(&solve->changed, [&] { sums_->evaluate(charges, moments_.data(), partners); });
  }
  /// Performs one sweep: the correction d becomes A r + A T d, with T for near dipoles only. The change of d over A is
  /// the remaining residual of the near system. If it does not decrease the series diverges, and the present correction
  /// is accepted as an initial guess.
  void sweep(const PointCharge* charges, const TableView& partners) {
    constexpr int most = 8;
    sums_->near_dipole_field(charges, moments_.data(), partners, field_.data());
    const FieldSample* field = field_.data();
    const Vec3* residual = residual_.data();
    Vec3* direction = direction_.data();
    Moment* moments = moments_.data();
    DipoleSolve* solve = solve_.data();
    const double a = polarizability_;
    sum(
        [=] LICHTENBERG_HOST_DEVICE(int s) {
          const Vec3 now = residual[s] + Vec3{field[s].x, field[s].y, field[s].z};
          const Vec3 change = now - (1 / a) * direction[s];
          direction[s] = a * now;
          moments[s] = moment(a * now);
          return ExactPair{ExactSum::of(norm2(change)), {}};
        },
        [=] LICHTENBERG_HOST_DEVICE(const ExactPair& all) {
          constexpr double share = 0.25;  // A share of the goal only, since far dipoles add to the residual
          const double now = all.first.value();
          solve->go = now > share * solve->goal && now < solve->square && ++solve->sweeps < most;
          solve->square = now;
        });
  }
  void correct() {
    Vec3* scaled = scaled_.data();
    const Vec3* direction = direction_.data();
    Moment* moments = moments_.data();
    DipoleSolve* solve = solve_.data();
    run_->for_each(n_, [=] LICHTENBERG_HOST_DEVICE(int s) {
      scaled[s] += direction[s];
      moments[s] = moment(scaled[s]);
      if (s == 0) ++solve->applications;
    });
  }
  void begin(const int* wanted) {
    const FieldSample* field_at_source = sums_->field_at_source();
    Vec3 *scaled = scaled_.data(), *residual = residual_.data(), *direction = direction_.data();
    Moment* moments = moments_.data();
    DipoleSolve* solve = solve_.data();
    const double a = polarizability_, tolerance2 = tolerance_ * tolerance_;
    sum(
        [=] LICHTENBERG_HOST_DEVICE(int s) {
          const Vec3 e{field_at_source[s].x, field_at_source[s].y, field_at_source[s].z}, r = e - (1 / a) * scaled[s];
          residual[s] = r, direction[s] = a * r, moments[s] = moment(a * r);
          return ExactPair{ExactSum::of(norm2(r)), ExactSum::of(norm2(e))};
        },
        [=] LICHTENBERG_HOST_DEVICE(const ExactPair& all) {
          solve->goal = tolerance2 * all.second.value(), solve->square = all.first.value();
          constexpr double much = 16;  // Squared: the norm of the residual fell to a quarter or less
          solve->go = solve->square > solve->goal && (!wanted || *wanted);
          solve->correct = solve->go && much * solve->square < solve->before;
          solve->changed = solve->go && !solve->correct;
          solve->before = solve->square;
          solve->iterations = solve->sweeps = 0;
        });
  }
  /// Computes the step length along the direction p, given T p.
  void find_step() {
    const FieldSample* field = field_.data();
    const Vec3* direction = direction_.data();
    DipoleSolve* solve = solve_.data();
    const double a = polarizability_;
    sum(
        [=] LICHTENBERG_HOST_DEVICE(int s) {
          const Vec3 p = direction[s], t{field[s].x, field[s].y, field[s].z};
          return ExactPair{ExactSum::of(dot(p, (1 / a) * p - t)), {}};
        },
        [=] LICHTENBERG_HOST_DEVICE(const ExactPair& all) {
          const double curvature = all.first.value();
          if (!(curvature > 0)) solve->unstable = 1;
          solve->step = curvature > 0 ? a * solve->square / curvature : 0;
        });
  }
  void go_on() {
    constexpr int most = 100;
    const FieldSample* field = field_.data();
    Vec3 *scaled = scaled_.data(), *residual = residual_.data(), *direction = direction_.data();
    Moment* moments = moments_.data();
    DipoleSolve* solve = solve_.data();
    const double a = polarizability_;
    sum(
        [=] LICHTENBERG_HOST_DEVICE(int s) {
          const Vec3 p = direction[s], t{field[s].x, field[s].y, field[s].z};
          const Vec3 r = residual[s] - solve->step * ((1 / a) * p - t);
          scaled[s] += solve->step * p;
          residual[s] = r;
          return ExactPair{ExactSum::of(norm2(r)), {}};
        },
        [=] LICHTENBERG_HOST_DEVICE(const ExactPair& all) {
          const double now = all.first.value();
          solve->beta = now / solve->square, solve->square = now;
          ++solve->iterations, ++solve->applications;
          solve->go = now > solve->goal && !solve->unstable;
          if (solve->go && solve->iterations == most) solve->go = 0, solve->unsolved = 1;
        });
    run_->for_each(n_, [=] LICHTENBERG_HOST_DEVICE(int s) {
      direction[s] = a * residual[s] + solve->beta * direction[s];
      moments[s] = moment(solve->go ? direction[s] : scaled[s]);
    });
  }
  /// Stores the unscaled dipoles, adds their own energy mu^2 / 2A to the totals, and makes them the last of the
  /// history. `known`: maximum length of the history then; 0 leaves the history unchanged. It grows by one if `go` is
  /// null or *go is not 0.
  void finish(const double* scale, int known, const int* go) {
    const DipoleArrays all = arrays();
    const Vec3* scaled = scaled_.data();
    DipoleSolve* solve = solve_.data();
    double* energy = &sums_->totals_to_change()->energy;
    const double a = polarizability_;
    run_->sum_segments((n_ + PartSizes::a_part - 1) / PartSizes::a_part, parts(),
                       [=] LICHTENBERG_HOST_DEVICE(int p, int t) {
                         const int s = p * PartSizes::a_part + t;
                         all.dipole[s] = (1 / *scale) * scaled[s];
                         if (known > 0) all.earlier[0][s] = all.dipole[s];
                         if (s == 0 && solve->known < known && (!go || *go)) ++solve->known;
                         return OneSum{on_fine_grid(norm2(scaled[s]) / (2 * a))};
                       },
                       [=] LICHTENBERG_HOST_DEVICE(int, OneSum of) { parallel::add_atomically(energy, of.value); });
  }

  /// Calls finish(sum of value(s) over all grains).
  template <class Value, class Finish>
  void sum(Value value, Finish finish) {
    run_->template sum<1>(n_, value, finish);
  }

 private:
  PartSizes parts() const { return {n_}; }

  DipoleArrays arrays() const {
    return {dipole_.data(),
            {earlier_[0].data(), earlier_[1].data(), earlier_[2].data(), earlier_[3].data()},
            sums_->force()};
  }
  static void upload(Array<Vec3>& array, const std::vector<double>& values) {
    std::vector<Vec3> vectors(values.size() / 3);
    for (std::size_t i = 0; i < vectors.size(); ++i) vectors[i] = {values[3 * i], values[3 * i + 1], values[3 * i + 2]};
    array.upload(vectors);
  }

  const Executor* run_;
  ChargeSums<Executor>* sums_;
  double polarizability_, tolerance_;
  int n_ = 0;
  Array<Vec3> dipole_{*run_};
  std::array<Array<Vec3>, dipole_history> earlier_{Array<Vec3>(*run_), Array<Vec3>(*run_), Array<Vec3>(*run_),
                                                   Array<Vec3>(*run_)};
  Array<Vec3> scaled_{*run_}, residual_{*run_}, direction_{*run_};
  Array<FieldSample> field_{*run_};
  Array<Moment> moments_{*run_};
  Array<DipoleGrain> spare_{*run_};
  Array<DipoleSolve> solve_{*run_};
};

}  // namespace lichtenberg::periodic::device
