#include "src/field_methods/field_method.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "solvers/error.hpp"

namespace lichtenberg {
namespace {

FieldMethodKinds& list() {
  static FieldMethodKinds methods = {&cut_cell_method(), &multipole_method(), &relaxation_method(), &spheres_method()};
  return methods;
}

}  // namespace

bool FieldMethodKind::takes(std::string_view key) const { return std::ranges::find(keys, key) != keys.end(); }

const FieldMethodKinds& field_methods() { return list(); }

void add_field_method(const FieldMethodKind& method) {
  if (find_field_method(method.name))
    throw InputError(fmt::format("the field method \"{}\" exists already: names must differ", method.name));
  if (!method.make && !method.make_in_space)
    throw InputError(
        fmt::format("the field method \"{}\" makes no solver: make or make_in_space is needed", method.name));
  list().push_back(&method);
}

const FieldMethodKind* find_field_method(std::string_view name) {
  const auto found = std::ranges::find_if(list(), [&](const FieldMethodKind* method) { return method->name == name; });
  return found == list().end() ? nullptr : *found;
}

const FieldMethodKind& usual_field_method(int dimension) {
  return **std::ranges::find_if(list(), [&](const FieldMethodKind* method) { return method->solves(dimension); });
}

std::string field_methods_that(int dimension, const std::function<bool(const FieldMethodKind&)>& have) {
  std::vector<std::string> names;
  for (const FieldMethodKind* method : list())
    if (method->solves(dimension) && have(*method)) names.push_back(method->name);
  return quoted(names);
}

FieldMethodCost field_method_cost(const FieldOptions& options) {
  return options.method->cost ? options.method->cost(options) : FieldMethodCost{};
}

bool runs_on_device(const FieldOptions& options) {
  return options.device == FieldDevice::cuda && options.method->on_device &&
         options.linear_solver == FieldLinearSolver::multigrid;
}

}  // namespace lichtenberg
