#include "solvers/laplace/spheres/cell_field.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace lichtenberg::laplace::spheres {
namespace {

/// Bit k: C_lm is odd along axis k.
int odd_axes(int l, int m) {
  return (mirror_sign(l, m, 1) < 0 ? 1 : 0) + (mirror_sign(l, m, 2) < 0 ? 2 : 0) + (mirror_sign(l, m, 4) < 0 ? 4 : 0);
}

double trigonometric(bool odd, double phase) { return odd ? std::sin(phase) : std::cos(phase); }

/// Terms fall off like (2 reach / distance)^(l + t), and most charges are not at the rim of their cells.
double fall_off(const Cells& cells) { return 1.3 * cells.reach / cells.range; }

}  // namespace

CellConvolution::CellConvolution(const Mirrors& mirrors, const Cells& cells, double accuracy)
    : CellConvolution(mirrors, cells, accuracy,
                      std::clamp(static_cast<int>(std::ceil(std::log(accuracy) / std::log(fall_off(cells)))), 4, 40)) {}

CellConvolution::CellConvolution(const Mirrors& mirrors, const Cells& cells, int degree)
    : CellConvolution(mirrors, cells, std::pow(fall_off(cells), degree + 1), degree) {}

CellConvolution::CellConvolution(const Mirrors& mirrors, const Cells& cells, double accuracy, int degree)
    : cells_(cells),
      accuracy_(accuracy),
      unit_(cells.reach),
      degree_(degree),
      bounded_(mirrors.bounded),
      images_(mirrors.images),
      volume_(mirrors.bounded ? mirrors.volume() : 0) {
  coupling_ = std::make_shared<const Coupling>(degree_);
  make_axes();
  make_kernel(mirrors, accuracy);
}

bool CellConvolution::fits(const Mirrors& mirrors, const Cells& cells, double accuracy) const {
  bool signs = mirrors.bounded == bounded_;
  for (int k = 0; k < 3; ++k)
    signs = signs && cells.mirrored[k] == cells_.mirrored[k] && cells.low_sign(k) == cells_.low_sign(k);
  return signs && cells.count == cells_.count && cells.edge == cells_.edge && cells.range == cells_.range &&
         cells.period == cells_.period && accuracy == accuracy_;
}

void CellConvolution::make_axes() {
  int last_complex = -1;
  for (int k = 0; k < 3; ++k)
    if (!cells_.mirrored[k]) last_complex = k;
  complex_ = last_complex >= 0;
  for (int k = 0; k < 3; ++k) {
    Axis& axis = axis_[k];
    const int n = cells_.count[k], period = cells_.period[k];
    const double turn = 2 * std::numbers::pi / period;
    const bool alternates = period == 4 * n;
    const int copies = period / n;
    // Waves that go the other way are the complex conjugates: of all axes together, so half of one axis will do.
    const int most = cells_.mirrored[k] ? (alternates ? 2 * n - 1 : n) : k == last_complex ? period / 2 : period - 1;
    for (int mode = alternates && cells_.mirrored[k] ? 1 : 0; mode <= most;
         mode += alternates && cells_.mirrored[k] ? 2 : 1)
      axis.mode.push_back(mode);
    const auto modes = static_cast<Eigen::Index>(axis.mode.size());
    for (int odd = 0; odd < 2; ++odd) {
      axis.to[odd].resize(modes, n);
      axis.from[odd].resize(n, modes);
    }
    axis.complex_to.resize(modes, n);
    axis.complex_from.resize(n, modes);
    for (Eigen::Index w = 0; w < modes; ++w)
      for (int i = 0; i < n; ++i) {
        const double phase = turn * axis.mode[w] * (i + 0.5);
        const bool single = axis.mode[w] == 0 || 2 * axis.mode[w] == period;
        for (int odd = 0; odd < 2; ++odd) {
          axis.to[odd](w, i) = trigonometric(odd, phase);
          axis.from[odd](i, w) = trigonometric(odd, phase) * (single ? 1 : 2) * copies / period;
        }
        const double weight = (k == last_complex && !single ? 2.0 : 1.0) / period;
        axis.complex_to(w, i) = std::polar(1.0, -phase);
        axis.complex_from(i, w) = std::polar(weight, phase);
      }
  }
}

