#pragma once

#include "solvers/geometry/vec.hpp"

namespace lichtenberg {

/// Compensated sum: adds numbers and, separately, the rounding error of each addition. The method is the two-sum of
/// Knuth (Ogita, Rump and Oishi 2005, algorithm 4.4). total() is as accurate as a sum in twice the precision, rounded
/// once. With a plain sum, 1e5 additions of the same small current could cause a relative drift of up to 1e-11.
class CompensatedSum {
 public:
  CompensatedSum() = default;
  /// Starts from a saved sum: its plain part `value` and its accumulated rounding errors `lost`.
  explicit CompensatedSum(double value, double lost = 0) : sum_(value), lost_(lost) {}

  CompensatedSum& operator+=(double x) {
    const double sum = sum_ + x, added = sum - sum_;
    lost_ += (sum_ - (sum - added)) + (x - added);
    sum_ = sum;
    return *this;
  }
  CompensatedSum& operator+=(const CompensatedSum& other) { return *this += other.sum_, *this += other.lost_; }
  CompensatedSum& operator-=(const CompensatedSum& other) { return *this += -other.sum_, *this += -other.lost_; }
  /// Returns the sum with its rounding errors corrected.
  double total() const { return sum_ + lost_; }
  double value() const { return sum_; }  ///< Plain sum, which a checkpoint saves together with lost()
  double lost() const { return lost_; }  ///< Accumulated rounding errors of the plain sum

 private:
  double sum_ = 0, lost_ = 0;
};

/// Compensated sum of vectors of space, component by component.
struct CompensatedVector {
  CompensatedSum x, y, z;

  CompensatedVector& operator+=(Vec3 v) {
    x += v.x;
    y += v.y;
    z += v.z;
    return *this;
  }
  Vec3 total() const { return {x.total(), y.total(), z.total()}; }
};

}  // namespace lichtenberg
