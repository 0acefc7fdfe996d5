#include "src/statics/minimization.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <thread>

#include "solvers/error.hpp"
#include "solvers/larger.hpp"
#include "solvers/minimize/fire.hpp"
#include "solvers/minimize/gradient_descent.hpp"
#include "solvers/minimize/lbfgs.hpp"
#include "solvers/minimize/newton_cg.hpp"
#include "solvers/stopwatch.hpp"
#include "src/effects/effects.hpp"
#include "src/statics/potential_energy.hpp"

namespace lichtenberg {
namespace {

double mean_diameter(const Scene& scene) {
  double sum = 0;
  for (const Conductor& conductor : scene.conductors) sum += 2 * conductor.radius;
  return sum / static_cast<double>(scene.conductors.size());
}

/// Returns the interleaved bits of three numbers (Morton 1966). Codes of neighbouring positions are mostly close to
/// each other.
std::uint64_t interleaved(const std::array<std::uint32_t, 3>& number) {
  std::uint64_t code = 0;
  for (int bit = 0; bit < 21; ++bit)
    for (int k = 0; k < 3; ++k) code |= static_cast<std::uint64_t>(number[k] >> bit & 1) << (3 * bit + k);
  return code;
}

/// Returns an order of the particles in which neighbours in space are mostly neighbours in memory.
std::vector<int> spatial_order(const Scene& scene, double diameter) {
  const double limit = 0x1p21 - 1;
  const auto cell = [&](double x) { return static_cast<std::uint32_t>(std::clamp(x / diameter, 0.0, limit)); };
  std::vector<std::pair<std::uint64_t, int>> codes;
  for (const Conductor& c : scene.conductors)
    codes.emplace_back(interleaved({cell(c.position.x), cell(c.position.y), cell(c.position.z)}),
                       static_cast<int>(codes.size()));
  std::ranges::sort(codes);
  std::vector<int> order;
  for (const auto& [code, i] : codes) order.push_back(i);
  return order;
}

/// Returns the scene with its particles in another order.
Scene reordered(Scene scene, const std::vector<int>& order) {
  std::vector<Conductor> conductors;
  for (const int i : order) conductors.push_back(scene.conductors[i]);
  scene.conductors = std::move(conductors);
  return scene;
}

/// Returns the number of threads. By default few particles use one thread, because parallel loops over them are not
/// efficient.
int threads_for(const Scene& scene) {
  constexpr std::size_t few = 10000;
  if (scene.minimize.threads > 0) return scene.minimize.threads;
  return scene.conductors.size() < few ? 1 : std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
}

/// Returns the smallest number round(ratio^k), k = 0, 1, ..., that is larger than `now`. The result depends only on the
/// iteration number, so a resumed run has the same marks.
std::int64_t next_mark(std::int64_t now, double ratio) {
  if (now < 1) return now + 1;
  for (double k = std::floor(std::log(static_cast<double>(now)) / std::log(ratio));; ++k)
    if (const std::int64_t mark = std::llround(std::pow(ratio, k)); mark > now) return mark;
}

double longest(std::span<const double> vectors, int dimension) {
  double most = 0;
  for (std::size_t i = 0; i < vectors.size(); i += dimension) {
    double sum = 0;
    for (int k = 0; k < dimension; ++k) sum += vectors[i + k] * vectors[i + k];
    most = larger(most, sum);
  }
  return std::sqrt(most);
}

/// Returns the largest length, computed by the threads of `objective`.
double longest(std::span<const double> vectors, int dimension, const minimize::Objective& objective) {
  const std::size_t block = 4096 * static_cast<std::size_t>(dimension);
  std::vector<double> most((vectors.size() + block - 1) / block);
  objective.share(static_cast<int>(most.size()), [&](int task) {
    const std::size_t first = task * block;
    most[task] = longest(vectors.subspan(first, std::min(block, vectors.size() - first)), dimension);
  });
  double all = 0;
  for (const double m : most) all = larger(all, m);
  return all;
}

}  // namespace

struct Minimization::Implementation {
  explicit Implementation(const Scene& s)
      : scene(s),
        diameter(mean_diameter(s)),
        order(spatial_order(s, diameter)),
        energy(reordered(s, order), threads_for(s)),
        stiffness(energy.potential().stiffness()),
        method(scene.minimize.method == MinimizeMethod::lbfgs_newton ? MinimizeMethod::lbfgs : scene.minimize.method) {
    start(energy.model().bodies.position);
  }

