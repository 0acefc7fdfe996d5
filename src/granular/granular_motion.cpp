#include "src/granular/granular_motion.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
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

/// Largest number of steps of a run, for which rounding of the time still resolves a single step.
constexpr double most_steps = 1e12;

void check_shortest(const Scene& scene) {
  const double step = scene.mechanics.step, end = scene.stop.time;
  if (std::isfinite(end) && !(end <= most_steps * step))
    throw InputError(
        fmt::format("{}: mechanics.step = {:g} is too short for stop.time = {:g}: that makes {:.2g} steps, and at most "
                    "{:g} are allowed",
                    scene.path, step, end, end / step, most_steps));
}

/// Returns the angular velocities of all grains as vectors in space, [N * 3].
std::vector<double> spins(const Bodies& bodies) {
  std::vector<double> all;
  for (int i = 0; i < bodies.size(); ++i) {
    const Vec3 w = spin_of(bodies, i);
    all.insert(all.end(), {w.x, w.y, w.z});
  }
  return all;
}

/// Throws Failure if the run would take more than most_steps steps.
void check_pace(const Gas& gas, double end, double step) {
  if ((end - gas.time()) <= most_steps * step) return;
  throw Failure(
      fmt::format("{}: time does not advance any more: at t = {:.6g} t0 the fastest grain has {:.3g} v0, which allows "
                  "steps of {:.2g} t0, and from there to t = {:g} t0 that makes more than {:g}; lower temperatures, "
                  "smaller charges or softer contacts are needed",
                  gas.scene().path, gas.time(), gas.fastest(), step, end, most_steps));
}

}  // namespace

struct GranularMotion::Implementation {
  Implementation(const Scene& scene, std::unique_ptr<GasIntegrator> by, std::unique_ptr<granular::device::DeviceGas> on)
      : host_gas(scene),
        integrator(std::move(by)),
        theory(HomogeneousGas::of(host_gas)),
        device(std::move(on)),
        stage_end(host_gas.stage_end()) {
    check_shortest(scene);
    instant = host_gas.instant();
    if (std::isfinite(scene.mechanics.step))
      integrator->longest_step(host_gas, instant);  // refuses a step that is too long before output begins
    load();
    energy_at_start = host_gas.energy(potential()).total();
  }

  /// Returns the gas on the CPU, after it has been copied back from the device if needed.
  Gas& gas() {
    wait_for_background_tasks();
    if (is_on_device) {
      copy_back(device->snapshot());
      is_on_device = false;
    }
    return host_gas;
  }
  void copy_back(const granular::device::Snapshot& snapshot) {
    Checkpoint checkpoint = host_gas.save();
    store(snapshot, checkpoint);
    host_gas.restore(checkpoint);
    instant = host_gas.instant();
  }
  double time() const { return is_on_device ? device->time() : host_gas.time(); }

  /// Returns a snapshot of the gas on the device; calls at the same instant return the same snapshot.
  std::shared_ptr<const granular::device::Snapshot> snapshot() {
    if (!now || now->time != device->time()) {
      const double potential = device->potential_energy();
      auto taken = std::make_shared<granular::device::Snapshot>(device->snapshot());
      taken->potential = potential;
      now = std::move(taken);
    }
    return now;
  }
  /// Waits for background tasks that use `host_gas`, `theory` and the notes, for frames and checkpoints of a gas on a
  /// device.
  void wait_for_background_tasks() {
    const Stopwatch stopwatch(analysis_seconds);
    for (const std::future<void>& task : std::exchange(background_tasks, {})) task.wait();
  }
  /// Registers a background task. It completes when its std::promise is fulfilled or destroyed.
  std::shared_ptr<std::promise<void>> register_background_task() {
    std::erase_if(background_tasks, [](const std::future<void>& earlier) {
      return earlier.wait_for(std::chrono::seconds(0)) == std::future_status::ready;
    });
    auto task = std::make_shared<std::promise<void>>();
    background_tasks.push_back(task->get_future());
    return task;
  }

