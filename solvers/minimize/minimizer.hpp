#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <span>
#include <string>
#include <vector>

namespace lichtenberg::minimize {

/// A function of many variables that is to be made small.
class Objective {
 public:
  virtual ~Objective() = default;
  virtual int size() const = 0;
  /// Its value and gradient (overwritten) at x. Infinite where x is not allowed; the gradient then means nothing.
  virtual double evaluate(std::span<const double> x, std::span<double> gradient) = 0;
  /// Calls task(k) for k from 0 to tasks - 1, in any order: one that has threads lets the minimizer use them too.
  virtual void share(int tasks, const std::function<void(int)>& task) const {
    for (int k = 0; k < tasks; ++k) task(k);
  }
};

/// One that knows its second derivatives.
class SmoothObjective : public Objective {
 public:
  /// Makes the Hessian at x the one that the others use.
  virtual void linearize(std::span<const double> x) = 0;
  /// product = Hessian * v
  virtual void multiply(std::span<const double> v, std::span<double> product) const = 0;
  /// z = M^-1 r, with M like the Hessian but positive definite and easy to invert.
  virtual void precondition(std::span<const double> r, std::span<double> z) const = 0;
};

/// What a minimizer remembers, by name.
using Memory = std::map<std::string, std::vector<double>>;

struct Point {
  std::vector<double> x, gradient;
  double value = 0;
};

/// A way downhill, one iteration at a time. Who calls it decides when that is far enough.
class Minimizer {
 public:
  /// Starts at x. `objective` must outlive this. Throws InputError if x is not allowed.
  Minimizer(Objective& objective, std::vector<double> x);
  virtual ~Minimizer() = default;

  /// Goes on to a point where the value is finite: one that is not higher, to rounding, but for Fire, which goes up now
  /// and then. False, and the point stays, if it finds none.
  virtual bool iterate() = 0;
  const Point& point() const { return point_; }
  std::int64_t evaluations() const { return evaluations_; }  ///< of value and gradient

  /// What it remembers besides the point, by name: with it, it goes on as if it had never stopped.
  virtual Memory memory() const { return {}; }
  virtual void remember(const Memory& memory) { (void)memory; }

 protected:
  void evaluate(Point& at) {
    at.value = objective_.evaluate(at.x, at.gradient);
    ++evaluations_;
  }

  Objective& objective_;
  Point point_;
  std::int64_t evaluations_ = 0;
};

}  // namespace lichtenberg::minimize
