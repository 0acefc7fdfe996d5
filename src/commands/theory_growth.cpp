#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <tuple>

#include "solvers/error.hpp"
#include "src/analysis/gas_growth.hpp"
#include "src/commands/theory_kind.hpp"
#include "src/theory/smoluchowski.hpp"

namespace lichtenberg {
namespace {

/// Mean aggregate size S for a kernel of the source over these times; NaN from where mass leaves the computed sizes.
struct Growth {
  theory::CoagulationSeries series;
  std::vector<double> size, slope;
  analysis::ShiftedPower fit;
  double fitted_from = 0, fitted_to = 0;
};

Growth growth_of(double beta, const std::vector<double>& times) {
  constexpr double first_fitted = 10;  // smaller S depends on the initial state
  Growth growth{.series = theory::coagulation_series(theory::flight_kernel(beta), times)};
  growth.size = growth.series.size;
  const std::size_t found = growth.size.size();
  growth.slope = analysis::local_slopes(std::span(times).first(found), growth.size);
  const auto from = static_cast<std::size_t>(std::ranges::lower_bound(growth.size, first_fitted) - growth.size.begin());
  const auto fit =
      analysis::fit_growth(std::span(times).subspan(from, found - from), std::span(growth.size).subspan(from));
  if (!fit) throw Failure("the growth of aggregates has no power law to fit");
  growth.fit = *fit;
  growth.fitted_from = growth.size[from], growth.fitted_to = growth.size.back();
  growth.size.resize(times.size(), NAN), growth.slope.resize(times.size(), NAN);
  return growth;
}

TheoryFigure error_figure(const std::string& name, double error, double ratio) {
  return {name, "1", error,
          fmt::format("relative error of S by the size classes, estimated (ratio {:g}, extrapolated)", ratio)};
}

/// Adds coagulation in the time of a gas, with bound clusters of a run.
void add_paced(TheoryAnswer& answer, const GasParameters& gas, const GasTimeSeries* run) {
  const std::vector<double> times = times_until(gas.end);
  const auto states = merging_states(gas, times);
  TheoryTable table{.name = "paced",
                    .title = "the same by the gas's time, at the coalescence rate of kinetic theory",
                    .columns = {{"time", "t0", "time", times}},
                    .panels = {{"S", true, {}}, {"aggregates by initial grain", true, {}}}};
  for (const double beta : {2.0, 3.0}) {
    const PacedGrowth growth = paced_growth(beta, gas, states);
    const std::string kind = beta == 2 ? "neutral" : "charged", label = fmt::format(R"($\beta$ = {:g})", beta);
    answer.figures.push_back(error_figure("paced_error_" + kind, growth.error, growth.ratio));
    table.columns.push_back({"paced_size_" + kind, "1", label, growth.size});
    table.columns.push_back({"paced_number_" + kind, "1", label, growth.number});
    table.panels[0].columns.push_back("paced_size_" + kind);
    table.panels[1].columns.push_back("paced_number_" + kind);
  }
  if (run) {
    run->show(table, "paced_size_neutral", "analysis/mean_bound_cluster", "run: bound clusters");
    run->show(table, "paced_number_neutral", "analysis/bound_clusters", "run: bound clusters", 1 / gas.grains);
  }
  answer.tables.push_back(table);
}

std::vector<double> linear_range(double last, int count) {
  std::vector<double> range;
  for (int k = 1; k <= count; ++k) range.push_back(last * k / count);
  return range;
}

void add_modes(TheoryTable& table, const std::string& suffix, const std::string& label,
               const std::vector<theory::Modes>& modes) {
  for (int n = 0; n < 3; ++n)
    for (const bool imaginary : {false, true}) {
      const auto part = [&](const theory::Modes& mode) {
        return imaginary ? mode.longitudinal[n].imag() : mode.longitudinal[n].real();
      };
      const TheoryColumn column{fmt::format("{}{}{}", imaginary ? "frequency" : "growth", n + 1, suffix), "1/t_0",
                                label, values_of(modes, part)};
      if (!imaginary) table.panels[0].columns.push_back(column.name);
      table.columns.push_back(column);
    }
}

TheoryTable modes_table(const theory::TransportCoefficients& c, double charge_number) {
  const std::vector<double> k = linear_range(0.3, 200);
  TheoryTable table{.name = "modes",
                    .title = "growth rates by wave number",
                    .columns = {{"wave_number", "1/l_0", "k", k}},
                    .panels = {{"growth rate", false, {}}},
                    .logarithmic = false};
  add_modes(table, "_neutral", "R = 0", theory::growth_rates(c, 0, k));
  if (charge_number > 0)
    add_modes(table, "", fmt::format("R = {:g}", charge_number), theory::growth_rates(c, charge_number, k));
  add(table, 0, {"shear", "1/t_0", "shear", values_of(theory::growth_rates(c, 0, k), &theory::Modes::shear)});
  return table;
}

/// Returns the largest critical wave number of sound modes (`oscillates`) or of the heat mode; NaN if there is none.
double largest_wave(const std::vector<theory::CriticalWave>& waves, bool oscillates) {
  double largest = NAN;
  for (const theory::CriticalWave& wave : waves)
    if (wave.oscillates == oscillates) largest = wave.wave_number;
  return largest;
}

TheoryTable critical_table(const theory::TransportCoefficients& c, double eps) {
  TheoryTable table{.name = "critical", .title = "wave numbers below which modes grow, by charge (G 6.3)"};
  TheoryColumn charge{"charge_by_loss", "1", R"(R / |$\epsilon^2$ - 1|)", {}}, number{"charge_number", "1", "R", {}},
      heat{"heat", "1/l_0", "heat mode", {}}, sound{"sound", "1/l_0", "sound modes", {}};
  for (const double r : logarithmic_range(1e-4, 10, 51)) {
    const auto waves = theory::critical_waves(c, r);
    number.values.push_back(r);
    charge.values.push_back(eps < 1 ? r / (1 - eps * eps) : NAN);
    heat.values.push_back(largest_wave(waves, false));
    sound.values.push_back(largest_wave(waves, true));
  }
  table.columns = {charge, number, heat, sound};
  table.panels = {{"critical wave number", false, {"heat", "sound"}}};
  return table;
}

TheoryAnswer smoluchowski_theory(const GasParameters* gas, const GasTimeSeries* run) {
  const std::vector<double> times = logarithmic_range(0.01, 2e3, 80);
  TheoryAnswer answer{"smoluchowski", "Coagulation of aggregates in flight (G 4.12, 4.13)", {}, {}};
  TheoryTable table{.name = "growth",
                    .title = "S = sum s^2 N_s / sum s N_s over time, in units of the kernel",
                    .columns = {{"time", "1", "time", times}},
                    .panels = {{"S", true, {"size_neutral", "size_charged"}},
                               {"d ln S / d ln t", false, {"slope_neutral", "slope_charged"}}}};
  for (const double beta : {2.0, 3.0}) {
    const std::string kind = beta == 2 ? "neutral" : "charged", label = fmt::format(R"($\beta$ = {:g})", beta);
    const Growth growth = growth_of(beta, times);
    table.columns.push_back({"size_" + kind, "1", label, growth.size});
    table.columns.push_back({"slope_" + kind, "1", label, growth.slope});
    answer.figures.push_back({"exponent_" + kind, "1", theory::flight_exponent(beta),
                              fmt::format("z of beta = {:g}, at t -> infinity", beta)});
    answer.figures.push_back({"fitted_exponent_" + kind, "1", growth.fit.exponent,
                              fmt::format("of S = a (t + t_0)^z from S = {:.3g} to {:.3g}, t_0 = {:.4g}",
                                          growth.fitted_from, growth.fitted_to, growth.fit.shift)});
    answer.figures.push_back(
        {"lost_" + kind, "1", growth.series.lost, "share of the mass that grew beyond a million grains"});
    answer.figures.push_back(error_figure("error_" + kind, growth.series.error, growth.series.ratio));
  }
  answer.tables = {table};
  if (gas && gas->exchange && gas->coupling > 0) add_paced(answer, *gas, run);
  return answer;
}

TheoryAnswer stability_theory(double eps, double charge_number) {
  if (!(charge_number >= 0 && charge_number < 1e6))
    throw InputError(fmt::format("theory stability is for a charge number R in [0, 1e6), not for {:g}", charge_number));
  const theory::TransportCoefficients c = theory::transport_coefficients(eps);
  TheoryAnswer answer{"stability", "Linear stability of a homogeneous gas (G chapter 6)", {}, {}};
  answer.figures = {{"restitution", "1", eps, ""},
                    {"charge_number", "1", charge_number, "R = 2 pi K n q^2 l_0^2 / T"},
                    {"zeta", "1", c.cooling, "zeta*, by which it cools"},
                    {"eta", "1", c.viscosity, "eta*, viscosity"},
                    {"kappa", "1", c.conduction, "kappa*, heat conduction by temperature"},
                    {"mu", "1", c.density_conduction, "mu*, heat conduction by density"}};
  add_critical(answer.figures, c, charge_number);
  // Roots zeta/8 +- sqrt(zeta^2/64 - R): charge oscillates unless the gas cools faster.
  const double slow = c.cooling * c.cooling / 64 - charge_number;
  if (charge_number > 0)
    answer.figures.push_back(
        {"growth_at_zero", "1/t_0", c.cooling / 8 + std::sqrt(std::max(0.0, slow)),
         fmt::format("of {} as k -> 0, since velocities are measured in a thermal speed that falls",
                     slow < 0 ? "charged sound" : "the flow of charge, too slow to oscillate,")});
  answer.tables = {modes_table(c, charge_number), critical_table(c, eps)};
  return answer;
}

}  // namespace

void add_critical(std::vector<TheoryFigure>& figures, const theory::TransportCoefficients& c, double charge_number) {
  figures.push_back({"critical_shear", "1/l_0", theory::critical_shear(c), "below it shear grows"});
  for (const theory::CriticalWave& wave : theory::critical_waves(c, charge_number))
    figures.push_back({"critical", "1/l_0", wave.wave_number,
                       wave.oscillates ? "where sound modes begin to grow or cease to"
                                       : "where the heat mode begins to grow or ceases to"});
}

PacedGrowth paced_growth(double beta, const GasParameters& gas, const std::vector<theory::KineticState>& states) {
  std::vector<double> times;
  for (const theory::KineticState& state : states) {
    const double now = theory::flight_time(beta, gas.density / state.density);
    // guards against rounding before the first coalescence
    times.push_back(std::max(now, times.empty() ? 0.0 : times.back()));
  }
  const theory::CoagulationSeries found = theory::coagulation_series(theory::flight_kernel(beta), times);
  PacedGrowth growth{found.number, found.size, found.error, found.ratio};
  growth.number.resize(times.size(), NAN), growth.size.resize(times.size(), NAN);
  return growth;
}

TheoryKind smoluchowski_kind() {
  return {.name = "smoluchowski",
          .answer =
              [](const TheoryRequest& request) {
                const TheoryOptions& options = request.options;
                if (!options.kernel.empty() || options.repulsion || options.until) {
                  if (request.gas_is_given) throw InputError("--kernel needs no gas: leave --scene or the result out");
                  return kernel_growth(options);
                }
                return smoluchowski_theory(request.gas ? &*request.gas : nullptr, request.run);
              },
          .options = {"--kernel", "--repulsion", "--until"}};
}

std::pair<double, double> stability_numbers(const TheoryRequest& request) {
  double eps = 0.7, charged = 0.9;
  if (request.gas_is_given) {
    const GasParameters& gas = *request.gas;
    eps = mean_restitution(gas);
    // The mean charge is 0 if grains exchange charge.
    charged = gas.exchange ? 0 : theory::charge_number(gas.coupling, gas.density, gas.mean_charge, gas.temperature);
  }
  return {request.options.restitution.value_or(eps), request.options.charge_number.value_or(charged)};
}

TheoryKind stability_kind() {
  return {
      .name = "stability",
      .answer = [](const TheoryRequest& request) { return std::apply(stability_theory, stability_numbers(request)); },
      .usual_gas = source_gas,
      .options = {"--restitution", "--charge-number"}};
}

}  // namespace lichtenberg
