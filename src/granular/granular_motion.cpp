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

/// Largest number of steps of a run. Rounding still resolves the time of a single step.
constexpr double most_steps = 1e12;

void check_shortest(const Scene& scene) {
  const double step = scene.mechanics.step, end = scene.stop.time;
  if (std::isfinite(end) && !(end <= most_steps * step))
    throw InputError(
        fmt::format("{}: mechanics.step = {:g} is too short for stop.time = {:g}: that makes {:.2g} steps, and at most "
                    "{:g} are allowed",
                    scene.path, step, end, end / step, most_steps));
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
      : here(scene),
        integrator(std::move(by)),
        theory(HomogeneousGas::of(here)),
        device(std::move(on)),
        stage_end(here.stage_end()) {
    check_shortest(scene);
    instant = here.look();
    if (std::isfinite(scene.mechanics.step))
      integrator->longest_step(here, instant);  // refuses a step that is too long before output begins
    load();
    energy_at_start = here.energy(potential()).total();
  }

  /// Returns the gas, copied back from the device if needed.
  Gas& gas() {
    catch_up();
    if (is_there) {
      bring(device->snapshot());
      is_there = false;
    }
    return here;
  }
  void bring(const granular::device::Snapshot& snapshot) {
    Checkpoint checkpoint = here.save();
    store(snapshot, checkpoint);
    here.restore(checkpoint);
    instant = here.look();
  }
  double time() const { return is_there ? device->time() : here.time(); }

  /// Returns the snapshot of the gas on the device, one per instant.
  std::shared_ptr<const granular::device::Snapshot> snapshot() {
    if (!now || now->time != device->time()) {
      const double potential = device->potential_energy();
      auto taken = std::make_shared<granular::device::Snapshot>(device->snapshot());
      taken->potential = potential;
      now = std::move(taken);
    }
    return now;
  }
  /// Waits for background tasks that use `here`, `theory` and the notes, for frames and checkpoints of a gas on a
  /// device.
  void catch_up() {
    const Stopwatch stopwatch(analysis_seconds);
    for (const std::future<void>& task : std::exchange(behind, {})) task.wait();
  }
  /// Registers a background task. It completes when its std::promise is fulfilled or destroyed.
  std::shared_ptr<std::promise<void>> leave_behind() {
    std::erase_if(behind, [](const std::future<void>& earlier) {
      return earlier.wait_for(std::chrono::seconds(0)) == std::future_status::ready;
    });
    auto task = std::make_shared<std::promise<void>>();
    behind.push_back(task->get_future());
    return task;
  }

  /// Takes a note. For a gas on a device another thread does so while the device continues.
  void note() {
    if (!is_there) {
      settle();
      keep(take_note(here, theory, analysis_seconds, potential()));
      return;
    }
    wait_for_a_core();
    pending.push_back(
        std::async(std::launch::async, [snapshot = snapshot(), of = like, with = law, book = flows]() mutable {
          const auto taken = std::move(snapshot);  // releases its memory at the end of this task
          return note_of(*taken, *of, with, book);
        }));
  }
  void wait_for_a_core() {
    const Stopwatch stopwatch(analysis_seconds);
    const std::size_t most = std::max(1u, std::thread::hardware_concurrency());
    if (pending.size() >= most) pending[pending.size() - most].wait();
  }
  /// Waits for notes of other threads, and appends them.
  void settle() {
    catch_up();
    const Stopwatch stopwatch(analysis_seconds);
    settle(std::exchange(pending, {}));
  }
  void settle(std::vector<std::future<Note>> taken) {
    for (std::future<Note>& future : taken) {
      Note one = future.get();
      if (theory) expect(one, here, *theory);
      keep(std::move(one));
    }
  }
  void keep(Note note) {
    notes.push_back(note);
    last = std::move(note);
  }
  /// Returns the note of this instant. It does not advance `theory`, so that later results do not depend on this call.
  Note look(std::optional<HomogeneousGas> with = {}) {
    settle();
    if (last && last->time == time()) return *last;
    return take_note(gas(), with, analysis_seconds, potential());
  }
  /// Returns the note for a progress line, without waiting for other threads.
  Note peek() { return is_there ? note_of(*snapshot(), *like, law, flows) : look(); }
  /// Returns the energy of smooth forces, if the device or the last step has computed it.
  std::optional<double> potential() { return loaded ? std::optional(device->potential_energy()) : instant.potential; }

  /// Makes the frame of `here`.
  Frame frame(std::optional<double> potential);
  Checkpoint checkpoint();
  std::map<std::string, double> all_seconds() const, seconds_here() const;
  ColumnGroup take_history() { return columns_of(std::exchange(notes, {}), theory); }

  /// Makes one step towards `time`, at most to the end of the stage.
  void step(double time) {
    const double end = std::min(time, stage_end), before = this->time();
    if (before < end) device ? step_there(end) : step_here(end, time);
    if (!(this->time() > before) && before < end)
      throw Failure(
          fmt::format("{}: time does not go on from t = {:.9g} t0: a step there is shorter than rounding of "
                      "the time; softer contacts or lower speeds are needed",
                      here.scene().path, before));
    if (this->time() >= stage_end) leave_stage();
  }
  /// `wanted`: time (t0) at which the caller needs the energy.
  void step_here(double end, double wanted) {
    const double left = end - here.time(), longest = integrator->longest_step(here, instant);
    check_pace(here, end, longest);
    const double count = std::ceil(left / longest);
    const bool ends = count <= 1;  // notes and frames at the end of a step need the energy
    instant = integrator->step(here, std::move(instant), ends ? end : here.time() + left / count,
                               ends && end >= wanted ? Want::energy : Want::forces);
  }
  void step_there(double end) {
    load();
    is_there = true;
    device->step(end, steps_at_once);
  }
  /// Copies the gas to the device, if there is one.
  void load() {
    if (!device || loaded) return;
    device->load(here.save(), here.law(), here.in_elastic_stage(), here.stage_begin());
    loaded = true;
    now.reset();
    law = here.law();
    flows = here.energy(0);
    const Bodies& b = here.bodies();
    like = std::make_shared<Bodies>(Bodies{.dimension = b.dimension, .mass = b.mass, .radius = b.radius, .box = b.box});
  }

  void leave_stage() {
    settle();
    if (theory) theory->follow(gas(), time(), look().temperature());
    const bool cools_on = gas().cools_on_after_stage();
    instant = here.leave_stage(std::move(instant));
    stage_end = here.stage_end();
    loaded = false;
    last.reset();
    integrator->begin_anew();
    if (theory && !cools_on) theory->begin(here);
  }

  double next_note() const {
    const double every = here.scene().output.every / notes_a_frame;
    return every * (std::floor(time() / every + 1e-9) + 1);
  }

  static constexpr int steps_at_once = 100;  ///< on a device, between two checks for a pause
  static constexpr int notes_a_frame = 10;
  Gas here;
  Instant instant;  ///< values of `here`
  std::unique_ptr<granular::GasIntegrator> integrator;
  double energy_at_start = 0;
  std::optional<HomogeneousGas> theory;
  std::unique_ptr<granular::device::DeviceGas> device;  ///< null: CPU
  bool loaded = false;                                  ///< the device has a copy of the gas
  bool is_there = false;                                ///< the device's copy is newer
  double stage_end;                                     ///< t0, end of the present stage
  std::vector<Note> notes;
  std::optional<Note> last;                               ///< last note of this stage
  std::shared_ptr<const Bodies> like;                     ///< masses, radii and box of the grains
  GrainContactLaw law;                                    ///< of contacts on the device
  GasEnergy flows;                                        ///< energy budget before the gas was copied to the device
  std::shared_ptr<const granular::device::Snapshot> now;  ///< last snapshot
  std::vector<std::future<Note>> pending;                 ///< in order of time
  std::vector<std::future<void>> behind;                  ///< background tasks
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
    while (self.time() < end) {
      self.step(end);
      if (self.time() < end && is_to_stop()) return;
    }
    self.note();  // before any pause: a run that is resumed here continues to the next note
    if (is_to_stop()) return;
  }
}

