#pragma once

#include "solvers/laplace/multipole/arrangement.hpp"

namespace lichtenberg::laplace {

/// Where the coefficients of each source lie in one array: the logarithm's (real) first, then a_1 ... a_order.
struct Layout {
  explicit Layout(const std::vector<Source>& sources) : start{0} {
    for (const Source& s : sources) start.push_back(start.back() + s.order + 1);
  }
  std::vector<int> start;  ///< of each source, and the end
  int size() const { return start.back(); }
  int sources() const { return static_cast<int>(start.size()) - 1; }
  /// Highest multipole of a source, -1 if there is no such source.
  int order(int source) const { return source < sources() ? start[source + 1] - start[source] - 1 : -1; }
};

/// What sources do to disks nearby, one by one. The source is
///   -lambda ln(z - c) + sum_k a_k (R_c / (z - c))^k,
/// the field at the disk sum_m b_m ((z - z_0) / R)^m, and with d = z_0 - c
///   b_m = (-R/d)^m [sum_k C(k+m-1, m) (R_c/d)^k a_k + lambda / m],   b_0 = -lambda ln d + sum_k (R_c/d)^k a_k
/// (Greengard & Rokhlin 1987, Lemma 2.4).
class NearField {
 public:
  /// Terms that change a field by less than `accuracy` of the source's largest are left out. Of a source whose field
  /// is constant on a circle only the logarithm's mean over it counts there.
  NearField(const Arrangement& arrangement, double accuracy);

  /// Adds the fields of all near sources to the local coefficients of the disks; both arrays laid out as the sources.
  void add(const Layout& layout, const Complex* coefficients, Complex* local) const;

 private:
  struct Pair {
    int disk = 0, source = 0;
    int source_order = 0, disk_order = 0;
    bool conjugates = false;
    double charge_factor = 0;  ///< sign of the image's charge
    double minus_log = 0;      ///< -ln |d|, with that sign
    std::size_t power = 0;     ///< where its powers begin
  };
  void add_pair(const Pair& pair, const Complex* coefficients, Complex* local) const;
  void append(const Source& disk, const Source& source, Image image, Complex d, Pair pair);
  void make_binomials();

  int largest_order_ = 0, stride_ = 0;
  std::vector<Pair> pairs_;
  std::vector<Complex>
      power_;  ///< of each pair: (2 R_c/d)^k, k = 1 ... source_order, then (-2 R/d)^m, m = 1 ... disk_order
  std::vector<double> binomial_;  ///< row k, column m: C(k+m-1, m) / 2^(k+m), row 0: 1 / (m 2^m)
};

}  // namespace lichtenberg::laplace
