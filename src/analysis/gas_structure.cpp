#include "src/analysis/gas_structure.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

#include "src/analysis/gas_cells.hpp"
#include "src/analysis/gas_distributions.hpp"
#include "src/analysis/gas_temperature.hpp"

namespace lichtenberg::analysis {
namespace {

using Phase = std::complex<double>;

/// Multiplies without the standard product's treatment of infinities.
Phase product(Phase a, Phase b) {
  return {a.real() * b.real() - a.imag() * b.imag(), a.real() * b.imag() + a.imag() * b.real()};
}

/// Returns exp(i 2 pi n x/L) of every grain for n = -most ... most, [n + most][N].
std::vector<std::vector<Phase>> phases_along(const Bodies& b, int axis, int most) {
  std::vector<std::vector<Phase>> phases(2 * most + 1, std::vector<Phase>(b.size(), 1));
  for (int i = 0; i < b.size(); ++i) {
    const Phase one = std::polar(1.0, 2 * std::numbers::pi * b.position[i * b.dimension + axis] / b.box.lengths[axis]);
    for (int n = 1; n <= most; ++n) {
      phases[most + n][i] = product(phases[most + n - 1][i], one);
      phases[most - n][i] = std::conj(phases[most + n][i]);
    }
  }
  return phases;
}

/// Sums over grains of exp(ikr) and of q exp(ikr).
struct Sums {
  Phase density = 0, charge = 0;
};
Sums sums_of(std::span<const Phase> phase, std::span<const Phase> last, std::span<const double> charge) {
  Sums sums;
  for (std::size_t i = 0; i < phase.size(); ++i) {
    const Phase whole = product(phase[i], last[i]);
    sums.density += whole;
    if (!charge.empty()) sums.charge += charge[i] * whole;
  }
  return sums;
}

/// Selects half of all wave vectors; the opposite ones have complex conjugate sums.
bool is_first_half(const int* n) { return n[0] > 0 || (n[0] == 0 && (n[1] > 0 || (n[1] == 0 && n[2] > 0))); }

}  // namespace

StructureFactors structure_factors(const Bodies& b, int shells) {
  double squares = 0;
  for (const double q : b.charge) squares += q * q;
  for (int axis = 0; axis < b.dimension; ++axis)
    if (!b.box.periodic(axis)) {
      const std::vector<double> none(shells, NAN);
      return {none, squares > 0 ? none : std::vector<double>{}};
    }
  std::vector<std::vector<Phase>> along[3];
  for (int axis = 0; axis < 3; ++axis)
    along[axis] = axis < b.dimension ? phases_along(b, axis, shells)
                                     : std::vector(2 * shells + 1, std::vector<Phase>(b.size(), 1));
  std::vector<double> density(shells), charge(shells);
  std::vector<int> vectors(shells);
  std::vector<Phase> in_plane(b.size());
  const int deep = b.dimension == 3 ? shells : 0;
  for (int x = 0; x <= shells; ++x)
    for (int y = -shells; y <= shells; ++y) {
      for (int i = 0; i < b.size(); ++i) in_plane[i] = product(along[0][shells + x][i], along[1][shells + y][i]);
      for (int z = -deep; z <= deep; ++z) {
        const int n[] = {x, y, z}, shell = static_cast<int>(std::lround(std::sqrt(x * x + y * y + z * z)));
        if (shell > shells || !is_first_half(n)) continue;
        const Sums sums = sums_of(in_plane, along[2][shells + z], b.charge);
        density[shell - 1] += std::norm(sums.density) / b.size();
        if (squares > 0) charge[shell - 1] += std::norm(sums.charge) / squares;
        ++vectors[shell - 1];
      }
    }
  for (int s = 0; s < shells; ++s) density[s] /= vectors[s], charge[s] /= vectors[s];
  return {density, squares > 0 ? charge : std::vector<double>{}};
}

MachNumber mach_number(const Bodies& b, double edge) {
  const double temperature = granular_temperature(b, edge).local;
  if (!(temperature > 0)) return {NAN, NAN};
  const OccupiedCells cells = occupied_cells(b, cells_of(b, edge));
  const std::vector<int>& cell = cells.body_cell;
  std::vector<Vec3> momentum(cells.size());
  std::vector<double> mass(cells.size());
  double whole = 0;
  for (int i = 0; i < b.size(); ++i) {
    mass[cell[i]] += b.mass[i], whole += b.mass[i];
    for (int k = 0; k < b.dimension; ++k) momentum[cell[i]][k] += b.momentum[i * b.dimension + k];
  }
  const double grain = whole / b.size();
  double squares = 0, noise = 0;
  for (int c = 0; c < cells.size(); ++c) {
    squares += norm2(momentum[c]) / (mass[c] * mass[c]) * grain / temperature;
    noise += b.dimension * grain / mass[c];
  }
  return {std::sqrt(squares / cells.size()), std::sqrt(std::max(squares - noise, 0.0) / cells.size())};
}

double mean_square_displacement(const Bodies& before, const Bodies& now) {
  double sum = 0;
  const auto unwrapped_coordinate = [](const Bodies& b, int i, int k) {
    const int n = i * b.dimension + k;
    return b.position[n] + (b.image.empty() ? 0 : b.image[n] * b.box.lengths[k]);
  };
  for (int i = 0; i < now.size(); ++i)
    for (int k = 0; k < now.dimension; ++k)
      sum += std::pow(unwrapped_coordinate(now, i, k) - unwrapped_coordinate(before, i, k), 2);
  return sum / now.size();
}

double persistence(std::span<const Pair> before, std::span<const Pair> now) {
  if (before.empty()) return NAN;
  int kept = 0;
  for (const Pair p : before) kept += std::ranges::binary_search(now, p);
  return kept / static_cast<double>(before.size());
}

std::vector<double> charge_by_speed(const Bodies& bodies, double fastest, int bins) {
  std::vector<double> squares(bins);
  std::vector<int> grains(bins);
  const std::vector<double> speed = scaled_speeds(bodies), charge = scaled_charges(bodies.charge);
  for (std::size_t i = 0; i < charge.size(); ++i) {
    const auto bin = static_cast<int>(speed[i] / fastest * bins);
    if (bin < bins) squares[bin] += charge[i] * charge[i], ++grains[bin];
  }
  for (int bin = 0; bin < bins; ++bin) squares[bin] = grains[bin] > 0 ? squares[bin] / grains[bin] : NAN;
  return squares;
}

}  // namespace lichtenberg::analysis
