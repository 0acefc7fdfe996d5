#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "src/model/model.hpp"

namespace lichtenberg::mechanics {

/// Event functions (root functions) of an integration of the bodies' motion. A change of sign in the given direction
/// ends the integration.
struct Events {
  std::vector<int> direction;                     ///< by event: -1 falls through zero, +1 rises
  std::function<void(std::span<double>)> values;  ///< writes the values at the present state of the bodies
  /// Returns a step (s) in which no event function changes its sign twice, for the present bodies and the forces on
  /// them (N); may be empty. Signs are checked at the ends of steps only.
  std::function<double(std::span<const double>)> longest_step;
  /// Writes the values of all events except the last, which is for bodies that collisions move beyond their reach; may
  /// be empty. These values and longest_step depend only on the bodies in `watched` and the forces on them.
  std::function<void(std::span<double>)> predicted_values;
  std::vector<int> watched;
  /// Returns only the events of predicted_values with these indices; their function is `values`. May be empty.
  std::function<Events(std::span<const int>)> subset;
};

/// Bodies that an integration does not move, because their paths are known, but whose positions its event functions
/// read. They do not interact with the moving bodies. Both functions take the time (s).
struct PassiveBodies {
  std::span<const int> watched;                           ///< bodies that events depend on
  std::function<void(double)> set_state;                  ///< sets positions and momenta of `watched`
  std::function<std::span<const double>(double)> forces;  ///< N, [N * dimension], valid for `watched`
};

/// Local error that one step of the integrator may have.
struct Accuracy {
  double relative = 0;           ///< of a momentum, relative to itself
  double position = 0;           ///< m
  std::vector<double> momentum;  ///< kg m/s, by body: absolute error of a momentum, added to the relative error
};

/// Integrates Newton's equations dx/dt = p/m, dp/dt = F(x, p, t) (D 5.7) of a model by CVODE (SUNDIALS). The method
/// uses backward differentiation formulas of variable order and step (Cohen & Hindmarsh 1996). Newton's iteration uses
/// the analytic Jacobian of the effects, factored by KLU. Contacts are stiff (1e5 rad/s for steel), drag relaxes in
/// milliseconds, and both are implicit.
///
/// Error tests use the largest error of any component. The order is at most 5. It is at most 2 if a force depends on
/// positions at the start, as in elastic contacts, or after 300 steps. Above order 2 the formulas amplify oscillations
/// with little damping. Two steel spheres pressed together in oil would oscillate forever at the amplitude of the
/// tolerance, with a million steps a second. At order 2 the formulas are A-stable (Dahlquist 1963), and the spheres
/// come to rest.
class Cvode {
 public:
  /// Makes an integrator of all bodies of a model, which must outlive this object.
  Cvode(Model& model, Accuracy accuracy);
  ~Cvode();

  /// Integrates the motion of all bodies from time `start` to time `end` (s), or to the first event if that is earlier.
  /// Returns the time reached. Each call restarts the integrator, so that earlier calls have no influence. Throws
  /// Failure if the accuracy cannot be reached or CVODE fails otherwise, and exceptions of forces and callbacks.
  double advance(double start, double end, const Events& events = {});
  /// Integrates only the motion of the bodies `moving` (indices in ascending order; empty: all), with the arguments and
  /// results of advance() for all bodies. `passive`: other bodies, on known paths, that the event functions read.
  double advance(double start, double end, const Events& events, std::vector<int> moving, const PassiveBodies& passive);

  /// Callback before an evaluation of forces, with the time (s); may be empty.
  std::function<void(double)> before_forces;

  /// Callback before each step of the integrator; may be empty.
  std::function<void()> between_steps;

  /// Callback after each step of the integrator: its length (s), and the positions (m) and momenta (kg m/s) of all
  /// bodies at its start. The model's bodies are at its end. May be empty.
  std::function<void(double dt, const std::vector<double>& position, const std::vector<double>& momentum)> after_step;

  std::int64_t steps() const;     ///< sum over all integrations
  std::int64_t rejected() const;  ///< repeated steps

  struct Shared;
  struct Implementation;

 private:
  std::unique_ptr<Shared> shared_;
};

}  // namespace lichtenberg::mechanics
