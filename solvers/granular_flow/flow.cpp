#include "solvers/granular_flow/flow.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "solvers/error.hpp"
#include "solvers/granular_flow/rates.hpp"
#include "solvers/ode/ode.hpp"

namespace lichtenberg::granular_flow {
namespace {

void check_grid(const Grid& grid) {
  constexpr int fewest = 6;  // With fewer cells a face would use one cell twice
  if (grid.dimension != 2 && grid.dimension != 3)
    throw InputError(fmt::format("flows of a gas have two or three dimensions, not {}", grid.dimension));
  if (grid.cells < fewest)
    throw InputError(fmt::format("flows of a gas need {} cells along an edge at least, not {}", fewest, grid.cells));
  if (!(grid.length > 0)) throw InputError(fmt::format("the length of a gas is positive, not {}", grid.length));
}

void check_fields(const Grid& grid, const Fields& start) {
  const auto check = [&](const std::vector<double>& values, bool positive) {
    if (values.size() != grid.size())
      throw InputError(fmt::format("a field has {} values, for {} cells", values.size(), grid.size()));
    if (!std::ranges::all_of(values, [&](double v) { return std::isfinite(v) && (v > 0 || !positive); }))
      throw InputError("density and temperature of a gas are positive, and all fields finite");
  };
  check(start.density, true);
  check(start.temperature, true);
  check(start.charge, false);
  for (int axis = 0; axis < grid.dimension; ++axis) check(start.velocity[axis], false);
}

/// Returns the absolute tolerances: that of density is small, so that low densities keep a relative accuracy; the other
/// fields pass through 0.
std::vector<double> absolute_errors(const Grid& grid, int unknowns, double tolerance) {
  std::vector<double> errors(unknowns * grid.size(), tolerance);
  std::fill_n(errors.begin(), grid.size(), 1e-6 * tolerance);
  return errors;
}

}  // namespace

std::size_t Grid::size() const {
  std::size_t size = 1;
  for (int axis = 0; axis < dimension; ++axis) size *= cells;
  return size;
}

Fields homogeneous(const Grid& grid) {
  const std::vector<double> one(grid.size(), 1.0), none(grid.size(), 0.0);
  Fields fields{one, one, one, {}};
  std::fill_n(fields.velocity.begin(), grid.dimension, none);
  return fields;
}

std::vector<Fields> evolve(const Gas& gas, const Grid& grid, const Fields& start, std::span<const double> times,
                           const EvolveOptions& options, parallel::Team& team) {
  check_grid(grid);
  check_fields(grid, start);
  Rates rates(gas, grid, team);
  const auto reported_rates = [&](double time, std::span<const double> y, std::span<double> rate) {
    if (options.report) options.report(time);
    rates(time, y, rate);
  };
  const Ode ode{.rates = reported_rates,
                .absolute = absolute_errors(grid, rates.unknowns(), options.tolerance),
                .relative = options.tolerance,
                .stiff = true};
  std::vector<Fields> found;
  for (const auto& y : integrate(ode, 0, rates.pack(start), times)) found.push_back(rates.unpack(y));
  return found;
}

}  // namespace lichtenberg::granular_flow
