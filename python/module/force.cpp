#include "python/module/force.hpp"

#include <fmt/format.h>

#include <cmath>
#include <memory>
#include <utility>
#include <vector>

#include "python/module/arrays.hpp"
#include "solvers/error.hpp"
#include "src/model/effect.hpp"
#include "src/scene/effect_kind.hpp"

namespace py = pybind11;

namespace lichtenberg::python {
namespace {

/// Python functions. Their last owner may release them on a thread without the interpreter lock.
struct Functions {
  std::vector<py::function> all;

  ~Functions() {
    const py::gil_scoped_acquire lock;
    all.clear();
  }
};

/// State of the bodies as the function sees it.
struct SeenState {
  double time;
  py::array position, momentum, mass, radius;
  py::object charge;
};

/// Returns a copy of the state, which the function may keep.
SeenState state_for_python(const State& state) {
  const Bodies& bodies = state.bodies;
  const py::ssize_t n = bodies.size(), d = bodies.dimension;
  SeenState result{state.time,
                   array_of(std::vector(bodies.position), {n, d}),
                   array_of(std::vector(bodies.momentum), {n, d}),
                   array_of(std::vector(bodies.mass), {n}),
                   array_of(std::vector(bodies.radius), {n}),
                   py::none()};
  if (!bodies.charge.empty()) result.charge = array_of(std::vector(bodies.charge), {n});
  return result;
}

using Numbers = py::array_t<double, py::array::c_style | py::array::forcecast>;

/// Forces and energy that a function returned.
struct Answer {
  Numbers force;
  double energy = 0;
};

/// Returns the number of a Python scalar. Throws InputError if the object is none.
double energy_of(const py::object& object) {
  try {
    const double energy = object.cast<double>();
    if (std::isfinite(energy)) return energy;
  } catch (const py::cast_error&) {
  }
  throw InputError("add_force: the function returned an energy that is no finite number");
}

/// Calls the function and checks its answer: forces, or a pair of forces and a number.
Answer call(const py::function& function, const State& state) {
  py::object returned = function(state_for_python(state));
  double energy = 0;
  if (py::isinstance<py::tuple>(returned) && py::len(returned) == 2) {
    const py::object second = returned[py::int_(1)];  // a force, or the energy
    if (!py::isinstance<py::sequence>(second) || py::isinstance<py::str>(second)) {
      energy = energy_of(second);
      returned = returned[py::int_(0)];
    }
  }
  const Numbers force = Numbers::ensure(returned);
  const py::ssize_t n = state.bodies.size(), d = state.bodies.dimension;
  if (!force || force.ndim() != 2 || force.shape(0) != n || force.shape(1) != d) {
    PyErr_Clear();
    throw InputError(
        fmt::format("add_force: the function must return forces of shape [{}, {}], or a pair of forces and their "
                    "potential energy",
                    n, d));
  }
  for (py::ssize_t k = 0; k < n * d; ++k)
    if (!std::isfinite(force.data()[k]))
      throw InputError(fmt::format(
          "add_force: the function returned a force that is not finite, on body {} at time {:g}", k / d, state.time));
  return {force, energy};
}

struct ForceOptions {
  std::shared_ptr<Functions> functions;
};

class Force : public Effect {
 public:
  Force(const EffectKind& kind, std::shared_ptr<Functions> functions)
      : kind_(&kind), functions_(std::move(functions)) {}

  const EffectKind& kind() const override { return *kind_; }

  void add_forces(const State& state, std::span<double> force) const override {
    const py::gil_scoped_acquire lock;
    const int d = state.bodies.dimension;
    for (const py::function& function : functions_->all) {
      const Answer answer = call(function, state);
      const double* values = answer.force.data();
      for_each_requested(state, [&](int i) {
        for (int k = 0; k < d; ++k) force[i * d + k] += values[i * d + k];
      });
    }
  }

  double stored_energy(const State& state) const override {
    const py::gil_scoped_acquire lock;
    double energy = 0;
    for (const py::function& function : functions_->all) energy += call(function, state).energy;
    return energy;
  }

 private:
  const EffectKind* kind_;
  std::shared_ptr<Functions> functions_;
};

const EffectKind& kind_for_conductors();
const EffectKind& kind_for_grains();

EffectKind make_kind(bool grains) {
  return {.name = "python_force",
          .description = "a force that a Python function returns",
          .options = ForceOptions{},
          .dimensions = {2, 3},
          .periodic = true,
          .grains = grains,
          .make =
              [](const Scene& scene) {
                return std::make_unique<Force>(scene.reference ? kind_for_grains() : kind_for_conductors(),
                                               scene.effects.find<ForceOptions>()->functions);
              },
          .energy_advice = "return the potential energy of Python forces, too"};
}

const EffectKind& kind_for_conductors() {
  static const EffectKind kind = make_kind(false);
  return kind;
}

const EffectKind& kind_for_grains() {
  static const EffectKind kind = make_kind(true);
  return kind;
}

}  // namespace

void add_force(Scene& scene, py::function function) {
  for (const Effects::Entry& entry : scene.effects)
    if (!entry.kind->alone.empty())
      throw InputError(fmt::format("add_force: a scene with effects.{} has no other forces", entry.kind->name));
  auto functions = std::make_shared<Functions>();
  if (const auto* present = scene.effects.find<ForceOptions>()) functions->all = present->functions->all;
  functions->all.push_back(std::move(function));
  scene.effects.add(scene.reference ? kind_for_grains() : kind_for_conductors(), ForceOptions{std::move(functions)});
}

void register_state(py::module_& module) {
  py::class_<SeenState>(module, "State")
      .def_readonly("time", &SeenState::time)
      .def_readonly("position", &SeenState::position)
      .def_readonly("momentum", &SeenState::momentum)
      .def_readonly("mass", &SeenState::mass)
      .def_readonly("radius", &SeenState::radius)
      .def_readonly("charge", &SeenState::charge);
}

}  // namespace lichtenberg::python