std::int64_t GranularMotion::searches() const { return implementation_->here.searches(); }

bool GranularMotion::exact_anywhere() const {
  return std::ranges::all_of(implementation_->here.model().effects, [](const auto& e) { return e->saves_exactly(); });
}

Frame GranularMotion::Implementation::frame(std::optional<double> potential) {
  const Bodies& b = here.bodies();
  Frame frame{.time = here.time(), .time_unit = "t0"};
  std::vector<double> velocity;
  for (std::size_t k = 0; k < b.momentum.size(); ++k) velocity.push_back(b.momentum[k] / b.mass[k / b.dimension]);
  frame.add_vectors("position", "d0", b.position, b.dimension);
  frame.add_vectors("velocity", "v0", velocity, b.dimension);
  std::vector<std::int32_t> image;
  for (int i = 0; i < b.size(); ++i)
    for (int k = 0; k < 3; ++k) image.push_back(k < b.dimension ? b.image[i * b.dimension + k] : 0);
  frame.add_particles("image", "1", std::move(image), 3);
  if (!b.charge.empty()) frame.add_particles("charge", "q0", b.charge);
  const std::vector<Pair> contacts = pairs_in_contact(here);
  frame.add_particles("cluster", "1", analysis::cluster_numbers(b.size(), contacts));
  std::vector<std::int32_t> pairs;
  for (const auto& [i, j] : contacts) pairs.insert(pairs.end(), {i, j});
  frame.add_list("contacts", "1", std::move(pairs), 2);
  const GasEnergy energy = here.energy(potential);
  for (const auto& [name, value] : {std::pair{"kinetic_energy", energy.kinetic},
                                    {"contact_energy", energy.contact},
                                    {"potential_energy", energy.potential},
                                    {"dissipated_energy", energy.dissipated},
                                    {"exchanged_energy", energy.exchanged},
                                    {"driven_energy", energy.driven}})
    frame.add_system(name, "m0 v0^2", value);
  frame.add_system("collisions", "1", here.collisions);
  here.model().add_columns(here.time(), frame);
  return frame;
}

