#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "solvers/laplace/problem.hpp"
#include "solvers/larger.hpp"
#include "validation/theory/two_disks.hpp"

namespace lichtenberg::validation {

/// Returns true if the first command-line argument is `long`, which adds the cases that take minutes.
inline bool long_run_requested(int argc, char** argv) { return argc > 1 && std::string_view(argv[1]) == "long"; }

/// Statistics of a sample: mean magnitude, largest magnitude, and standard deviation about the signed mean. They are
/// NaN, which fails every bound, for an empty sample or a sample with a NaN.
struct Spread {
  double mean = 0, worst = 0, jitter = 0;
};
/// Computes the statistics of a sample.
inline Spread spread(const std::vector<double>& sample) {
  Spread result;
  if (sample.empty()) return {NAN, NAN, NAN};
  double signed_mean = 0;
  const auto n = static_cast<double>(sample.size());
  for (double x : sample) {
    signed_mean += x / n;
    result.mean += std::abs(x) / n;
    result.worst = larger(result.worst, std::abs(x));
  }
  for (double x : sample) result.jitter += (x - signed_mean) * (x - signed_mean) / n;
  result.jitter = std::sqrt(result.jitter);
  return result;
}

/// Sample of values from random cases, with the seed of the case with the largest value.
struct SampleBySeed {
  std::vector<double> values;
  double largest = 0;
  std::uint64_t seed = 0;
  void add(double value, std::uint64_t at) {
    values.push_back(value);
    if (value <= largest) return;
    largest = value;
    seed = at;
  }
  /// Returns the number of cases and the seed as a remark for a table.
  std::string note() const { return fmt::format("{} cases, seed {}", values.size(), seed); }
};

/// Report of a validation program: prints a table of values with their bounds, and counts the bounds that fail.
class Report {
 public:
  explicit Report(const std::string& title) { fmt::print("{}\n", title); }

  /// Begins a section of the table.
  void section(const std::string& heading) {
    fmt::print("\n{}\n{:<58}{:>10}{:>10}{:>13}\n", heading, "", "mean", "worst", "bound");
  }
  /// Prints a row for a sample, which passes if its largest magnitude is at most `bound`. Without a bound the row is
  /// informative only. `note` is printed after the verdict.
  void at_most(const std::string& what, const Spread& sample, std::optional<double> bound,
               const std::string& note = {}) {
    fmt::print("{:<58}{:>10.3g}{:>10.3g}", what, sample.mean, sample.worst);
    verdict("<=", bound, bound && sample.worst <= *bound, note);
  }
  /// Prints a row for a value, which passes if it is at most `bound`.
  void at_most(const std::string& what, double value, std::optional<double> bound, const std::string& note = {}) {
    fmt::print("{:<58}{:>10}{:>10.3g}", what, "", value);
    verdict("<=", bound, bound && value <= *bound, note);
  }
  /// Prints a row for a value, which passes if it is at least `bound`.
  void at_least(const std::string& what, double value, std::optional<double> bound) {
    fmt::print("{:<58}{:>10}{:>10.3g}", what, "", value);
    verdict(">=", bound, bound && value >= *bound);
  }

  /// Prints how many bounds hold. Returns the program's exit status: 0 if all bounds hold, otherwise 1.
  int exit_status() const {
    fmt::print("\n{} of {} bounds kept\n", checked_ - failed_, checked_);
    return failed_ > 0 ? 1 : 0;
  }

 private:
  void verdict(const char* relation, std::optional<double> bound, bool kept, const std::string& note = {}) {
    if (bound) {
      ++checked_;
      failed_ += !kept;
      fmt::print("{:>4}{:>9.3g}  {}", relation, *bound, kept ? "PASS" : "FAIL");
    }
    if (!note.empty()) fmt::print("  {}", note);
    fmt::print("\n");
    std::fflush(stdout);
  }
  int checked_ = 0, failed_ = 0;
};

/// Computes the order of convergence p in error ~ resolution^-p by a least-squares fit of the logarithms.
inline double order(const std::vector<double>& resolution, const std::vector<double>& error) {
  const auto n = static_cast<double>(error.size());
  double x = 0, y = 0, xx = 0, xy = 0;
  for (std::size_t k = 0; k < error.size(); ++k) {
    const double log_resolution = std::log(resolution[k]), log_error = std::log(error[k]);
    x += log_resolution;
    y += log_error;
    xx += log_resolution * log_resolution;
    xy += log_resolution * log_error;
  }
  return -(n * xy - x * y) / (n * xx - x * x);
}

/// Makes a field problem in a box for a pair of disks in the unbounded plane. The sides of the box have the exact
/// bipolar potential, so that the only error is that of the numerical scheme. Group 0 (the positive disk) floats with
/// `charge` (C/m); group 1 is fixed at its exact potential.
inline laplace::LaplaceProblem in_plane(const theory::DiskPair& pair, Vec2 size, double charge) {
  laplace::LaplaceProblem problem;
  problem.size = size;
  problem.permittivity = pair.permittivity;
  problem.bodies = {{pair.positive, 0}, {pair.negative, 1}};
  problem.groups = {{.floating = true, .charge = charge},
                    {.floating = false, .potential = theory::negative_potential(pair, charge)}};
  problem.sides.fill({.kind = laplace::Side::Kind::electrode,
                      .profile = [pair, charge](Vec2 p) { return theory::potential(pair, charge, p); }});
  return problem;
}

}  // namespace lichtenberg::validation
