#include "src/model/pair_law_check.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "solvers/error.hpp"

namespace lichtenberg {
namespace {

/// Force of a law at one distance, and the force that follows from its energy.
struct Sample {
  double distance = 0, force = 0, slope = 0;
};

/// Step of central differences, relative to the range. Their truncation error for a power law r^-n is about
/// (n step)^2 / 6 of the force, 1e-6 for n = 24; the rounding of the energy gives 1e-12 of it.
constexpr double step = 1e-4;
/// Allowed error of a force relative to the largest force: a hundred times the truncation error.
constexpr double allowed = 1e-4;

}  // namespace

void check_pair_law(const std::function<PairForce(double distance)>& law, double from, double cutoff,
                    const std::string& name) {
  constexpr int count = 10;
  const double range = cutoff - from;
  if (!(range > 0)) return;
  std::vector<Sample> samples;
  double largest_force = 0, largest_energy = 0;
  for (int k = 0; k < count; ++k) {
    const double distance = from + (k + 0.5137) / count * range;  // no simple fraction, where a law may have a kink
    const double above = law(distance + step * range).energy, below = law(distance - step * range).energy;
    samples.push_back({distance, law(distance).force, (below - above) / (2 * step * range)});
    largest_force = std::max({largest_force, std::abs(samples.back().force), std::abs(samples.back().slope)});
    largest_energy = std::max({largest_energy, std::abs(above), std::abs(below)});
  }
  int wrong = 0;
  for (const auto& [distance, force, slope] : samples)
    if (!(std::abs(force - slope) <= allowed * largest_force) && ++wrong > 1)
      throw InputError(
          fmt::format("effects.{}: the law of the pair force contradicts itself at the distance {:g}: the "
                      "force is {:g}, and minus the derivative of the energy is {:g}",
                      name, distance, force, slope));
  // The energy changes by at most the largest force times this distance from the cutoff.
  constexpr double inside = 1e-9, jump = 1e-6;
  const double energy = law(cutoff - inside * range).energy;
  if (!(std::abs(energy) <= jump * largest_energy + inside * range * largest_force))
    throw InputError(fmt::format("effects.{}: the energy of the pair force is {:g} at its cutoff {:g}: it must be 0",
                                 name, energy, cutoff));
}

}  // namespace lichtenberg
