#include "solvers/minimize/minimizer.hpp"

#include <fmt/format.h>

#include <cmath>

#include "solvers/error.hpp"

namespace lichtenberg::minimize {

const std::vector<double>& remembered(const Memory& memory, const std::string& name, std::size_t size) {
  const auto found = memory.find(name);
  if (found == memory.end() || found->second.size() != size)
    throw Failure(
        fmt::format("the state of the minimization has no \"{}\" of {} numbers: it is of another scene", name, size));
  return found->second;
}

Minimizer::Minimizer(Objective& objective, std::vector<double> x) : objective_(objective) {
  point_.x = std::move(x);
  point_.gradient.resize(point_.x.size());
  evaluate(point_);
  if (!std::isfinite(point_.value)) throw InputError("the energy is infinite where the minimization would start");
}

}  // namespace lichtenberg::minimize
