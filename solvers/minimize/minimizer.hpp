#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <span>
#include <string>
#include <vector>

namespace lichtenberg::minimize {

/// Function of many variables to be minimized.
class Objective {
 public:
  virtual ~Objective() = default;
  virtual int size() const = 0;
  /// Returns the value and overwrites the gradient at x. The value is infinite, and the gradient undefined, for a
  /// forbidden x.
  virtual double evaluate(std::span<const double> x, std::span<double> gradient) = 0;
  /// Calls task(k) for k from 0 to tasks - 1, in any order. An objective with threads may run the tasks on them.
  virtual void share(int tasks, const std::function<void(int)>& task) const {
    for (int k = 0; k < tasks; ++k) task(k);
  }
};

/// Objective with second derivatives.
class SmoothObjective : public Objective {
 public:
  /// Computes the Hessian at x that the other functions use.
  virtual void linearize(std::span<const double> x) = 0;
  /// Computes product = Hessian * v.
  virtual void multiply(std::span<const double> v, std::span<double> product) const = 0;
  /// Computes z = M^-1 r, with M an approximation of the Hessian that is positive definite and easy to invert.
  virtual void precondition(std::span<const double> r, std::span<double> z) const = 0;
};

/// State of a minimizer, by name.
using Memory = std::map<std::string, std::vector<double>>;

struct Point {
  std::vector<double> x, gradient;
  double value = 0;
};

/// Iterative minimizer. The caller decides when to stop.
class Minimizer {
 public:
  /// Starts at x. `objective` must outlive this object. Throws InputError if x is forbidden.
  Minimizer(Objective& objective, std::vector<double> x);
  virtual ~Minimizer() = default;

  /// Moves to a point of finite value. The value does not increase beyond rounding, except for Fire, with which it may
  /// increase. Returns false, without moving, if there is no such point.
  virtual bool iterate() = 0;
  const Point& point() const { return point_; }
  std::int64_t evaluations() const { return evaluations_; }  ///< Number of evaluations of value and gradient

  /// Returns the state besides the point, by name. A minimizer with the same point and state continues identically.
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
