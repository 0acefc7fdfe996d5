#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "src/model/model.hpp"

namespace lichtenberg::mechanics {

/// Event functions of the model's bodies. A change of sign ends an integration.
struct Events {
  std::vector<int> direction;                     ///< by event: -1 falls through zero, +1 rises
  std::function<void(std::span<double>)> values;  ///< values at the present state of the bodies
  /// Time (s) in which no event function changes its sign twice, for the present bodies and the forces on them (N); may
  /// be empty. Signs are checked at the ends of steps only.
  std::function<double(std::span<const double>)> longest_step;
  /// Values of all events except the last, which is for bodies that collisions move beyond their reach; may be empty.
  /// These values and longest_step depend on the positions of, and the forces on, the bodies in `watched`.
  std::function<void(std::span<double>)> predicted_values;
  std::vector<int> watched;
  /// Returns the events of predicted_values with these numbers only, as `values`; may be empty.
  std::function<Events(std::span<const int>)> subset;
};

/// Bodies that an integration does not move and that do not interact with those that it moves. Both functions take the
/// time (s).
struct PassiveBodies {
  std::span<const int> watched;                           ///< bodies that events depend on
  std::function<void(double)> set_state;                  ///< sets their positions and momenta
  std::function<std::span<const double>(double)> forces;  ///< N, [N * dimension], forces on them
};

/// Error allowed in one step of the integrator.
struct Accuracy {
  double relative = 0;           ///< of a momentum
  double position = 0;           ///< m
  std::vector<double> momentum;  ///< kg m/s, by body: added to the relative part
};

/// Newton's equations dx/dt = p/m, dp/dt = F(x, p, t) (D 5.7) of a model, by CVODE. The method uses backward
/// differentiation formulas of variable order and step (Cohen & Hindmarsh 1996), and Newton's iteration with the
/// effects' analytic Jacobian, factored by KLU. Contacts are stiff (1e5 rad/s for steel), drag relaxes in milliseconds,
/// and both are implicit.
///
/// The error is that of the worst body. The order is at most 5, and at most 2 if bodies press each other at the start
/// or if the end is not reached after some hundred steps. Above order 2 the formulas amplify oscillations with little
/// damping. Two steel spheres pressed together in oil would oscillate forever at the amplitude of the tolerance, with a
/// million steps a second. At order 2 the formulas are A-stable (Dahlquist 1963), and the spheres come to rest.
class Cvode {
 public:
  /// The model must outlive this object.
  Cvode(Model& model, Accuracy accuracy);
  ~Cvode();

  /// Moves the model's bodies from time `start` to time `end` (s), or to the first event if that is earlier. Returns
  /// the time reached. Each call restarts the integrator, so that the result depends only on the bodies and the times.
  /// Throws Failure if the accuracy cannot be reached, and exceptions of the callbacks.
  double advance(double start, double end, const Events& events = {});
  /// Moves only the bodies `moving`, in ascending order.
  double advance(double start, double end, const Events& events, std::vector<int> moving, const PassiveBodies& passive);

  /// Called with the time (s) before forces are evaluated; may be empty.
  std::function<void(double)> before_forces;

  /// Called before each step of the integrator; may be empty.
  std::function<void()> between_steps;

  /// Called after each step of the integrator with its length (s) and the positions (m) and momenta (kg m/s) at its
  /// start; the model's bodies are at its end. May be empty.
  std::function<void(double dt, const std::vector<double>& position, const std::vector<double>& momentum)> after_step;

  std::int64_t steps() const;     ///< sum over all integrations
  std::int64_t rejected() const;  ///< repeated steps

  struct Shared;
  struct Implementation;

 private:
  std::unique_ptr<Shared> shared_;
};

}  // namespace lichtenberg::mechanics