Checkpoint GranularMotion::Implementation::checkpoint() {
  Checkpoint checkpoint = here.save();
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
  if (!self.is_there) return Motion::frame_later();
  return [&self, now = self.snapshot(), task = self.leave_behind()] {
    self.bring(*now);
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
  implementation_->settle();
  return implementation_->take_history();
}

std::function<Kept()> GranularMotion::keep_later() {
  Implementation& self = *implementation_;
  if (!self.is_there) return Motion::keep_later();
  auto taken = std::make_shared<std::vector<std::future<Note>>>(std::exchange(self.pending, {}));
  return [&self, taken, now = self.snapshot(), task = self.leave_behind()] {
    self.settle(std::move(*taken));
    if (self.here.time() != now->time) self.bring(*now);
    Kept kept{self.checkpoint(), self.take_history()};
    task->set_value();
    return kept;
  };
}

bool GranularMotion::leaves_a_core() const {
  const int busy = implementation_->device ? 1 : implementation_->here.team().size();
  return busy < static_cast<int>(std::thread::hardware_concurrency());
}

Summary GranularMotion::summary() {
  Implementation& self = *implementation_;
  self.settle();
  return summarize(self.gas(), self.look(self.theory), self.energy_at_start);
}

std::vector<std::string> GranularMotion::warnings() {
  std::vector<std::string> all;
  if (std::exchange(implementation_->warned, true)) return all;
  for (const auto& effect : implementation_->here.model().effects)
    for (std::string& warning : effect->warnings()) all.push_back(std::move(warning));
  return all;
}

std::map<std::string, double> GranularMotion::Implementation::all_seconds() const {
  // With a device, background tasks use `here` for frames.
  std::map<std::string, double> all = device ? std::map<std::string, double>{} : seconds_here();
  all["analysis"] = analysis_seconds;
  if (device) all["device"] = device->counts().seconds;
  double known = 0;
  for (const auto& [activity, value] : all) known += value;
  all["other"] = std::max(seconds - known, 0.0);
  return all;
}

std::map<std::string, double> GranularMotion::Implementation::seconds_here() const {
  const auto& [contacts, forces, lists, exchange] = here.seconds();
  std::map<std::string, double> all{{"contacts", contacts}, {"lists", lists}};
  if (here.bodies().charge.empty()) return all;
  double rest = forces;
  for (const auto& effect : here.model().effects)
    for (const auto& [part, value] : effect->seconds()) all[part] += value, rest -= value;
  all.insert({{"forces", std::max(rest, 0.0)}, {"exchange", exchange}});
  return all;
}

std::map<std::string, double> GranularMotion::seconds() const { return implementation_->all_seconds(); }

Checkpoint GranularMotion::checkpoint() {
  implementation_->settle();
  implementation_->gas();
  return implementation_->checkpoint();
}

void GranularMotion::restore(const Checkpoint& checkpoint) {
  implementation_->settle();
  implementation_->here.restore(checkpoint);
  implementation_->instant = implementation_->here.look();
  implementation_->loaded = implementation_->is_there = false;
  implementation_->stage_end = implementation_->here.stage_end();
  implementation_->energy_at_start = reals(checkpoint, "energy_at_start", 1).front();
  implementation_->integrator->restore(checkpoint);
  if (implementation_->theory) implementation_->theory->restore(checkpoint);
  implementation_->notes.clear();
  implementation_->last.reset();
}

}  // namespace lichtenberg