  /// Records a note (observables of this instant) for the time series. For a gas on a device another thread computes it
  /// while the device continues.
  void note() {
    if (!is_on_device) {
      collect_notes();
      keep(take_note(host_gas, theory, analysis_seconds, potential()));
      return;
    }
    wait_for_a_core();
    pending.push_back(std::async(std::launch::async, [snapshot = snapshot(), of = grain_data, with = contact_laws(),
                                                      budget = budget_at_load]() mutable {
      const auto taken = std::move(snapshot);  // releases its memory at the end of this task
      return note_of(*taken, *of, with, budget);
    }));
  }
  LawsOfContacts contact_laws() const { return {law, surface}; }
  void wait_for_a_core() {
    const Stopwatch stopwatch(analysis_seconds);
    const std::size_t most = std::max(1u, std::thread::hardware_concurrency());
    if (pending.size() >= most) pending[pending.size() - most].wait();
  }
  /// Waits for the notes that other threads compute, and appends them to the time series.
  void collect_notes() {
    wait_for_background_tasks();
    const Stopwatch stopwatch(analysis_seconds);
    collect_notes(std::exchange(pending, {}));
  }
  void collect_notes(std::vector<std::future<Note>> taken) {
    for (std::future<Note>& future : taken) {
      Note one = future.get();
      if (theory) expect(one, host_gas, *theory);
      keep(std::move(one));
    }
  }
  void keep(Note note) {
    notes.push_back(note);
    last = std::move(note);
  }
  /// Returns the note (observables) of this instant. It does not advance `theory`, so that later results do not depend
  /// on this call. `with`: predictions to be advanced and included.
  Note current_note(std::optional<HomogeneousGas> with = {}) {
    collect_notes();
    if (last && last->time == time()) return *last;
    return take_note(gas(), with, analysis_seconds, potential());
  }
  /// Returns the note of this instant for a progress line, without waiting for other threads if the gas is on a device.
  Note peek() {
    return is_on_device ? note_of(*snapshot(), *grain_data, contact_laws(), budget_at_load) : current_note();
  }
  /// Returns the potential energy (m0 v0^2) if the device or the last step has computed it; otherwise empty.
  std::optional<double> potential() { return loaded ? std::optional(device->potential_energy()) : instant.potential; }

  /// Makes the frame of `host_gas`. `potential`: potential energy if it is known.
  Frame frame(std::optional<double> potential);
  Checkpoint checkpoint();
  std::map<std::string, double> all_seconds() const, seconds_here() const;
  ColumnGroup take_history() { return columns_of(std::exchange(notes, {}), theory); }

  /// Makes one step on the CPU, or several steps on a device, towards `time` (t0), at most to the end of the stage.
  /// Begins the next stage at the end. Throws Failure if the time does not advance.
  void step(double time) {
    const double end = std::min(time, stage_end), before = this->time();
    if (before < end) device ? step_on_device(end) : step_on_host(end, time);
    if (!(this->time() > before) && before < end)
      throw Failure(
          fmt::format("{}: time does not advance beyond t = {:.9g} t0: a step there is shorter than rounding of the "
                      "time; softer contacts or lower speeds are needed",
                      host_gas.scene().path, before));
    if (this->time() >= stage_end) leave_stage();
  }
  /// Makes one step on the CPU towards `end` (t0). `wanted`: time (t0) at which the caller needs the potential energy.
  void step_on_host(double end, double wanted) {
    const double left = end - host_gas.time(), longest = integrator->longest_step(host_gas, instant);
    check_pace(host_gas, end, longest);
    const double count = std::ceil(left / longest);
    const bool ends = count <= 1;  // notes and frames at the end of a step need the energy
    instant = integrator->step(host_gas, std::move(instant), ends ? end : host_gas.time() + left / count,
                               ends && end >= wanted ? Want::energy : Want::forces);
  }
  void step_on_device(double end) {
    load();
    is_on_device = true;
    device->step(end, steps_at_once);
  }
  /// Copies the gas to the device, if there is one that does not have it.
  void load() {
    if (!device || loaded) return;
    device->load(host_gas.save(), host_gas.law(), host_gas.in_elastic_stage(), host_gas.stage_begin(),
                 host_gas.surface());
    loaded = true;
    now.reset();
    law = host_gas.law();
    surface.reset();
    if (host_gas.surface()) surface = *host_gas.surface();
    budget_at_load = host_gas.energy(0);
    const Bodies& b = host_gas.bodies();
    grain_data = std::make_shared<Bodies>(
        Bodies{.dimension = b.dimension, .mass = b.mass, .radius = b.radius, .box = b.box, .inertia = b.inertia});
  }

  void leave_stage() {
    collect_notes();
    if (theory) theory->follow(gas(), time(), current_note().temperature());
    const bool cools_on = gas().cools_on_after_stage();
    instant = host_gas.leave_stage(std::move(instant));
    stage_end = host_gas.stage_end();
    loaded = false;
    last.reset();
    integrator->reset_history();
    if (theory && !cools_on) theory->begin(host_gas);
  }

  double next_note() const {
    const double every = host_gas.scene().output.every / notes_a_frame;
    return every * (std::floor(time() / every + 1e-9) + 1);
  }

