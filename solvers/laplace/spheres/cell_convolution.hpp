#pragma once

#include <variant>

#include "solvers/laplace/spheres/cell_axes.hpp"
#include "solvers/laplace/spheres/images.hpp"
#include "solvers/laplace/spheres/lattice.hpp"
#include "solvers/parallel/team.hpp"

namespace lichtenberg::laplace::spheres {

/// Far field between cells, including images: computes local coefficients about the cells' centres from multipoles
/// about the cells' centres. On the grid continued by images this is a convolution, hence a product of Fourier
/// coefficients. A mirror makes each multipole even or odd, so an axis with mirrors needs only cosine or sine
/// transforms of the cells inside.
class CellConvolution {
 public:
  /// Chooses the degree of the expansions (4 to 40) for a relative error `accuracy`, and computes the kernel.
  CellConvolution(const Mirrors& mirrors, const Cells& cells, double accuracy);
  /// Makes a convolution of a given degree and of matching accuracy, for a preconditioner.
  CellConvolution(const Mirrors& mirrors, const Cells& cells, int degree);

  int degree() const { return degree_; }  ///< Degree of the cells' expansions
  double unit() const { return unit_; }   ///< Unit of length of the coefficients (m)
  /// Computes local coefficients from multipoles, both [harmonics(degree)][cell]. Multipoles are moments of the charges
  /// divided by unit^(l+1); local coefficients are those of the potential times unit^l.
  void apply(const std::vector<double>& multipoles, std::vector<double>& local, parallel::Team& team) const;
  /// Returns true if a new convolution with these arguments would be equal, so that this one can be used again.
  bool fits(const Mirrors& mirrors, const Cells& cells, double accuracy) const;

 private:
  /// Product of coefficients, for all modes: local[target] += factor kernel[derivative] multipoles[source], times -i if
  /// `turned`.
  struct Product {
    int target = 0, source = 0, derivative = 0;
    double factor = 0;
    bool turned = false;
  };
  CellConvolution(const Mirrors& mirrors, const Cells& cells, double accuracy, int degree);
  bool is_sine(int axis, int odd) const;
  Product product(const Coupling::Term& term) const;
  Eigen::Index modes(int axis) const { return static_cast<Eigen::Index>(axis_[axis].mode.size()); }
  template <class Scalar>
  RowMatrix<Scalar> to_waves(int axis, int odd) const;
  template <class Scalar>
  RowMatrix<Scalar> from_waves(int axis, int odd) const;
  template <class Scalar>
  void convolve(const std::vector<double>& multipoles, std::vector<double>& local, parallel::Team& team) const;
  template <class Scalar>
  void transform(int harmonic, const double* in_cells, Scalar* in_waves) const;
  template <class Scalar>
  void transform_back(int harmonic, const Scalar* in_waves, double* in_cells) const;
  template <class Scalar>
  void multiply(Eigen::Index first, Eigen::Index size, const Scalar* source, Scalar* field) const;
  void add_background(const std::vector<double>& multipoles, std::vector<double>& local) const;

  Cells cells_;
  double accuracy_, unit_;
  int degree_;
  bool bounded_;
  std::vector<MirrorImage> images_;
  double volume_ = 0;
  std::array<CellAxis, 3> axis_;
  std::vector<int> odd_;  ///< odd_axes of each harmonic
  std::vector<Product> products_;
  /// Kernel in the layout of cell_kernel, in single precision if this suffices for the accuracy
  std::variant<RowMatrix<double>, RowMatrix<float>> kernel_;
  mutable std::vector<double> scratch_;  ///< Kept between products, because its initialization takes time
};

}  // namespace lichtenberg::laplace::spheres
