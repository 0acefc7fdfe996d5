#include "src/commands/analyse_gas.hpp"

#include <fmt/format.h>

#include <numeric>
#include <utility>

#include "solvers/error.hpp"
#include "src/commands/analyse_columns.hpp"
#include "src/scene/effect_kind.hpp"

namespace lichtenberg {
namespace {

using GasFrames = std::vector<GasFrame>;
using analysis::Histogram;

constexpr const char* energy_unit = "m0 v0^2";

/// How many there are of each size, from 0 on.
std::vector<int> number_by_size(std::span<const int> sizes) {
  std::vector<int> number(sizes.empty() ? 1 : *std::ranges::max_element(sizes) + 1);
  for (const int size : sizes) ++number[size];
  return number;
}

ClusterState state_of(const Bodies& bodies, std::span<const std::int32_t> numbers) {
  ClusterState state{.sizes = analysis::cluster_sizes(numbers)};
  const std::vector<analysis::Cluster> clusters = analysis::clusters(bodies, numbers);
  const auto count = static_cast<double>(clusters.size());
  std::vector<int> grains;
  for (const analysis::Cluster& cluster : clusters) grains.push_back(cluster.grains);
  state.number = number_by_size(grains);
  for (const analysis::Cluster& cluster : clusters) {
    state.temperature += cluster.mass * norm2(cluster.velocity) / (bodies.dimension * count);
    state.square_charge += cluster.charge * cluster.charge / count;
  }
  return state;
}

std::vector<Pair> pairs_of(const std::optional<std::vector<analysis::Edge>>& contacts) {
  std::vector<Pair> pairs;
  if (contacts)
    for (const auto& [i, j] : *contacts) pairs.push_back({i, j});
  return pairs;
}

std::vector<double> squares(std::vector<double> values) {
  for (double& value : values) value *= value;
  return values;
}

void add_clusters(Columns<GasFrame>& columns, const std::string& kind,
                  const std::function<const ClusterState&(const GasFrame&)>& of) {
  columns.whole(kind + "clusters", [=](auto& f) { return of(f).sizes.number; });
  columns.whole("largest_" + kind + "cluster", [=](auto& f) { return of(f).sizes.largest; });
  columns.real("mean_" + kind + "aggregate", "1", [=](auto& f) { return of(f).sizes.aggregate; });
  columns.real("mean_" + kind + "cluster", "1", [=](auto& f) { return of(f).sizes.mean; });
  columns.wholes(kind + "cluster_number", [=](auto& f) { return of(f).number; });
  columns.real(kind + "cluster_temperature", energy_unit, [=](auto& f) { return of(f).temperature; });
  columns.real(kind + "cluster_square_charge", "q0^2", [=](auto& f) { return of(f).square_charge; });
}

void print_gas_head() {
  fmt::print("{:>6} {:>9} {:^21} {:>7} {:^27} {:>8} {:^24} {:^14}\n", "", "", "T", "", "charge", "",
             "clusters in contact", "dense cells");
  fmt::print("{:>6} {:>9} {:>10} {:>10} {:>7} {:>9} {:>9} {:>7} {:>8} {:>8} {:>7} {:>7} {:>6} {:>7}\n", "frame", "t",
             "local", "with flow", "a_2", "sum", "<q^2>", "kurt.", "contacts", "number", "largest", "mean>1", "number",
             "S");
}

void print_gas_line(const GasFrame& f) {
  fmt::print("{:>6} {:>9.4g} {:>10.4g} {:>10.4g} {:>7.3f} {:>9.2g} {:>9.3g} {:>7.3g} ", f.frame, f.time,
             f.gas.temperature.local, f.gas.temperature.total, f.gas.sonine, f.total_charge, f.gas.charge.square,
             f.gas.charge.kurtosis);
  const analysis::ClusterSizes& c = f.contact.sizes;
  fmt::print("{:>8} {:>8} {:>7} {:>7.3g} {:>6} {:>7.3g}\n", f.contacts, c.number, c.largest, c.aggregate,
             f.gas.density.size.size(), f.gas.density.mean_size());
}

void print_clusters(const std::string& kind, const ClusterState& state) {
  fmt::print("{:<15}{}, the largest of {}, by mass of {:.3g}; T = {:.4g} and <q^2> = {:.4g} of them as bodies\n", kind,
             state.sizes.number, state.sizes.largest, state.sizes.mean, state.temperature, state.square_charge);
}

void print_last(const GasFrame& f) {
  const analysis::DensityClusters& d = f.gas.density;
  fmt::print("\nframe {} at t = {:.6g} t0\n", f.frame, f.time);
  print_clusters("in contact", f.contact);
  if (f.bound) print_clusters("bound", *f.bound);
  fmt::print("dense          cells of {:.4g} d0 with at least {} grains\n", d.cells.edge.x, d.least);
  fmt::print("correlation    {:.3g} of charge^2 and speed^2\n", f.correlation);
}

}  // namespace

GasAnalyser::GasAnalyser(const Result& result, Scene scene)
    : result_(result), scene_(std::move(scene)), at_start_(make_bodies(scene_)) {
  if (at_start_.radius.size() != result_.radius().size())
    throw InputError(fmt::format("{} is damaged and cannot be analysed (its scene has {} grains, its frames {})",
                                 result_.path(), at_start_.radius.size(), result_.radius().size()));
}

AnalysedGas GasAnalyser::run() const {
  return {.file = result_.path(), .title = scene_.title, .grains = at_start_.size(), .frames = result_.frames()};
}

std::vector<GasFrame> GasAnalyser::all() const {
  std::vector<GasFrame> found;
  for (int k = 0; k < result_.frames(); ++k) found.push_back(one(k));
  return found;
}

Bodies GasAnalyser::bodies(int index) const {
  const Frame frame = result_.frame(index);
  const std::vector<double> position = frame.reals("position"), velocity = frame.reals("velocity");
  Bodies bodies = at_start_;
  const int d = bodies.dimension;
  if (position.size() != 3 * bodies.radius.size() || velocity.size() != position.size())
    throw InputError(
        fmt::format("{} is damaged and cannot be analysed (frame {} has not the places and velocities of "
                    "{} grains)",
                    result_.path(), index, bodies.size()));
  for (int i = 0; i < bodies.size(); ++i)
    for (int k = 0; k < d; ++k) {
      bodies.position[i * d + k] = position[3 * i + k];
      bodies.momentum[i * d + k] = bodies.mass[i] * velocity[3 * i + k];
    }
  bodies.charge = frame.reals("charge");
  return bodies;
}

GasFrame GasAnalyser::one(int index) const {
  constexpr int speed_bins = 50, charge_bins = 60;
  constexpr double fastest = 5, most = 6;  // in rms values
  const Bodies now = bodies(index);
  const std::vector<Pair> contacts = pairs_of(result_.contacts(index));
  GasFrame found{
      .frame = index,
      .time = result_.times()[index],
      .gas = analysis::gas_state(now, contacts),
      .contacts = static_cast<std::int64_t>(contacts.size()),
      .total_charge = std::accumulate(now.charge.begin(), now.charge.end(), 0.0),
      .correlation = now.charge.empty() ? 0 : analysis::correlation(squares(now.charge), analysis::squared_speeds(now)),
      .speeds = analysis::histogram(analysis::scaled_speeds(now), 0, fastest, speed_bins),
      .charges = analysis::histogram(analysis::scaled_charges(now.charge), -most, most, charge_bins),
      .contact = state_of(now, analysis::cluster_numbers(now.size(), contacts)),
      .bound = {}};
  if (const auto strength = number_in(scene_, &EffectKind::charge_strength))
    found.bound = state_of(now, analysis::cluster_numbers(now.size(), analysis::bound_pairs(now, *strength)));
  return found;
}

std::vector<Column> columns_of(const AnalysedGas&, const GasFrames& frames) {
  Columns<GasFrame> columns(frames);
  columns.real("time", "t0", [](auto& f) { return f.time; });
  columns.real("temperature", energy_unit, [](auto& f) { return f.gas.temperature.total; });
  columns.real("local_temperature", energy_unit, [](auto& f) { return f.gas.temperature.local; });
  columns.real("sonine", "1", [](auto& f) { return f.gas.sonine; });
  columns.real("total_charge", "q0", [](auto& f) { return f.total_charge; });
  columns.real("mean_charge_magnitude", "q0", [](auto& f) { return f.gas.charge.magnitude; });
  columns.real("mean_square_charge", "q0^2", [](auto& f) { return f.gas.charge.square; });
  columns.real("charge_kurtosis", "1", [](auto& f) { return f.gas.charge.kurtosis; });
  columns.real("charge_speed_correlation", "1", [](auto& f) { return f.correlation; });
  columns.whole("contacts", [](auto& f) { return f.contacts; });
  add_clusters(columns, "", [](const GasFrame& f) -> const ClusterState& { return f.contact; });
  if (!frames.empty() && frames.front().bound)
    add_clusters(columns, "bound_", [](const GasFrame& f) -> const ClusterState& { return *f.bound; });
  columns.whole("density_clusters", [](auto& f) { return static_cast<std::int64_t>(f.gas.density.size.size()); });
  columns.real("density_cluster_size", "1", [](auto& f) { return f.gas.density.mean_size(); });
  columns.wholes("density_cluster_number", [](auto& f) { return number_by_size(f.gas.density.size); });
  columns.reals("speed_density", "1", [](auto& f) { return f.speeds.density; });
  columns.reals("charge_density", "1", [](auto& f) { return f.charges.density; });
  return columns.take();
}

void print_analysis(const AnalysedGas& run, const GasFrames& frames) {
  fmt::print("{}: {}, {} grains, {} frames, in units of d0, m0, v0 and q0\n\n", run.file, run.title, run.grains,
             run.frames);
  print_gas_head();
  for (const GasFrame& found : frames) print_gas_line(found);
  print_last(frames.back());
}

void print_analysis_json(const AnalysedGas& run, const GasFrames& frames) {
  const Histogram &speeds = frames.back().speeds, &charges = frames.back().charges;
  const analysis::DensityClusters& density = frames.back().gas.density;
  nlohmann::ordered_json json{{"file", run.file},
                              {"title", run.title},
                              {"grains", run.grains},
                              {"temperature_edge", analysis::temperature_edge},
                              {"density_edge", density.cells.edge.x},
                              {"density_least", density.least},
                              {"speed_bins", {speeds.low, speeds.high}},
                              {"charge_bins", {charges.low, charges.high}}};
  add_frames(json, columns_of(run, frames), frames);
  fmt::print("{}\n", json.dump(1));
}

}  // namespace lichtenberg
