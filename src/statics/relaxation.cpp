#include "src/statics/relaxation.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "solvers/error.hpp"
#include "solvers/minimize/gradient_descent.hpp"
#include "src/effects/contact_potential.hpp"
#include "src/effects/effects.hpp"

namespace lichtenberg {
namespace {

/// The potential energy (J) of a model's bodies, by their positions (m).
class PotentialEnergy : public minimize::Objective {
 public:
  explicit PotentialEnergy(Model model)
      : model_(std::move(model)), potential_(*model_.find<effects::ContactPotential>()) {}

  int size() const override { return static_cast<int>(model_.bodies.position.size()); }
  double evaluate(std::span<const double> x, std::span<double> gradient) override {
    move_to(x);
    std::ranges::fill(gradient, 0.0);
    const double energy = potential_.energy_and_forces({0, model_.bodies, model_.neighbours->pairs()}, gradient);
    for (double& g : gradient) g = -g;
    return energy;
  }

  const Model& model() const { return model_; }

 private:
  void move_to(std::span<const double> x) {
    model_.bodies.position.assign(x.begin(), x.end());
    model_.neighbours->update(model_.bodies);
  }

  Model model_;
  const effects::ContactPotential& potential_;
};

double mean_diameter(const Scene& scene) {
  double sum = 0;
  for (const Conductor& conductor : scene.conductors) sum += 2 * conductor.radius;
  return sum / static_cast<double>(scene.conductors.size());
}

double longest(std::span<const double> vectors, int dimension) {
  double largest = 0;
  for (std::size_t i = 0; i < vectors.size(); i += dimension) {
    double sum = 0;
    for (int k = 0; k < dimension; ++k) sum += vectors[i + k] * vectors[i + k];
    largest = std::max(largest, sum);
  }
  return std::sqrt(largest);
}

}  // namespace

struct Relaxation::Implementation {
  explicit Implementation(const Scene& s) : scene(s), diameter(mean_diameter(s)), energy(effects::make_model(s)) {
    start(energy.model().bodies.position);
  }

  void start(std::vector<double> x) {
    const double unit = diameter * diameter / scene.effects.contact_potential->stiffness;
    minimizer =
        std::make_unique<minimize::GradientDescent>(energy, std::move(x), scene.minimize.step * unit, 0.1 * diameter);
    look();
  }
  void look() { largest_force = longest(minimizer->point().gradient, scene.dimension()); }

  Scene scene;
  double diameter;  ///< m, mean
  PotentialEnergy energy;
  std::unique_ptr<minimize::Minimizer> minimizer;
  std::int64_t iteration = 0, earlier_evaluations = 0;
  double largest_force = 0;  ///< N
};

Relaxation::Relaxation(const Scene& scene) : implementation_(std::make_unique<Implementation>(scene)) {}
Relaxation::~Relaxation() = default;

std::int64_t Relaxation::iteration() const { return implementation_->iteration; }
std::int64_t Relaxation::evaluations() const {
  return implementation_->earlier_evaluations + implementation_->minimizer->evaluations();
}
double Relaxation::energy() const { return implementation_->minimizer->point().value; }
double Relaxation::largest_force() const { return implementation_->largest_force; }
double Relaxation::force_unit() const {
  return implementation_->scene.effects.contact_potential->stiffness / implementation_->diameter;
}
bool Relaxation::at_rest() const {
  return largest_force() <= implementation_->scene.minimize.force_tolerance * force_unit();
}
Bodies Relaxation::bodies() const {
  Bodies bodies = implementation_->energy.model().bodies;
  bodies.position = implementation_->minimizer->point().x;  // the model was moved to every point that was tried
  return bodies;
}

bool Relaxation::iterate() {
  Implementation& self = *implementation_;
  if (!self.minimizer->iterate()) return false;
  ++self.iteration;
  self.look();
  return true;
}

Frame Relaxation::frame() const {
  const Implementation& self = *implementation_;
  const std::vector<double>& x = self.minimizer->point().x;
  const int d = self.scene.dimension();
  Frame frame;
  frame.time = static_cast<double>(self.iteration);
  for (std::size_t i = 0; i < x.size(); i += d) {
    frame.position.push_back({x[i], x[i + 1]});
    if (d == 3) frame.z.push_back(x[i + 2]);
  }
  frame.energy = energy();
  frame.largest_force = largest_force();
  return frame;
}

Checkpoint Relaxation::checkpoint() const {
  const Implementation& self = *implementation_;
  Checkpoint checkpoint;
  checkpoint.reals = self.minimizer->memory();
  checkpoint.reals["position"] = self.minimizer->point().x;
  checkpoint.integers["counters"] = {self.iteration, evaluations()};
  return checkpoint;
}

void Relaxation::restore(const Checkpoint& checkpoint) {
  Implementation& self = *implementation_;
  const auto position = checkpoint.reals.find("position");
  const auto counters = checkpoint.integers.find("counters");
  if (position == checkpoint.reals.end() || counters == checkpoint.integers.end() || counters->second.size() != 2 ||
      position->second.size() != self.minimizer->point().x.size())
    throw Failure("the checkpoint is not one of this scene's relaxation");
  self.start(position->second);
  self.minimizer->remember(checkpoint.reals);
  self.iteration = counters->second[0];
  self.earlier_evaluations = counters->second[1] - self.minimizer->evaluations();
}

}  // namespace lichtenberg
