#pragma once

#include <cstdlib>
#include <exception>
#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>
#include <utility>

#include "solvers/random.hpp"
#include "validation/harness.hpp"

/// The accuracy contract: realised over requested errors of random cases, for each error that the program guarantees.
/// Each program contract_*.cpp covers one part of the library.
namespace lichtenberg::validation {

/// Random numbers of one case.
class CaseRandom {
 public:
  explicit CaseRandom(std::uint64_t seed, std::uint64_t part = 0)
      : random_({.seed = seed, .purpose = RandomPurpose::population, .i = part}) {}
  double uniform(double low, double high) { return random_.uniform(low, high); }
  double logarithmic(double low, double high) { return low * std::pow(high / low, random_.uniform()); }
  bool chance(double p) { return random_.uniform() < p; }
  double normal() { return random_.normal(); }
  int whole(int low, int high) { return low + static_cast<int>(random_.uniform() * (high - low + 1.0)); }
  double pick(std::initializer_list<double> values) {
    return values.begin()[whole(0, static_cast<int>(values.size()) - 1)];
  }

 private:
  Random random_;
};

/// A guarantee about errors: its name, and the source of the exact values.
struct Guarantee {
  std::string name, reference;
};

/// Table of realised over requested errors, one row per guarantee.
class Contract {
 public:
  /// Adds a case of a guarantee.
  void add(const Guarantee& guarantee, double requested, double error) {
    Row& row = row_of(guarantee);
    row.ratio.add(error / requested, seed_);
    if (!(error <= requested))
      fmt::print("seed {}: {}: requested {:.3g}, realised {:.4g} times that\n", seed_, guarantee.name, requested,
                 error / requested);
  }
  /// Adds a case that the program refused with a message; no guarantee is broken.
  void refuse(const Guarantee& guarantee) { ++row_of(guarantee).refused; }
  /// Adds the result of a case that must neither fail nor be refused.
  void fail(const std::exception& error) {
    ++failures_;
    fmt::print("seed {}: {}\n", seed_, error.what());
  }

  /// Runs `check` for each seed of the command line: `quick` seeds, or the seeds FROM to TO of two numbers. With the
  /// argument `long` it runs seeds until each guarantee has `full` cases, at most four times as many seeds. Prints the
  /// table, and writes it as JSON to the path in the environment variable LICHTENBERG_FIGURES. Returns the exit status:
  /// 0 if each ratio is at most 1 and no case failed.
  int run(const std::string& title, int argc, char** argv, int quick, int full,
          const std::function<void(Contract&, std::uint64_t seed)>& check) {
    const bool given = argc > 2;
    const int from = given ? std::atoi(argv[1]) : 1;
    const bool until_full = !given && long_run_requested(argc, argv);
    const int to = given ? std::atoi(argv[2]) : until_full ? 4 * full : quick;
    const auto is_full = [&](const Row& row) { return static_cast<int>(row.ratio.values.size()) >= full; };
    for (int seed = from; seed <= to; ++seed) {
      if (until_full && seed > full && std::ranges::all_of(rows_, is_full)) break;
      seed_ = static_cast<std::uint64_t>(seed);
      try {
        check(*this, seed_);
      } catch (const std::exception& error) {
        fail(error);
      }
    }
    return finish(title);
  }

 private:
  struct Row {
    Guarantee guarantee;
    SampleBySeed ratio;
    int refused = 0;
  };

  Row& row_of(const Guarantee& guarantee) {
    for (Row& row : rows_)
      if (row.guarantee.name == guarantee.name) return row;
    return rows_.emplace_back(Row{guarantee, {}, 0});
  }

  /// Returns the value that the fraction p of the sample does not exceed. NaN counts as infinite.
  static double quantile(std::vector<double> sample, double p) {
    for (double& value : sample) value = std::isnan(value) ? INFINITY : value;
    std::ranges::sort(sample);
    return sample[static_cast<std::size_t>(std::ceil(p * static_cast<double>(sample.size()))) - 1];
  }

  int finish(const std::string& title) const {
    fmt::print("{}: realised over requested error\n{:<52}{:>7}{:>9}{:>9}{:>9}{:>6}{:>9}\n", title, "", "cases",
               "median", "90 %", "largest", "seed", "refused");
    bool kept = failures_ == 0 && !rows_.empty();
    nlohmann::json table = nlohmann::json::array();
    for (const auto& [guarantee, ratio, refused] : rows_) {
      nlohmann::json row = {
          {"guarantee", guarantee.name}, {"reference", guarantee.reference}, {"cases", ratio.values.size()}};
      fmt::print("{:<52}{:>7}", guarantee.name, ratio.values.size());
      if (!ratio.values.empty()) {
        const double largest = quantile(ratio.values, 1);
        kept = kept && largest <= 1;
        for (const auto& [name, value] :
             {std::pair{"median", quantile(ratio.values, 0.5)}, std::pair{"90 %", quantile(ratio.values, 0.9)},
              std::pair{"largest", largest}}) {
          fmt::print("{:>9.2g}", value);
          row[name] = std::stod(fmt::format("{:.2g}", value));
        }
        const auto above = std::ranges::count_if(ratio.values, [](double value) { return !(value <= 1); });
        row["above 1"] = above, row["seed"] = ratio.seed;
        fmt::print("{:>6}{:>9}  {}\n", ratio.seed, refused,
                   largest <= 1 ? "PASS" : fmt::format("FAIL ({} above)", above));
      } else {
        fmt::print("{:>42}  FAIL (no case)\n", refused);
        kept = false;
      }
      row["refused"] = refused;
      table.push_back(std::move(row));
    }
    fmt::print("{} failed; {}\n", failures_, kept ? "all guarantees kept" : "a guarantee is broken");
    if (const char* path = std::getenv("LICHTENBERG_FIGURES")) std::ofstream(path) << table.dump(1) << '\n';
    return kept ? 0 : 1;
  }

  std::vector<Row> rows_;
  std::uint64_t seed_ = 0;
  int failures_ = 0;
};

}  // namespace lichtenberg::validation
