#include <fmt/format.h>

#include <algorithm>
#include <boost/math/tools/minima.hpp>
#include <cmath>
#include <numbers>

#include "solvers/error.hpp"
#include "src/commands/reading.hpp"
#include "src/commands/theory_kind.hpp"
#include "src/record/result_file.hpp"
#include "src/theory/kinetic.hpp"
#include "src/theory/kinetic_printed.hpp"
#include "src/theory/monopolar.hpp"
#include "src/theory/restitution.hpp"

namespace lichtenberg {
namespace {

constexpr const char* unit_of_energy = "m0 v0^2";

double last_slope(const std::vector<double>& time, const std::vector<double>& value) {
  const std::size_t n = time.size();
  return std::log(value[n - 1] / value[n - 2]) / std::log(time[n - 1] / time[n - 2]);
}

bool is_constant(const GrainContactLaw& law) {
  return std::visit([](const auto& one) { return one.constant_restitution; }, law);
}

/// Returns the rms deviation of ln T of a run from the law of a monopolar gas with this barrier.
double rms_deviation(const GasTimeSeries::Series& found, theory::MonopolarGas law, double barrier) {
  law.barrier = barrier;
  double squares = 0;
  for (std::size_t k = 0; k < found.time.size(); ++k)
    squares += std::pow(std::log(found.value[k] / theory::monopolar_temperature(law, found.time[k])), 2);
  return std::sqrt(squares / static_cast<double>(found.time.size()));
}

/// Fits the effective barrier. Neighbours reduce it relative to that of a pair: U_eff = U (1 - c phi^(1/3)).
void fit_barrier(TheoryAnswer& answer, const GasParameters& gas, const GasTimeSeries& run,
                 const theory::MonopolarGas& law) {
  const GasTimeSeries::Series* temperature = run.find("local_temperature");
  if (!temperature) return;
  const double least = std::log(1e-4 * law.barrier), most = std::log(10 * law.barrier);
  const auto [logarithm, scatter] = boost::math::tools::brent_find_minima(
      [&](double u) { return rms_deviation(*temperature, law, std::exp(u)); }, least, most, 30);
  constexpr double margin = 1e-3;  // a minimum this close to a limit is not valid
  if (logarithm < least + margin || logarithm > most - margin) {
    answer.figures.push_back({"fitted_barrier", unit_of_energy, NAN,
                              "none from 1e-4 U to 10 U fits: the run is too short, or cools by another law"});
    return;
  }
  theory::MonopolarGas fitted = law;
  fitted.barrier = std::exp(logarithm);
  const double c = (1 - fitted.barrier / law.barrier) / std::cbrt(std::numbers::pi / 6 * gas.density);
  answer.figures.push_back(
      {"fitted_barrier", unit_of_energy, fitted.barrier,
       fmt::format("to the run, U (1 - c phi^(1/3)) with c = {:.4g}; rms of ln T {:.2g}", c, scatter)});
  const auto expected = [&](double t) { return theory::monopolar_temperature(fitted, t); };
  add(answer.tables[0], 0,
      {"temperature_fitted", unit_of_energy, "barrier fitted to the run",
       values_of(answer.tables[0].columns[0].values, expected)});
}

/// Variants of `kinetic_theory`.
struct Variant {
  const char *suffix, *label;
  bool merges, speeds_at_contact;
};
constexpr Variant variants[] = {{"", "merging", true, false},
                                {"_bouncing", "without merging", false, false},
                                {"_contact_speeds", "merging, speeds at contact", true, true}};

std::vector<theory::KineticState> kinetic_states(const GasParameters& gas, const Variant& variant,
                                                 const std::vector<double>& times) {
  return theory::kinetic_evolution({.density = gas.density,
                                    .temperature = gas.temperature,
                                    .coupling = gas.coupling,
                                    .impacts = gas.impacts(true),
                                    .contact_value = theory::contact_value(gas.density),
                                    .merges = variant.merges,
                                    .speeds_at_contact = variant.speeds_at_contact},
                                   times);
}

void check_merging(const GasParameters& gas) {
  if (!gas.exchange || gas.coupling <= 0)
    throw InputError(gas.source +
                     ": theory kinetic is for grains that charge each other and attract, which needs "
                     "effects.charge_exchange and effects.coulomb");
}

TheoryTable kinetic_table(const GasParameters& gas) {
  TheoryTable table{
      .name = "course", .title = "the gas over time", .columns = {{"time", "t0", "time", times_until(gas.end)}}};
  table.panels = {
      {"temperature", true, {}}, {R"($\langle q^2 \rangle$)", true, {}}, {"density", true, {}}, {"B", true, {}}};
  for (const Variant& variant : variants) {
    const auto states = kinetic_states(gas, variant, table.columns[0].values);
    using State = theory::KineticState;
    const auto show = [&](int panel, const std::string& name, const std::string& unit, double State::*member) {
      add(table, panel, {name + variant.suffix, unit, variant.label, values_of(states, member)});
    };
    show(0, "temperature", unit_of_energy, &State::temperature);
    show(1, "square_charge", "q0^2", &State::charge_square);
    show(2, "density", "1/d0^3", &State::density);
    show(3, "bjerrum", "1", &State::bjerrum);
  }
  return table;
}

/// Returns the printed functions of the dissertation G together with the corrected ones.
TheoryTable printed_table(double exponent) {
  TheoryTable table{.name = "printed",
                    .title = "g_1 ... g_5 (G 5.32-5.37), of m = d = C_eps = C_dq = 1, and as printed"};
  table.columns = {{"bjerrum", "1", "B", {0.01, 0.1, 0.2, 0.4, 0.6, 0.8, 0.99, 2, 10}}};
  using Functions = theory::KineticFunctions;
  constexpr double Functions::*members[] = {&Functions::mergers, &Functions::contact_loss, &Functions::merging_loss,
                                            &Functions::contact_charge, &Functions::merging_charge};
  for (int g = 0; g < 5; ++g) {
    const auto right = [&](double b) { return theory::corrected_functions(b, exponent).*members[g]; };
    const auto printed = [&](double b) { return b < 1 ? theory::printed_functions(b, exponent).*members[g] : NAN; };
    table.columns.push_back({fmt::format("g{}", g + 1), "1", "", values_of(table.columns[0].values, right)});
    table.columns.push_back({fmt::format("g{}_printed", g + 1), "1", "", values_of(table.columns[0].values, printed)});
  }
  return table;
}

TheoryAnswer haff_theory(const GasParameters& gas, const GasTimeSeries* run) {
  const std::vector<double> times = times_until(gas.end);
  const auto states = theory::cool(gas.density, gas.impacts(), gas.temperature, times);
  const auto lasting = theory::cool(gas.density, gas.impacts(true), gas.temperature, times);
  using State = theory::CoolingState;
  TheoryTable table{
      .name = "course",
      .title = "a neutral gas over time",
      .columns = {{"time", "t0", "time", times},
                  {"temperature", unit_of_energy, "collisions at once", values_of(states, &State::temperature)},
                  {"temperature_lasting", unit_of_energy, "collisions of the length that they have",
                   values_of(lasting, &State::temperature)},
                  {"collisions", "1", "of a grain", values_of(states, &State::collisions)}},
      .panels = {{"temperature", true, {"temperature", "temperature_lasting"}}}};
  TheoryAnswer answer{"haff", "Cooling of a homogeneous gas without charges (Haff; G 2.12)", common_figures(gas), {}};
  if (gas.exchange) {
    table.columns.push_back({"square_charge", "q0^2", "collisions at once", values_of(states, &State::charge_square)});
    table.columns.push_back({"square_charge_lasting", "q0^2", "collisions of the length that they have",
                             values_of(lasting, &State::charge_square)});
    table.panels.push_back({R"($\langle q^2 \rangle$)", true, {"square_charge", "square_charge_lasting"}});
    if (run) run->show(table, "square_charge_lasting", "mean_square_charge", "run: grains");
  }
  if (is_constant(gas.law)) {
    const double eps = restitution(gas.law, 1);
    answer.figures.push_back({"haff_time", "t0", theory::haff_time(gas.density, gas.temperature, eps),
                              fmt::format("tau of T_0/(1 + t/tau)^2, restitution {:.6g}", eps)});
  }
  answer.figures.push_back({"exponent", "1", last_slope(times, table.columns[1].values), "of T by t at the end"});
  if (run) {
    run->show(table, "temperature_lasting", "local_temperature", "run: relative to the flow");
    run->show(table, "temperature_lasting", "temperature", "run: with the flow");
  }
  answer.tables = {table};
  return answer;
}

TheoryAnswer monopolar_theory(const GasParameters& gas, const GasTimeSeries* run) {
  if (!is_constant(gas.law))
    throw InputError(gas.source + ": theory monopolar is for a constant restitution, which effects.linear_contact has");
  constexpr double rounding = 1e-9;
  if (gas.coupling <= 0 || gas.charge <= 0 || std::abs(gas.mean_charge) < (1 - rounding) * gas.charge || gas.exchange)
    throw InputError(gas.source +
                     ": theory monopolar is for grains that all have the same charge, which it needs together with "
                     "effects.coulomb and without effects.charge_exchange");
  const theory::MonopolarGas law{gas.temperature,
                                 theory::haff_time(gas.density, gas.temperature, restitution(gas.law, 1)),
                                 gas.coupling * gas.charge * gas.charge};
  const std::vector<double> times = times_until(gas.end);
  const auto charged = [&](double t) { return theory::monopolar_temperature(law, t); };
  const auto neutral = [&](double t) { return theory::haff_temperature(law.initial, law.tau, t); };
  TheoryTable table{.name = "course",
                    .title = "the gas over time",
                    .columns = {{"time", "t0", "time", times}},
                    .panels = {{"temperature", true, {}}}};
  add(table, 0, {"temperature", unit_of_energy, "equal charges", values_of(times, charged)});
  theory::MonopolarGas screened = law;
  screened.barrier = theory::effective_barrier(law.barrier, std::numbers::pi / 6 * gas.density);
  const auto correlated = [&](double t) { return theory::monopolar_temperature(screened, t); };
  add(table, 0,
      {"temperature_effective", unit_of_energy, "effective barrier of neighbours", values_of(times, correlated)});
  add(table, 0, {"haff_temperature", unit_of_energy, "neutral", values_of(times, neutral)});
  TheoryAnswer answer{
      "monopolar", "Cooling of grains that all repel each other (G 4.1a)", common_figures(gas), {table}};
  answer.figures.push_back({"haff_time", "t0", law.tau, "tau without charges"});
  answer.figures.push_back(
      {"barrier", unit_of_energy, law.barrier, "U = K q^2/d of a pair; at late times T decreases like U / ln t"});
  answer.figures.push_back({"effective_barrier", unit_of_energy, screened.barrier,
                            "U (1 - 2.40 phi^(1/3) + 1.44 phi^(2/3)) with neighbours, for T below it"});
  answer.figures.push_back({"barrier_time", "t0", theory::monopolar_time(law, std::min(law.barrier, law.initial)),
                            "when T has come down to U; 0 if it starts below"});
  if (run) {
    run->show(answer.tables[0], "temperature", "local_temperature", "run");
    fit_barrier(answer, gas, *run, law);
  }
  return answer;
}

TheoryAnswer restitution_theory(const GasParameters& gas) {
  const std::vector<double> speeds = logarithmic_range(1e-6, 10, 71);
  TheoryTable table{.name = "collision",
                    .title = "two grains head-on",
                    .columns = {{"speed", "v0", "speed", speeds}},
                    .panels = {{"restitution", false, {}}, {"duration", true, {}}}};
  const auto duration = [&](double v) { return contact_duration(gas.law, v); };
  add(table, 0, {"restitution", "1", "true", values_of(speeds, [&](double v) { return restitution(gas.law, v); })});
  add(table, 1, {"duration", "t0", "of the force", values_of(speeds, duration)});
  TheoryAnswer answer{
      "restitution", "The collision of two grains, G 3.9, 3.10 with the non-attractive cut-off", {}, {}};
  const auto* soft = std::get_if<ViscoelasticLaw>(&gas.law);
  if (soft && soft->dissipative > 0) {
    const theory::ViscoelasticPair pair{soft->elastic, soft->dissipative};
    const double k1 = theory::dissipation_number(pair, 1), c = theory::first_loss() * k1;
    const auto number = [&](double v) { return theory::dissipation_number(pair, v); };
    const auto overlap = [&](double v) {
      return number(v) <= theory::RestitutionCurve::largest ? theory::collision(pair, v).overlap : NAN;
    };
    const auto pade = [&](double v) { return theory::pade_restitution(number(v)); };
    const auto first = [&](double v) {
      const double linear = 1 - c * std::pow(v, 0.2);
      return linear >= 0 ? linear : NAN;
    };
    table.panels.push_back({"largest overlap", true, {}});
    add(table, 2, {"overlap", "d0", "largest", values_of(speeds, overlap)});
    add(table, 0, {"pade", "1", "Mueller and Poeschel", values_of(speeds, pade)});
    add(table, 0, {"first_order", "1", "1 - C v^(1/5) (G 5.31)", values_of(speeds, first)});
    const double negative = std::pow(c, -5);
    answer.figures = {
        {"dissipation_number", "1", k1, "k at speed 1, which goes as v^(1/5)"},
        {"C", "(t0/d0)^(1/5)", c,
         std::isfinite(negative)
             ? fmt::format("of the first-order law, which is negative above a speed of {:.4g}", negative)
             : "of the first-order law, which is negative at no speed"},
        {"piercing_speed", "v0", theory::piercing_speed(pair), "above which elastic grains pass through each other"}};
  }
  answer.tables = {table};
  return answer;
}

TheoryAnswer kinetic_theory(const GasParameters& gas, const GasTimeSeries* run) {
  check_merging(gas);
  TheoryAnswer answer{
      "kinetic", "Kinetic theory of a gas that charges and merges (G chapter 5, corrected)", common_figures(gas), {}};
  TheoryTable course = kinetic_table(gas);
  const std::vector<double>& bjerrum = course.columns[4].values;
  const auto top = std::ranges::max_element(bjerrum) - bjerrum.begin();
  answer.figures.push_back({"coupling", "1", gas.coupling * gas.exchange->strength * gas.exchange->strength,
                            "K Q^2, the only number of charges that matters"});
  answer.figures.push_back({"largest_bjerrum", "1", bjerrum[top],
                            fmt::format("B with merging, at t = {:.4g}", course.columns[0].values[top])});
  if (run) {
    run->show(course, "temperature", "local_temperature", "run: grains");
    run->show(course, "square_charge", "mean_square_charge", "run: grains");
    const double volume = gas.grains / gas.density;
    run->show(course, "temperature", "analysis/bound_cluster_local_temperature", "run: bound clusters");
    run->show(course, "square_charge", "analysis/bound_cluster_square_charge", "run: bound clusters");
    run->show(course, "density", "analysis/bound_clusters", "run: bound clusters", 1 / volume);
    run->show(course, "bjerrum", "analysis/bound_bjerrum", "run: bound clusters");
  }
  answer.tables = {course, printed_table(2 * gas.exchange->exponent)};
  return answer;
}

}  // namespace

std::vector<TheoryFigure> common_figures(const GasParameters& gas) {
  const double filled = std::numbers::pi / 6 * gas.density;
  return {
      {"density", "1/d0^3", gas.density, fmt::format("of grains, which fill {:.4f} of the box", filled)},
      {"temperature", unit_of_energy, gas.temperature, "at the start, after the warm-up"},
      {"contact_value", "1", theory::contact_value(gas.density), "factor by which pairs are more frequent in contact"},
      {"collision_frequency", "1/t0", theory::collision_frequency(gas.density, gas.temperature),
       "of a grain at the start"}};
}

std::vector<double> times_until(double end) {
  const double first = std::min(0.01, end / 100);
  return logarithmic_range(first, end, 1 + static_cast<int>(std::ceil(20 * std::log10(end / first))));
}

double mean_restitution(const GasParameters& gas) {
  const auto lost = [&](double speed, double x) { return x * (1 - std::pow(restitution(gas.law, speed), 2)); };
  return std::sqrt(1 - theory::impact_mean(gas.temperature, lost));
}

std::vector<theory::KineticState> merging_states(const GasParameters& gas, const std::vector<double>& times) {
  check_merging(gas);
  return kinetic_states(gas, variants[0], times);
}

std::vector<double> logarithmic_range(double first, double last, int count) {
  std::vector<double> range;
  for (int k = 0; k < count; ++k) range.push_back(first * std::pow(last / first, k / (count - 1.0)));
  range.back() = last;
  return range;
}

GasTimeSeries::GasTimeSeries(const std::string& path, double warm_up) : path_(path) {
  try {
    const ResultFile file(path, "compared with theory");
    if (!hdf5::exists(file.file(), "gas/time"))
      throw InputError(path + " holds no time series of a gas to compare with a theory");
    for (const std::string group : {"gas", "analysis"})
      if (hdf5::exists(file.file(), group + "/time")) read(file.file(), group, warm_up);
    warn_if_changed(file);
  } catch (const hdf5::Error& error) {
    throw InputError(fmt::format(
        "the result file {} is damaged: the time series of its gas cannot be read ({}); run its scene again", path,
        error.what()));
  }
  if (series_["time"].time.empty()) throw InputError(path + " holds no data after the warm-up, where theory begins");
}

void GasTimeSeries::read(const hdf5::Handle& file, const std::string& group_name, double warm_up) {
  const hdf5::Handle group = hdf5::open_group(file, group_name);
  const std::vector<double> time = hdf5::get<double>(group, "time");
  for (const std::string& name : hdf5::names(group)) {
    const std::string series_name = group_name == "gas" ? name : group_name + "/" + name;
    const hdf5::Shape shape = hdf5::shape(group, name);
    const bool shells = name.ends_with("_structure") && shape.size() == 2;
    if (shape.empty() || shape[0] != time.size() || (shape.size() > 1 && !shells)) {
      malformed_names_.insert(series_name);
      continue;
    }
    const std::vector<double> value = hdf5::get<double>(group, name);
    const std::size_t columns = shells ? shape[1] : 1;
    for (std::size_t column = 0; column < columns; ++column) {
      Series& series = series_[series_name + (shells ? fmt::format("/{}", column + 1) : "")];
      for (std::size_t k = 0; k < time.size(); ++k)
        if (time[k] > warm_up)
          series.time.push_back(time[k] - warm_up), series.value.push_back(value[k * columns + column]);
    }
  }
}

const GasTimeSeries::Series* GasTimeSeries::find(const std::string& name) const {
  if (malformed_names_.contains(name))
    throw InputError(fmt::format(
        "the result file {} is damaged: its time series {} has not one number for each instant; run {} again", path_,
        name, name.starts_with("analysis/") ? "its scene or `lichtenberg analyse`" : "its scene"));
  const auto found = series_.find(name);
  return found == series_.end() ? nullptr : &found->second;
}

void GasTimeSeries::show(TheoryTable& table, const std::string& column, const std::string& name,
                         const std::string& label, double factor) const {
  const Series* series = find(name);
  if (!series) return;
  table.found.push_back({column, label, series->time, series->value});
  for (double& y : table.found.back().y) y *= factor;
}

TheoryKind haff_kind() {
  return {.name = "haff",
          .answer = [](const TheoryRequest& request) { return haff_theory(*request.gas, request.run); },
          .usual_gas = source_gas};
}

TheoryKind monopolar_kind() {
  return {.name = "monopolar",
          .answer = [](const TheoryRequest& request) { return monopolar_theory(*request.gas, request.run); },
          .usual_gas = source_monopolar_gas};
}

TheoryKind restitution_kind() {
  return {.name = "restitution",
          .answer = [](const TheoryRequest& request) { return restitution_theory(*request.gas); },
          .usual_gas = source_gas};
}

TheoryKind kinetic_kind() {
  return {.name = "kinetic",
          .answer = [](const TheoryRequest& request) { return kinetic_theory(*request.gas, request.run); },
          .usual_gas = source_gas};
}

}  // namespace lichtenberg
