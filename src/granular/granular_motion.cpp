#include "src/granular/granular_motion.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <future>
#include <thread>

#include "solvers/error.hpp"
#include "solvers/stopwatch.hpp"
#include "src/granular/device/device.hpp"
#include "src/granular/integrator.hpp"
#include "src/granular/note.hpp"
#include "src/granular/summary.hpp"

namespace lichtenberg {

using namespace granular;

namespace {

/// Time that is so late that a step is within its rounding stands still.
void check_shortest(const Scene& scene) {
  const double step = scene.mechanics.step, end = scene.stop.time;
  if (std::isfinite(end) && !(end + step > end))
    throw InputError(
        fmt::format("{}: mechanics.step = {:g} is too short for time to go on up to stop.time = {:g}: a longer step or "
                    "an earlier end is needed",
                    scene.path, step, end));
}

}  // namespace

struct GranularMotion::Implementation {
  Implementation(const Scene& scene, std::unique_ptr<granular::device::DeviceGas> on)
      : here(scene),
        integrator(make_integrator(scene.mechanics.integrator)),
        theory(HomogeneousGas::of(here)),
        device(std::move(on)) {
    check_shortest(scene);
    if (std::isfinite(scene.mechanics.step)) integrator->longest_step(here);  // refuses one before anything is written
    load();
    energy_at_start = here.energy(potential()).total();
  }

  /// The gas as it is now, brought here from the device if it is there.
  Gas& gas() {
    if (is_there) {
      Checkpoint checkpoint = here.save();
      device->store(checkpoint);
      here.restore(checkpoint);
      is_there = false;
    }
    return here;
  }
  double time() const { return is_there ? device->time() : here.time(); }

  /// Takes a note. Of a gas on a device others do so, while it goes on.
  void note() {
    if (!is_there) {
      settle();
      keep(take_note(here, theory, analysis_seconds, potential()));
      return;
    }
    if (pending.size() >= std::max(1u, std::thread::hardware_concurrency())) settle();
    pending.push_back(std::async(std::launch::async, [snapshot = device->snapshot(), of = like, law = here.law(),
                                                      book = flows] { return note_of(snapshot, *of, law, book); }));
  }
  /// Waits for the notes that are being taken.
  void settle() {
    const Stopwatch stopwatch(analysis_seconds);
    for (std::future<Note>& future : std::exchange(pending, {})) {
      Note taken = future.get();
      if (theory) expect(taken, here, *theory);
      keep(std::move(taken));
    }
  }
  void keep(Note note) {
    notes.push_back(note);
    last = std::move(note);
  }
  /// The note of now; one that leaves the theory where it is, or what follows would depend on who looked when.
  Note look(std::optional<HomogeneousGas> with = {}) {
    settle();
    if (last && last->time == time()) return *last;
    return take_note(gas(), with, analysis_seconds, potential());
  }
  /// What the device knows of it, if it has the gas as it is.
  std::optional<double> potential() { return loaded ? std::optional(device->potential_energy()) : std::nullopt; }

  /// One step towards `time`, and no farther than to the end of the stage.
  void step(double time) {
    const double end = std::min(time, here.stage_end());
    device ? step_there(end) : step_here(end);
    if (this->time() >= here.stage_end()) leave_stage();
  }
  void step_here(double end) {
    const double left = end - here.time(), count = std::ceil(left / integrator->longest_step(here));
    integrator->step(here, count <= 1 ? end : here.time() + left / count);
  }
  void step_there(double end) {
    load();
    is_there = true;
    device->step(end, steps_at_once);
  }
  /// Takes the gas to the device, if there is one.
  void load() {
    if (!device || loaded) return;
    device->load(here.save(), here.law(), here.in_elastic_stage());
    loaded = true;
    flows = here.energy(0);
    const Bodies& b = here.bodies();
    like = std::make_shared<Bodies>(Bodies{.dimension = b.dimension, .mass = b.mass, .radius = b.radius, .box = b.box});
  }

  void leave_stage() {
    settle();
    if (theory) theory->follow(gas(), time(), look().temperature());
    const bool cools_on = gas().cools_on_after_stage();
    here.leave_stage();
    loaded = false;
    last.reset();
    integrator->begin_anew();
    if (theory && !cools_on) theory->begin(here);
  }

  double next_note() const {
    const double every = here.scene().output.every / notes_a_frame;
    return every * (std::floor(time() / every + 1e-9) + 1);
  }

