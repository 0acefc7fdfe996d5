#include "src/granular/summary.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

#include "src/effects/coulomb.hpp"

namespace lichtenberg::granular {
namespace {

double total_charge(const Gas& gas) {
  const std::vector<double>& charge = gas.bodies().charge;
  return std::accumulate(charge.begin(), charge.end(), 0.0);
}

/// Returns the magnitude of the total momentum, and its ratio to the value sqrt(sum of p^2) for random directions.
std::pair<double, double> momentum(const Bodies& bodies) {
  Vec3 sum{};
  double squares = 0;
  for (std::size_t k = 0; k < bodies.momentum.size(); ++k) {
    sum[static_cast<int>(k) % bodies.dimension] += bodies.momentum[k];
    squares += bodies.momentum[k] * bodies.momentum[k];
  }
  return {norm(sum), squares > 0 ? norm(sum) / std::sqrt(squares) : 0};
}

std::string temperature_line(const Note& now) {
  const analysis::GranularTemperature& t = now.gas.temperature;
  std::string text =
      std::isnan(t.local)
          ? fmt::format("{:.4g} with all flow: no cell of {:g} d0 has two grains", t.total, analysis::temperature_edge)
          : fmt::format("{:.4g} relative to the flow in cells of {:g} d0, {:.4g} with it", t.local,
                        analysis::temperature_edge, t.total);
  if (now.expected) text += fmt::format("; a homogeneous neutral gas would have {:.4g}", now.expected->temperature);
  if (!std::isnan(now.gas.sonine)) text += fmt::format("; a_2 = {:.3g}", now.gas.sonine);
  return text;
}

std::string charge_line(const Gas& gas, const Note& now) {
  const analysis::ChargeMoments& q = now.gas.charge;
  std::string text =
      fmt::format("{:.3g} in total; mean |q| {:.4g}, rms {:.4g}", total_charge(gas), q.magnitude, std::sqrt(q.square));
  if (!std::isnan(q.kurtosis)) text += fmt::format(", kurtosis {:.3g}", q.kurtosis);
  if (now.expected && now.expected->charge_square.value_or(0) > 0)
    text += fmt::format("; <q^2> is {:.3g} times that of a homogeneous gas in which no three meet",
                        q.square / *now.expected->charge_square);
  return text;
}

std::string clusters_line(const Gas& gas, const Note& now) {
  const analysis::ClusterSizes& c = now.gas.contact;
  std::string text = fmt::format("{} of {} grains, {} contacts, the largest of {}", c.number, gas.bodies().size(),
                                 now.contacts, c.largest);
  if (!std::isnan(c.aggregate)) text += fmt::format("; those of two and more have {:.3g} on average", c.aggregate);
  return text;
}

std::string density_line(const Note& now) {
  const analysis::DensityClusters& d = now.gas.density;
  const std::string cells = fmt::format("cells of {:.3g} d0 with {} grains or more", d.cells.edge.x, d.least);
  if (d.size.empty()) return "no " + cells;
  return fmt::format("{} clusters of {}, S = {:.3g} cells", d.size.size(), cells, d.mean_size());
}

std::string collisions_line(const Gas& gas, const Note& now) {
  std::string text = fmt::format("{}", gas.collisions);
  if (now.expected && now.expected->collisions > 0)
    text += fmt::format(
        ", {:.3g} times those of a homogeneous gas of the same temperature (every contact counts, also within "
        "clusters)",
        static_cast<double>(gas.collisions) / now.expected->collisions);
  return text + fmt::format("; largest overlap {:.3g} of a diameter", gas.largest_overlap);
}

std::string energy_line(const GasEnergy& e, double error) {
  std::string text = fmt::format("{:.6g} kinetic, ", e.kinetic);
  if (e.rotational) text += fmt::format("{:.4g} of rotation, ", *e.rotational);
  text += fmt::format("{:.4g} in contacts", e.contact);
  if (e.potential != 0) text += fmt::format(", {:.4g} of charges", e.potential);
  text += fmt::format("; {:.6g} dissipated", e.dissipated);
  if (e.exchanged != 0) text += fmt::format(", {:.4g} gained by exchange", e.exchanged);
  if (e.driven != 0) text += fmt::format(", {:.4g} by driving", e.driven);
  text += fmt::format(": error {:.1e}", error);
  if (e.dissipated > 0) text += fmt::format(", {:.1e} of the dissipated energy", std::abs(error) / e.dissipated);
  if (e.contact_error != 0)  // integrators that separate the two
    text += fmt::format("; {:.1e} by contact substeps, {:.1e} by steps of smooth forces", e.contact_error,
                        error - e.contact_error);
  return text;
}

std::string in_words(const RestitutionCheck::Decade& found) {
  return fmt::format("error {:.1e} on average, {:.1e} at most, in {}", found.mean(), found.worst, found.collisions);
}

/// Adds a line about the errors of the restitution coefficient for all head-on collisions of isolated pairs, and a line
/// for each decade of the impact speed.
void add_restitution(const Gas& gas, Summary& summary) {
  const RestitutionCheck::Decade all = gas.restitution.all();
  if (all.collisions == 0) return;
  const bool charged = !gas.bodies().charge.empty();
  summary.lines.push_back(
      {"restitution", in_words(all) + " collisions of isolated pairs, with an error of at most 1e-3 by rotation" +
                          (charged ? "; charges change it, which the contact law does not include" : "")});
  for (int k = 0; k < RestitutionCheck::decades; ++k)
    if (const auto& decade = gas.restitution.by_speed()[k]; decade.collisions > 0)
      summary.lines.push_back({fmt::format("  speed 1e{}", RestitutionCheck::first_decade + k), in_words(decade)});
}

void add_lines(const Gas& gas, const Note& now, double energy_error, Summary& summary) {
  summary.lines = {{"temperature", temperature_line(now)}};
  summary.lines.push_back({"momentum", fmt::format("{:.1e} of the thermal one", momentum(gas.bodies()).second)});
  if (!gas.bodies().charge.empty()) summary.lines.push_back({"charge", charge_line(gas, now)});
  summary.lines.push_back({"clusters", clusters_line(gas, now)});
  summary.lines.push_back({"density", density_line(now)});
  summary.lines.push_back({"collisions", collisions_line(gas, now)});
  add_restitution(gas, summary);
  summary.lines.push_back({"energy", energy_line(now.energy, energy_error)});
  summary.lines.push_back({"steps", fmt::format("{}, {} of contacts", gas.steps, gas.contact_steps)});
  if (!gas.scene().output.picture) return;
  const std::filesystem::path picture = std::filesystem::path(gas.scene().output.file).replace_extension();
  summary.lines.push_back({"pictures", fmt::format("{0}.png (grains), {0}-series.png (over time)", picture.string())});
}

void add_quantities(const Gas& gas, const Note& now, double energy_error, Summary& summary) {
  const std::string energy = "m0 v0^2";
  const RestitutionCheck::Decade restitution = gas.restitution.all();
  summary.quantities = {{"finished", now.time >= gas.scene().stop.time ? 1.0 : 0.0, "1"},
                        {"time", now.time, "t0"},
                        {"temperature", now.gas.temperature.total, energy},
                        {"local_temperature", now.gas.temperature.local, energy},
                        {"sonine", now.gas.sonine, "1"},
                        {"momentum", momentum(gas.bodies()).first, "m0 v0"},
                        {"mean_charge_magnitude", now.gas.charge.magnitude, "q0"},
                        {"mean_square_charge", now.gas.charge.square, "q0^2"},
                        {"total_charge", total_charge(gas), "q0"},
                        {"energy_error", energy_error, energy},
                        {"contact_energy_error", now.energy.contact_error, energy},
                        {"dissipated_energy", now.energy.dissipated, energy},
                        {"contacts", static_cast<double>(now.contacts), "1"},
                        {"clusters", static_cast<double>(now.gas.contact.number), "1"},
                        {"largest_cluster", static_cast<double>(now.gas.contact.largest), "1"},
                        {"mean_aggregate", now.gas.contact.aggregate, "1"},
                        {"density_cluster_size", now.gas.density.mean_size(), "1"},
                        {"collisions", static_cast<double>(gas.collisions), "1"},
                        {"largest_overlap", gas.largest_overlap, "1"},
                        {"restitution_error", restitution.worst, "1"}};
  if (!now.expected) return;
  summary.quantities.push_back({"haff_temperature", now.expected->temperature, energy});
  summary.quantities.push_back({"expected_collisions", now.expected->collisions, "1"});
}

/// Returns the largest error that the potential energy itself causes in the change of total energy. Its sum over n
/// grains rounds by at most n units in the last digit, at the start and now. In a periodic domain the forces F of a
/// mesh or of Ewald's sum have a relative accuracy. The energy of a pair is of the order of F r, and so has this
/// accuracy too. Forces of sums over pairs are derivatives of their energy, which only rounds.
double potential_error(const Gas& gas, const GasEnergy& energy) {
  const Scene& scene = gas.scene();
  const double n = static_cast<double>(scene.conductors.size());
  const double by_rounding = 2 * n * std::numeric_limits<double>::epsilon();
  const auto* coulomb = scene.effects.find<effects::CoulombOptions>();
  const bool by_waves = coulomb && !scene.domain.open &&
                        (coulomb->sum == effects::CoulombSum::mesh || coulomb->sum == effects::CoulombSum::ewald);
  const double by_field = by_waves ? coulomb->accuracy : 0;
  return (by_rounding + by_field) * std::abs(energy.potential);
}

/// Returns a warning if the error of the energy budget exceeds 1 % of the converted energy and the error of the
/// potential energy; otherwise an empty string. The converted energy is the largest of kinetic, dissipated, exchanged
/// and driven energy.
std::string energy_warning(const Gas& gas, const GasEnergy& energy, double error, double at_start) {
  constexpr double allowed = 1e-2;  // ten times the error of default contact substeps
  const double turned_over = std::max({energy.kinetic, energy.rotational.value_or(0), energy.dissipated,
                                       std::abs(energy.exchanged), std::abs(energy.driven)});
  const double scale = turned_over > 0 ? turned_over : std::abs(at_start);
  const double most = allowed * scale + potential_error(gas, energy);
  if (std::abs(error) <= most) return "";
  const IntegratorKind& integrator = gas.scene().mechanics.kind();
  const bool by_contacts =
      integrator.reads("contact_substeps") && std::abs(energy.contact_error) > 0.5 * std::abs(error);
  const char* advice = by_contacts                              ? "use more mechanics.contact_substeps"
                       : integrator.reads("relative_tolerance") ? "use a smaller mechanics.relative_tolerance"
                                                                : "use a shorter mechanics.step";
  return fmt::format(
      "energy balance off by {:.2g} % of the kinetic, dissipated and driven energy, where {:.2g} % is allowed; {}",
      100 * std::abs(error) / scale, 100 * most / scale, advice);
}

std::vector<std::string> warnings_of(const Gas& gas, const GasEnergy& energy, double error, double at_start) {
  constexpr double most_overlap = 0.1;  // contact laws hold for small overlaps
  std::vector<std::string> warnings;
  if (std::string warning = energy_warning(gas, energy, error, at_start); !warning.empty())
    warnings.push_back(std::move(warning));
  if (std::string warning = stages_warning(gas.scene()); !warning.empty()) warnings.push_back(std::move(warning));
  if (gas.largest_overlap > most_overlap)
    warnings.push_back(
        fmt::format("grains overlap by {:.2g} % of a diameter: contact laws are valid up to a few per cent; a stiffer "
                    "contact or slower grains reduce the overlap",
                    100 * gas.largest_overlap));
  return warnings;
}

}  // namespace

std::string stages_warning(const Scene& scene) {
  double stages = 0;
  for (const Stage& stage : scene.stages) stages += stage.duration;
  if (stages == 0 || scene.stop.time > stages) return "";
  return fmt::format(
      "stages alone: stop.time = {0:g} t0 counts from the start and leaves nothing after the stages, which last {1:g} "
      "t0; stop.time = {2:g} would go on for {0:g} t0 after them",
      scene.stop.time, stages, stages + scene.stop.time);
}

Summary summarize(Gas& gas, const Note& now, double energy_at_start) {
  Summary summary{.title = fmt::format("holds the run up to t = {:.6g}", now.time), .goal = "finished"};
  const double energy_error = now.energy.total() - energy_at_start;
  add_lines(gas, now, energy_error, summary);
  add_quantities(gas, now, energy_error, summary);
  summary.warnings = warnings_of(gas, now.energy, energy_error, energy_at_start);
  gas.model().summarize(now.time, summary);
  return summary;
}

}  // namespace lichtenberg::granular
