#pragma once

#include "solvers/geometry/vec.hpp"

namespace lichtenberg {

/// A sum that keeps what each addition rounds off (Knuth's two-sum; Ogita, Rump and Oishi 2005, algorithm 4.4): as good
/// as one made in twice the digits and rounded once at the end. Adding the same small current a hundred thousand times
/// loses the same fraction of it each time, and a plain sum would drift by up to 1e-11 of itself.
class CompensatedSum {
 public:
  CompensatedSum() = default;
  explicit CompensatedSum(double value, double lost = 0) : sum_(value), lost_(lost) {}

  CompensatedSum& operator+=(double x) {
    const double sum = sum_ + x, added = sum - sum_;
    lost_ += (sum_ - (sum - added)) + (x - added);
    sum_ = sum;
    return *this;
  }
  CompensatedSum& operator+=(const CompensatedSum& other) { return *this += other.sum_, *this += other.lost_; }
  CompensatedSum& operator-=(const CompensatedSum& other) { return *this += -other.sum_, *this += -other.lost_; }
  double total() const { return sum_ + lost_; }
  double value() const { return sum_; }  ///< the two parts, for checkpoints
  double lost() const { return lost_; }

 private:
  double sum_ = 0, lost_ = 0;
};

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
