#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <span>
#include <string>
#include <vector>

namespace lichtenberg::minimize {

/// Objective function of a minimization: a scalar function of many variables x with its gradient, such as the potential
/// energy of a packing.
class Objective {
 public:
  virtual ~Objective() = default;
  /// Returns the number of variables.
  virtual int size() const = 0;
  /// Returns the value at x and overwrites `gradient` with the gradient there; both have size() components. At a
  /// forbidden x (outside the function's domain) the value is infinite and the gradient undefined.
  virtual double evaluate(std::span<const double> x, std::span<double> gradient) = 0;
  /// Calls task(k) for k from 0 to tasks - 1, in any order. Some minimizers divide vector operations into tasks with
  /// this function. A derived class may run the tasks on several threads; this version runs them on the calling thread.
  virtual void share(int tasks, const std::function<void(int)>& task) const {
    for (int k = 0; k < tasks; ++k) task(k);
  }
};

/// Objective function with second derivatives: products with its Hessian matrix, and a preconditioner.
class SmoothObjective : public Objective {
 public:
  /// Computes the Hessian matrix at x, which multiply() and precondition() then use.
  virtual void linearize(std::span<const double> x) = 0;
  /// Computes the product of the Hessian matrix with v: product = Hessian * v.
  virtual void multiply(std::span<const double> v, std::span<double> product) const = 0;
  /// Applies the preconditioner: computes z = M^-1 r. M is a positive definite approximation of the Hessian matrix that
  /// is easy to invert.
  virtual void precondition(std::span<const double> r, std::span<double> z) const = 0;
};

/// Internal state of a minimizer for checkpoints, such as velocities or past gradients: arrays by name.
using Memory = std::map<std::string, std::vector<double>>;

/// Returns the array `name` of a memory. Throws Failure if there is none with `size` numbers.
const std::vector<double>& remembered(const Memory& memory, const std::string& name, std::size_t size);

/// Variables x with the gradient and the value of the objective function there.
struct Point {
  std::vector<double> x, gradient;
  double value = 0;
};

/// Base class of iterative minimizers of an objective function. The caller repeats iterate() and decides when to stop.
class Minimizer {
 public:
  /// Starts the minimization at x, where it evaluates `objective`. `objective` must outlive this object. Throws
  /// InputError if the value at x is not finite.
  Minimizer(Objective& objective, std::vector<double> x);
  virtual ~Minimizer() = default;

  /// Performs one iteration: moves point() by an accepted step to a point of finite value. The value does not increase
  /// beyond rounding, except with Fire. Returns false if no step was accepted.
  virtual bool iterate() = 0;
  const Point& point() const { return point_; }              ///< Current point
  std::int64_t evaluations() const { return evaluations_; }  ///< Number of evaluations of value and gradient

  /// Returns the minimizer's internal state, without the point, for a checkpoint. A minimizer that is made with the
  /// same arguments at the same point and restores this state continues with identical bits.
  virtual Memory memory() const { return {}; }
  /// Restores an internal state that memory() returned. Throws Failure if it is of another minimizer.
  virtual void remember(const Memory& memory) { (void)memory; }

 protected:
  /// Evaluates the objective function at at.x: sets value and gradient of `at`, and counts the evaluation.
  void evaluate(Point& at) {
    at.value = objective_.evaluate(at.x, at.gradient);
    ++evaluations_;
  }

  Objective& objective_;
  Point point_;
  std::int64_t evaluations_ = 0;
};

}  // namespace lichtenberg::minimize
