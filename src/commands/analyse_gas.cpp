#include "src/commands/analyse_gas.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "solvers/error.hpp"
#include "src/analysis/gas_growth.hpp"
#include "src/commands/analyse_columns.hpp"
#include "src/commands/gas_parameters.hpp"
#include "src/commands/streams.hpp"
#include "src/scene/effect_kind.hpp"

namespace lichtenberg {
namespace {

using GasFrames = std::vector<GasFrame>;
using analysis::ClusterShape;
using analysis::Histogram;

constexpr const char* energy_unit = "m0 v0^2";
constexpr double fastest_of_charges = 4;  // range of the charge histogram, in rms values
constexpr int charge_by_speed_bins = 20;

/// Returns the number of clusters of each size, from 0 on.
std::vector<int> number_by_size(std::span<const int> sizes) {
  std::vector<int> number(sizes.empty() ? 1 : *std::ranges::max_element(sizes) + 1);
  for (const int size : sizes) ++number[size];
  return number;
}

std::vector<double> squares(std::vector<double> values) {
  for (double& value : values) value *= value;
  return values;
}

template <class Number>
std::vector<Number> member_values(const std::vector<ClusterShape>& shapes, Number ClusterShape::*member) {
  std::vector<Number> values;
  for (const ClusterShape& shape : shapes) values.push_back(shape.*member);
  return values;
}

template <class Estimate>
double value_or_nothing(const std::optional<Estimate>& found, double Estimate::*member) {
  return found ? (*found).*member : NAN;
}

void add_dimension(Columns<GasFrame>& columns, const std::string& name,
                   const std::function<const std::optional<analysis::ClusterDimension>&(const GasFrame&)>& get) {
  using Dimension = analysis::ClusterDimension;
  columns.real(name, "1", [=](auto& f) { return value_or_nothing(get(f), &Dimension::dimension); });
  columns.real(name + "_error", "1", [=](auto& f) { return value_or_nothing(get(f), &Dimension::error); });
  columns.real(name + "_from", "d0", [=](auto& f) { return value_or_nothing(get(f), &Dimension::from); });
  columns.real(name + "_to", "d0", [=](auto& f) { return value_or_nothing(get(f), &Dimension::to); });
}

void add_exponent(Columns<GasFrame>& columns, const std::string& name,
                  const std::function<const std::optional<analysis::SizeExponent>&(const GasFrame&)>& get) {
  using Exponent = analysis::SizeExponent;
  columns.real(name, "1", [=](auto& f) { return value_or_nothing(get(f), &Exponent::exponent); });
  columns.real(name + "_error", "1", [=](auto& f) { return value_or_nothing(get(f), &Exponent::error); });
}

void add_clusters(Columns<GasFrame>& columns, const AnalysedGas& run, const std::string& kind,
                  const std::function<const ClusterState&(const GasFrame&)>& get) {
  columns.integer(kind + "clusters", [=](auto& f) { return get(f).sizes.number; });
  columns.integer("largest_" + kind + "cluster", [=](auto& f) { return get(f).sizes.largest; });
  columns.real("mean_" + kind + "aggregate", "1", [=](auto& f) { return get(f).sizes.aggregate; });
  columns.real("mean_" + kind + "cluster", "1", [=](auto& f) { return get(f).sizes.mean; });
  columns.integers(kind + "cluster_number", [=](auto& f) { return get(f).number; });
  columns.real(kind + "cluster_temperature", energy_unit, [=](auto& f) { return get(f).temperature; });
  columns.real(kind + "cluster_local_temperature", energy_unit, [=](auto& f) { return get(f).local_temperature; });
  columns.real(kind + "cluster_square_charge", "q0^2", [=](auto& f) { return get(f).square_charge; });
  columns.real(kind + "bjerrum", "1", [=](auto& f) { return get(f).bjerrum; });
  columns.integer(kind + "percolating_clusters", [=](auto& f) { return get(f).percolating; });
  columns.integers(kind + "shape_grains", [=](auto& f) { return member_values(get(f).shapes, &ClusterShape::grains); });
  columns.reals(kind + "shape_gyration", "d0",
                [=](auto& f) { return member_values(get(f).shapes, &ClusterShape::gyration); });
  columns.reals(kind + "shape_charge_dipole", "q0 d0",
                [=](auto& f) { return member_values(get(f).shapes, &ClusterShape::charge_dipole); });
  if (run.charged)
    columns.reals(
        kind + "charge_dipole", "q0 d0", [=](auto& f) { return get(f).charge_dipole; }, NAN);
  if (run.polarized) {
    columns.reals(kind + "shape_induced_dipole", "q0 d0",
                  [=](auto& f) { return member_values(get(f).shapes, &ClusterShape::induced_dipole); });
    columns.reals(
        kind + "induced_dipole", "q0 d0", [=](auto& f) { return get(f).induced_dipole; }, NAN);
  }
  add_dimension(
      columns, kind + "fractal_dimension", [=](auto& f) -> auto& { return get(f).dimension; });
  add_exponent(
      columns, kind + "cluster_exponent", [=](auto& f) -> auto& { return get(f).exponent; });
}

/// Formats the value with this number of significant digits; a dash if it is not finite.
std::string shown(double value, int digits) {
  return std::isfinite(value) ? fmt::format("{:.{}g}", value, digits) : "-";
}

void print_gas_head() {
  fmt::print("{:>6} {:>9} {:^21} {:>7} {:^27} {:>8} {:^24} {:^14}\n", "", "", "T", "", "charge", "",
             "clusters in contact", "dense cells");
  fmt::print("{:>6} {:>9} {:>10} {:>10} {:>7} {:>9} {:>9} {:>7} {:>8} {:>8} {:>7} {:>7} {:>6} {:>7}\n", "frame", "t",
             "local", "with flow", "a_2", "sum", "<q^2>", "kurt.", "contacts", "number", "largest", "mean>1", "number",
             "S");
}

void print_gas_line(const GasFrame& f) {
  fmt::print("{:>6} {:>9.4g} {:>10} {:>10.4g} {:>7} {:>9.2g} {:>9.3g} {:>7} ", f.frame, f.time,
             shown(f.gas.temperature.local, 4), f.gas.temperature.total, shown(f.gas.sonine, 3), f.total_charge,
             f.gas.charge.square, shown(f.gas.charge.kurtosis, 3));
  const analysis::ClusterSizes& c = f.contact.sizes;
  fmt::print("{:>8} {:>8} {:>7} {:>7} {:>6} {:>7}\n", f.contacts, c.number, c.largest, shown(c.aggregate, 3),
             f.gas.density.size.size(), shown(f.gas.density.mean_size(), 3));
}

std::string with_error(double value, double error) { return fmt::format("{:.3f} +- {:.2g}", value, error); }

void print_shapes(const ClusterState& state) {
  const std::string beyond =
      state.percolating > 0 ? fmt::format("; {} around the box left out", state.percolating) : "";
  if (const auto& d = state.dimension)
    fmt::print("{:<15}D_f = {} of {} clusters of {} grains and more, R_g = {:.3g} to {:.3g} d0{}\n", "",
               with_error(d->dimension, d->error), d->clusters, analysis::least_grains, d->from, d->to, beyond);
  else
    fmt::print("{:<15}no D_f: fewer than five clusters of {} grains and more, or all of one size{}\n", "",
               analysis::least_grains, beyond);
  if (const auto& e = state.exponent)
    fmt::print("{:<15}N_s ~ s^-{} of {} aggregates\n", "", with_error(e->exponent, e->error), e->clusters);
}

void print_clusters(const std::string& kind, const ClusterState& state) {
  fmt::print("{:<15}{}, the largest of {}, by mass of {:.3g}; T = {} and <q^2> = {} of clusters as single bodies\n",
             kind, state.sizes.number, state.sizes.largest, state.sizes.mean, shown(state.temperature, 4),
             shown(state.square_charge, 4));
  if (std::isfinite(state.bjerrum))
    fmt::print("{:<15}B = {:.4g}, with T = {:.4g} relative to the flow\n", "", state.bjerrum, state.local_temperature);
  print_shapes(state);
}

void print_last(const GasFrame& f) {
  const analysis::DensityClusters& d = f.gas.density;
  fmt::print("\nframe {} at t = {:.6g} t0\n", f.frame, f.time);
  print_clusters("in contact", f.contact);
  if (f.bound) print_clusters("bound", *f.bound);
  fmt::print("dense          cells of {:.4g} d0 with at least {} grains\n", d.cells.edge.x, d.least);
  if (const auto& e = f.density_exponent)
    fmt::print("{:<15}N_s ~ s^-{} of {} clusters\n", "", with_error(e->exponent, e->error), e->clusters);
  fmt::print("correlation    {} of charge^2 and speed^2\n", shown(f.correlation, 3));
  fmt::print("Mach number    {}, {} of the flow without the contribution of temperature\n", shown(f.mach.raw, 3),
             shown(f.mach.flow, 3));
  fmt::print("structure      {} of density in the longest waves", shown(f.structure.density.front(), 3));
  if (!f.structure.charge.empty()) fmt::print(", {} of charge", shown(f.structure.charge.front(), 3));
  fmt::print("\n");
}

/// Growth of a cluster size after the warm-up.
struct SizeGrowth {
  std::vector<int> index;             ///< of the frames that count, in which there are aggregates
  std::vector<double> time, slope{};  ///< since the warm-up; local exponents
  std::optional<analysis::ShiftedPower> fit;
};

constexpr std::size_t min_growth_points = 5;

SizeGrowth size_growth(const AnalysedGas& run, const GasFrames& frames, double (*size)(const GasFrame&)) {
  SizeGrowth growth;
  std::vector<double> sizes;
  for (std::size_t k = 0; k < frames.size(); ++k)
    if (const double s = size(frames[k]); frames[k].time > run.warm_up && s > 1) {
      growth.index.push_back(static_cast<int>(k));
      growth.time.push_back(frames[k].time - run.warm_up), sizes.push_back(s);
    }
  if (!sizes.empty()) growth.slope = analysis::local_slopes(growth.time, sizes);
  if (sizes.size() >= min_growth_points) growth.fit = analysis::fit_growth(growth.time, sizes);
  return growth;
}

double aggregate_of(const GasFrame& f) { return f.contact.sizes.aggregate; }
double dense_size_of(const GasFrame& f) { return f.gas.density.mean_size(); }

void print_growth(const SizeGrowth& growth, const std::string& what) {
  if (growth.time.size() < min_growth_points)
    return fmt::print("{:<15}too few frames of aggregates after the warm-up for a fit\n", what);
  const double slope = growth.slope.back();
  if (const auto& fit = growth.fit)
    fmt::print("{:<15}{:.3g} (t {:+.4g})^{:.3f} from t = {:.4g} on, rms of ln {:.2g}; last local slope {:.3f}\n", what,
               fit->amplitude, fit->shift, fit->exponent, growth.time.front(), fit->scatter, slope);
  else
    fmt::print("{:<15}faster or slower than any power of a shifted time; last local slope {:.3f}\n", what, slope);
}

nlohmann::ordered_json json_of_growth(const SizeGrowth& growth) {
  if (growth.time.size() < min_growth_points) return {{"missing", "fewer than five frames of aggregates to fit"}};
  if (!growth.fit) return {{"missing", "faster or slower than any power of a shifted time"}};
  return {{"amplitude", growth.fit->amplitude}, {"shift", growth.fit->shift},  {"exponent", growth.fit->exponent},
          {"scatter", growth.fit->scatter},     {"from", growth.time.front()}, {"to", growth.time.back()}};
}

/// Returns the run's time series; empty if the run has recorded none yet.
std::optional<GasTimeSeries> read_time_series(const std::string& path) {
  try {
    return GasTimeSeries(path, -std::numeric_limits<double>::min());  // includes records at time 0
  } catch (const InputError&) {
    return {};
  }
}

/// Adds the reasons for missing values of clusters of this kind, which prefixes their columns' names.
void add_reasons(nlohmann::ordered_json& json, const std::string& kind) {
  for (const char* part : {"", "_error", "_from", "_to"})
    json[kind + "fractal_dimension" + part] =
        "fewer than five clusters of at least six grains that do not span the box, or all of one size";
  for (const char* part : {"", "_error"})
    json[kind + "cluster_exponent" + part] = "fewer than ten clusters, or all of the smallest size";
  for (const char* what : {"shape_gyration", "shape_charge_dipole"})
    json[kind + what] = "the cluster reaches around the box";
  json[kind + "bjerrum"] = "no forces between charges, or no two clusters in any cell";
  json[kind + "cluster_local_temperature"] = "no two clusters in any cell";
  json["mean_" + kind + "aggregate"] = "no two grains in contact";
}

/// Returns the reasons why columns are missing or hold no number.
nlohmann::ordered_json missing_reasons(const AnalysedGas& run) {
  nlohmann::ordered_json json;
  add_reasons(json, "");
  if (run.coulomb)
    add_reasons(json, "bound_");
  else
    json["bound_clusters"] = "no forces between charges";
  for (const char* part : {"", "_error"})
    json[std::string("density_cluster_exponent") + part] = "fewer than ten clusters of cells, or all of one cell";
  json["local_temperature"] = "no two grains in any cell";
  json["sonine"] = "no grain moves";
  for (const char* name : {"mach_number", "mach_number_of_flow"})
    json[name] = "no two grains in any cell, or none that moves";
  json["density_cluster_size"] = "no dense cell";
  json["density_structure"] = "a side is not periodic";
  json["contact_persistence"] = "the first frame, or no contacts in the frame before";
  json["aggregate_local_slope"] = "no aggregates at half the time, or one frame alone";
  json["density_local_slope"] = "no dense cell at half the time, or one frame alone";
  for (const char* name : energy_names) json[name] = "the run has no record at that instant";
  if (run.charged) {
    json["charge_by_speed"] = "no grain in this range of speeds, or all charges equal";
    json["charge_kurtosis"] = "all charges equal";
    for (const char* name : {"charge_dipole", "bound_charge_dipole"})
      json[name] = "no cluster of this size, or only clusters that span the box";
    json["charge_speed_correlation"] = "all charges equal, or all speeds";
    json["charge_structure"] = "no grain is charged then, or a side is not periodic";
  } else {
    for (const char* name : {"charge_by_speed", "charge_kurtosis", "charge_speed_correlation", "charge_structure",
                             "charge_density", "charge_dipole"})
      json[name] = "no grain is charged";
  }
  for (const char* name : {"induced_dipole", "bound_induced_dipole"})
    json[name] = run.polarized ? "no cluster of this size" : "the scene is without [effects.induced_dipoles]";
  return json;
}

}  // namespace

GasAnalyser::GasAnalyser(const Result& result, Scene scene)
    : result_(result), scene_(std::move(scene)), at_start_(make_bodies(scene_)) {
  if (at_start_.radius.size() != result_.radius().size())
    throw InputError(fmt::format(
        "the result file {} is damaged and cannot be analysed (its scene has {} grains, but its frames have {})",
        result_.path(), at_start_.radius.size(), result_.radius().size()));
  first_ = bodies(0);
  time_series_ = read_time_series(result_.path());
}

AnalysedGas GasAnalyser::run() const {
  std::map<std::string, std::vector<double>> notes;
  if (time_series_)
    for (const auto& [name, series] : time_series_->all())
      if (!name.starts_with("analysis/")) notes[name] = series.value;
  return {.file = result_.path(),
          .title = scene_.title,
          .grains = at_start_.size(),
          .frames = result_.frames(),
          .warm_up = warm_up(scene_),
          .warnings = result_.warnings(),
          .charged = !first_.charge.empty(),
          .polarized = scene_.effects.has("induced_dipoles"),
          .coulomb = number_in(scene_, &EffectKind::charge_strength).has_value(),
          .notes = std::move(notes)};
}

std::vector<GasFrame> GasAnalyser::all() const {
  std::vector<GasFrame> found;
  for (int k = 0; k < result_.frames(); ++k) found.push_back(one(k));
  const SizeGrowth aggregates = size_growth(run(), found, aggregate_of),
                   dense = size_growth(run(), found, dense_size_of);
  for (std::size_t k = 0; k < aggregates.index.size(); ++k)
    found[aggregates.index[k]].aggregate_slope = aggregates.slope[k];
  for (std::size_t k = 0; k < dense.index.size(); ++k) found[dense.index[k]].density_slope = dense.slope[k];
  return found;
}

std::vector<double> GasAnalyser::energies_at(double time) const {
  std::vector<double> found(energy_names.size(), NAN);
  for (std::size_t k = 0; k < energy_names.size() && time_series_; ++k) {
    const GasTimeSeries::Series* noted = time_series_->find(energy_names[k]);
    if (!noted) continue;
    const double rounded = 1e-9 * time;  // a record's time is a sum of steps
    const auto at = std::ranges::lower_bound(noted->time, time - rounded) - noted->time.begin();
    if (at < std::ssize(noted->time) && noted->time[at] <= time + rounded) found[k] = noted->value[at];
  }
  return found;
}

Bodies GasAnalyser::bodies(int index) const {
  const Frame frame = result_.frame(index);
  const std::vector<double> position = frame.reals("position"), velocity = frame.reals("velocity");
  Bodies bodies = at_start_;
  const int d = bodies.dimension;
  if (position.size() != 3 * bodies.radius.size() || velocity.size() != position.size())
    throw InputError(
        fmt::format("the result file {} is damaged and cannot be analysed (frame {} does not hold the positions and "
                    "velocities of {} grains)",
                    result_.path(), index, bodies.size()));
  for (int i = 0; i < bodies.size(); ++i)
    for (int k = 0; k < d; ++k) {
      bodies.position[i * d + k] = position[3 * i + k];
      bodies.momentum[i * d + k] = bodies.mass[i] * velocity[3 * i + k];
    }
  bodies.charge = frame.reals("charge");
  if (!bodies.charge.empty() && bodies.charge.size() != bodies.radius.size())
    throw InputError(
        fmt::format("the result file {} is damaged and cannot be analysed ({} charges of {} grains, frame {})",
                    result_.path(), bodies.charge.size(), bodies.size(), index));
  const std::vector<double> image = frame.reals("image");
  for (int i = 0; i < bodies.size() && image.size() == position.size(); ++i)
    for (int k = 0; k < d; ++k) bodies.image[i * d + k] = static_cast<int>(image[3 * i + k]);
  return bodies;
}

std::vector<Pair> GasAnalyser::contacts(int index) const {
  const auto recorded = result_.contacts(index);
  if (!recorded)
    throw InputError(
        fmt::format("the result file {} holds no contacts between its grains, without which there are no clusters: it "
                    "cannot be analysed",
                    result_.path()));
  std::vector<Pair> pairs;
  for (const auto& [i, j] : *recorded) {
    if (j < 0)
      throw InputError(
          fmt::format("the result file {} is damaged and cannot be analysed (in frame {} grain {} touches the ground, "
                      "which a gas does not have)",
                      result_.path(), index, i));
    pairs.push_back({i, j});
  }
  std::ranges::sort(pairs);
  return pairs;
}

ClusterState GasAnalyser::state_of(const Bodies& bodies, std::span<const Pair> pairs,
                                   std::span<const double> dipole) const {
  const std::vector<std::int32_t> numbers = analysis::cluster_numbers(bodies.size(), pairs);
  const Bodies clusters = analysis::cluster_bodies(bodies, numbers);
  ClusterState state{.sizes = analysis::cluster_sizes(numbers)};
  const double count = clusters.size();
  std::vector<int> grains;
  for (const analysis::Cluster& cluster : analysis::clusters(bodies, numbers)) grains.push_back(cluster.grains);
  state.number = number_by_size(grains);
  const analysis::GranularTemperature temperature = analysis::granular_temperature(clusters);
  state.temperature = temperature.total, state.local_temperature = temperature.local;
  for (const double charge : clusters.charge) state.square_charge += charge * charge / count;
  const auto strength = number_in(scene_, &EffectKind::charge_strength);
  state.bjerrum =
      strength.value_or(NAN) * state.square_charge / (state.local_temperature * std::cbrt(bodies.size() / count));
  const std::vector<ClusterShape> shapes = analysis::cluster_shapes(bodies, pairs, 2, dipole);
  state.charge_dipole = analysis::mean_by_grains(shapes, &ClusterShape::charge_dipole);
  state.induced_dipole = analysis::mean_by_grains(shapes, &ClusterShape::induced_dipole);
  state.percolating = static_cast<int>(std::ranges::count_if(shapes, &ClusterShape::percolates));
  state.dimension = analysis::cluster_dimension(shapes);
  std::ranges::copy_if(shapes, std::back_inserter(state.shapes),
                       [](const ClusterShape& shape) { return shape.grains >= analysis::least_grains; });
  state.exponent = analysis::size_exponent(grains, 2);
  return state;
}

GasFrame GasAnalyser::one(int index) const {
  constexpr int speed_bins = 50, charge_bins = 60;
  constexpr double fastest = 5, most = 6;  // in rms values
  const Bodies now = bodies(index);
  const std::vector<Pair> touching = contacts(index);
  const std::vector<double> dipole = result_.frame(index).reals("dipole");
  GasFrame found{.frame = index,
                 .time = result_.times()[index],
                 .gas = analysis::gas_state(now, touching),
                 .contacts = static_cast<std::int64_t>(touching.size()),
                 .total_charge = std::accumulate(now.charge.begin(), now.charge.end(), 0.0),
                 .correlation = now.charge.empty()
                                    ? NAN
                                    : analysis::correlation(squares(now.charge), analysis::squared_speeds(now)),
                 .speeds = analysis::histogram(analysis::scaled_speeds(now), 0, fastest, speed_bins),
                 .charges = analysis::histogram(analysis::scaled_charges(now.charge), -most, most, charge_bins),
                 .contact = state_of(now, touching, dipole),
                 .mach = analysis::mach_number(now, analysis::temperature_edge),
                 .structure = analysis::structure_factors(now),
                 .displacement = analysis::mean_square_displacement(first_, now),
                 .persistence = index > 0 ? analysis::persistence(contacts(index - 1), touching) : NAN,
                 .charge_by_speed = analysis::charge_by_speed(now, fastest_of_charges, charge_by_speed_bins)};
  found.energies = energies_at(found.time);
  found.density_exponent = analysis::size_exponent(found.gas.density.size);
  if (const auto strength = number_in(scene_, &EffectKind::charge_strength))
    found.bound = state_of(now, analysis::bound_pairs(now, *strength), dipole);
  return found;
}

std::vector<Column> columns_of(const AnalysedGas& run, const GasFrames& frames) {
  Columns<GasFrame> columns(frames);
  columns.real("time", "t0", [](auto& f) { return f.time; });
  columns.real("temperature", energy_unit, [](auto& f) { return f.gas.temperature.total; });
  columns.real("local_temperature", energy_unit, [](auto& f) { return f.gas.temperature.local; });
  for (std::size_t k = 0; k < energy_names.size(); ++k)
    columns.real(energy_names[k], energy_unit, [k](auto& f) { return f.energies[k]; });
  columns.real("sonine", "1", [](auto& f) { return f.gas.sonine; });
  columns.real("total_charge", "q0", [](auto& f) { return f.total_charge; });
  columns.real("mean_charge_magnitude", "q0", [](auto& f) { return f.gas.charge.magnitude; });
  columns.real("mean_square_charge", "q0^2", [](auto& f) { return f.gas.charge.square; });
  columns.real("charge_kurtosis", "1", [](auto& f) { return f.gas.charge.kurtosis; });
  columns.real("charge_speed_correlation", "1", [](auto& f) { return f.correlation; });
  columns.integer("contacts", [](auto& f) { return f.contacts; });
  add_clusters(columns, run, "", [](const GasFrame& f) -> const ClusterState& { return f.contact; });
  if (!frames.empty() && frames.front().bound)
    add_clusters(columns, run, "bound_", [](const GasFrame& f) -> const ClusterState& { return *f.bound; });
  columns.integer("density_clusters", [](auto& f) { return static_cast<std::int64_t>(f.gas.density.size.size()); });
  columns.real("density_cluster_size", "1", [](auto& f) { return f.gas.density.mean_size(); });
  columns.real("aggregate_local_slope", "1", [](auto& f) { return f.aggregate_slope; });
  columns.real("density_local_slope", "1", [](auto& f) { return f.density_slope; });
  columns.integers("density_cluster_number", [](auto& f) { return number_by_size(f.gas.density.size); });
  add_exponent(
      columns, "density_cluster_exponent", [](auto& f) -> auto& { return f.density_exponent; });
  columns.real("mach_number", "1", [](auto& f) { return f.mach.raw; });
  columns.real("mach_number_of_flow", "1", [](auto& f) { return f.mach.flow; });
  columns.real("mean_square_displacement", "d0^2", [](auto& f) { return f.displacement; });
  columns.real("contact_persistence", "1", [](auto& f) { return f.persistence; });
  columns.reals(
      "density_structure", "1", [](auto& f) { return f.structure.density; }, NAN);
  columns.reals("speed_density", "1", [](auto& f) { return f.speeds.density; });
  if (run.charged) {
    columns.reals(
        "charge_structure", "1", [](auto& f) { return f.structure.charge; }, NAN);
    columns.reals("charge_by_speed", "1", [](auto& f) { return f.charge_by_speed; });
    columns.reals("charge_density", "1", [](auto& f) { return f.charges.density; });
  }
  return columns.take();
}

void print_analysis(const AnalysedGas& run, const GasFrames& frames) {
  fmt::print("{}: {}, {} grains, {} frames, in units of d0, m0, v0 and q0\n\n", printable(run.file),
             printable(run.title), run.grains, run.frames);
  print_gas_head();
  for (const GasFrame& found : frames) print_gas_line(found);
  print_last(frames.back());
  if (frames.size() == 1) return;
  fmt::print("\ngrowth after the warm-up of {:g} t0\n", run.warm_up);
  print_growth(size_growth(run, frames, aggregate_of), "aggregates");
  print_growth(size_growth(run, frames, dense_size_of), "dense cells: S");
}

nlohmann::ordered_json analysis_json(const AnalysedGas& run, const GasFrames& frames) {
  const Histogram &speeds = frames.back().speeds, &charges = frames.back().charges;
  const analysis::DensityClusters& density = frames.back().gas.density;
  nlohmann::ordered_json json{{"file", run.file},
                              {"title", run.title},
                              {"grains", run.grains},
                              {"temperature_edge", analysis::temperature_edge},
                              {"density_edge", density.cells.edge.x},
                              {"density_least", density.least},
                              {"warm_up", run.warm_up},
                              {"warnings", run.warnings},
                              {"charge_by_speed_bins", {0, fastest_of_charges}},
                              {"speed_bins", {speeds.low, speeds.high}},
                              {"charge_bins", {charges.low, charges.high}}};
  json["growth"] = {{"aggregates", json_of_growth(size_growth(run, frames, aggregate_of))},
                    {"dense_cells", json_of_growth(size_growth(run, frames, dense_size_of))}};
  json["notes"] = run.notes;
  json["null"] = missing_reasons(run);
  add_frames(json, columns_of(run, frames), frames);
  return json;
}

}  // namespace lichtenberg