/// Of all copies of a charge that lie this many cells away, up to whole periods.
Eigen::VectorXd CellConvolution::octant_derivatives(double alpha, double cutoff, int x, int y, int z) const {
  std::vector<double> term(harmonics(degree_));
  Eigen::VectorXd value = Eigen::VectorXd::Zero(harmonics(degree_));
  if (!bounded_) {
    const bool beyond = 2 * x == cells_.period[0] || 2 * y == cells_.period[1] || 2 * z == cells_.period[2];
    if (!beyond && !cells_.is_near(x, y, z)) irregular_harmonics(cells_.way(x, y, z), degree_, value.data());
    return value;
  }
  const std::array<int, 3> at{x, y, z};
  std::array<int, 3> low, high;
  for (int k = 0; k < 3; ++k) {
    low[k] = static_cast<int>(std::ceil((-cutoff / cells_.edge[k] - at[k]) / cells_.period[k]));
    high[k] = static_cast<int>(std::floor((cutoff / cells_.edge[k] - at[k]) / cells_.period[k]));
  }
  for (int a = low[0]; a <= high[0]; ++a)
    for (int b = low[1]; b <= high[1]; ++b)
      for (int c = low[2]; c <= high[2]; ++c) {
        const int i = x + a * cells_.period[0], j = y + b * cells_.period[1], k = z + c * cells_.period[2];
        const Vec3 way = cells_.way(i, j, k);
        if (norm(way) < cutoff)
          add_screened(way, alpha, cells_.is_near(i, j, k), 1, degree_, term.data(), value.data());
      }
  return value;
}