  static constexpr int steps_at_once = 100;  ///< on a device, between two checks for a pause
  static constexpr int notes_a_frame = 10;
  Gas host_gas;
  Instant instant;  ///< values of `host_gas`
  std::unique_ptr<granular::GasIntegrator> integrator;
  double energy_at_start = 0;
  std::optional<HomogeneousGas> theory;
  std::unique_ptr<granular::device::DeviceGas> device;  ///< null: CPU
  bool loaded = false;                                  ///< the device has a copy of the gas
  bool is_on_device = false;                            ///< the device's copy is newer
  double stage_end;                                     ///< t0, end of the present stage
  std::vector<Note> notes;
  std::optional<Note> last;                               ///< last note of this stage
  std::shared_ptr<const Bodies> grain_data;               ///< masses, radii and box of the grains
  GrainContactLaw law;                                    ///< of contacts on the device
  std::optional<SurfaceLaw> surface;                      ///< of rough grains on the device
  GasEnergy budget_at_load;                               ///< energy budget before the gas was copied to the device
  std::shared_ptr<const granular::device::Snapshot> now;  ///< last snapshot
  std::vector<std::future<Note>> pending;                 ///< in order of time
  std::vector<std::future<void>> background_tasks;        ///< frames and checkpoints that another thread makes
  double seconds = 0, analysis_seconds = 0;
  bool warned = false;  ///< warnings of effects have been printed
};

GranularMotion::GranularMotion(const Scene& scene)
    : GranularMotion(scene, std::unique_ptr<granular::device::DeviceGas>()) {}

GranularMotion::GranularMotion(const Scene& scene, std::unique_ptr<granular::device::DeviceGas> device)
    : implementation_(
          std::make_unique<Implementation>(scene, make_integrator(scene.mechanics.integrator), std::move(device))) {
  implementation_->note();
}
GranularMotion::~GranularMotion() = default;

double GranularMotion::time() const { return implementation_->time(); }
double GranularMotion::end_time() const { return implementation_->host_gas.scene().stop.time; }
bool GranularMotion::finished() { return time() >= end_time(); }

double GranularMotion::next_frame() const {
  constexpr double rounding = 1e-9;
  const double every = implementation_->host_gas.scene().output.every, stop = end_time();
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
    const bool noted = due < time - 1e-9 * self.host_gas.scene().output.every;
    const double end = noted ? due : time;
    while (self.time() < end) {
      self.step(end);
      if (self.time() < end && is_to_stop()) return;
    }
    self.note();  // before any pause: a run that is resumed here continues to the next note
    if (is_to_stop()) return;
  }
}

std::int64_t GranularMotion::searches() const { return implementation_->host_gas.searches(); }

bool GranularMotion::exact_anywhere() const {
  return std::ranges::all_of(implementation_->host_gas.model().effects,
                             [](const auto& e) { return e->saves_exactly(); });
}

Frame GranularMotion::Implementation::frame(std::optional<double> potential) {
  const Bodies& b = host_gas.bodies();
  Frame frame{.time = host_gas.time(), .time_unit = "t0"};
  std::vector<double> velocity;
  for (std::size_t k = 0; k < b.momentum.size(); ++k) velocity.push_back(b.momentum[k] / b.mass[k / b.dimension]);
  frame.add_vectors("position", "d0", b.position, b.dimension);
  frame.add_vectors("velocity", "v0", velocity, b.dimension);
  if (!b.inertia.empty()) frame.add_vectors("angular_velocity", "1/t0", spins(b), 3);
  std::vector<std::int32_t> image;
  for (int i = 0; i < b.size(); ++i)
    for (int k = 0; k < 3; ++k) image.push_back(k < b.dimension ? b.image[i * b.dimension + k] : 0);
  frame.add_particles("image", "1", std::move(image), 3);
  if (!b.charge.empty()) frame.add_particles("charge", "q0", b.charge);
  const std::vector<Pair> contacts = pairs_in_contact(host_gas);
  frame.add_particles("cluster", "1", analysis::cluster_numbers(b.size(), contacts));
  std::vector<std::int32_t> pairs;
  for (const auto& [i, j] : contacts) pairs.insert(pairs.end(), {i, j});
  frame.add_list("contacts", "1", std::move(pairs), 2);
  const GasEnergy energy = host_gas.energy(potential);
  for (const auto& [name, value] : {std::pair{"kinetic_energy", energy.kinetic},
                                    {"contact_energy", energy.contact},
                                    {"potential_energy", energy.potential},
                                    {"dissipated_energy", energy.dissipated},
                                    {"exchanged_energy", energy.exchanged},
                                    {"driven_energy", energy.driven}})
    frame.add_system(name, "m0 v0^2", value);
  if (energy.rotational) frame.add_system("rotational_energy", "m0 v0^2", *energy.rotational);
  frame.add_system("collisions", "1", host_gas.collisions);
  host_gas.model().add_columns(host_gas.time(), frame);
  return frame;
}

