#pragma once

#include "solvers/fftw.hpp"
#include "solvers/laplace/multipole/cells.hpp"
#include "solvers/laplace/multipole/lattice.hpp"

namespace lichtenberg::laplace::multipole {

/// Far field of the multipole method: interaction of all cells that are not near each other, with all mirror images. It
/// is a convolution over the grid, computed by FFT. The input are multipole expansions of the sources about the cells'
/// centres, the output local (Taylor) expansions about these centres.
/// With u = z - centre, the potential of a cell's sources is Re [alpha_0 ln u + sum_k (-1)^(k-1) alpha_k (k-1)!
/// (h/u)^k], and its local field Re sum_m beta_m (u/h)^m / m!. The translation (M2L) is beta_m = sum_k G_(m+k) alpha_k.
/// Here G_n = h^n d^n Lambda / dz^n at the displacement of the two cells, with the lattice sum Lambda. The kernel
/// depends on m + k only.
class FarField {
 public:
  /// Computes the Fourier coefficients of the kernel G_n for expansions of order `order`.
  FarField(const Mirrors& mirrors, const LatticeSum& lattice, const Cells& cells, int order);

  /// Returns true if a new object with these arguments would have the same kernel, so that this object can be used
  /// again.
  bool fits(const Mirrors& mirrors, const Cells& cells, int order) const;
  int order() const { return order_; }     ///< Order of the expansions
  double scale() const { return scale_; }  ///< Unit of length h (m)
  /// Returns the multipole coefficients alpha_0 ... alpha_order (V) of a cell, to be set before apply().
  Complex* source(int cell) { return &source_[static_cast<std::size_t>(cell) * (order_ + 1)]; }
  /// Returns the local coefficients beta_0 ... beta_order (V) of a cell, the result of apply().
  const Complex* local(int cell) const { return &local_[static_cast<std::size_t>(cell) * (order_ + 1)]; }
  /// Sets the multipole coefficients of all cells to 0.
  void clear_sources();
  /// Computes the local coefficients of all cells, the field of all far cells and images, from the multipole
  /// coefficients.
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
  /// Phase factors that make a function periodic whose sign alternates between periods.
  std::vector<Complex> twist_x_, twist_y_;
};

}  // namespace lichtenberg::laplace::multipole
