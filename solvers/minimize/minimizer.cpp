#include "solvers/minimize/minimizer.hpp"

#include <cmath>

#include "solvers/error.hpp"

namespace lichtenberg::minimize {

Minimizer::Minimizer(Objective& objective, std::vector<double> x) : objective_(objective) {
  point_.x = std::move(x);
  point_.gradient.resize(point_.x.size());
  evaluate(point_);
  if (!std::isfinite(point_.value)) throw InputError("the energy is infinite where the minimization would start");
}

}  // namespace lichtenberg::minimize
