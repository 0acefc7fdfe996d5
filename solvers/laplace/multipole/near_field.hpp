#pragma once

#include "solvers/laplace/multipole/setting.hpp"

namespace lichtenberg::laplace::multipole {

/// Near field of the multipole method: direct translation of the multipoles of each source to local expansions at near
/// disks. A source at c of radius R_c has the complex potential -lambda ln(z - c) + sum_k a_k (R_c / (z - c))^k, with
/// lambda = charge / (2 pi eps). At a disk with centre z_0 and radius R it is sum_m b_m ((z - z_0) / R)^m. With d = z_0
/// - c:
///   b_m = (-R/d)^m [sum_k C(k+m-1, m) (R_c/d)^k a_k + lambda / m],
///   b_0 = -lambda ln d + sum_k (R_c/d)^k a_k (Greengard & Rokhlin 1987, Lemma 2.4).
class NearField {
 public:
  /// Prepares the translations of all near pairs. Terms that change a field by less than about `accuracy` of the
  /// source's largest term are neglected. For a source whose potential is constant on the disk's circle, only the mean
  /// of the logarithm is kept.
  NearField(const Arrangement& arrangement, double accuracy);

  /// Adds the fields of all near sources, with multipole `coefficients` (V), to the local coefficients b_m of the
  /// disks, `local` (V). Both arrays have the given layout.
  void add(const Layout& layout, const Complex* coefficients, Complex* local) const;

 private:
  /// Pair of a disk and a near source, or an image of a source.
  struct NearSource {
    int disk = 0, source = 0;
    int source_order = 0, disk_order = 0;  ///< Highest significant k and m
    bool conjugates = false;               ///< Image::conjugates()
    double charge_factor = 0;              ///< Sign of the image's charge
    double minus_log = 0;                  ///< Minus the mean of ln |z - c| over the circle, with that sign
    std::size_t power = 0;                 ///< Index of its first power
  };
  void fill_powers(const std::vector<Source>& sources, const Image& image, Complex d, const NearSource& pair);
  void make_binomials();
  void add_pair(const NearSource& pair, const Complex* coefficients, Complex* local) const;

  int largest_order_ = 0, stride_ = 0;
  std::vector<NearSource> pairs_;
  /// Powers of each pair: (2 R_c/d)^k, k = 1 ... source_order, then (-2 R/d)^m, m = 1 ... disk_order.
  std::vector<Complex> power_;
  /// Matrix with row k, column m: C(k+m-1, m) / 2^(k+m), row 0: 1 / (m 2^m). The powers of two keep both factors in
  /// range.
  std::vector<double> binomial_;
};

}  // namespace lichtenberg::laplace::multipole