void CellConvolution::make_kernel(const Mirrors& mirrors, double accuracy) {
  const std::array<int, 3> period = cells_.period;
  const std::array<int, 3> half{period[0] / 2, period[1] / 2, period[2] / 2};
  const double decay = std::sqrt(-std::log(0.1 * accuracy)) + 0.5;
  const double alpha = decay / cells_.range, cutoff = 1.3 * cells_.range;
  const int all = harmonics(degree_);
  const auto index = [&](int x, int y, int z) {
    return (static_cast<Eigen::Index>(x) * (half[1] + 1) + y) * (half[2] + 1) + z;
  };

  // Sums over the grid with cosines and sines, axis by axis, for wave numbers up to half a period.
  Matrix<double> octant(all, index(half[0], half[1], half[2]) + 1);
  for (int x = 0; x <= half[0]; ++x)
    for (int y = 0; y <= half[1]; ++y)
      for (int z = 0; z <= half[2]; ++z) octant.col(index(x, y, z)) = octant_derivatives(alpha, cutoff, x, y, z);
  std::array<std::array<Matrix<double>, 2>, 3> sum;
  for (int k = 0; k < 3; ++k)
    for (int odd = 0; odd < 2; ++odd) {
      sum[k][odd].resize(half[k] + 1, half[k] + 1);
      for (int w = 0; w <= half[k]; ++w)
        for (int i = 0; i <= half[k]; ++i)
          sum[k][odd](w, i) =
              (i == 0 || 2 * i == period[k] ? 1 : 2) * trigonometric(odd, 2 * std::numbers::pi * w * i / period[k]);
    }
  for (int l = 0; l <= degree_; ++l)
    for (int m = -l; m <= l; ++m) {
      const int odd = odd_axes(l, m);
      double* row = octant.row(at(l, m)).data();
      Eigen::Map<Matrix<double>> z(row, (half[0] + 1) * (half[1] + 1), half[2] + 1);
      z = (z * sum[2][odd >> 2 & 1].transpose()).eval();
      for (int x = 0; x <= half[0]; ++x) {
        Eigen::Map<Matrix<double>> y(row + index(x, 0, 0), half[1] + 1, half[2] + 1);
        y = (sum[1][odd >> 1 & 1] * y).eval();
      }
      Eigen::Map<Matrix<double>> x(row, half[0] + 1, (half[1] + 1) * (half[2] + 1));
      x = (sum[0][odd & 1] * x).eval();
    }

  // The waves: those that look alike on the grid are one.
  if (bounded_) {
    const double most = 2 * alpha * (decay + 1), grid = double(period[0]) * period[1] * period[2];
    std::array<double, 3> unit;
    std::array<int, 3> high;
    for (int k = 0; k < 3; ++k) {
      unit[k] = 2 * std::numbers::pi / mirrors.period[k];
      high[k] = static_cast<int>(most / unit[k]);
    }
    std::vector<double> value(all);
    for (int x = -high[0]; x <= high[0]; ++x)
      for (int y = -high[1]; y <= high[1]; ++y)
        for (int z = -high[2]; z <= high[2]; ++z) {
          const Vec3 wave{x * unit[0], y * unit[1], z * unit[2]};
          const double k2 = norm2(wave);
          if (k2 == 0 || k2 > most * most) continue;
          const auto folded = [&](int axis, int w) { return ((w % period[axis]) + period[axis]) % period[axis]; };
          const int a = folded(0, x), b = folded(1, y), c = folded(2, z);
          if (a > half[0] || b > half[1] || c > half[2]) continue;
          regular_harmonics(wave, degree_, value.data());
          double factor = grid * 4 * std::numbers::pi / mirrors.volume() / k2 * std::exp(-k2 / (4 * alpha * alpha));
          for (int l = 0; l <= degree_; ++l) {
            if (l > 0) factor /= 2 * l - 1;
            for (int m = -l; m <= l; ++m) {
              const int odd = odd_axes(l, m), odds = (odd & 1) + (odd >> 1 & 1) + (odd >> 2 & 1);
              octant(at(l, m), index(a, b, c)) += ((l - odds) / 2 & 1 ? -1 : 1) * factor * value[at(l, m)];
            }
          }
        }
    octant(0, 0) -= grid * std::numbers::pi / (alpha * alpha * mirrors.volume());
  }

  // Spread over the modes, in powers of the unit.
  std::array<Eigen::Index, 3> modes;
  for (int k = 0; k < 3; ++k) modes[k] = static_cast<Eigen::Index>(axis_[k].mode.size());
  kernel_.resize(all, modes[0] * modes[1] * modes[2]);
  double power = unit_;
  for (int l = 0; l <= degree_; ++l, power *= unit_)
    for (int m = -l; m <= l; ++m) {
      const int odd = odd_axes(l, m);
      Eigen::Index w = 0;
      for (const int x : axis_[0].mode)
        for (const int y : axis_[1].mode)
          for (const int z : axis_[2].mode) {
            const std::array<int, 3> mode{x, y, z};
            std::array<int, 3> folded;
            double sign = 1;
            for (int k = 0; k < 3; ++k) {
              folded[k] = mode[k] <= half[k] ? mode[k] : period[k] - mode[k];
              if (mode[k] > half[k] && (odd >> k & 1)) sign = -sign;
            }
            kernel_(at(l, m), w++) = power * sign * octant(at(l, m), index(folded[0], folded[1], folded[2]));
          }
    }
}