  void start(std::vector<double> x) {
    minimizer = make_minimizer(std::move(x));
    update_largest_force();
  }

  /// Makes the minimizer with lengths, times and steps in natural units of the scene. With unit masses, the fastest
  /// motions of a disk have a period of about 2 diameter / sqrt(stiffness).
  std::unique_ptr<minimize::Minimizer> make_minimizer(std::vector<double> x) {
    const double area = diameter * diameter / stiffness;
    const double move = 0.1 * diameter;
    if (method == MinimizeMethod::gradient_descent)
      return std::make_unique<minimize::GradientDescent>(energy, std::move(x), scene.minimize.step * area, move);
    if (method == MinimizeMethod::fire)
      return std::make_unique<minimize::Fire>(energy, std::move(x), 0.4 * std::sqrt(area), move);
    if (method == MinimizeMethod::lbfgs)
      return std::make_unique<minimize::Lbfgs>(energy, std::move(x), 0.05 * area, move);
    return std::make_unique<minimize::NewtonCg>(energy, std::move(x), move, stiffness / diameter);
  }

  /// Positions in the scene's order of particles, and back.
  std::vector<double> in_scene_order(const std::vector<double>& x) const {
    std::vector<double> result(x.size());
    const std::size_t d = scene.dimension();
    for (std::size_t k = 0; k < order.size(); ++k) std::copy_n(&x[d * k], d, &result[d * order[k]]);
    return result;
  }
  std::vector<double> in_own_order(const std::vector<double>& x) const {
    std::vector<double> result(x.size());
    const std::size_t d = scene.dimension();
    for (std::size_t k = 0; k < order.size(); ++k) std::copy_n(&x[d * order[k]], d, &result[d * k]);
    return result;
  }

  void update_largest_force() {
    largest_force = longest(minimizer->point().gradient, scene.dimension(), energy);
    if (!std::isfinite(largest_force))
      throw Failure(
          fmt::format("{}: after {} iterations a force on a particle is not finite: its centre nearly coincides with "
                      "another one or lies on a wall",
                      scene.path, iteration));
  }

  void change_to(MinimizeMethod other) {
    method = other;
    changed_at = earlier_evaluations = evaluations();
    start(minimizer->point().x);
  }

  std::int64_t evaluations() const { return earlier_evaluations + minimizer->evaluations(); }

  /// Changes the method of lbfgs-newton. Once few contacts close or open, the energy is nearly quadratic, and Newton's
  /// method converges in about ten evaluations. If it does not, contacts still change, and L-BFGS continues to a
  /// smaller force.
  void choose_method() {
    if (scene.minimize.method != MinimizeMethod::lbfgs_newton) return;
    constexpr std::int64_t most_evaluations = 30;
    const double unit = stiffness / diameter;
    if (method == MinimizeMethod::lbfgs && largest_force <= newton_threshold * unit) {
      change_to(MinimizeMethod::newton_cg);
    } else if (method == MinimizeMethod::newton_cg && evaluations() - changed_at > most_evaluations) {
      newton_threshold *= 0.1;
      change_to(MinimizeMethod::lbfgs);
    }
  }

