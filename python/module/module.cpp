// Python module lichtenberg._core: scenes, solves and runs in the process of the interpreter. The package
// python/lichtenberg wraps it.
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "python/module/answers.hpp"
#include "python/module/arrays.hpp"
#include "python/module/coagulation.hpp"
#include "python/module/compiled.hpp"
#include "python/module/exchange.hpp"
#include "python/module/force.hpp"
#include "python/module/run.hpp"
#include "solvers/error.hpp"
#include "solvers/parallel/petsc.hpp"
#include "src/commands/device.hpp"
#include "src/effects/effects.hpp"
#include "src/scene/scene.hpp"
#include "src/scene/stopping.hpp"
#include "src/scene/vary.hpp"
#include "src/version.hpp"

namespace py = pybind11;

namespace lichtenberg::python {
namespace {

using Settings = std::vector<std::pair<std::string, std::string>>;

std::vector<Setting> settings_from(const Settings& written) {
  std::vector<Setting> settings;
  for (const auto& [key, value] : written) settings.push_back({key, value});
  return settings;
}

/// Returns the built-in effects and then the compiled ones.
EffectKinds kinds_with(const std::vector<CompiledEffect>& compiled) {
  EffectKinds kinds = effects::all_kinds();
  for (const CompiledEffect& effect : compiled) kinds.push_back(effect.kind);
  return kinds;
}

/// Reads a scene from its text; `name`: for messages. A signal of the keyboard ends the placement of bodies.
Scene scene_from_text(const std::string& text, const std::string& name, const Settings& settings,
                      const std::vector<CompiledEffect>& compiled) {
  std::optional<py::error_already_set> interruption;
  const auto stop = [&] {
    const py::gil_scoped_acquire lock;
    if (PyErr_CheckSignals() != 0) interruption.emplace();
    return interruption.has_value();
  };
  try {
    const py::gil_scoped_release unlocked;
    return parse_scene(text, name, kinds_with(compiled), settings_from(settings), stop);
  } catch (const Stopped&) {
    throw std::move(*interruption);
  }
}

std::pair<std::string, std::string> split_setting(const std::string& written) {
  const Setting setting = setting_of(written);
  return {setting.key, setting.value};
}

Scene with_force(const Scene& scene, py::function function) {
  Scene changed = scene;
  add_force(changed, std::move(function));
  return changed;
}

Scene with_charge_exchange(const Scene& scene, py::function function, double unit) {
  Scene changed = scene;
  add_charge_exchange(changed, std::move(function), unit);
  return changed;
}

Scene on_device(const Scene& scene, const std::string& device) {
  if (!value_of<FieldDevice>(device))
    throw InputError("device = \"" + device + "\" is not allowed: it must be \"cpu\" or \"cuda\"");
  Scene changed = scene;
  set_device(changed, device);
  return changed;
}

/// Makes InputError and Failure of C++ those of the Python package.
void register_errors() {
  py::register_exception_translator([](std::exception_ptr pointer) {
    const auto raise = [](const char* name, const char* message) {
      const py::object type = py::module_::import("lichtenberg.errors").attr(name);
      PyErr_SetString(type.ptr(), message);
    };
    try {
      if (pointer) std::rethrow_exception(pointer);
    } catch (const InputError& error) {
      raise("InputError", error.what());
    } catch (const Failure& error) {
      raise("Failure", error.what());
    }
  });
}

}  // namespace

std::recursive_timed_mutex& solver_mutex() {
  static std::recursive_timed_mutex mutex;
  return mutex;
}

}  // namespace lichtenberg::python

PYBIND11_MODULE(_core, module) {
  using namespace lichtenberg;
  using namespace lichtenberg::python;
  register_errors();
  register_state(module);
  register_contacts(module);
  py::class_<Scene>(module, "Scene")
      .def_static("from_text", &scene_from_text, py::arg("text"), py::arg("name"), py::arg("settings"),
                  py::arg("effects"))
      .def("with_force", &with_force)
      .def("with_charge_exchange", &with_charge_exchange)
      .def("on_device", &on_device)
      .def_readonly("text", &Scene::text)
      .def_readonly("title", &Scene::title)
      .def_readonly("warnings", &Scene::warnings)
      .def_property_readonly("dimension", &Scene::dimension)
      .def_property_readonly("grains", [](const Scene& scene) { return scene.reference.has_value(); })
      .def_property_readonly("body_count", [](const Scene& scene) { return scene.conductors.size(); })
      .def_property_readonly("effects", [](const Scene& scene) {
        std::vector<std::string> names;
        for (const Effects::Entry& entry : scene.effects) names.push_back(entry.kind->name);
        return names;
      });
  module.def("setting_of", &split_setting, py::arg("text"));
  py::class_<CompiledEffect>(module, "CompiledEffect")
      .def_property_readonly("name", [](const CompiledEffect& effect) { return effect.kind->name; })
      .def_property_readonly("description", [](const CompiledEffect& effect) { return effect.kind->description; });
  module.def("load_effect", &load_effect, py::arg("path"));
  module.def("solve", &solve, py::arg("scene"), py::arg("capacitance"), py::arg("potential_field"));
  module.def("coagulate", &coagulate, py::arg("kernel"), py::arg("times"), py::arg("tolerance"), py::arg("largest"),
             py::arg("stiff"));
  register_run(module);
  module.attr("version") = lichtenberg_version().number;
  module.attr("compiler_flags") = lichtenberg_version().flags;
  py::module_::import("atexit").attr("register")(py::cpp_function(&parallel::finish_petsc));
}
