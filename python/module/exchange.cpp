#include "python/module/exchange.hpp"

#include <fmt/format.h>

#include <cmath>
#include <memory>
#include <utility>
#include <vector>

#include "python/module/arrays.hpp"
#include "solvers/error.hpp"
#include "src/effects/charge_exchange_law.hpp"
#include "src/model/effect.hpp"
#include "src/model/grain_contact.hpp"
#include "src/scene/effect_kind.hpp"

namespace py = pybind11;

namespace lichtenberg::python {
namespace {

/// A Python function and the unit of its charges. Its last owner may release it on a thread without the interpreter
/// lock.
struct ExchangeFunction {
  py::function call;
  double unit = 1;

  ~ExchangeFunction() {
    const py::gil_scoped_acquire lock;
    call = py::function();
  }
};

struct ExchangeOptions {
  std::vector<std::shared_ptr<ExchangeFunction>> functions;
};

/// New contacts as the function sees them.
struct SeenContacts {
  double time;
  py::array pair, impact_speed, direction, charge, radius, mass;
};

SeenContacts contacts_for_python(const ContactRecord& contacts, const Bodies& bodies) {
  const py::ssize_t n = static_cast<py::ssize_t>(contacts.begun.size()), d = bodies.dimension;
  std::vector<std::int64_t> pair;
  std::vector<double> speed, direction, charge, radius, mass;
  for (const GrainContact& contact : contacts.begun) {
    speed.push_back(contact.impact_speed);
    for (const int k : {contact.pair.i, contact.pair.j}) {
      pair.push_back(k), charge.push_back(bodies.charge[k]);
      radius.push_back(bodies.radius[k]), mass.push_back(bodies.mass[k]);
    }
    const Vec3 r =
        bodies.box.difference(position_in_space(bodies, contact.pair.i), position_in_space(bodies, contact.pair.j));
    for (int k = 0; k < d; ++k) direction.push_back(r[k] / norm(r));
  }
  return {contacts.time,
          array_of(std::move(pair), {n, 2}),
          array_of(std::move(speed), {n}),
          array_of(std::move(direction), {n, d}),
          array_of(std::move(charge), {n, 2}),
          array_of(std::move(radius), {n, 2}),
          array_of(std::move(mass), {n, 2})};
}

/// Returns the charges of a function's answer. Throws InputError unless it has one finite number for each contact.
py::array_t<double> charges_of(const py::object& answer, std::size_t contacts) {
  auto charges = py::array_t<double, py::array::c_style | py::array::forcecast>::ensure(answer);
  if (!charges) {
    PyErr_Clear();
    throw InputError("add_charge_exchange: the function must return an array of charges");
  }
  if (charges.ndim() != 1 || static_cast<std::size_t>(charges.size()) != contacts)
    throw InputError(
        fmt::format("add_charge_exchange: the function must return {} charges, one for each contact", contacts));
  for (std::size_t k = 0; k < contacts; ++k)
    if (!std::isfinite(charges.data()[k]))
      throw InputError("add_charge_exchange: the function returned a charge that is not finite");
  return charges;
}

class PythonExchange : public Effect {
 public:
  PythonExchange(const EffectKind& kind, std::vector<std::shared_ptr<ExchangeFunction>> functions)
      : kind_(&kind), functions_(std::move(functions)) {}

  const EffectKind& kind() const override { return *kind_; }
  Needs needs() const override { return {.charges = true}; }

  void exchange_charges(const ContactRecord& contacts, const Bodies& bodies, std::span<double> charge) override {
    if (contacts.begun.empty()) return;
    const py::gil_scoped_acquire lock;
    for (const auto& function : functions_) {
      const auto moved = charges_of(function->call(contacts_for_python(contacts, bodies)), contacts.begun.size());
      for (std::size_t k = 0; k < contacts.begun.size(); ++k) {
        const double dq = effects::whole_quanta(moved.data()[k], effects::charge_quantum(function->unit));
        charge[contacts.begun[k].pair.i] += dq;
        charge[contacts.begun[k].pair.j] -= dq;
      }
    }
  }

 private:
  const EffectKind* kind_;
  std::vector<std::shared_ptr<ExchangeFunction>> functions_;
};

const EffectKind& exchange_kind() {
  static const EffectKind kind = {.name = "python_charge_exchange",
                                  .description = "charge transfer that a Python function returns",
                                  .options = ExchangeOptions{},
                                  .dimensions = {2, 3},
                                  .periodic = true,
                                  .grains = true,
                                  .make = [](const Scene& scene) {
                                    return std::make_unique<PythonExchange>(
                                        exchange_kind(), scene.effects.find<ExchangeOptions>()->functions);
                                  }};
  return kind;
}

}  // namespace

void add_charge_exchange(Scene& scene, py::function function, double unit) {
  if (!scene.reference) throw InputError("add_charge_exchange: only grains exchange charge, and the scene has none");
  if (!(unit > 0 && std::isfinite(unit)))
    throw InputError(fmt::format("add_charge_exchange: unit = {:g} is not allowed: it must be positive", unit));
  ExchangeOptions options;
  if (const auto* present = scene.effects.find<ExchangeOptions>()) options = *present;
  options.functions.push_back(std::make_shared<ExchangeFunction>(std::move(function), unit));
  scene.effects.add(exchange_kind(), std::move(options));
}

void register_contacts(py::module_& module) {
  py::class_<SeenContacts>(module, "Contacts")
      .def_readonly("time", &SeenContacts::time)
      .def_readonly("pair", &SeenContacts::pair)
      .def_readonly("impact_speed", &SeenContacts::impact_speed)
      .def_readonly("direction", &SeenContacts::direction)
      .def_readonly("charge", &SeenContacts::charge)
      .def_readonly("radius", &SeenContacts::radius)
      .def_readonly("mass", &SeenContacts::mass);
}

}  // namespace lichtenberg::python
