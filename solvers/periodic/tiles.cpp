#include "solvers/periodic/tiles.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace lichtenberg::periodic {

Tiles::Tiles(Vec3 lengths, double reach) : lengths_(lengths) {
  for (int k = 0; k < 2; ++k) {
    // Rounding must not make what is in reach of one tile seem to be in reach of the next but one.
    const int fit = static_cast<int>(lengths[k] / (2 * reach) * (1 - 1e-12));
    tiles_[k] = std::max(1, fit / 2 * 2);
  }
  tiles_[2] = std::max(1, static_cast<int>(2 * lengths.z / reach));
}

void Tiles::sort(const Sources& sources) {
  const int n = sources.size();
  const Vec3 turns{1 / lengths_.x, 1 / lengths_.y, 1 / lengths_.z};
  piece_.resize(n);
  first_.assign(tiles_[0] * tiles_[1] * tiles_[2] + 1, 0);
  for (int i = 0; i < n; ++i) {
    int piece = 0;
    for (int k = 0; k < 3; ++k) {
      const double turned = sources.position[3 * i + k] * turns[k];
      piece = piece * tiles_[k] + std::min(static_cast<int>((turned - std::floor(turned)) * tiles_[k]), tiles_[k] - 1);
    }
    piece_[i] = piece;
    ++first_[piece + 1];
  }
  std::partial_sum(first_.begin(), first_.end(), first_.begin());
  order_.resize(n);
  sorted_.resize(n);
  charges_.resize(4 * static_cast<std::size_t>(n));
  next_.assign(first_.begin(), first_.end());
  for (int i = 0; i < n; ++i) {
    const int s = next_[piece_[i]]++;
    order_[s] = i;
    sorted_[i] = s;
    for (int k = 0; k < 3; ++k) {
      const double x = sources.position[3 * i + k];
      charges_[4 * s + k] = x - std::floor(x * turns[k]) * lengths_[k];
    }
    charges_[4 * s + 3] = sources.charge[i];
  }
  if (!sources.dipole.empty()) sort_dipoles(sources.dipole);
}

void Tiles::sort_dipoles(std::span<const double> dipole) {
  dipoles_.resize(charges_.size());
  for (int i = 0; i < size(); ++i) std::copy_n(&dipole[3 * i], 3, &dipoles_[4 * sorted_[i]]);
}

}  // namespace lichtenberg::periodic
