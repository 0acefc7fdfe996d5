#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "src/model/model.hpp"

namespace lichtenberg::mechanics {

/// Quantities of the model's bodies whose change of sign ends an integration.
struct Events {
  std::vector<int> direction;                     ///< one an event: -1 it must fall through zero, +1 rise
  std::function<void(std::span<double>)> values;  ///< their values for the bodies as they are
  /// The time (s) in which none comes and goes unseen, for the bodies as they are and the forces on them (N); may be
  /// empty. Signs are looked at at the ends of steps only.
  std::function<double(std::span<const double>)> longest_step;
  /// May be empty: the values of all events but the last, which is for bodies that collisions throw farther than
  /// foreseen, and whose places and forces they and longest_step depend on.
  std::function<void(std::span<double>)> foreseen_values;
  std::vector<int> watched;
  /// May be empty: of the foreseen ones those alone that have these numbers, as `values`.
  std::function<Events(std::span<const int>)> only;
};

/// Bodies that an integration leaves out, which do not feel those that it moves. Both functions are for the time (s).
struct Others {
  std::span<const int> watched;                           ///< those that events look at
  std::function<void(double)> place;                      ///< puts these where they are
  std::function<std::span<const double>(double)> forces;  ///< N, [N * dimension], on these
};

/// What one step of the integrator may be wrong by.
struct Accuracy {
  double relative = 0;           ///< of a momentum
  double position = 0;           ///< m
  std::vector<double> momentum;  ///< kg m/s, a body: added to the relative part
};

/// Newton's equations dx/dt = p/m, dp/dt = F(x, p, t) (D 5.7) of a model, by CVODE: backward differentiation formulas
/// of variable order and step (Cohen & Hindmarsh 1996), Newton's iteration with the effects' analytic Jacobian,
/// factored by KLU. Contacts are stiff (1e5 rad/s for steel), drag relaxes in milliseconds, and both are implicit.
///
/// Errors are those of the worst body. The order is up to 5, but up to 2 where bodies press each other at the start or
/// where hundreds of steps have not led to the end: above 2 the formulas feed oscillations that are hardly damped, and
/// two spheres of steel pressed together in oil, at rest, would ring at the amplitude of the tolerance for ever, at a
/// million steps a second. Of order 2 they are A-stable (Dahlquist 1963), and the spheres come to rest.
class Cvode {
 public:
  /// The model must outlive this.
  Cvode(Model& model, Accuracy accuracy);
  ~Cvode();

  /// Moves the model's bodies from time `start` to time `end` (s) or, if that is earlier, to the first event; returns
  /// the time reached. Starts anew each time: the result depends on the bodies and the times alone. Throws Failure if
  /// the accuracy cannot be reached, and what the callbacks throw.
  double advance(double start, double end, const Events& events = {});
  /// The same for some of the bodies alone, in ascending order.
  double advance(double start, double end, const Events& events, std::vector<int> moving, const Others& others);

  /// Called with the time before forces are evaluated, for what depends on the bodies as they are.
  std::function<void(double)> before_forces;

  /// Called before each step of the integrator; may be empty.
  std::function<void()> between_steps;

  /// Called after each step of the integrator with its length (s) and the momenta (kg m/s) at its start; the model's
  /// bodies are at its end, and `position` is where they were. May be empty.
  std::function<void(double dt, const std::vector<double>& position, const std::vector<double>& momentum)> after_step;

  std::int64_t steps() const;     ///< all integrations together
  std::int64_t rejected() const;  ///< steps that had to be repeated

  struct Shared;
  struct Implementation;

 private:
  std::unique_ptr<Shared> shared_;
};

}  // namespace lichtenberg::mechanics
