#pragma once

#include <memory>

#include "src/granular/gas.hpp"

namespace lichtenberg::granular {

/// A way to carry a gas on by one step.
class Integrator {
 public:
  virtual ~Integrator() = default;
  /// The longest step that it may take from here.
  virtual double longest_step(const Gas& gas) const = 0;
  /// Carries the gas on to `end`, at most a longest step away.
  virtual void step(Gas& gas, double end) = 0;
};

/// The one that the scene's [mechanics] asks for.
std::unique_ptr<Integrator> make_integrator(const Scene& scene);

}  // namespace lichtenberg::granular
