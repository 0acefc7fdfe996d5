#pragma once

#include <Eigen/Core>
#include <complex>
#include <memory>

#include "solvers/laplace/spheres/cells.hpp"
#include "solvers/laplace/spheres/lattice.hpp"

namespace lichtenberg::laplace::spheres {

/// What cells that are not near do to each other, images included: the multipoles of a cell's spheres are moved to its
/// centre, their field arrives as local coefficients about each cell's centre. From cell to cell that is a convolution
/// on the continued grid, a product of Fourier coefficients. A mirror makes each multipole even or odd, so that an axis
/// with mirrors needs cosines or sines of the cells inside only.
class CellConvolution {
 public:
  CellConvolution(const Mirrors& mirrors, const Cells& cells, double accuracy);
  /// Up to a degree, and no better than that: for a preconditioner.
  CellConvolution(const Mirrors& mirrors, const Cells& cells, int degree);

  int degree() const { return degree_; }
  double unit() const { return unit_; }  ///< length, in powers of which the coefficients are
  /// Both [harmonics(degree)][cell]. Multipoles are moments over unit^(l+1), local ones potentials times unit^l.
  void apply(const std::vector<double>& multipoles, std::vector<double>& local, parallel::Team& team) const;
  /// Whether it would be the same for other cells.
  bool fits(const Mirrors& mirrors, const Cells& cells, double accuracy) const;

 private:
  using Complex = std::complex<double>;
  template <class Scalar>
  using Matrix = Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  /// To and from the Fourier coefficients along one axis, of even and of odd functions where it has mirrors.
  struct Axis {
    std::vector<int> mode;  ///< wave numbers in units of 2 pi / period
    std::array<Matrix<double>, 2> to, from;
    Matrix<Complex> complex_to, complex_from;
  };
  CellConvolution(const Mirrors& mirrors, const Cells& cells, double accuracy, int degree);
  void make_axes();
  void make_kernel(const Mirrors& mirrors, double accuracy);
  Eigen::VectorXd octant_derivatives(double alpha, double cutoff, int x, int y, int z) const;
  void add_background(const std::vector<double>& multipoles, std::vector<double>& local) const;
  template <class Scalar>
  void convolve(const std::vector<double>& multipoles, std::vector<double>& local, parallel::Team& team) const;

  Cells cells_;
  double accuracy_, unit_;
  int degree_;
  bool bounded_, complex_ = false;
  std::vector<MirrorImage> images_;
  double volume_ = 0;
  std::array<Axis, 3> axis_;
  std::shared_ptr<const Coupling> coupling_;
  Matrix<double> kernel_;                ///< [harmonics][mode]: over (-i)^(number of odd axes)
  mutable std::vector<double> scratch_;  ///< that is large, and would be cleared for each product
};

/// The same between spheres, or from spheres to points.
class CellField {
 public:
  CellField(std::shared_ptr<const CellConvolution> convolution, const Cells& cells, const std::vector<Site>& targets,
            const std::vector<Site>& sources);
  void add(const double* multipoles, double* local, parallel::Team& team) const;

 private:
  struct Member {
    int site = 0, cell = 0, degree = 0;
    Vec3 way;  ///< from the cell's centre to the site's
  };
  struct Batch {
    int degree = 0;
    Ways ways;
    Lanes length{};
    std::array<Member, lanes> member;
    int count = 0;
  };
  std::vector<Batch> batches(const Cells& cells, const std::vector<Site>& sites) const;
  void gather(const double* multipoles, std::vector<double>& in_cells, parallel::Team& team) const;
  void spread(const std::vector<double>& in_cells, double* local, parallel::Team& team) const;

  std::shared_ptr<const CellConvolution> convolution_;
  std::vector<Site> targets_, sources_;
  std::vector<int> target_start_, source_start_;
  int cells_;
  std::vector<Batch> up_, down_;
  std::shared_ptr<const Translation> translation_;
  mutable std::vector<double> up_values_, down_values_;  ///< [harmonic][cell]
  mutable std::vector<Lanes> moved_;                     ///< [batch][harmonic]
};

}  // namespace lichtenberg::laplace::spheres
