#include "python/module/answers.hpp"

#include <nlohmann/json.hpp>

#include <cstdint>
#include <utility>
#include <vector>

#include "python/module/arrays.hpp"
#include "solvers/error.hpp"
#include "src/commands/field_answer.hpp"
#include "src/commands/solve_grains.hpp"

namespace py = pybind11;

namespace lichtenberg::python {
namespace {

/// Returns one value for each conductor.
template <class Value>
auto for_each_conductor(int count, const Value& value) {
  std::vector<decltype(value(0))> values;
  values.reserve(count);
  for (int i = 0; i < count; ++i) values.push_back(value(i));
  return array_of(std::move(values), {count});
}

/// Returns an array [N, dimension].
template <class Vector>
py::array vectors(int count, int dimension, const Vector& vector) {
  std::vector<double> values;
  values.reserve(static_cast<std::size_t>(count) * dimension);
  for (int i = 0; i < count; ++i) {
    const Vec3 v = vector(i);
    for (int k = 0; k < dimension; ++k) values.push_back(v[k]);
  }
  return array_of(std::move(values), {count, dimension});
}

/// Converts JSON to Python objects by Python's own reader.
py::dict dictionary_of(const nlohmann::ordered_json& json) {
  return py::module_::import("json").attr("loads")(json.dump()).cast<py::dict>();
}

py::dict dictionary_of(FieldAnswer answer) {
  const int n = answer.size(), d = answer.scene.dimension();
  const std::vector<Conductor>& conductors = answer.scene.conductors;
  py::dict result = dictionary_of(summary_json(answer));
  result["position"] = vectors(n, d, [&](int i) { return conductors[i].position; });
  result["radius"] = for_each_conductor(n, [&](int i) { return conductors[i].radius; });
  result["group"] = for_each_conductor(n, [&](int i) { return std::int64_t{answer.field.group_of_body[i]}; });
  result["potential"] = for_each_conductor(n, [&](int i) { return answer.potential(i); });
  result["charge"] = for_each_conductor(n, [&](int i) { return answer.charge(i); });
  result["force"] = vectors(n, d, [&](int i) { return answer.force[i]; });
  if (answer.potential_field) {
    laplace::Field& potential = *answer.potential_field;
    result["potential_field"] = array_of(std::move(potential.value), {potential.ny, potential.nx});
    result["cell"] = potential.h;
  }
  return result;
}

py::dict dictionary_of(const GrainAnswer& answer) {
  const int n = answer.bodies.size();
  py::dict result = dictionary_of(summary_json(answer));
  result["position"] = vectors(n, 3, [&](int i) { return position_in_space(answer.bodies, i); });
  result["radius"] = array_of(std::vector(answer.bodies.radius), {n});
  result["charge"] = array_of(std::vector(answer.bodies.charge), {n});
  result["potential"] = array_of(std::vector(answer.potential), {n});
  result["force"] = vectors(n, 3, [&](int i) { return answer.force[i]; });
  if (!answer.dipole.empty()) result["dipole"] = vectors(n, 3, [&](int i) { return answer.dipole[i]; });
  return result;
}

}  // namespace

py::dict solve(const Scene& scene, bool capacitance, bool potential_field) {
  if (!scene.reference)
    return dictionary_of(compute_until_interrupt(
        [&] { return solve_field(scene, {.capacitance = capacitance, .potential_field = potential_field}); }));
  if (capacitance || potential_field)
    throw InputError("capacitance and potential_field are for scenes of conductors: leave them out for charged grains");
  return dictionary_of(compute_until_interrupt([&] { return solve_grain_field(scene); }));
}

}  // namespace lichtenberg::python
