#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>
#include <sstream>

#include "solvers/error.hpp"
#include "src/analysis/gas_growth.hpp"
#include "src/commands/theory_kind.hpp"
#include "src/theory/coagulation_kernels.hpp"

namespace lichtenberg {
namespace {

/// Returns the numbers of a text that are separated by commas. Throws InputError with `origin` for anything else.
std::vector<double> numbers_of(const std::string& text, const std::string& origin) {
  std::vector<double> numbers;
  std::stringstream words(text);
  for (std::string word; std::getline(words, word, ',');) {
    const auto first = word.find_first_not_of(" \t"), last = word.find_last_not_of(" \t\r");
    if (first != std::string::npos) word = word.substr(first, last - first + 1);
    double number = 0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), number);
    if (error != std::errc() || end != word.data() + word.size() || !std::isfinite(number))
      throw InputError(fmt::format("{}: \"{}\" is no number", origin, word));
    numbers.push_back(number);
  }
  return numbers;
}

/// Reads a kernel's table: n sizes in the first line, and n values in each of n further lines, separated by commas.
theory::Kernel kernel_in_file(const std::string& path) {
  std::ifstream file(path);
  if (!file) throw InputError(path + " cannot be read: --kernel names a kernel or a CSV file with its values");
  theory::KernelTable table;
  int count = 0;
  for (std::string line; std::getline(file, line);) {
    ++count;
    if (line.find_first_not_of(" \t\r") == std::string::npos) continue;
    std::vector<double> numbers = numbers_of(line, fmt::format("{}, line {}", path, count));
    if (table.size.empty())
      table.size = std::move(numbers);
    else
      table.value.push_back(std::move(numbers));
  }
  try {
    return theory::table_kernel(std::move(table));
  } catch (const InputError& error) {
    throw InputError(path + ": " + error.what());
  }
}

theory::Kernel kernel_named(const std::string& name) {
  const std::string power = "power:";
  if (name == "brownian") return theory::brownian_kernel();
  if (!name.starts_with(power)) return kernel_in_file(name);
  const std::vector<double> exponents = numbers_of(name.substr(power.size()), "--kernel " + name);
  if (exponents.size() != 2)
    throw InputError("--kernel " + name + " is not allowed: it must have two exponents, as power:1,0");
  for (const double exponent : exponents)
    if (std::abs(exponent) > 3)
      throw InputError(fmt::format("--kernel {} is not allowed: exponents must be from -3 to 3", name));
  return theory::power_kernel(exponents[0], exponents[1]);
}

void check_coagulation(const TheoryOptions& options) {
  if (options.kernel.empty() && (options.repulsion || options.until))
    throw InputError(fmt::format("{} needs --kernel: it belongs to a kernel of your choice",
                                 options.repulsion ? "--repulsion" : "--until"));
  if (options.repulsion && !(*options.repulsion > 1e-9 && *options.repulsion <= 100))
    throw InputError(
        fmt::format("--repulsion {:g} is not allowed: it must be above 1e-9 and at most 100", *options.repulsion));
  if (options.until && !(*options.until >= 0.1 && *options.until <= 1e200))
    throw InputError(fmt::format("--until {:g} is not allowed: it must be from 0.1 to 1e200", *options.until));
}

}  // namespace

TheoryAnswer kernel_growth(const TheoryOptions& options) {
  check_coagulation(options);
  theory::Kernel kernel = kernel_named(options.kernel);
  theory::CoagulationOptions limits;
  if (options.repulsion) {
    kernel = theory::repelled(kernel, *options.repulsion);
    // Two aggregates of the largest size that still merge yield twice this size.
    limits.largest = std::clamp(2 * theory::largest_repelled_size(*options.repulsion), 100.0, limits.largest);
    limits.stiff = true, limits.tolerance = 1e-3;
  }
  const double first = 0.01, last = options.until.value_or(1e3);
  const std::vector<double> times = logarithmic_range(first, last, 1 + static_cast<int>(16 * std::log10(last / first)));
  const theory::CoagulationSeries series = theory::coagulation_series(kernel, times, limits);
  std::vector<double> size = series.size, number = series.number, width = series.relative_width();
  if (size.empty()) throw Failure("coagulation with this kernel loses mass at once");
  std::vector<double> slope = analysis::local_slopes(std::span(times).first(size.size()), size);
  TheoryAnswer answer{"smoluchowski", "Coagulation with the kernel " + options.kernel, {}, {}};
  answer.figures = {
      {"last_time", "1", times[size.size() - 1], "until which all mass is in finite sizes"},
      {"last_size", "1", size.back(), "S then"},
      {"last_width", "1", width.back(), "standard deviation of the sizes over their mean then"},
      {"lost", "1", series.lost, fmt::format("share of the mass that grew beyond {:.4g} grains", limits.largest)},
      {"error", "1", series.error,
       fmt::format("relative error of S by the size classes, estimated (ratio {:g}, extrapolated)", series.ratio)}};
  for (auto* column : {&size, &number, &width, &slope}) column->resize(times.size(), NAN);
  answer.tables = {
      {.name = "growth",
       .title = "coagulation from single grains, in units of the kernel",
       .columns = {{"time", "1", "time", times},
                   {"size", "1", "S", size},
                   {"number", "1", "aggregates by initial grain", number},
                   {"width", "1", "relative width", width},
                   {"slope", "1", "d ln S / d ln t", slope}},
       .panels = {{"S", true, {"size"}}, {"relative width", false, {"width"}}, {"d ln S / d ln t", false, {"slope"}}}}};
  return answer;
}

}  // namespace lichtenberg