template <class Scalar>
void CellConvolution::convolve(const std::vector<double>& multipoles, std::vector<double>& local,
                               parallel::Team& team) const {
  constexpr bool is_complex = std::is_same_v<Scalar, Complex>;
  const int all = harmonics(degree_), n = cells_.cells();
  const std::array<int, 3> count = cells_.count;
  std::array<Eigen::Index, 3> modes;
  for (int k = 0; k < 3; ++k) modes[k] = static_cast<Eigen::Index>(axis_[k].mode.size());
  const Eigen::Index total = modes[0] * modes[1] * modes[2];
  // A multipole is odd across a mirror if its harmonic is, or if the mirror turns its sign.
  const auto symmetry = [&](int k, int odd) -> int {
    return (odd >> k & 1) != (cells_.low_sign(k) < 0 ? 1 : 0) ? 1 : 0;
  };
  const auto to = [&](int k, int odd) -> Matrix<Scalar> {
    if constexpr (is_complex) {
      if (!cells_.mirrored[k]) return axis_[k].complex_to;
    }
    return axis_[k].to[symmetry(k, odd)].template cast<Scalar>();
  };
  const auto from = [&](int k, int odd) -> Matrix<Scalar> {
    if constexpr (is_complex) {
      if (!cells_.mirrored[k]) return axis_[k].complex_from;
    }
    return axis_[k].from[symmetry(k, odd)].template cast<Scalar>();
  };

  scratch_.resize(2 * all * total * sizeof(Scalar) / sizeof(double));
  auto *source = reinterpret_cast<Scalar*>(scratch_.data()), *field = source + all * total;
  std::vector<int> odd(all);
  for (int l = 0; l <= degree_; ++l)
    for (int m = -l; m <= l; ++m) odd[at(l, m)] = odd_axes(l, m);
  team.for_each(all, [&](int h) {
    const Eigen::Map<const Matrix<double>> in(multipoles.data() + static_cast<std::ptrdiff_t>(h) * n,
                                              count[0] * count[1], count[2]);
    const Matrix<Scalar> z = in.template cast<Scalar>() * to(2, odd[h]).transpose();
    Matrix<Scalar> y(count[0], modes[1] * modes[2]);
    const Matrix<Scalar> along_y = to(1, odd[h]);
    for (int x = 0; x < count[0]; ++x)
      Eigen::Map<Matrix<Scalar>>(y.row(x).data(), modes[1], modes[2]) = along_y * z.middleRows(x * count[1], count[1]);
    Eigen::Map<Matrix<Scalar>>(source + h * total, modes[0], modes[1] * modes[2]) = to(0, odd[h]) * y;
  });

  constexpr Eigen::Index block = 128;
  team.for_each(static_cast<int>((total + block - 1) / block), [&](int part) {
    const Eigen::Index first = part * block, size = std::min(block, total - first);
    for (int h = 0; h < all; ++h) std::fill_n(field + h * total + first, size, Scalar{});
    for (int l = 0; l <= degree_; ++l)
      for (int t = 0; l + t <= degree_; ++t)
        for (const Coupling::Term& term : coupling_->terms(l, t)) {
          // A sine times a sine is minus a cosine; along axes without mirrors a sine is -i times an odd function.
          double factor = term.factor;
          int turns = 0;
          for (int k = 0; k < 3; ++k) {
            if (!(odd[term.derivative] >> k & 1)) continue;
            if (!cells_.mirrored[k])
              ++turns;
            else if (symmetry(k, odd[term.source]))
              factor = -factor;
          }
          if (turns & 2) factor = -factor;
          const double* kernel = kernel_.row(term.derivative).data() + first;
          const Scalar* in = source + term.source * total + first;
          Scalar* out = field + term.target * total + first;
          if constexpr (is_complex) {
            if (turns & 1)
              for (Eigen::Index w = 0; w < size; ++w)
                out[w] += factor * kernel[w] * Complex{in[w].imag(), -in[w].real()};
            else
              for (Eigen::Index w = 0; w < size; ++w) out[w] += factor * kernel[w] * in[w];
          } else {
            for (Eigen::Index w = 0; w < size; ++w) out[w] += factor * kernel[w] * in[w];
          }
        }
  });

  team.for_each(all, [&](int h) {
    const Eigen::Map<const Matrix<Scalar>> in(field + h * total, modes[0], modes[1] * modes[2]);
    const Matrix<Scalar> y = from(0, odd[h]) * in;
    Matrix<Scalar> z(count[0] * count[1], modes[2]);
    const Matrix<Scalar> along_y = from(1, odd[h]);
    for (int x = 0; x < count[0]; ++x)
      z.middleRows(x * count[1], count[1]) =
          along_y * Eigen::Map<const Matrix<Scalar>>(y.row(x).data(), modes[1], modes[2]);
    Eigen::Map<Matrix<double>>(local.data() + static_cast<std::ptrdiff_t>(h) * n, count[0] * count[1], count[2]) =
        (z * from(2, odd[h]).transpose()).real();
  });
}

void CellConvolution::apply(const std::vector<double>& multipoles, std::vector<double>& local,
                            parallel::Team& team) const {
  if (complex_)
    convolve<Complex>(multipoles, local, team);
  else
    convolve<double>(multipoles, local, team);
  if (bounded_) add_background(multipoles, local);
}

/// As FarField's, against the dipoles of cells.
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

