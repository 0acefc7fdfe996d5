#pragma once

// Induced dipoles on an executor: prediction from earlier steps (DipolePredictor), then conjugate gradients
// (../dipoles.hpp). Sums over all grains are sums of integers, so that their order does not matter.

#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "solvers/periodic/device/charges.hpp"

namespace lichtenberg::periodic::device {

/// Exact sum of numbers, each rounded down to a multiple of 2^-60, by integers, so that the order does not matter. It
/// is exact for up to 2^23 numbers with a total below 2^43.
struct ExactSum {
  std::int64_t high = 0, low = 0;  ///< Parts in units of 2^-20 and 2^-60

  /// Returns the exact sum that consists of one number.
  static LICHTENBERG_HOST_DEVICE ExactSum of(double value) {
    const double scaled = value * 0x1p20, whole = std::floor(scaled);
    return {static_cast<std::int64_t>(whole), static_cast<std::int64_t>((scaled - whole) * 0x1p40)};
  }
  /// Returns the sum as a floating-point number.
  LICHTENBERG_HOST_DEVICE double value() const {
    return (static_cast<double>(high) + static_cast<double>(low) * 0x1p-40) * 0x1p-20;
  }
  LICHTENBERG_HOST_DEVICE ExactSum& operator+=(const ExactSum& other) {
    high += other.high, low += other.low;
    return *this;
  }
  friend LICHTENBERG_HOST_DEVICE ExactSum operator+(ExactSum a, const ExactSum& b) { return a += b; }
};

/// Two exact sums that are computed together.
struct ExactPair {
  ExactSum first, second;

  LICHTENBERG_HOST_DEVICE ExactPair& operator+=(const ExactPair& other) {
    first += other.first, second += other.second;
    return *this;
  }
  friend LICHTENBERG_HOST_DEVICE ExactPair operator+(ExactPair a, const ExactPair& b) { return a += b; }
};

/// State of the solver of induced dipoles, in device memory.
struct DipoleSolve {
  /// Squared norms: permitted residual; present residual (during sweeps over near dipoles: last change over A).
  double goal = 0, square = 0;
  double step = 0, beta = 0;             ///< Coefficients of conjugate gradients
  double before = INFINITY;              ///< Squared norm of the residual at the last evaluation of this solve
  std::int64_t applications = 0;         ///< Total number of applications of the interaction tensor T in the run
  int go = 0, correct = 0, changed = 0;  ///< Conditions of the solver's loops
  int iterations = 0, sweeps = 0;
  int unstable = 0, unsolved = 0;  ///< Flags: 1 if a step had no stable state, or did not converge
  int known = 0;                   ///< Number of steps in the history
};

/// Largest number of steps in the history of dipoles.
constexpr int dipole_history = 4;

/// Dipole data of a grain, which move with it when grains are sorted: dipole, dipoles of earlier steps, and force.
struct DipoleGrain {
  Vec3 dipole;
  Vec3 earlier[dipole_history];
  FieldSample force;
};

/// Device pointers to the dipole data of all grains (struct of arrays).
struct DipoleArrays {
  Vec3* dipole;
  Vec3* earlier[dipole_history];
  FieldSample* force;

  /// Returns a copy of the dipole data of grain i: dipole, dipoles of earlier steps, and force.
  LICHTENBERG_HOST_DEVICE DipoleGrain take(int i) const {
    DipoleGrain grain{.dipole = dipole[i], .earlier = {}, .force = force[i]};
    for (int k = 0; k < dipole_history; ++k) grain.earlier[k] = earlier[k][i];
    return grain;
  }
  /// Stores the data of a grain at index s.
  LICHTENBERG_HOST_DEVICE void put(int s, const DipoleGrain& grain) const {
    dipole[s] = grain.dipole;
    for (int k = 0; k < dipole_history; ++k) earlier[k][s] = grain.earlier[k];
    force[s] = grain.force;
  }
};

/// Function object that returns the number of elements in part p, if n elements are divided into parts of 256.
struct PartSizes {
  static constexpr int a_part = 256;
  int n;
  LICHTENBERG_HOST_DEVICE int operator()(int p) const { return n - p * a_part < a_part ? n - p * a_part : a_part; }
};

/// Sum of double-precision numbers, one per segment, as the executors' sum_segments() needs it.
struct OneSum {
  double value = 0;

  LICHTENBERG_HOST_DEVICE OneSum& operator+=(const OneSum& other) {
    value += other.value;
    return *this;
  }
  friend LICHTENBERG_HOST_DEVICE OneSum operator+(OneSum a, const OneSum& b) { return a += b; }
};

/// Converts a dipole to single precision.
LICHTENBERG_HOST_DEVICE inline Moment moment(Vec3 v) {
  return {static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)};
}

/// Solver for induced dipoles on an executor, mu = A (e + T mu), with the fields of ChargeSums (see ../dipoles.hpp for
/// the equations). Arrays of dipoles are in units of charge times length; only within the solver they are scaled by a
/// power of two, like the charges.
template <class Executor>
class InducedDipolesOn {
  template <class T>
  using Array = parallel::Array<T, Executor>;

