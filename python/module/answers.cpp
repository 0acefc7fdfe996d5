#include "python/module/answers.hpp"

#include <pybind11/stl.h>

#include <span>
#include <utility>
#include <vector>

#include "python/module/arrays.hpp"
#include "solvers/error.hpp"
#include "src/commands/field_answer.hpp"
#include "src/commands/solve_grains.hpp"
#include "src/field_methods/field_method.hpp"

namespace py = pybind11;
using namespace py::literals;

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

py::list electrodes(const FieldAnswer& answer) {
  py::list rows;
  for (const auto& [name, potential, charge, group] : terminals(answer))
    rows.append(py::dict("name"_a = name, "potential"_a = potential, "charge"_a = charge, "group"_a = group));
  return rows;
}

py::dict seconds_of(const FieldAnswer& answer) {
  const auto& seconds = answer.solution.seconds;
  return py::dict("setup"_a = seconds.setup, "solve"_a = seconds.solve, "forces"_a = seconds.forces);
}

py::dict dictionary_of(FieldAnswer answer) {
  const int n = answer.size(), d = answer.scene.dimension();
  const std::vector<Conductor>& conductors = answer.scene.conductors;
  const FieldOptions& field = answer.scene.field();
  const laplace::LaplaceSolution& solution = answer.solution;
  py::dict result("position"_a = vectors(n, d, [&](int i) { return conductors[i].position; }),
                  "radius"_a = for_each_conductor(n, [&](int i) { return conductors[i].radius; }),
                  "group"_a = for_each_conductor(n, [&](int i) { return std::int64_t{answer.field.group_of_body[i]}; }),
                  "potential"_a = for_each_conductor(n, [&](int i) { return answer.potential(i); }),
                  "charge"_a = for_each_conductor(n, [&](int i) { return answer.charge(i); }),
                  "force"_a = vectors(n, d, [&](int i) { return answer.force[i]; }),
                  "electrodes"_a = electrodes(answer), "energy"_a = answer.energy(), "method"_a = field.method->name,
                  "unknowns"_a = solution.unknowns, "iterations"_a = solution.iterations,
                  "residual"_a = solution.residual, "seconds"_a = seconds_of(answer),
                  "warnings"_a = warnings_of(answer));
  result["units"] = py::dict("position"_a = "m", "radius"_a = "m", "potential"_a = "V", "charge"_a = "C",
                             "force"_a = "N", "energy"_a = "J", "depth"_a = "m", "capacitance"_a = "F");
  if (!answer.in_space()) result["depth"] = answer.depth();
  if (field.chosen_for) {
    py::dict accuracy("asked"_a = field.chosen_for->requested, "estimated_error"_a = field.chosen_for->estimate);
    if (!answer.in_space()) accuracy["cells"] = field.cells;
    accuracy["tolerance"] = field.tolerance;
    result["accuracy"] = accuracy;
  }
  if (solution.work > 0) result["work"] = solution.work;
  if (const int groups = static_cast<int>(answer.capacitance.names.size()))
    result["capacitance"] = py::dict("groups"_a = answer.capacitance.names,
                                     "matrix"_a = array_of(std::move(answer.capacitance.matrix), {groups, groups}));
  if (answer.potential_field) {
    laplace::Field& potential = *answer.potential_field;
    result["potential_field"] = array_of(std::move(potential.value), {potential.ny, potential.nx});
    result["cell"] = potential.h;
  }
  return result;
}

py::dict dictionary_of(const GrainAnswer& answer) {
  const int n = answer.bodies.size();
  py::dict result("position"_a = vectors(n, 3, [&](int i) { return position_in_space(answer.bodies, i); }),
                  "radius"_a = array_of(std::vector(answer.bodies.radius), {n}),
                  "charge"_a = array_of(std::vector(answer.bodies.charge), {n}),
                  "potential"_a = array_of(std::vector(answer.potential), {n}),
                  "force"_a = vectors(n, 3, [&](int i) { return answer.force[i]; }), "energy"_a = answer.energy,
                  "method"_a = answer.method, "warnings"_a = answer.warnings,
                  "seconds"_a = py::dict("solve"_a = answer.seconds));
  if (!answer.dipole.empty()) result["dipole"] = vectors(n, 3, [&](int i) { return answer.dipole[i]; });
  if (answer.accuracy) result["accuracy"] = py::dict("asked"_a = *answer.accuracy);
  result["units"] = py::dict("position"_a = "d0", "radius"_a = "d0", "charge"_a = "q0", "potential"_a = "q0/d0",
                             "force"_a = "m0 v0^2/d0", "dipole"_a = "q0 d0", "energy"_a = "m0 v0^2");
  return result;
}

/// Calls work() without the interpreter lock.
template <class Work>
auto unlocked(const Work& work) {
  const py::gil_scoped_release released;
  return work();
}

}  // namespace

py::dict solve(const Scene& scene, bool capacitance, bool potential_field) {
  if (!scene.reference)
    return dictionary_of(
        unlocked([&] { return solve_field(scene, {.capacitance = capacitance, .potential_field = potential_field}); }));
  if (capacitance || potential_field)
    throw InputError("capacitance and potential_field are for scenes of conductors: leave them out for charged grains");
  return dictionary_of(unlocked([&] { return solve_grain_field(scene); }));
}

}  // namespace lichtenberg::python