Checkpoint GranularMotion::Implementation::checkpoint() {
  Checkpoint checkpoint = host_gas.save();
  checkpoint.reals["energy_at_start"] = {energy_at_start};
  integrator->save(checkpoint);
  if (theory) theory->save(checkpoint);
  return checkpoint;
}

Frame GranularMotion::frame() {
  Implementation& self = *implementation_;
  self.gas();
  return self.frame(self.potential());
}

std::function<Frame()> GranularMotion::frame_later() {
  Implementation& self = *implementation_;
  if (!self.is_on_device) return Motion::frame_later();
  return [&self, now = self.snapshot(), task = self.register_background_task()] {
    self.copy_back(*now);
    Frame frame = self.frame(now->potential);
    task->set_value();
    return frame;
  };
}

std::string GranularMotion::progress() {
  const Note now = implementation_->peek();
  std::string text = fmt::format("t = {:.4g} of {:.4g}, T = {:.3g}", now.time, end_time(), now.temperature());
  if (now.gas.charge.square > 0) text += fmt::format(", mean |q| {:.3g}", now.gas.charge.magnitude);
  return text + fmt::format(", {} clusters", now.gas.contact.number);
}

ColumnGroup GranularMotion::take_history() {
  implementation_->collect_notes();
  return implementation_->take_history();
}

std::function<SavedState()> GranularMotion::saved_state_later() {
  Implementation& self = *implementation_;
  if (!self.is_on_device) return Motion::saved_state_later();
  auto taken = std::make_shared<std::vector<std::future<Note>>>(std::exchange(self.pending, {}));
  return [&self, taken, now = self.snapshot(), task = self.register_background_task()] {
    self.collect_notes(std::move(*taken));
    if (self.host_gas.time() != now->time) self.copy_back(*now);
    SavedState saved{self.checkpoint(), self.take_history()};
    task->set_value();
    return saved;
  };
}

bool GranularMotion::leaves_a_core() const {
  const int busy = implementation_->device ? 1 : implementation_->host_gas.team().size();
  return busy < static_cast<int>(std::thread::hardware_concurrency());
}

Summary GranularMotion::summary() {
  Implementation& self = *implementation_;
  self.collect_notes();
  return summarize(self.gas(), self.current_note(self.theory), self.energy_at_start);
}

std::vector<std::string> GranularMotion::warnings() {
  std::vector<std::string> all;
  if (std::exchange(implementation_->warned, true)) return all;
  for (const auto& effect : implementation_->host_gas.model().effects)
    for (std::string& warning : effect->warnings()) all.push_back(std::move(warning));
  return all;
}

std::map<std::string, double> GranularMotion::Implementation::all_seconds() const {
  // With a device, background tasks use `host_gas` for frames.
  std::map<std::string, double> all = device ? std::map<std::string, double>{} : seconds_here();
  all["analysis"] = analysis_seconds;
  if (device) all["device"] = device->counts().seconds;
  double known = 0;
  for (const auto& [activity, value] : all) known += value;
  all["other"] = std::max(seconds - known, 0.0);
  return all;
}

std::map<std::string, double> GranularMotion::Implementation::seconds_here() const {
  const auto& [contacts, forces, lists, exchange] = host_gas.seconds();
  std::map<std::string, double> all{{"contacts", contacts}, {"lists", lists}};
  if (host_gas.bodies().charge.empty()) return all;
  double rest = forces;
  for (const auto& effect : host_gas.model().effects)
    for (const auto& [part, value] : effect->seconds()) all[part] += value, rest -= value;
  all.insert({{"forces", std::max(rest, 0.0)}, {"exchange", exchange}});
  return all;
}

std::map<std::string, double> GranularMotion::seconds() const { return implementation_->all_seconds(); }

Checkpoint GranularMotion::checkpoint() {
  implementation_->collect_notes();
  implementation_->gas();
  return implementation_->checkpoint();
}

void GranularMotion::restore(const Checkpoint& checkpoint) {
  implementation_->collect_notes();
  implementation_->host_gas.restore(checkpoint);
  implementation_->instant = implementation_->host_gas.instant();
  implementation_->loaded = implementation_->is_on_device = false;
  implementation_->stage_end = implementation_->host_gas.stage_end();
  implementation_->energy_at_start = reals(checkpoint, "energy_at_start", 1).front();
  implementation_->integrator->restore(checkpoint);
  if (implementation_->theory) implementation_->theory->restore(checkpoint);
  implementation_->notes.clear();
  implementation_->last.reset();
}

}  // namespace lichtenberg