 public:
  /// Prepares the solver. `polarizability`: A (length^3); `tolerance`: permitted residual, relative to the field of
  /// charges and dipoles.
  InducedDipolesOn(const Executor& run, ChargeSums<Executor>& sums, double polarizability, double tolerance)
      : run_(&run), sums_(&sums), polarizability_(polarizability), tolerance_(tolerance) {
    solve_.resize(1);
  }

  /// Loads the history of n grains: dipoles [3 n] of up to dipole_history earlier steps, the last step first. The
  /// dipoles of the last step (0 without history) become the present dipoles. `applications`: number of applications of
  /// T in the run so far.
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
  bool known() const { return download().known > 0; }                 ///< True if the dipoles of a step are known
  DipoleSolve download() const { return solve_.download().front(); }  ///< Copy of the solver's state
  const DipoleSolve* state() const { return solve_.data(); }          ///< State in device memory
  const int* unstable() const { return &solve_.data()->unstable; }    ///< Flag in device memory
  std::vector<Vec3> dipoles() const { return dipole_.download(); }    ///< Copy of the present dipoles
  /// Returns a copy of the dipoles of earlier steps, the last step first.
  std::vector<std::vector<Vec3>> history() const {
    std::vector<std::vector<Vec3>> all;
    for (int k = 0; k < download().known; ++k) all.push_back(earlier_[k].download());
    return all;
  }
  /// Returns the address of the dipoles in device memory. Recorded kernels are invalid after it changes.
  const void* address() const { return dipole_.data(); }

  /// Computes the dipoles of the next step, with fields and forces, from the predictor's initial guess. `scale`: factor
  /// by which `charges` are scaled. If *go is 0 there is no next step, and the dipoles stay unchanged.
  void follow(const PointCharge* charges, const double* scale, const TableView& partners, const int* go) {
    predict(go);
    solve(charges, scale, partners, go);
    finish(scale, dipole_history, go);
  }
  /// Computes the dipoles of the last step again, with fields and forces, for other charges, from the present dipoles
  /// as initial guess.
  void follow_charges(const PointCharge* charges, const double* scale, const TableView& partners) {
    solve(charges, scale, partners, nullptr);
    finish(scale, 1, nullptr);
  }
  /// Computes fields and forces for the present dipoles, without a solve.
  void evaluate(const PointCharge* charges, const double* scale, const TableView& partners) {
    take(scale);
    sums_->evaluate(charges, moments_.data(), partners);
    finish(scale, 0, nullptr);
  }

  // The following functions contain kernels, which nvcc requires to be public.

  /// Sorts the dipole data: the grain order[s] moves to index s.
  void permute(const int* order) {
    DipoleGrain* spare = spare_.data();
    const DipoleArrays all = arrays();
    run_->for_each(n_, [=] LICHTENBERG_HOST_DEVICE(int s) { spare[s] = all.take(order[s]); });
    run_->for_each(n_, [=] LICHTENBERG_HOST_DEVICE(int s) { all.put(s, spare[s]); });
  }

  /// Replaces the dipoles by the predictor's initial guess for the next step, and makes space for it in the history,
  /// unless *go is 0.
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
  /// Copies the dipoles, times *scale, to the solver's arrays.
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

  /// Solves for the induced dipoles, and computes fields and forces. An evaluation with the initial guess suffices if
  /// its residual is within the tolerance. Otherwise sweeps over near dipoles correct most of the residual. Sweeps and
  /// evaluation are repeated while they reduce the residual to less than a quarter. If it is then still too large,
  /// conjugate gradients follow, with 1/A as the inverse preconditioner. The tolerance is relative to the field of
  /// charges and dipoles. If *go is 0 the initial guess is accepted.
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
  /// Performs one sweep of a fixed-point iteration for the correction d of the dipoles: d becomes A r + A T d, with T
  /// for near dipoles only and the residual r. The change of d over A is the remaining residual of the near system.
  /// Sweeps end when this residual is small or does not decrease, or after 8 sweeps.
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
  /// Adds the correction d of the sweeps to the scaled dipoles.
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
  /// Computes the residual from the evaluated fields, and decides how the solver continues: `correct` for sweeps,
  /// `changed` and `go` for conjugate gradients, or neither if the residual is small or *wanted is 0.
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
  /// Computes the step length of conjugate gradients along the direction p, given T p. If the curvature along p is not
  /// positive, sets the flag `unstable`, and the length to 0.
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
  /// Performs the step of conjugate gradients, decides whether another one follows, and computes its direction.
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
  /// Stores the dipoles without scaling, adds their own energy mu^2 / 2A to the totals, and writes them to the history
  /// as the last step. `known`: maximum length of the history; 0 leaves the history unchanged. A shorter history grows
  /// by one if `go` is null or *go is not 0.
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

  /// Computes the sum of value(s) over all grains s, and calls finish(sum).
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