CellField::CellField(std::shared_ptr<const CellConvolution> convolution, const Cells& cells,
                     const std::vector<Site>& targets, const std::vector<Site>& sources)
    : convolution_(std::move(convolution)),
      targets_(targets),
      sources_(sources),
      target_start_(starts(targets)),
      source_start_(starts(sources)),
      cells_(cells.cells()) {
  up_ = batches(cells, sources);
  down_ = batches(cells, targets);
  translation_ = translation_up_to(convolution_->degree());
}

std::vector<CellField::Batch> CellField::batches(const Cells& cells, const std::vector<Site>& sites) const {
  std::vector<Member> members;
  for (std::size_t i = 0; i < sites.size(); ++i) {
    const auto at = cells.place(sites[i].centre);
    members.push_back({static_cast<int>(i), cells.number(at), std::min(sites[i].degree, convolution_->degree()),
                       sites[i].centre - cells.centre(at)});
  }
  std::stable_sort(members.begin(), members.end(),
                   [](const Member& a, const Member& b) { return a.degree < b.degree; });
  std::vector<Batch> result;
  for (const Member& member : members) {
    if (result.empty() || result.back().count == lanes || result.back().degree != member.degree) {
      result.push_back({member.degree});
      for (int k = 0; k < lanes; ++k) result.back().ways.set(k, {0, 0, 1});
    }
    Batch& batch = result.back();
    const double length = norm(member.way);
    if (length > 0) batch.ways.set(batch.count, member.way);
    batch.length[batch.count] = length / convolution_->unit();
    batch.member[batch.count++] = member;
  }
  return result;
}

void CellField::gather(const double* multipoles, std::vector<double>& in_cells, parallel::Team& team) const {
  const int degree = convolution_->degree(), all = harmonics(degree);
  moved_.resize(up_.size() * all);
  team.for_each(static_cast<int>(up_.size()), [&](int b) {
    const Batch& batch = up_[b];
    std::vector<Lanes> scratch(all);
    Lanes* value = moved_.data() + static_cast<std::ptrdiff_t>(b) * all;
    std::fill_n(value, all, Lanes{});
    for (int k = 0; k < batch.count; ++k) {
      const Member& member = batch.member[k];
      const double ratio = sources_[member.site].radius / convolution_->unit();
      double power = ratio;
      for (int l = 0; l <= batch.degree; ++l, power *= ratio)
        for (int m = -l; m <= l; ++m) value[at(l, m)][k] = power * multipoles[source_start_[member.site] + at(l, m)];
    }
    translation_->shift(batch.ways, batch.length, true, batch.degree, degree, value, scratch.data());
  });
  for (std::size_t b = 0; b < up_.size(); ++b)
    for (int k = 0; k < up_[b].count; ++k)
      for (int h = 0; h < all; ++h)
        in_cells[static_cast<std::ptrdiff_t>(h) * cells_ + up_[b].member[k].cell] += moved_[b * all + h][k];
}

void CellField::spread(const std::vector<double>& in_cells, double* local, parallel::Team& team) const {
  const int degree = convolution_->degree(), all = harmonics(degree);
  team.for_each(static_cast<int>(down_.size()), [&](int b) {
    const Batch& batch = down_[b];
    std::vector<Lanes> value(all), scratch(all);
    for (int k = 0; k < batch.count; ++k)
      for (int h = 0; h < all; ++h)
        value[h][k] = in_cells[static_cast<std::ptrdiff_t>(h) * cells_ + batch.member[k].cell];
    translation_->shift(batch.ways, batch.length, false, degree, batch.degree, value.data(), scratch.data());
    for (int k = 0; k < batch.count; ++k) {
      const Member& member = batch.member[k];
      const double ratio = targets_[member.site].radius / convolution_->unit();
      double power = 1;
      for (int l = 0; l <= batch.degree; ++l, power *= ratio)
        for (int m = -l; m <= l; ++m) local[target_start_[member.site] + at(l, m)] += power * value[at(l, m)][k];
    }
  });
}

void CellField::add(const double* multipoles, double* local, parallel::Team& team) const {
  up_values_.assign(static_cast<std::size_t>(harmonics(convolution_->degree())) * cells_, 0.0);
  down_values_.resize(up_values_.size());
  gather(multipoles, up_values_, team);
  convolution_->apply(up_values_, down_values_, team);
  spread(down_values_, local, team);
}

}  // namespace lichtenberg::laplace::spheres
