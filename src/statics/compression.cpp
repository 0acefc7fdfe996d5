#include "src/statics/compression.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "solvers/error.hpp"
#include "solvers/stopwatch.hpp"
#include "src/scene/loads.hpp"

namespace lichtenberg {
namespace {

constexpr const char* axes = "xyz";

/// Pressures below this fraction of effects::lowest_pressure() count as none, because net forces cause them.
constexpr double unjammed = 0.1;

/// Returns the pressure (N/m, in space Pa) of a packing that counts as just jammed. Its overlaps are about 1e-6
/// diameters, so that analysis::contact_margin hides one contact in 1000.
double jamming_pressure(const Scene& scene) {
  return std::max(effects::lowest_pressure(scene), 1e-6 * effects::pressure_unit(scene));
}

}  // namespace

double PressureSearch::next(double at, double measured, double target, double largest_step) {
  if (limit == 0) limit = largest_step;
  if (measured > 0 && measure > 0 && at != filling)
    if (const double s = (measured - measure) / (at - filling); s > 0) slope = s;
  filling = at, measure = measured;
  const double change = measured > 0 && slope > 0 ? (target - measured) / slope
                        : target > measured       ? INFINITY
                                                  : -INFINITY;
  const int sign = change > 0 ? 1 : -1;
  constexpr double growth = 1.25;  // below 2, so that alternating halving and growth narrow the steps
  if (direction * sign < 0)
    limit *= 0.5;
  else if (std::abs(change) > limit)
    limit = std::min(growth * limit, largest_step);
  direction = sign;
  return at + std::clamp(change, -limit, limit);
}

Compression::Compression(const Scene& scene)
    : scene_(scene), minimization_(std::make_unique<Minimization>(scene)), filling_(packing_fraction(scene)) {}

double Compression::pressure() {
  const analysis::Packing& packing = minimization_->packing();
  const int axis = plate_axis(options());
  if (axis < 0) return *packing.pressure;
  const auto plate = std::ranges::find(scene_.walls, options().plate, &Wall::name);
  double across = 1;
  for (int k = 0; k < scene_.dimension(); ++k)
    if (k != axis) across *= scene_.domain.size[k];
  return packing.wall_force[plate - scene_.walls.begin()] / across;
}

std::optional<double> Compression::towards_filling(double target) const {
  if (filling_ == target) return {};
  if (target > 1)
    throw InputError(fmt::format(
        "{}: compression.excess is too large: the packing jams at a packing fraction of {:.6g}, and the sum of both "
        "must be at most 1",
        scene_.path, jamming_));
  const double change = target - filling_, step = options().step;
  return std::abs(change) <= step ? target : filling_ + std::copysign(step, change);
}

std::optional<double> Compression::towards_pressure(double target) {
  const double now = pressure(), least = effects::lowest_pressure(scene_);
  if (std::abs(now - target) <= options().tolerance * target) return {};
  const auto linear = [&](double p) {
    const effects::RepulsionForm form = scene_.effects.find<effects::SoftRepulsionOptions>()->form;
    return std::pow(p / target, 1 / effects::force_exponent(form));
  };
  const double next = search_.next(filling_, now < unjammed * least ? 0 : linear(now), 1, options().step);
  if (next > 1)
    throw InputError(fmt::format(
        "{}: the pressure {:g} is not reached: at a packing fraction of {:.4g} it is {:.3g}, and the fraction must be "
        "at most 1; choose a lower compression.pressure or a larger effects.soft_repulsion.stiffness",
        scene_.path, target, filling_, now));
  constexpr double rounding = 1e-14;
  if (search_.limit < rounding || next == filling_)
    throw Failure(fmt::format(
        "the pressure {:g} is not reached: at a packing fraction of {:.12g} it jumps across that value, and it is {:g}",
        target, filling_, now));
  return next;
}

std::optional<double> Compression::next_filling() {
  if (!options().pressure.empty()) return towards_pressure(options().pressure[load_]);
  if (!options().filling.empty()) return towards_filling(options().filling[load_]);
  if (load_ > 0) return towards_filling(jamming_ + options().excess[load_ - 1]);
  const std::optional<double> next = towards_pressure(jamming_pressure(scene_));
  // The measure of the wanted pressure is 1 and vanishes at jamming
  if (!next) jamming_ = filling_ - (search_.slope > 0 ? 1 / search_.slope : 0);
  return next;
}

/// Starts a minimization at another packing fraction from the present positions.
void Compression::minimize_at(double filling) {
  Bodies bodies = minimization_->bodies();
  wrap(bodies);
  for (std::size_t i = 0; i < scene_.conductors.size(); ++i)
    scene_.conductors[i].position = position_in_space(bodies, static_cast<int>(i));
  Vec3 size = scene_.domain.size;
  const int axis = plate_axis(options()), d = scene_.dimension();
  const double ratio = filling_ / filling;
  for (int k = 0; k < d; ++k)
    if (axis < 0 || axis == k) size[k] *= axis < 0 ? std::pow(ratio, 1.0 / d) : ratio;
  scene_ = resized(std::move(scene_), size);
  filling_ = filling;
  ++minimizations_;
  evaluations_ += minimization_->evaluations();
  minimization_ = std::make_unique<Minimization>(scene_);
  earlier_force_ = INFINITY;
}

/// Continues the present minimization. Returns true at its end, false if `pause` returned true. It also ends if the
/// largest force has hardly decreased over many iterations, because rounding stops some minimizations above the
/// tolerance.
bool Compression::minimize(const std::function<bool()>& pause) {
  constexpr std::int64_t between_checks = 10'000;
  constexpr double decrease = 0.9;
  bool paused = false;
  while (!minimization_->finished()) {
    const std::int64_t check = (minimization_->iteration() / between_checks + 1) * between_checks;
    minimization_->advance_to(static_cast<double>(check), [&] { return paused = pause && pause(); });
    if (minimization_->iteration() == check) {
      const double force = minimization_->largest_force();
      if (force > decrease * earlier_force_) return true;
      earlier_force_ = force;
    }
    if (paused) return false;
  }
  return true;
}

void Compression::advance_to(double load, const std::function<bool()>& pause) {
  const Stopwatch stopwatch(seconds_);
  while (time() < load && !finished()) {
    if (!minimize(pause)) return;
    if (const std::optional<double> next = next_filling()) {
      minimize_at(*next);
    } else {
      if (!minimization_->at_rest()) ++not_at_rest_;
      ++load_;
      search_ = {};
    }
  }
}

Frame Compression::frame() {
  Frame frame = minimization_->frame();
  frame.time = time();
  frame.time_unit = time_unit();
  for (int k = 0; k < scene_.dimension(); ++k)
    frame.add_system(fmt::format("size_{}", axes[k]), "m", scene_.domain.size[k]);
  const analysis::Packing& packing = minimization_->packing();
  frame.add_system("packing_fraction", "1", filling_);
  frame.add_system("pressure", scene_.dimension() == 3 ? "Pa" : "N m-1", pressure());
  frame.add_system("backbone_coordination", "1", packing.backbone_coordination);
  frame.add_system("rattlers", "1", static_cast<std::int64_t>(packing.rattlers));
  if (!options().excess.empty()) frame.add_system("excess_fraction", "1", filling_ - jamming_);
  return frame;
}

std::string Compression::progress() {
  return fmt::format("load {} of {}: packing fraction {:.8f}, {}", load_ + 1, options().loads(), filling_,
                     minimization_->progress());
}

Summary Compression::summary() {
  Summary summary = minimization_->summary();
  summary.title = fmt::format("holds {} loads of the packing: {} minimizations, {} evaluations", load_, minimizations_,
                              evaluations_ + minimization_->evaluations());
  if (!std::isnan(jamming_)) {
    summary.lines.insert(summary.lines.begin(), {"jamming", fmt::format("at a packing fraction of {:.8f}", jamming_)});
    summary.quantities.push_back({"jamming_fraction", jamming_, "1"});
  }
  summary.quantities.push_back({"loads", time(), "1"});
  summary.quantities.push_back({"load_pressure", pressure(), scene_.dimension() == 3 ? "Pa" : "N m-1"});
  if (not_at_rest_ > 0)
    summary.warnings.push_back(fmt::format(
        "{} loads not at rest: minimize.max_iterations or the digits that there are allow no smaller forces",
        not_at_rest_));
  return summary;
}

Checkpoint Compression::checkpoint() {
  Checkpoint checkpoint = minimization_->checkpoint();
  std::vector<double>& start = checkpoint.reals["start"];
  for (const Conductor& c : scene_.conductors) start.insert(start.end(), {c.position.x, c.position.y, c.position.z});
  const Vec3 size = scene_.domain.size;
  checkpoint.reals["compression"] = {size.x,        size.y,          size.z,          filling_,      jamming_,
                                     search_.limit, search_.filling, search_.measure, search_.slope, earlier_force_};
  checkpoint.integers["compression"] = {load_, search_.direction, minimizations_, not_at_rest_, evaluations_};
  return checkpoint;
}

void Compression::restore(const Checkpoint& checkpoint) {
  const auto start = checkpoint.reals.find("start");
  const auto reals = checkpoint.reals.find("compression");
  const auto integers = checkpoint.integers.find("compression");
  if (start == checkpoint.reals.end() || reals == checkpoint.reals.end() || integers == checkpoint.integers.end() ||
      start->second.size() != 3 * scene_.conductors.size() || reals->second.size() != 10 ||
      integers->second.size() != 5)
    throw Failure("the checkpoint is not one of this scene's compression");
  const std::vector<double>& r = reals->second;
  const std::vector<std::int64_t>& n = integers->second;
  scene_ = resized(std::move(scene_), {r[0], r[1], r[2]});
  for (std::size_t i = 0; i < scene_.conductors.size(); ++i)
    scene_.conductors[i].position = vector_at(start->second, 3, static_cast<int>(i));
  filling_ = r[3], jamming_ = r[4];
  search_ = {.limit = r[5], .direction = static_cast<int>(n[1]), .filling = r[6], .measure = r[7], .slope = r[8]};
  earlier_force_ = r[9];
  load_ = n[0], minimizations_ = n[2], not_at_rest_ = n[3], evaluations_ = n[4];
  minimization_ = std::make_unique<Minimization>(scene_);
  minimization_->restore(checkpoint);
}

}  // namespace lichtenberg