  Scene scene;
  double diameter;         ///< m, mean diameter
  std::vector<int> order;  ///< particle k is particle order[k] of the scene
  statics::PotentialEnergy energy;
  double stiffness;       ///< J
  MinimizeMethod method;  ///< current method
  /// Force (stiffness / diameter) below which contacts are assumed not to change.
  double newton_threshold = 1e-5;
  std::unique_ptr<minimize::Minimizer> minimizer;
  std::int64_t iteration = 0;
  std::int64_t earlier_evaluations = 0;  ///< evaluations of earlier minimizers
  std::int64_t changed_at = 0;           ///< number of evaluations at the last change of method
  double largest_force = 0;              ///< N
};

Minimization::Minimization(const Scene& scene) : implementation_(std::make_unique<Implementation>(scene)) {
  record_history();
}
Minimization::~Minimization() = default;

std::int64_t Minimization::iteration() const { return implementation_->iteration; }
std::int64_t Minimization::evaluations() const { return implementation_->evaluations(); }
double Minimization::energy() const { return implementation_->minimizer->point().value; }
double Minimization::largest_force() const { return implementation_->largest_force; }
double Minimization::force_unit() const { return implementation_->stiffness / implementation_->diameter; }
bool Minimization::at_rest() const {
  return largest_force() <= implementation_->scene.minimize.force_tolerance * force_unit();
}
Bodies Minimization::bodies() const {
  const Implementation& self = *implementation_;
  Bodies bodies = make_bodies(self.scene);
  bodies.position = self.in_scene_order(self.minimizer->point().x);
  return bodies;
}

bool Minimization::iterate() {
  Implementation& self = *implementation_;
  self.choose_method();
  if (!self.minimizer->iterate()) return false;
  ++self.iteration;
  self.update_largest_force();
  return true;
}

double Minimization::next_frame() const {
  const std::int64_t every = implementation_->scene.minimize.record_every, now = iteration();
  // Intervals increase, because the relaxation is fast first and slow later
  constexpr double ratio = 1.4142135623730951;
  const std::int64_t next = every > 0 ? (now / every + 1) * every : next_mark(now, ratio);
  return std::min(static_cast<double>(next), most_iterations());
}

double Minimization::most_iterations() const {
  return static_cast<double>(implementation_->scene.minimize.max_iterations);
}

bool Minimization::finished() { return at_rest() || cannot_decrease_ || time() >= most_iterations(); }

void Minimization::record_history() {
  history_.push_back({iteration(), energy(), largest_force()});
  recorded_at_ = iteration();
}

void Minimization::advance_to(double iteration, const std::function<bool()>& pause) {
  const Stopwatch stopwatch(seconds_);
  constexpr double ratio = 1.02;  // ratio of iterations with a record
  while (!finished() && time() < iteration) {
    const std::int64_t next_record = next_mark(this->iteration(), ratio);
    cannot_decrease_ = !iterate();
    if (!cannot_decrease_ && this->iteration() == next_record) record_history();
    if (pause && pause()) return;
  }
  if (finished() && recorded_at_ != this->iteration()) record_history();
}

Frame Minimization::frame() {
  const Implementation& self = *implementation_;
  Frame frame{.time = time(), .time_unit = "1"};
  Bodies now = bodies();
  wrap(now);
  frame.add_vectors("position", "m", now.position, self.scene.dimension());
  frame.add_system("energy", "J", energy());
  frame.add_system("largest_force", "N", largest_force());
  return frame;
}

std::string Minimization::progress() {
  return fmt::format("iteration {}: energy {:.10g} J, largest force {:.2e} of {:.2g} k/D", iteration(), energy(),
                     force_in_units(), implementation_->scene.minimize.force_tolerance);
}

ProgressMeasure Minimization::progress_measure() {
  const double whole = -std::log(implementation_->scene.minimize.force_tolerance);
  return {at_rest() ? whole : -std::log(force_in_units()), whole};
}

ColumnGroup Minimization::take_history() {
  std::vector<std::int64_t> iteration;
  std::vector<double> energy, force;
  for (const HistoryRecord& entry : history_) {
    iteration.push_back(entry.iteration);
    energy.push_back(entry.energy);
    force.push_back(entry.largest_force);
  }
  history_.clear();
  return {"relaxation",  // name in result files
          {{"iteration", "1", Column::Of::list, 0, std::move(iteration)},
           {"energy", "J", Column::Of::list, 0, std::move(energy)},
           {"largest_force", "N", Column::Of::list, 0, std::move(force)}}};
}

const analysis::Packing& Minimization::packing() {
  const Implementation& self = *implementation_;
  if (!packing_ || packed_at_ != iteration())
    packing_ = analysis::packing(bodies(), self.scene, self.energy.potential());
  packed_at_ = iteration();
  return *packing_;
}

std::vector<ColumnGroup> Minimization::findings() { return {analysis::columns_of(packing())}; }

Summary Minimization::summary() {
  const Scene& scene = implementation_->scene;
  Summary summary = analysis::summarize(packing(), scene);
  const auto line = [](std::string label, std::string text) {
    return Summary::Line{std::move(label), std::move(text)};
  };
  summary.goal = "at_rest";
  summary.title =
      fmt::format("holds the packing: {} after {} iterations of {}, {} evaluations",
                  at_rest() ? "at rest" : "not at rest", iteration(), name_of(scene.minimize.method), evaluations());
  summary.lines.insert(summary.lines.begin(),
                       {line("energy", fmt::format("{:.10g} J", energy())),
                        line("largest force", fmt::format("{:.3g} N, {:.2e} of stiffness / mean diameter",
                                                          largest_force(), force_in_units()))});
  const std::vector<Quantity> own{{"at_rest", at_rest() ? 1.0 : 0.0, "1"},
                                  {"iterations", time(), "1"},
                                  {"evaluations", static_cast<double>(evaluations()), "1"},
                                  {"energy", energy(), "J"},
                                  {"largest_force", largest_force(), "N"},
                                  {"relative_largest_force", force_in_units(), "1"}};
  summary.quantities.insert(summary.quantities.begin(), own.begin(), own.end());
  if (!at_rest())
    summary.warnings.insert(
        summary.warnings.begin(),
        fmt::format("not at rest after {} iterations: the largest force is {:.1e} of stiffness / mean diameter, where "
                    "minimize.force_tolerance is {:g}, and {}",
                    iteration(), force_in_units(), scene.minimize.force_tolerance,
                    cannot_decrease_ ? "the energy goes no lower with the digits that there are"
                                     : "minimize.max_iterations allows no more"));
  return summary;
}

std::map<std::string, double> Minimization::seconds() const { return {{"minimization", seconds_}}; }

Checkpoint Minimization::checkpoint() {
  const Implementation& self = *implementation_;
  Checkpoint checkpoint;
  checkpoint.reals = self.minimizer->memory();
  checkpoint.reals["position"] = self.in_scene_order(self.minimizer->point().x);
  checkpoint.integers["counters"] = {self.iteration, evaluations(), recorded_at_};
  checkpoint.integers["method"] = {self.method == MinimizeMethod::newton_cg, self.changed_at};
  checkpoint.reals["settled"] = {self.newton_threshold};
  return checkpoint;
}

void Minimization::restore(const Checkpoint& checkpoint) {
  Implementation& self = *implementation_;
  const auto position = checkpoint.reals.find("position");
  const auto counters = checkpoint.integers.find("counters");
  const std::vector<std::int64_t>& method = integers(checkpoint, "method");
  if (position == checkpoint.reals.end() || counters == checkpoint.integers.end() || counters->second.size() != 3 ||
      position->second.size() != self.minimizer->point().x.size() || method.size() != 2)
    throw Failure("the checkpoint is not one of this scene's minimization");
  if (method[0]) self.method = MinimizeMethod::newton_cg;
  self.changed_at = method[1];
  self.newton_threshold = reals(checkpoint, "settled", 1).front();
  self.start(self.in_own_order(position->second));
  self.minimizer->remember(checkpoint.reals);
  self.iteration = counters->second[0];
  history_.clear();
  recorded_at_ = counters->second[2];
  self.earlier_evaluations = counters->second[1] - self.minimizer->evaluations();
}

}  // namespace lichtenberg
