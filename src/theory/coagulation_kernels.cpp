#include "src/theory/coagulation_kernels.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "solvers/error.hpp"

namespace lichtenberg::theory {
namespace {

void check_table(const KernelTable& table) {
  const std::size_t n = table.size.size();
  if (n < 2) throw InputError("a table of a kernel needs at least two sizes");
  for (std::size_t i = 0; i < n; ++i)
    if (!(table.size[i] > (i == 0 ? 0 : table.size[i - 1]) && std::isfinite(table.size[i])))
      throw InputError(fmt::format(
          "size {} of the kernel's table is {:g}, which is not allowed: sizes must be positive and ascending", i + 1,
          table.size[i]));
  if (table.value.size() != n)
    throw InputError(fmt::format("the kernel's table has {} rows of values for {} sizes", table.value.size(), n));
  for (std::size_t i = 0; i < n; ++i) {
    if (table.value[i].size() != n)
      throw InputError(
          fmt::format("row {} of the kernel's table has {} values for {} sizes", i + 1, table.value[i].size(), n));
    for (std::size_t j = 0; j < n; ++j)
      if (!(table.value[i][j] > 0 && std::isfinite(table.value[i][j])) ||
          (j < i && table.value[i][j] != table.value[j][i]))
        throw InputError(fmt::format(
            "the kernel's table has the value {:g} for sizes {:g} and {:g}, which is not allowed: values must be "
            "positive, and equal for both orders of two sizes",
            table.value[i][j], table.size[i], table.size[j]));
  }
}

/// Logarithms of a table's sizes and values.
struct LogarithmicTable {
  explicit LogarithmicTable(const KernelTable& table) {
    for (const double size : table.size) log_size.push_back(std::log(size));
    for (const auto& row : table.value) {
      log_value.emplace_back();
      for (const double value : row) log_value.back().push_back(std::log(value));
    }
  }

  /// Returns the index of the interval of a size, and the position in it: 0 to 1 inside the table.
  std::pair<std::size_t, double> position(double size) const {
    const double x = std::log(size);
    const auto above = std::upper_bound(log_size.begin() + 1, log_size.end() - 1, x);
    const std::size_t k = above - log_size.begin() - 1;
    return {k, (x - log_size[k]) / (log_size[k + 1] - log_size[k])};
  }

  double operator()(double i, double j) const {
    const auto [a, u] = position(i);
    const auto [b, v] = position(j);
    return std::exp((1 - u) * ((1 - v) * log_value[a][b] + v * log_value[a][b + 1]) +
                    u * ((1 - v) * log_value[a + 1][b] + v * log_value[a + 1][b + 1]));
  }

  std::vector<double> log_size;
  std::vector<std::vector<double>> log_value;
};

}  // namespace

Kernel brownian_kernel() {
  return [](double i, double j) {
    const double a = std::cbrt(i), b = std::cbrt(j);
    return (a + b) * (1 / a + 1 / b);
  };
}

Kernel power_kernel(double mu, double nu) {
  return [mu, nu](double i, double j) {
    return (std::pow(i, mu) * std::pow(j, nu) + std::pow(i, nu) * std::pow(j, mu)) / 2;
  };
}

Kernel repelled(Kernel kernel, double repulsion) {
  return [kernel = std::move(kernel), repulsion](double i, double j) {
    const double x = 2 * repulsion * i * j / (std::cbrt(i) + std::cbrt(j));
    return kernel(i, j) * (x > 0 ? x / std::expm1(x) : 1);
  };
}

double largest_repelled_size(double repulsion) {
  const double most = 300 * std::log(10.0);
  return std::pow(most / repulsion, 0.6);
}

Kernel table_kernel(KernelTable table) {
  check_table(table);
  return [logarithms = std::make_shared<const LogarithmicTable>(table)](double i, double j) {
    return (*logarithms)(i, j);
  };
}

}  // namespace lichtenberg::theory
