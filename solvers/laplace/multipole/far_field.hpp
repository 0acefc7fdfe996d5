#pragma once

#include "solvers/fftw.hpp"
#include "solvers/laplace/multipole/cells.hpp"
#include "solvers/laplace/multipole/lattice.hpp"

namespace lichtenberg::laplace::multipole {

/// Interaction of far cells with all images: a convolution over the grid, by FFT. Sources of a cell are shifted to its
/// centre; the field arrives as a Taylor series about each cell's centre. The potential of a cell's sources is Re sum_k
/// (-1)^(k-1) alpha_k (k-1)! (h/u)^k + alpha_0 ln u with u = z - centre, its local field Re sum_m beta_m (u/h)^m / m!.
/// In these units beta_m = sum_k G_(m+k) alpha_k, G_n = h^n d^n Lambda / dz^n at the displacement of the two cells. The
/// kernel depends on n = m + k only, not on each pair (m, k).
class FarField {
 public:
  FarField(const Mirrors& mirrors, const LatticeSum& lattice, const Cells& cells, int order);

  /// Returns true if a new object with these arguments would be equal, so that this object can be used again.
  bool fits(const Mirrors& mirrors, const Cells& cells, int order) const;
  int order() const { return order_; }
  double scale() const { return scale_; }  ///< Unit of length h (m)
  /// Coefficients alpha_0 ... alpha_order of a cell, to be set before `apply`.
  Complex* source(int cell) { return &source_[static_cast<std::size_t>(cell) * (order_ + 1)]; }
  const Complex* local(int cell) const { return &local_[static_cast<std::size_t>(cell) * (order_ + 1)]; }
  void clear_sources();
  void apply();

 private:
  FftwPlan plan(int count, int direction);
  void cell_interaction(const LatticeSum& lattice, const Cells& cells, int di, int dj,
                        std::vector<Complex>& value) const;
  void make_kernel(const LatticeSum& lattice, const Cells& cells);
  void spread();
  void multiply_spectra();
  void collect();
  Complex twist(int i, int j) const { return multiply(twist_x_[i], twist_y_[j]); }
  std::size_t at(int i, int j) const { return static_cast<std::size_t>(j) * columns_ + i; }
  std::size_t grid() const { return static_cast<std::size_t>(columns_) * rows_; }
  Complex* plane(int k) { return reinterpret_cast<Complex*>(data_.get()) + k * grid(); }

  Mirrors mirrors_;
  int nx_, ny_, window_, order_, columns_, rows_;
  double width_, height_, scale_;
  std::vector<Complex> source_, local_;
  FftwNumbers data_;
  FftwPlan forward_, backward_;
  std::vector<double> kernel_re_, kernel_im_;  ///< Spectra of G_0 ... G_(2 order), grid() values each
  std::vector<Complex> twist_x_, twist_y_;     ///< Phase factors that make functions periodic whose sign alternates
                                               ///< between periods
};

}  // namespace lichtenberg::laplace::multipole
