#include "solvers/laplace/spheres/cell_convolution.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "solvers/laplace/spheres/cell_kernel.hpp"

namespace lichtenberg::laplace::spheres {
namespace {

/// Ratio at which terms decrease with l + t. Two charges at the rims of their cells have 2 reach / range, but most are
/// nearer to the centre. The root mean square distance for spheres that are spread evenly in square cells of one layer
/// is 0.59 of the reach, 1.2 for two of them. The rest is a margin.
double decay_ratio(const Cells& cells) { return 1.3 * cells.reach / cells.range; }

/// Bounds of the degree. Below 4 the savings are negligible compared to the near pairs. 1e-12 needs degree 33 if cells
/// are near up to three times their reach; 40 includes a margin. Memory grows with the degree squared, products with
/// its third to fourth power.
constexpr int least_degree = 4, most_degree = 40;

int degree_for(double accuracy, const Cells& cells) {
  const double degree = std::log(accuracy) / std::log(decay_ratio(cells));
  return std::clamp(static_cast<int>(std::ceil(degree)), least_degree, most_degree);
}

/// Accuracy from which single precision suffices: its rounding errors are at most 1 % of it.
constexpr double least_single = 1e-4;

/// Multiplies each row of a contiguous matrix: out = in factor', `in` [rows][.]. A flat box with one layer of cells has
/// two waves along z.
template <class Scalar>
void multiply_rows(const Scalar* in, Eigen::Index rows, const RowMatrix<Scalar>& factor, Scalar* out) {
  const Scalar* f = factor.data();
  if (factor.cols() == 1 && factor.rows() == 2) {
    for (Eigen::Index r = 0; r < rows; ++r) out[2 * r] = f[0] * in[r], out[2 * r + 1] = f[1] * in[r];
  } else if (factor.cols() == 2 && factor.rows() == 1) {
    for (Eigen::Index r = 0; r < rows; ++r) out[r] = f[0] * in[2 * r] + f[1] * in[2 * r + 1];
  } else {
    const RowMatrix<Scalar> transposed = factor.transpose();
    multiply_matrices(in, transposed.data(), rows, factor.cols(), factor.rows(), out);
  }
}

/// Transforms the second index of a contiguous array [x][y][z] with `nx` and `nz` values of x and z.
template <class Scalar>
RowMatrix<Scalar> along_middle_axis(const RowMatrix<Scalar>& factor, const Scalar* in, Eigen::Index nx,
                                    Eigen::Index nz) {
  RowMatrix<Scalar> out(nx, factor.rows() * nz);
  if (nz == 1) {
    const RowMatrix<Scalar> transposed = factor.transpose();
    multiply_matrices(in, transposed.data(), nx, factor.cols(), factor.rows(), out.data());
  } else {
    for (Eigen::Index x = 0; x < nx; ++x)
      multiply_matrices(factor.data(), in + x * factor.cols() * nz, factor.rows(), factor.cols(), nz,
                        out.row(x).data());
  }
  return out;
}

}  // namespace

CellConvolution::CellConvolution(const Mirrors& mirrors, const Cells& cells, double accuracy)
    : CellConvolution(mirrors, cells, accuracy, degree_for(accuracy, cells)) {}

CellConvolution::CellConvolution(const Mirrors& mirrors, const Cells& cells, int degree)
    : CellConvolution(mirrors, cells, std::pow(decay_ratio(cells), degree + 1), degree) {}

CellConvolution::CellConvolution(const Mirrors& mirrors, const Cells& cells, double accuracy, int degree)
    : cells_(cells),
      accuracy_(accuracy),
      unit_(cells.reach),
      degree_(degree),
      bounded_(mirrors.bounded),
      images_(mirrors.images),
      volume_(mirrors.bounded ? mirrors.volume() : 0),
      axis_(cell_axes(cells)) {
  RowMatrix<double> kernel = cell_kernel(mirrors, cells, axis_, degree, unit_, 0.1 * accuracy);  // See far_field
  if (accuracy >= least_single)
    kernel_ = kernel.cast<float>().eval();
  else
    kernel_ = std::move(kernel);
  for (int l = 0; l <= degree_; ++l)
    for (int m = -l; m <= l; ++m) odd_.push_back(odd_axes(l, m));
  const Coupling coupling(degree_);
  for (int l = 0; l <= degree_; ++l)
    for (int t = 0; l + t <= degree_; ++t)
      for (const Coupling::Term& term : coupling.terms(l, t)) products_.push_back(product(term));
  std::ranges::stable_sort(products_, {}, &Product::target);  // So that sums stay in the first-level cache
}

bool CellConvolution::fits(const Mirrors& mirrors, const Cells& cells, double accuracy) const {
  bool signs = mirrors.bounded == bounded_;
  for (int k = 0; k < 3; ++k)
    signs = signs && cells.mirrored[k] == cells_.mirrored[k] && cells.low_sign(k) == cells_.low_sign(k);
  return signs && cells.count == cells_.count && cells.edge == cells_.edge && cells.range == cells_.range &&
         cells.period == cells_.period && accuracy == accuracy_;
}

/// Returns true if the sum uses sines: a multipole is odd across a mirror if its harmonic is, or if the mirror inverts
/// its sign.
bool CellConvolution::is_sine(int axis, int odd) const {
  return (odd >> axis & 1) != (cells_.low_sign(axis) < 0 ? 1 : 0);
}

/// A product of two sines is minus a cosine; along axes without mirrors a sine is -i times an odd function.
CellConvolution::Product CellConvolution::product(const Coupling::Term& term) const {
  double factor = term.factor;
  int turns = 0;
  for (int k = 0; k < 3; ++k) {
    if (!(odd_[term.derivative] >> k & 1)) continue;
    if (!cells_.mirrored[k])
      ++turns;
    else if (is_sine(k, odd_[term.source]))
      factor = -factor;
  }
  return {term.target, term.source, term.derivative, turns & 2 ? -factor : factor, (turns & 1) != 0};
}

template <class Scalar>
RowMatrix<Scalar> CellConvolution::to_waves(int axis, int odd) const {
  if constexpr (Eigen::NumTraits<Scalar>::IsComplex)
    if (!cells_.mirrored[axis]) return axis_[axis].complex_to.template cast<Scalar>();
  return axis_[axis].to[is_sine(axis, odd)].template cast<Scalar>();
}

template <class Scalar>
RowMatrix<Scalar> CellConvolution::from_waves(int axis, int odd) const {
  if constexpr (Eigen::NumTraits<Scalar>::IsComplex)
    if (!cells_.mirrored[axis]) return axis_[axis].complex_from.template cast<Scalar>();
  return axis_[axis].from[is_sine(axis, odd)].template cast<Scalar>();
}

template <class Scalar>
void CellConvolution::transform(int harmonic, const double* in_cells, Scalar* in_waves) const {
  const auto [nx, ny, nz] = cells_.count;
  const int odd = odd_[harmonic];
  const RowMatrix<Scalar> in = Eigen::Map<const RowMatrix<double>>(in_cells, nx, ny * nz).template cast<Scalar>();
  RowMatrix<Scalar> x(modes(0), ny * nz);
  multiply_matrices(to_waves<Scalar>(0, odd).data(), in.data(), modes(0), nx, ny * nz, x.data());
  const RowMatrix<Scalar> y = along_middle_axis<Scalar>(to_waves<Scalar>(1, odd), x.data(), modes(0), nz);
  multiply_rows<Scalar>(y.data(), modes(0) * modes(1), to_waves<Scalar>(2, odd), in_waves);
}

template <class Scalar>
void CellConvolution::transform_back(int harmonic, const Scalar* in_waves, double* in_cells) const {
  const auto [nx, ny, nz] = cells_.count;
  const int odd = odd_[harmonic];
  RowMatrix<Scalar> z(modes(0) * modes(1), nz), x(nx, ny * nz);
  multiply_rows<Scalar>(in_waves, z.rows(), from_waves<Scalar>(2, odd), z.data());
  const RowMatrix<Scalar> y = along_middle_axis<Scalar>(from_waves<Scalar>(1, odd), z.data(), modes(0), nz);
  multiply_matrices(from_waves<Scalar>(0, odd).data(), y.data(), nx, modes(0), ny * nz, x.data());
  Eigen::Map<RowMatrix<double>>(in_cells, nx, ny * nz) = x.real().template cast<double>();
}

/// Multiplies `size` modes from `first` on.
template <class Scalar>
void CellConvolution::multiply(Eigen::Index first, Eigen::Index size, const Scalar* source, Scalar* field) const {
  using Real = typename Eigen::NumTraits<Scalar>::Real;
  const RowMatrix<Real>& kernels = std::get<RowMatrix<Real>>(kernel_);
  const Eigen::Index total = kernels.cols();
  int target = -1;
  for (const Product& product : products_) {
    if (product.target != target) std::fill_n(field + (target = product.target) * total + first, size, Scalar{});
    const auto factor = static_cast<Real>(product.factor);
    const Real* kernel = kernels.row(product.derivative).data() + first;
    const Scalar* in = source + product.source * total + first;
    Scalar* out = field + product.target * total + first;
    if constexpr (Eigen::NumTraits<Scalar>::IsComplex)
      if (product.turned) {
        for (Eigen::Index w = 0; w < size; ++w) out[w] += factor * kernel[w] * Scalar{in[w].imag(), -in[w].real()};
        continue;
      }
    for (Eigen::Index w = 0; w < size; ++w) out[w] += factor * kernel[w] * in[w];
  }
}

template <class Scalar>
void CellConvolution::convolve(const std::vector<double>& multipoles, std::vector<double>& local,
                               parallel::Team& team) const {
  // This many modes of all harmonics take some hundred kilobytes, which fit into a core's second-level cache.
  constexpr Eigen::Index block = 128;
  const int all = harmonics(degree_);
  const std::ptrdiff_t cells = cells_.cells();
  const Eigen::Index total = modes(0) * modes(1) * modes(2);
  scratch_.resize(2 * all * total * sizeof(Scalar) / sizeof(double));
  auto *source = reinterpret_cast<Scalar*>(scratch_.data()), *field = source + all * total;
  team.for_each(all, [&](int h) { transform(h, multipoles.data() + h * cells, source + h * total); });
  team.for_each(static_cast<int>((total + block - 1) / block),
                [&](int part) { multiply(part * block, std::min(block, total - part * block), source, field); });
  team.for_each(all, [&](int h) { transform_back(h, field + h * total, local.data() + h * cells); });
}

void CellConvolution::apply(const std::vector<double>& multipoles, std::vector<double>& local,
                            parallel::Team& team) const {
  const bool complex = has_complex_waves(cells_), single = std::holds_alternative<RowMatrix<float>>(kernel_);
  if (single)
    complex ? convolve<std::complex<float>>(multipoles, local, team) : convolve<float>(multipoles, local, team);
  else
    complex ? convolve<std::complex<double>>(multipoles, local, team) : convolve<double>(multipoles, local, team);
  if (bounded_) add_background(multipoles, local);
}

/// Adds the background's field, like that of FarField, for the dipoles of cells.
void CellConvolution::add_background(const std::vector<double>& multipoles, std::vector<double>& local) const {
  const int n = cells_.cells();
  const std::array<int, 3> row{at(1, 1), at(1, -1), at(1, 0)};
  Vec3 dipole, sum;
  for (int k = 0; k < 3; ++k)
    for (int c = 0; c < n; ++c) dipole[k] += multipoles[static_cast<std::ptrdiff_t>(row[k]) * n + c];
  for (const MirrorImage& image : images_) sum += mirrored(dipole, image.mask) * image.sign;
  sum *= -4 * std::numbers::pi / (3 * volume_) * unit_ * unit_ * unit_;
  for (int k = 0; k < 3; ++k)
    for (int c = 0; c < n; ++c) local[static_cast<std::ptrdiff_t>(row[k]) * n + c] += sum[k];
}

}  // namespace lichtenberg::laplace::spheres
