#include "solvers/laplace/multipole/near_field.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <utility>

namespace lichtenberg::laplace::multipole {

namespace {

constexpr int lane = 8;  // Disk orders are processed in multiples of it
using Lane = Eigen::Array<double, lane, 1>;

/// Returns the number of significant terms of a geometric series with ratio q.
int terms(double q, double accuracy, int most) {
  if (q <= 0) return 0;
  if (q >= 1) return most;
  return std::min(most, static_cast<int>(std::ceil(std::log(accuracy) / std::log(q))));
}

}  // namespace

NearField::NearField(const Arrangement& arrangement, double accuracy) {
  std::vector<std::pair<Complex, Image>> seen;  // Displacement and image of each pair
  std::size_t powers = 0;
  for (int i = 0; i < arrangement.disks; ++i) {
    const Source& disk = arrangement.sources[i];
    arrangement.cells.for_each_near(disk.centre, [&](int j, const Image& image, Complex shift) {
      const Source& source = arrangement.sources[j];
      const Complex d = disk.centre - image.centre(source.centre) - shift;
      const double distance = std::abs(d);
      NearSource pair{i, j, 0, 0, image.conjugates(), image.sign, 0, powers};
      pair.minus_log = -image.sign * std::log(std::max(distance, disk.radius));
      const auto is_here = [&](Complex centre) {
        return std::abs(image.centre(centre) + shift - disk.centre) < 1e-9 * disk.radius;
      };
      if (!is_here(source.constant_on[0]) && !is_here(source.constant_on[1])) {
        // Convergence ratios at the nearest point of the other circle. The singularities of a source lie within `decay`
        // of its radius.
        const double reach = arrangement.decay[j] * source.radius;
        pair.source_order = terms(reach / (distance - disk.radius), accuracy, source.order);
        pair.disk_order = terms(disk.radius / (distance - reach), accuracy, disk.order);
      }
      powers += pair.source_order + pair.disk_order;
      largest_order_ = std::max({largest_order_, pair.source_order, pair.disk_order});
      pairs_.push_back(pair);
      seen.emplace_back(d, image);
    });
  }
  power_.resize(powers);
  for (std::size_t p = 0; p < pairs_.size(); ++p)
    fill_powers(arrangement.sources, seen[p].second, seen[p].first, pairs_[p]);
  make_binomials();
}

void NearField::fill_powers(const std::vector<Source>& sources, const Image& image, Complex d, const NearSource& pair) {
  const Complex u = 2 * sources[pair.source].radius / d, v = -2 * sources[pair.disk].radius / d;
  Complex* at = power_.data() + pair.power;
  Complex power = 1;
  for (int k = 1; k <= pair.source_order; ++k) {
    power = multiply(power, u);
    // The image's sign is the same for each term up to (-1)^k: coefficient() of a real number.
    *at++ = image.coefficient(k, 1).real() * power;
  }
  power = 1;
  for (int m = 1; m <= pair.disk_order; ++m) *at++ = power = multiply(power, v);
}

void NearField::make_binomials() {
  stride_ = (largest_order_ / lane + 1) * lane;
  binomial_.assign(static_cast<std::size_t>(largest_order_ + 1) * stride_, 0);
  double half_power = 1;
  for (int m = 1; m < stride_; ++m) binomial_[m] = (half_power *= 0.5) / m;
  half_power = 1;
  for (int k = 1; k <= largest_order_; ++k) {
    double* row = &binomial_[static_cast<std::size_t>(k) * stride_];
    row[0] = half_power *= 0.5;
    for (int m = 1; m < stride_; ++m) row[m] = row[m - 1] * (0.5 * (k + m - 1)) / m;
  }
}

void NearField::add(const Layout& layout, const Complex* coefficients, Complex* local) const {
  for (const NearSource& pair : pairs_)
    add_pair(pair, coefficients + layout.start[pair.source], local + layout.start[pair.disk]);
}

void NearField::add_pair(const NearSource& pair, const Complex* coefficients, Complex* local) const {
  const Complex* source_power = power_.data() + pair.power;
  const Complex* disk_power = source_power + pair.source_order;
  std::array<double, largest_order + 1> re, im;  // (2 R_c/d)^k a_k
  re[0] = pair.charge_factor * coefficients[0].real();
  im[0] = 0;
  const double turn = pair.conjugates ? -1 : 1;
  for (int k = 1; k <= pair.source_order; ++k) {
    const Complex a{coefficients[k].real(), turn * coefficients[k].imag()};
    const Complex x = multiply(source_power[k - 1], a);
    re[k] = x.real();
    im[k] = x.imag();
  }
  local[0] += pair.minus_log * coefficients[0].real();
  for (int block = 0; block <= pair.disk_order; block += lane) {
    Lane sum_re = Lane::Zero(), sum_im = Lane::Zero();
    const double* binomial = &binomial_[block];
    for (int k = 0; k <= pair.source_order; ++k, binomial += stride_) {
      const Eigen::Map<const Lane> row(binomial);
      sum_re += re[k] * row;
      sum_im += im[k] * row;
    }
    const int end = std::min(lane - 1, pair.disk_order - block);
    if (block == 0) local[0] += sum_re[0];
    for (int m = block == 0 ? 1 : 0; m <= end; ++m)
      local[block + m] += multiply(disk_power[block + m - 1], {sum_re[m], sum_im[m]});
  }
}

}  // namespace lichtenberg::laplace::multipole
