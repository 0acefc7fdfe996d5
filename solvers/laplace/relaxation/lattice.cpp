#include "solvers/laplace/relaxation/lattice.hpp"

#include <algorithm>
#include <cmath>

#include "solvers/laplace/problem.hpp"
#include "solvers/stop.hpp"

namespace lichtenberg::laplace {

void Lattice::reset(int cells_x, int cells_y, double spacing, const std::array<bool, 4>& insulating,
                    const std::vector<int>& fixed) {
  h_ = spacing;
  insulating_ = insulating;
  if (cells_x + 1 != nx_ || cells_y + 1 != ny_) {
    nx_ = cells_x + 1;
    ny_ = cells_y + 1;
    stride_ = (nx_ + 2) / 2 + 1;
    colour_size_ = (ny_ + 2) * stride_;
    value_.assign(2 * colour_size_, 0.0);
  }
  find_runs(fixed);
}

void Lattice::find_runs(const std::vector<int>& fixed) {
  runs_.clear();
  fluid_sites_ = 0;
  for (int colour = 0; colour < 2; ++colour) {
    first_run_[colour].assign(ny_ + 1, 0);
    for (int j = 0; j < ny_; ++j) {
      first_run_[colour][j] = runs_.size();
      bool in_run = false;
      for (int i = (colour + j) & 1; i < nx_; i += 2) {
        const bool relaxed = fixed[j * nx_ + i] == fluid;
        if (relaxed && !in_run) runs_.push_back({slot(i, j), slot(i - 1, j), 0});
        if (relaxed) {
          ++runs_.back().count;
          ++fluid_sites_;
        }
        in_run = relaxed;
      }
    }
    first_run_[colour][ny_] = runs_.size();
  }
}

void Lattice::relax_row(int colour, int j, double omega) {
  // The rows above and below have the other colour, at the same offset in their row.
  const std::ptrdiff_t vertical = (colour == 0 ? 1 : -1) * colour_size_;
  const double w = omega / 4;
  for (std::size_t r = first_run_[colour][j]; r < first_run_[colour][j + 1]; ++r) {
    const Run& run = runs_[r];
    double* __restrict own = value_.data() + run.own;
    const double* side = value_.data() + run.left;
    const double* below = value_.data() + run.own + vertical - stride_;
    const double* above = value_.data() + run.own + vertical + stride_;
    for (std::ptrdiff_t k = 0; k < run.count; ++k)
      own[k] += w * (side[k] + side[k + 1] + below[k] + above[k] - 4 * own[k]);
  }
  mirror_row(colour, j);
}

void Lattice::mirror_row(int colour, int j) {
  // D 6.4 copies the outermost site itself, which puts the wall half a spacing outside the box. Mirroring about the
  // outermost site puts it on the side, where the electrodes' sites are.
  if (insulating_[left] && ((1 + j) & 1) == colour) at(-1, j) = at(1, j);
  if (insulating_[right] && ((nx_ + j) & 1) == colour) at(nx_, j) = at(nx_ - 2, j);
  const bool mirrors_down = insulating_[bottom] && j == 1;
  const bool mirrors_up = insulating_[top] && j == ny_ - 2;
  for (int i = (colour + j) & 1; i < nx_ && (mirrors_down || mirrors_up); i += 2) {
    if (mirrors_down) at(i, -1) = at(i, 1);
    if (mirrors_up) at(i, ny_) = at(i, ny_ - 2);
  }
}

void Lattice::mirror_all() {
  for (int colour = 0; colour < 2; ++colour)
    for (int j = 0; j < ny_; ++j) mirror_row(colour, j);
}

void Lattice::relax(int sweeps, double omega) {
  mirror_all();
  for (int sweep = 0; sweep < sweeps; ++sweep) {
    stop_if_requested();
    // The black row below follows as soon as the red rows around it are updated: one pass over memory for both colours.
    for (int j = 0; j <= ny_; ++j) {
      if (j < ny_) relax_row(0, j, omega);
      if (j > 0) relax_row(1, j - 1, omega);
    }
  }
}

double Lattice::leftover() const {
  double sum = 0;
  for (int colour = 0; colour < 2; ++colour) {
    const std::ptrdiff_t vertical = (colour == 0 ? 1 : -1) * colour_size_;
    for (std::size_t r = first_run_[colour].front(); r < first_run_[colour].back(); ++r) {
      const Run& run = runs_[r];
      const double* own = value_.data() + run.own;
      const double* side = value_.data() + run.left;
      const double* below = own + vertical - stride_;
      const double* above = own + vertical + stride_;
      for (std::ptrdiff_t k = 0; k < run.count; ++k)
        sum += std::abs(side[k] + side[k + 1] + below[k] + above[k] - 4 * own[k]);
    }
  }
  return sum;
}

Vec2 Lattice::gradient(Vec2 p) const {
  const double x = p.x / h_, y = p.y / h_;
  const int i = std::clamp(static_cast<int>(std::floor(x)), 0, nx_ - 2);
  const int j = std::clamp(static_cast<int>(std::floor(y)), 0, ny_ - 2);
  const double fx = x - i, fy = y - j;
  const double v00 = at(i, j), v10 = at(i + 1, j), v01 = at(i, j + 1), v11 = at(i + 1, j + 1);
  Vec2 gradient = {((v10 - v00) * (1 - fy) + (v11 - v01) * fy) / h_, ((v01 - v00) * (1 - fx) + (v11 - v10) * fx) / h_};
  if ((insulating_[left] && x <= 0) || (insulating_[right] && x >= nx_ - 1)) gradient.x = 0;
  if ((insulating_[bottom] && y <= 0) || (insulating_[top] && y >= ny_ - 1)) gradient.y = 0;
  return gradient;
}

double Lattice::dirichlet_integral() const {
  double sum = 0;
  for (int j = 0; j < ny_; ++j) {
    const double weight = j == 0 || j == ny_ - 1 ? 0.5 : 1;  // An edge along a side borders one cell only
    for (int i = 0; i + 1 < nx_; ++i) sum += weight * std::pow(at(i + 1, j) - at(i, j), 2);
  }
  for (int j = 0; j + 1 < ny_; ++j)
    for (int i = 0; i < nx_; ++i) {
      const double weight = i == 0 || i == nx_ - 1 ? 0.5 : 1;
      sum += weight * std::pow(at(i, j + 1) - at(i, j), 2);
    }
  return sum;
}

double Lattice::flux_through(int side) const {
  const bool vertical = side == left || side == right;
  const int count = vertical ? ny_ : nx_;
  double sum = 0;
  for (int k = 0; k < count; ++k) {
    const double weight = k == 0 || k == count - 1 ? 0.5 : 1;
    double difference = 0;
    if (side == left) difference = at(0, k) - at(1, k);
    if (side == right) difference = at(nx_ - 1, k) - at(nx_ - 2, k);
    if (side == bottom) difference = at(k, 0) - at(k, 1);
    if (side == top) difference = at(k, ny_ - 1) - at(k, ny_ - 2);
    sum += weight * difference;
  }
  return sum;
}

}  // namespace lichtenberg::laplace
