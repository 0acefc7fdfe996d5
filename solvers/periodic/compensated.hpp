#pragma once

#include "solvers/geometry/vec.hpp"

namespace lichtenberg::periodic {

/// A sum that keeps what each addition rounds off (Knuth's two-sum; Ogita, Rump and Oishi 2005, algorithm 4.4): as good
/// as one made in twice the digits and rounded once at the end.
class CompensatedSum {
 public:
  CompensatedSum& operator+=(double x) {
    const double sum = sum_ + x, added = sum - sum_;
    lost_ += (sum_ - (sum - added)) + (x - added);
    sum_ = sum;
    return *this;
  }
  double value() const { return sum_ + lost_; }

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
  Vec3 value() const { return {x.value(), y.value(), z.value()}; }
};

}  // namespace lichtenberg::periodic
