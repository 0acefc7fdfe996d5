#include "src/granular/granular_motion.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "solvers/disjoint_sets.hpp"
#include "src/granular/integrator.hpp"
#include "src/model/stopwatch.hpp"

namespace lichtenberg {

using namespace granular;

namespace {

/// What is noted of a gas between frames too.
struct Note {
  double time = 0;
  EnergyBook energy;
  double temperature = 0, mean_square_charge = 0;
  std::int64_t contacts = 0, clusters = 0, collisions = 0;
};

/// Grains in contact are one cluster; one without contacts is one by itself.
std::vector<std::int32_t> clusters_of(int grains, const std::vector<GrainContact>& contacts) {
  DisjointSets sets(grains);
  for (const GrainContact& contact : contacts) sets.unite(contact.pair.i, contact.pair.j);
  std::vector<std::int32_t> number(grains);
  for (int i = 0; i < grains; ++i) number[i] = sets.find(i);
  return number;
}

double mean_square(const std::vector<double>& values) {
  double sum = 0;
  for (const double v : values) sum += v * v;
  return values.empty() ? 0 : sum / static_cast<double>(values.size());
}

}  // namespace

struct GranularMotion::Implementation {
  explicit Implementation(const Scene& scene)
      : gas(scene), integrator(make_integrator(scene.mechanics.integrator)), energy_at_start(gas.energy().total()) {}

  Note note() {
    Note note{.time = gas.time(), .energy = gas.energy()};
    const Bodies& b = gas.bodies();
    note.temperature = 2 * note.energy.kinetic / (b.dimension * b.size());
    note.mean_square_charge = mean_square(b.charge);
    note.contacts = static_cast<std::int64_t>(gas.contacts().size());
    const std::vector<std::int32_t> cluster = clusters_of(b.size(), gas.contacts());
    for (int i = 0; i < b.size(); ++i) note.clusters += cluster[i] == i;
    note.collisions = gas.collisions;
    return note;
  }

  /// One step towards `time`, and no farther than to the end of the stage.
  void step(double time) {
    const double end = std::min(time, gas.stage_end()), left = end - gas.time();
    const double count = std::ceil(left / integrator->longest_step(gas));
    integrator->step(gas, count <= 1 ? end : gas.time() + left / count);
    if (gas.time() < gas.stage_end()) return;
    gas.leave_stage();
    integrator->begin_anew();
  }

  double next_note() const {
    const double every = gas.scene().output.every / notes_a_frame;
    return every * (std::floor(gas.time() / every + 1e-9) + 1);
  }