  static constexpr int steps_at_once = 100;  ///< on a device, before who waits is asked
  static constexpr int notes_a_frame = 10;
  Gas here;
  std::unique_ptr<granular::GasIntegrator> integrator;
  double energy_at_start = 0;
  std::optional<HomogeneousGas> theory;
  std::unique_ptr<granular::device::DeviceGas> device;  ///< null: there is none
  bool loaded = false;                                  ///< the device has the gas, as it was or as it is
  bool is_there = false;                                ///< and has carried it on
  std::vector<Note> notes;
  std::optional<Note> last;                ///< that was taken, in this stage
  std::vector<std::future<Note>> pending;  ///< in the order of their times
  std::shared_ptr<const Bodies> like;      ///< masses, radii and box of what is there
  GasEnergy flows;                         ///< booked before it went there
  double seconds = 0, analysis_seconds = 0;
  bool warned = false;  ///< what effects have to say has been said
};

GranularMotion::GranularMotion(const Scene& scene) : GranularMotion(scene, nullptr) {}

GranularMotion::GranularMotion(const Scene& scene, std::unique_ptr<granular::device::DeviceGas> device)
    : implementation_(std::make_unique<Implementation>(scene, std::move(device))) {
  implementation_->note();
}
GranularMotion::~GranularMotion() = default;

double GranularMotion::time() const { return implementation_->time(); }
double GranularMotion::end_time() const { return implementation_->here.scene().stop.time; }
bool GranularMotion::finished() { return time() >= end_time(); }

double GranularMotion::next_frame() const {
  constexpr double rounding = 1e-9;
  const double every = implementation_->here.scene().output.every, stop = end_time();
  const double next = every * (std::floor(time() / every + rounding) + 1);
  return next < stop - rounding * every ? next : stop;
}

void GranularMotion::advance_to(double time, const std::function<bool()>& pause) {
  Implementation& self = *implementation_;
  const Stopwatch stopwatch(self.seconds);
  const auto is_to_stop = [&] {
    if (!pause || !pause()) return false;
    if (!exact_anywhere()) throw Paused();
    return true;
  };
  while (self.time() < time) {
    const double due = self.next_note();
    const bool noted = due < time - 1e-9 * self.here.scene().output.every;
    const double end = noted ? due : time;
    self.here.expect_energy_at(end);
    while (self.time() < end) {
      self.step(end);
      if (self.time() < end && is_to_stop()) return;
    }
    self.note();  // before any pause: a run that is resumed here goes on to the next one
    if (is_to_stop()) return;
  }
}

std::int64_t GranularMotion::searches() const { return implementation_->here.searches(); }

bool GranularMotion::exact_anywhere() const {
  return std::ranges::all_of(implementation_->here.model().effects, [](const auto& e) { return e->saves_exactly(); });
}

Frame GranularMotion::frame() {
  Implementation& self = *implementation_;
  const Bodies& b = self.gas().bodies();
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
  frame.add_particles("cluster", "1", analysis::cluster_numbers(b.size(), pairs_in_contact(self.here)));
  std::vector<std::int32_t> pairs;
  for (const auto& [i, j] : pairs_in_contact(self.here)) pairs.insert(pairs.end(), {i, j});
  frame.add_list("contacts", "1", std::move(pairs), 2);
  const GasEnergy energy = self.here.energy(self.potential());
  for (const auto& [name, value] : {std::pair{"kinetic_energy", energy.kinetic},
                                    {"contact_energy", energy.contact},
                                    {"potential_energy", energy.potential},
                                    {"dissipated_energy", energy.dissipated},
                                    {"exchanged_energy", energy.exchanged},
                                    {"driven_energy", energy.driven}})
    frame.add_system(name, "m0 v0^2", value);
  frame.add_system("collisions", "1", self.here.collisions);
  self.here.model_to_change().add_columns(time(), frame);
  return frame;
}

std::string GranularMotion::progress() {
  const Note now = implementation_->look();
  std::string text = fmt::format("t = {:.4g} of {:.4g}, T = {:.3g}", now.time, end_time(), now.temperature());
  if (now.gas.charge.square > 0) text += fmt::format(", mean |q| {:.3g}", now.gas.charge.magnitude);
  return text + fmt::format(", {} clusters", now.gas.contact.number);
}

ColumnGroup GranularMotion::take_history() {
  implementation_->settle();
  return columns_of(std::exchange(implementation_->notes, {}), implementation_->theory);
}

Summary GranularMotion::summary() {
  Implementation& self = *implementation_;
  return summarize(self.gas(), self.look(self.theory), self.energy_at_start);
}

std::vector<std::string> GranularMotion::warnings() {
  std::vector<std::string> all;
  if (std::exchange(implementation_->warned, true)) return all;
  for (const auto& effect : implementation_->here.model().effects)
    for (std::string& warning : effect->warnings()) all.push_back(std::move(warning));
  return all;
}

std::map<std::string, double> GranularMotion::seconds() const {
  const Implementation& self = *implementation_;
  const auto& [contacts, forces, lists, exchange] = self.here.seconds();
  std::map<std::string, double> all{{"contacts", contacts}, {"lists", lists}, {"analysis", self.analysis_seconds}};
  if (!self.here.bodies().charge.empty()) {
    double rest = forces;
    for (const auto& effect : self.here.model().effects)
      for (const auto& [part, value] : effect->seconds()) all[part] += value, rest -= value;
    all.insert({{"forces", std::max(rest, 0.0)}, {"exchange", exchange}});
  }
  if (self.device) all["device"] = self.device->counts().seconds;
  double known = 0;
  for (const auto& [activity, value] : all) known += value;
  all["other"] = std::max(self.seconds - known, 0.0);
  return all;
}

Checkpoint GranularMotion::checkpoint() {
  implementation_->settle();
  Checkpoint checkpoint = implementation_->gas().save();
  checkpoint.reals["energy_at_start"] = {implementation_->energy_at_start};
  implementation_->integrator->save(checkpoint);
  if (implementation_->theory) implementation_->theory->save(checkpoint);
  return checkpoint;
}

void GranularMotion::restore(const Checkpoint& checkpoint) {
  implementation_->settle();
  implementation_->here.restore(checkpoint);
  implementation_->loaded = implementation_->is_there = false;
  implementation_->energy_at_start = reals(checkpoint, "energy_at_start", 1).front();
  implementation_->integrator->restore(checkpoint);
  if (implementation_->theory) implementation_->theory->restore(checkpoint);
  implementation_->notes.clear();
  implementation_->last.reset();
}

}  // namespace lichtenberg
