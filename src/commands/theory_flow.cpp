#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <functional>
#include <iterator>
#include <numbers>

#include "solvers/error.hpp"
#include "solvers/granular_flow/flow.hpp"
#include "solvers/random.hpp"
#include "src/commands/progress.hpp"
#include "src/commands/theory_kind.hpp"
#include "src/record/vtkhdf.hpp"

namespace lichtenberg {
namespace {

using granular_flow::Fields;
using granular_flow::Grid;
using std::numbers::pi;
using Complex = std::complex<double>;
using Wave = std::array<int, 3>;

/// Parameters of a gas and a grid for the hydrodynamic equations.
struct FlowRequest {
  double restitution = 0, charge_number = 0;
  double length = 0;          ///< edge of the box, l_0
  double grains = 0;          ///< number of grains that determines the thermal noise
  double end = 0;             ///< t_0 at the start
  bool charges_last = false;  ///< constant charges; otherwise they fade as the thermal speed (G 6.29)
  bool separated = false;     ///< separate regions of either sign (G A5.3); otherwise homogeneous
  int dimension = 2, cells = 0;
  std::uint64_t seed = 1;
  /// Called with the present and last time, in the gas's own time
  std::function<void(double scaled_time, double end)> at = {};
};

constexpr int rows = 60;                   // of the time series
constexpr double first_map_time = 3.48e2;  // t_0, time of G A5.3 (a)
constexpr int max_noise_waves = 3;         // largest wave number of the initial noise, in waves per box edge
constexpr std::array<int, 2> most_flow_cells{1024, 128};  // per edge, in a plane and in space
constexpr double tolerance = 1e-4;                        // of a time step

void check_flow(const FlowRequest& r) {
  if (!(r.restitution > 0 && r.restitution < 1))
    throw InputError(
        fmt::format("theory hydrodynamics is for a gas that cools, of a restitution coefficient in (0, 1), not of {:g}",
                    r.restitution));
  if (!(r.charge_number >= 0 && r.charge_number <= 100))
    throw InputError(
        fmt::format("theory hydrodynamics is for a charge number R in [0, 100], not for {:g}", r.charge_number));
  if (!(r.length >= 10))
    throw InputError(
        fmt::format("theory hydrodynamics is for boxes of 10 l_0 and more, not of {:.3g} l_0 (l_0 = .12467 / (n d^2) "
                    "for the number density n and the diameter d, about half a mean free path)",
                    r.length));
  const int most = most_flow_cells[r.dimension - 2];
  if (r.cells < 8 || r.cells > most)
    throw InputError(fmt::format("--cells is for 8 to {} cells along an edge, not for {}", most, r.cells));
}

/// Conversion between t and the gas's own time: dtau = dt v_h(t)/l_0 with Haff's v_h, in units of the start.
double scaled_time_at(double cooling, double t) { return 4 / cooling * std::log1p(cooling / 4 * t); }
double time_of(double cooling, double scaled_time) { return std::expm1(cooling / 4 * scaled_time) * 4 / cooling; }

/// Returns the centre of a cell as a fraction of the edge, times 2 pi.
std::array<double, 3> angles(const Grid& grid, std::size_t cell) {
  std::array<double, 3> x{};
  for (int axis = grid.dimension - 1; axis >= 0; --axis, cell /= grid.cells)
    x[axis] = 2 * pi * (static_cast<double>(cell % grid.cells) + 0.5) / grid.cells;
  return x;
}

double phase(const Wave& wave, const std::array<double, 3>& x) {
  return wave[0] * x[0] + wave[1] * x[1] + wave[2] * x[2];
}

int square(const Wave& wave) { return wave[0] * wave[0] + wave[1] * wave[1] + wave[2] * wave[2]; }

/// Returns one of each pair k, -k with at most `most` waves per box edge.
std::vector<Wave> waves(int dimension, int most) {
  std::vector<Wave> found;
  const int deep = dimension == 3 ? most : 0;
  for (int x = 0; x <= most; ++x)
    for (int y = -most; y <= most; ++y)
      for (int z = -deep; z <= deep; ++z)
        if (const Wave wave{x, y, z}; wave > Wave{} && square(wave) <= most * most) found.push_back(wave);
  return found;
}

/// Adds a wave of noise to a field: random cosine and sine with this variance of the field's mode.
void add_noise(std::vector<double>& field, const Grid& grid, const Wave& wave, double variance, Random& random) {
  const double cosine = std::sqrt(2 * variance) * random.normal(), sine = std::sqrt(2 * variance) * random.normal();
  for (std::size_t cell = 0; cell < field.size(); ++cell) {
    const double p = phase(wave, angles(grid, cell));
    field[cell] += cosine * std::cos(p) + sine * std::sin(p);
  }
}

/// Returns a homogeneous gas with thermal noise of N grains: <|n_k|^2> = 1/N, <|T_k|^2> = 2/(3N), <|u_k|^2> = 1/(2N)
/// per component.
Fields disturbed(const FlowRequest& request, const Grid& grid) {
  Fields fields = granular_flow::homogeneous(grid);
  const auto key = [](int n) { return static_cast<std::uint64_t>(n + max_noise_waves); };
  for (const Wave& wave : waves(grid.dimension, max_noise_waves)) {
    Random random({.seed = request.seed,
                   .purpose = RandomPurpose::flow,
                   .i = key(wave[0]),
                   .j = key(wave[1]),
                   .count = key(wave[2])});
    add_noise(fields.density, grid, wave, 1 / request.grains, random);
    add_noise(fields.temperature, grid, wave, 2 / (3 * request.grains), random);
    for (int axis = 0; axis < grid.dimension; ++axis)
      add_noise(fields.velocity[axis], grid, wave, 1 / (2 * request.grains), random);
  }
  const auto least = std::min(std::ranges::min(fields.density), std::ranges::min(fields.temperature));
  if (least <= 0)
    throw InputError(
        fmt::format("the thermal noise of {:g} grains makes the density or temperature of a cell zero or negative: "
                    "theory hydrodynamics needs more grains",
                    request.grains));
  fields.charge = fields.density;
  if (request.separated)
    for (std::size_t cell = 0; cell < grid.size(); ++cell) {
      const auto x = angles(grid, cell);
      fields.charge[cell] = std::cos(x[0]) * std::cos(x[1]);
    }
  return fields;
}

/// Amplitudes of a wave: density, temperature, i times the longitudinal velocity; squared transverse velocity.
struct Mode {
  theory::Disturbance along;
  double across = 0;
};

Mode mode_of(const Fields& fields, const Grid& grid, const Wave& wave) {
  Mode mode;
  std::array<Complex, 3> velocity{};
  for (std::size_t cell = 0; cell < grid.size(); ++cell) {
    const Complex p = std::polar(1 / static_cast<double>(grid.size()), -phase(wave, angles(grid, cell)));
    mode.along.density += p * fields.density[cell];
    mode.along.temperature += p * fields.temperature[cell];
    for (int axis = 0; axis < grid.dimension; ++axis) velocity[axis] += p * fields.velocity[axis][cell];
  }
  Complex along = 0;
  for (int axis = 0; axis < grid.dimension; ++axis) along += velocity[axis] * static_cast<double>(wave[axis]);
  along /= std::sqrt(square(wave));
  mode.along.speed = Complex(0, 1) * along;
  for (const Complex& u : velocity) mode.across += std::norm(u);
  mode.across -= std::norm(along);
  return mode;
}

/// Rms amplitudes over all waves of one length, of density and transverse velocity: computed and by linear theory.
struct WaveGrowth {
  std::vector<double> density, across, linear_density, linear_across;
};

WaveGrowth wave_growth(const FlowRequest& request, const Grid& grid, const theory::TransportCoefficients& c,
                       std::span<const double> times, const std::vector<Fields>& states, int length) {
  WaveGrowth growth{std::vector(times.size(), 0.0), std::vector(times.size(), 0.0), std::vector(times.size(), 0.0),
                    std::vector(times.size(), 0.0)};
  const double k = 2 * pi / grid.length * std::sqrt(length);
  const double shear = c.cooling / 4 - c.viscosity * k * k;
  for (const Wave& wave : waves(grid.dimension, 2)) {
    if (square(wave) != length) continue;
    const Mode start = mode_of(states[0], grid, wave);
    const auto linear = theory::disturbance_evolution(c, request.separated ? 0 : request.charge_number,
                                                      request.charges_last, k, start.along, times);
    for (std::size_t n = 0; n < times.size(); ++n) {
      const Mode now = mode_of(states[n], grid, wave);
      growth.density[n] += std::norm(now.along.density);
      growth.across[n] += now.across;
      growth.linear_density[n] += std::norm(linear[n].density);
      growth.linear_across[n] += start.across * std::exp(2 * shear * times[n]);
    }
  }
  for (auto* values : {&growth.density, &growth.across, &growth.linear_density, &growth.linear_across})
    for (double& value : *values) value = std::sqrt(2 * value);
  return growth;
}

/// Adds the growth of the longest waves and of those along the diagonal of a square.
void add_growth(TheoryTable& table, const FlowRequest& request, const Grid& grid,
                const theory::TransportCoefficients& c, std::span<const double> times,
                const std::vector<Fields>& states) {
  for (const int length : {1, 2}) {
    const WaveGrowth growth = wave_growth(request, grid, c, times, states, length);
    const std::string k = fmt::format("k = {:.3g}", 2 * pi / grid.length * std::sqrt(length));
    const auto show = [&](int panel, const std::string& name, const std::string& label,
                          const std::vector<double>& values) {
      add(table, panel, {fmt::format("{}_{}", name, length), "1", label, values});
    };
    show(2, "density", k, growth.density);
    if (!request.separated) show(2, "linear_density", k + ", linear", growth.linear_density);
    show(3, "shear", k, growth.across);
    show(3, "linear_shear", k + ", linear", growth.linear_across);
  }
}

double square_speed(const Fields& fields, int dimension, std::size_t cell) {
  double sum = 0;
  for (int axis = 0; axis < dimension; ++axis) sum += fields.velocity[axis][cell] * fields.velocity[axis][cell];
  return sum;
}

TheoryTable time_series_table(const FlowRequest& request, const Grid& grid, const theory::TransportCoefficients& c,
                              const std::vector<double>& times, const std::vector<Fields>& states) {
  TheoryTable table{.name = "course",
                    .title = "the gas over its own time",
                    .columns = {{"own_time", "1", R"($\tau$)", times}, {"time", "t_0", "time", {}}},
                    .panels = {{R"(T and $u^2$ over Haff's T)", true, {}},
                               {"density", true, {}},
                               {"rms waves of density", true, {}},
                               {"rms waves of shear", true, {}}},
                    .logarithmic = false};
  for (const double scaled_time : times) table.columns[1].values.push_back(time_of(c.cooling, scaled_time));
  TheoryColumn temperature{"temperature", "1", "T, mean of grains", {}}, flow{"flow", "1", R"($u^2$)", {}},
      coldest{"coldest", "1", "least T", {}}, densest{"densest", "1", "most", {}},
      thinnest{"thinnest", "1", "least", {}};
  for (const Fields& fields : states) {
    double heat = 0, motion = 0, mass = 0;
    for (std::size_t cell = 0; cell < grid.size(); ++cell) {
      mass += fields.density[cell];
      heat += fields.density[cell] * fields.temperature[cell];
      motion += fields.density[cell] * square_speed(fields, grid.dimension, cell);
    }
    temperature.values.push_back(heat / mass);
    flow.values.push_back(motion / mass);
    coldest.values.push_back(std::ranges::min(fields.temperature));
    densest.values.push_back(std::ranges::max(fields.density));
    thinnest.values.push_back(std::ranges::min(fields.density));
  }
  for (const TheoryColumn& column : {temperature, flow, coldest}) add(table, 0, column);
  for (const TheoryColumn& column : {densest, thinnest}) add(table, 1, column);
  add_growth(table, request, grid, c, times, states);
  return table;
}

/// Returns a plane of a field; in space, the middle plane.
std::vector<double> plane_of(const std::vector<double>& field, const Grid& grid) {
  const std::size_t plane = static_cast<std::size_t>(grid.cells) * grid.cells;
  const std::size_t first = grid.dimension == 3 ? grid.cells / 2 * plane : 0;
  return {field.begin() + first, field.begin() + first + plane};
}

TheoryMaps maps_of(const Fields& fields, const Grid& grid, double scaled_time, double time) {
  std::vector<double> speed;
  for (std::size_t cell = 0; cell < grid.size(); ++cell)
    speed.push_back(std::sqrt(square_speed(fields, grid.dimension, cell)));
  return {fmt::format("t/t_0 = {:.3g}, own time {:.3g}", time, scaled_time),
          grid.cells,
          grid.length,
          {{"density", "density", true, plane_of(fields.density, grid)},
           {"charge", "charge density", false, plane_of(fields.charge, grid)},
           {"temperature", "temperature", true, plane_of(fields.temperature, grid)},
           {"speed", "speed", false, plane_of(speed, grid)}}};
}

/// Returns the fields on a lattice. Their last dimension is x.
Lattice lattice_of(const Fields& fields, const Grid& grid) {
  Lattice lattice{.points = {grid.cells, grid.cells, grid.dimension == 3 ? grid.cells : 1}, .spacing = grid.step()};
  std::vector<double> velocity;
  for (std::size_t cell = 0; cell < grid.size(); ++cell)
    for (int axis = 2; axis >= 0; --axis) velocity.push_back(axis < grid.dimension ? fields.velocity[axis][cell] : 0);
  if (grid.dimension == 2)  // to x, y and zero out of the plane
    for (std::size_t cell = 0; cell < grid.size(); ++cell)
      std::rotate(&velocity[3 * cell], &velocity[3 * cell + 1], &velocity[3 * cell] + 3);
  lattice.values = {{"density", "n_0", 1, fields.density},
                    {"charge", "rho_0", 1, fields.charge},
                    {"temperature", "T_h", 1, fields.temperature},
                    {"velocity", "v_h", 3, velocity}};
  return lattice;
}

/// Returns evenly spaced times; the nearest to the source's first picture is moved to it if that is before the end.
std::vector<double> scaled_times(double cooling, double end) {
  std::vector<double> times;
  const double last = scaled_time_at(cooling, end), first = scaled_time_at(cooling, first_map_time);
  for (int k = 0; k <= rows; ++k) times.push_back(last * k / rows);
  if (first < last) *std::ranges::min_element(times, {}, [&](double t) { return std::abs(t - first); }) = first;
  return times;
}

/// Returns the rows of the pictures: the source's first or a third of the time, halfway from there to the end, the end.
std::array<std::size_t, 3> pictured(const std::vector<double>& times, double cooling) {
  const auto exact = std::ranges::find(times, scaled_time_at(cooling, first_map_time));
  const std::size_t first = exact == times.end() ? rows / 3 : exact - times.begin();
  return {first, (first + rows) / 2, rows};
}

std::vector<TheoryFigure> flow_figures(const FlowRequest& request, const theory::TransportCoefficients& c) {
  std::vector<TheoryFigure> figures = {
      {"restitution", "1", request.restitution, "the same for all collisions"},
      {"charge_number", "1", request.charge_number,
       request.charges_last ? "R = 2 pi K n q^2 l_0^2 / T at the start; charges last, so that it grows"
                            : "R = 2 pi K n q^2 l_0^2 / T, which stays: charges fade as the thermal speed does"},
      {"length", "l_0", request.length,
       fmt::format("of the box, in {} dimensions, {} cells", request.dimension, request.cells)},
      {"least_wave_number", "1/l_0", 2 * pi / request.length, "of the longest waves"}};
  add_critical(figures, c, request.separated ? 0 : request.charge_number);
  return figures;
}

const TheoryColumn& column_of(const TheoryTable& table, const std::string& name) {
  return *std::ranges::find(table.columns, name, &TheoryColumn::name);
}

/// Returns the largest relative change of a column on a grid with twice the cell length.
TheoryFigure grid_change(const TheoryTable& fine, const TheoryTable& coarse, const std::string& name,
                         const std::string& meaning) {
  const std::vector<double>&values = column_of(fine, name).values, &others = column_of(coarse, name).values;
  double most = 0;
  for (std::size_t k = 0; k < values.size(); ++k) most = std::max(most, std::abs(others[k] / values[k] - 1));
  return {"grid_change_" + name, "1", most, "the most that " + meaning + " changes on half the cells along an edge"};
}

/// Compares the result with one on half the cells per edge. Empty if these are too few or the computation fails on
/// them.
std::vector<TheoryFigure> grid_changes(const FlowRequest& request, const granular_flow::Gas& gas,
                                       const theory::TransportCoefficients& c, const std::vector<double>& times,
                                       const TheoryTable& fine) {
  constexpr int fewest = 8;
  if (request.cells < 2 * fewest) return {};
  const Grid half{request.dimension, request.cells / 2, request.length};
  try {
    const auto states = granular_flow::evolve(gas, half, disturbed(request, half), times, {.tolerance = tolerance});
    const TheoryTable coarse = time_series_table(request, half, c, times, states);
    return {grid_change(fine, coarse, "temperature", "T"), grid_change(fine, coarse, "densest", "the largest density")};
  } catch (const Failure&) {
    return {};
  }
}

/// Returns the time series with maps. `last` receives the final fields.
TheoryAnswer flow_theory(const FlowRequest& request, Lattice& last) {
  check_flow(request);
  const theory::TransportCoefficients c = theory::transport_coefficients(request.restitution);
  const granular_flow::Gas gas{
      c.cooling, c.viscosity, c.conduction, c.density_conduction, request.charge_number, request.charges_last};
  const Grid grid{request.dimension, request.cells, request.length};
  const std::vector<double> times = scaled_times(c.cooling, request.end);
  const auto at = [&](double scaled_time) {
    if (request.at) request.at(scaled_time, times.back());
  };
  const auto states = granular_flow::evolve(gas, grid, disturbed(request, grid), times, {tolerance, at});
  TheoryAnswer answer{"hydrodynamics",
                      "Hydrodynamic equations of a charged gas that cools (G 6.26, corrected)",
                      flow_figures(request, c),
                      {time_series_table(request, grid, c, times, states)}};
  const TheoryTable& table = answer.tables[0];
  answer.figures.push_back(
      {"end", "t_0", table.columns[1].values.back(), fmt::format("own time {:.4g}", times.back())});
  std::ranges::copy(grid_changes(request, gas, c, times, table), std::back_inserter(answer.figures));
  for (const std::size_t k : pictured(times, c.cooling))
    answer.maps.push_back(maps_of(states[k], grid, times[k], table.columns[1].values[k]));
  last = lattice_of(states.back(), grid);
  return answer;
}

TheoryAnswer answer_to(const TheoryRequest& request) {
  const GasParameters& gas = *request.gas;
  const TheoryOptions& options = request.options;
  const auto [eps, charged] = stability_numbers(request);
  const double unit = theory::hydrodynamic_length(gas.density);
  const double last_map_time = 1.19e12;  // t_0, time of G A5.3 (b)
  Lattice last;
  std::optional<Progress> progress;  // shown on a terminal only
  const auto at = [&](double scaled_time, double end) {
    if (!progress) progress.emplace(0, end, !isatty(STDERR_FILENO));
    if (progress->due()) progress->show(fmt::format("own time {:.1f} of {:.1f}", scaled_time, end), scaled_time);
  };
  const TheoryAnswer answer =
      flow_theory({.restitution = eps,
                   .charge_number = charged,
                   .length = std::cbrt(gas.grains / gas.density) / unit,
                   .grains = gas.grains,
                   .end = request.gas_is_given ? gas.end * std::sqrt(2 * gas.temperature) / unit : last_map_time,
                   .charges_last = request.gas_is_given,
                   .separated = options.separated,
                   .dimension = options.space ? 3 : 2,
                   .cells = options.cells.value_or(options.space ? 24 : 32),
                   .seed = static_cast<std::uint64_t>(options.seed.value_or(1)),
                   .at = at},
                  last);
  if (!options.field.empty()) write_lattice_vtkhdf(options.field, last);
  return answer;
}

}  // namespace

TheoryKind hydrodynamics_kind() {
  return {.name = "hydrodynamics",
          .answer = answer_to,
          .usual_gas = source_gas,
          .options = {"--restitution", "--charge-number", "--cells", "--seed", "--space", "--separated", "--field"}};
}

}  // namespace lichtenberg