  static constexpr int notes_a_frame = 10;
  Gas gas;
  std::unique_ptr<granular::Integrator> integrator;
  double energy_at_start;
  std::vector<Note> notes;
  double seconds = 0;
};

GranularMotion::GranularMotion(const Scene& scene) : implementation_(std::make_unique<Implementation>(scene)) {
  implementation_->notes.push_back(implementation_->note());
}
GranularMotion::~GranularMotion() = default;

double GranularMotion::time() const { return implementation_->gas.time(); }
double GranularMotion::end_time() const { return implementation_->gas.scene().stop.time; }
bool GranularMotion::finished() { return time() >= end_time(); }

double GranularMotion::next_frame() const {
  constexpr double rounding = 1e-9;
  const double every = implementation_->gas.scene().output.every, stop = end_time();
  const double next = every * (std::floor(time() / every + rounding) + 1);
  return next < stop - rounding * every ? next : stop;
}

void GranularMotion::advance_to(double time, const std::function<bool()>& pause) {
  Implementation& self = *implementation_;
  const Stopwatch stopwatch(self.seconds);
  while (self.gas.time() < time) {
    const double due = self.next_note();
    const bool noted = due < time - 1e-9 * self.gas.scene().output.every;
    const double end = noted ? due : time;
    while (self.gas.time() < end) {
      self.step(end);
      if (pause && pause()) return;
    }
    self.notes.push_back(self.note());
  }
}

Frame GranularMotion::frame() {
  Implementation& self = *implementation_;
  const Bodies& b = self.gas.bodies();
  Frame frame{.time = time(), .time_unit = time_unit()};
  std::vector<double> velocity;
  for (std::size_t k = 0; k < b.momentum.size(); ++k) velocity.push_back(b.momentum[k] / b.mass[k / b.dimension]);
  frame.add_vectors("position", "d0", b.position, b.dimension);
  frame.add_vectors("velocity", "v0", velocity, b.dimension);
  std::vector<std::int32_t> image;
  for (int i = 0; i < b.size(); ++i)
    for (int k = 0; k < 3; ++k) image.push_back(k < b.dimension ? b.image[i * b.dimension + k] : 0);
  frame.add_particles("image", "1", std::move(image), 3);
  if (!b.charge.empty()) frame.add_particles("charge", "q0", b.charge);
  frame.add_particles("cluster", "1", clusters_of(b.size(), self.gas.contacts()));
  std::vector<std::int32_t> pairs;
  for (const GrainContact& c : self.gas.contacts()) pairs.insert(pairs.end(), {c.pair.i, c.pair.j});
  frame.add_list("contacts", "1", std::move(pairs), 2);
  const EnergyBook energy = self.gas.energy();
  for (const auto& [name, value] : {std::pair{"kinetic_energy", energy.kinetic},
                                    {"contact_energy", energy.contact},
                                    {"potential_energy", energy.potential},
                                    {"dissipated_energy", energy.dissipated},
                                    {"exchanged_energy", energy.exchanged},
                                    {"driven_energy", energy.driven}})
    frame.add_system(name, "m0 v0^2", value);
  frame.add_system("collisions", "1", self.gas.collisions);
  self.gas.model().add_columns(time(), frame);
  return frame;
}

std::string GranularMotion::progress() {
  const Note now = implementation_->note();
  std::string text = fmt::format("t = {:.4g} of {:.4g}, T = {:.3g}", now.time, end_time(), now.temperature);
  if (now.mean_square_charge > 0) text += fmt::format(", rms charge {:.3g}", std::sqrt(now.mean_square_charge));
  return text + fmt::format(", {} clusters", now.clusters);
}

ColumnGroup GranularMotion::take_history() {
  const std::vector<Note> notes = std::exchange(implementation_->notes, {});
  const auto reals = [&](std::string name, std::string unit, auto value) {
    std::vector<double> values;
    for (const Note& note : notes) values.push_back(value(note));
    return Column{std::move(name), std::move(unit), Column::Of::list, 0, std::move(values)};
  };
  const auto counts = [&](std::string name, auto value) {
    std::vector<std::int64_t> values;
    for (const Note& note : notes) values.push_back(value(note));
    return Column{std::move(name), "1", Column::Of::list, 0, std::move(values)};
  };
  const std::string energy = "m0 v0^2";
  return {"gas",
          {reals("time", "t0", [](const Note& n) { return n.time; }),
           reals("temperature", energy, [](const Note& n) { return n.temperature; }),
           reals("mean_square_charge", "q0^2", [](const Note& n) { return n.mean_square_charge; }),
           reals("kinetic_energy", energy, [](const Note& n) { return n.energy.kinetic; }),
           reals("contact_energy", energy, [](const Note& n) { return n.energy.contact; }),
           reals("potential_energy", energy, [](const Note& n) { return n.energy.potential; }),
           reals("dissipated_energy", energy, [](const Note& n) { return n.energy.dissipated; }),
           reals("exchanged_energy", energy, [](const Note& n) { return n.energy.exchanged; }),
           reals("driven_energy", energy, [](const Note& n) { return n.energy.driven; }),
           counts("contacts", [](const Note& n) { return n.contacts; }),
           counts("clusters", [](const Note& n) { return n.clusters; }),
           counts("collisions", [](const Note& n) { return n.collisions; })}};
}

Summary GranularMotion::summary() {
  Implementation& self = *implementation_;
  const Note now = self.note();
  const EnergyBook& e = now.energy;
  const double left = e.total() - self.energy_at_start;
  double charge = 0;
  for (const double q : self.gas.bodies().charge) charge += q;
  Summary summary{.title = fmt::format("holds the run up to t = {:.6g}", now.time), .goal = "finished"};
  summary.lines = {
      {"temperature", fmt::format("{:.4g}", now.temperature)},
      {"clusters", fmt::format("{} of {} grains, {} contacts", now.clusters, self.gas.bodies().size(), now.contacts)},
      {"collisions", fmt::format("{}, largest overlap {:.3g} of a diameter", now.collisions, self.gas.largest_overlap)},
      {"energy", fmt::format("{:.6g} kinetic + {:.4g} in contacts + {:.4g} of charges + {:.6g} dissipated - {:.4g} by "
                             "exchange - {:.4g} driven: off by {:.1e}, {:.1e} of what was dissipated",
                             e.kinetic, e.contact, e.potential, e.dissipated, e.exchanged, e.driven, left,
                             e.dissipated > 0 ? std::abs(left) / e.dissipated : 0)}};
  if (!self.gas.bodies().charge.empty())
    summary.lines.push_back(
        {"charge", fmt::format("{:.3g} in all, rms {:.4g}", charge, std::sqrt(now.mean_square_charge))});
  summary.lines.push_back({"steps", fmt::format("{}, {} of contacts", self.gas.steps, self.gas.contact_steps)});
  summary.quantities = {{"finished", finished() ? 1.0 : 0.0, "1"},
                        {"time", now.time, "t0"},
                        {"temperature", now.temperature, "m0 v0^2"},
                        {"mean_square_charge", now.mean_square_charge, "q0^2"},
                        {"total_charge", charge, "q0"},
                        {"energy_error", left, "m0 v0^2"},
                        {"dissipated_energy", e.dissipated, "m0 v0^2"},
                        {"contacts", static_cast<double>(now.contacts), "1"},
                        {"clusters", static_cast<double>(now.clusters), "1"},
                        {"collisions", static_cast<double>(now.collisions), "1"},
                        {"largest_overlap", self.gas.largest_overlap, "1"}};
  self.gas.model().summarize(now.time, summary);
  return summary;
}

std::map<std::string, double> GranularMotion::seconds() const { return {{"motion", implementation_->seconds}}; }

Checkpoint GranularMotion::checkpoint() {
  Checkpoint checkpoint = implementation_->gas.save();
  checkpoint.reals["energy_at_start"] = {implementation_->energy_at_start};
  implementation_->integrator->save(checkpoint);
  return checkpoint;
}

void GranularMotion::restore(const Checkpoint& checkpoint) {
  implementation_->gas.restore(checkpoint);
  implementation_->energy_at_start = reals(checkpoint, "energy_at_start", 1).front();
  implementation_->integrator->restore(checkpoint);
  implementation_->notes.clear();
}

}  // namespace lichtenberg
