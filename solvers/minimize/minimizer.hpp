#pragma once

#include <cstdint>
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
};

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

  /// Goes to a point that is not higher. False if there is none that rounding can tell from this one.
  virtual bool iterate() = 0;
  const Point& point() const { return point_; }
  std::int64_t evaluations() const { return evaluations_; }  ///< of value and gradient

  /// What it remembers besides the point, by name: with it, it goes on as if it had never stopped.
  virtual std::map<std::string, std::vector<double>> memory() const { return {}; }
  virtual void remember(const std::map<std::string, std::vector<double>>& memory) { (void)memory; }

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
