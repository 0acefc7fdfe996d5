#include "solvers/periodic/short_range.hpp"

#include <fmt/format.h>

#include "solvers/error.hpp"
#include "solvers/periodic/field_sums.hpp"

namespace lichtenberg::periodic {
namespace {

FieldSample field_within(const Sources& sources, int i, double reach2) {
  const Multipole on = multipole(sources, i);
  CompensatedFieldSample sum;
  for (int j = 0; j < sources.size(); ++j) {
    if (j == i) continue;
    const Vec3 r = nearest_image(sources.position_of(j) - sources.position_of(i), sources.lengths);
    const double r2 = norm2(r);
    if (r2 < reach2) sum += pair_field(unscreened(r2), r, on, multipole(sources, j));
  }
  return sum.total();
}

/// Potential of a unit charge at some distance, and its field divided by that distance.
struct Shifted {
  double potential = 0, field = 0;
};

class ShiftedCharge {
 public:
  ShiftedCharge(double cutoff, double alpha) : cutoff_(cutoff), alpha_(alpha), end_(screened(cutoff * cutoff, alpha)) {}

  Shifted at(double r2) const {
    if (!(r2 < cutoff_ * cutoff_)) return {};
    const Screened here = screened(r2, alpha_);
    const double r = std::sqrt(r2), field = end_.b1 * cutoff_;  // Slope of w at the cut-off: -w'(c)
    return {here.b0 - end_.b0 + (r - cutoff_) * field, here.b1 - field / r};
  }
  /// Limit of v - 1/r at r = 0.
  double self_potential() const {
    return -2 * alpha_ * std::numbers::inv_sqrtpi - end_.b0 - cutoff_ * cutoff_ * end_.b1;
  }

 private:
  double cutoff_, alpha_;
  Screened end_;
};

void add(std::span<double> vectors, int i, Vec3 v) {
  for (int k = 0; k < 3; ++k) vectors[3 * i + k] += v[k];
}

}  // namespace

void MinimumImage::evaluate(const Sources& sources, std::span<const Pair>, parallel::Team& team, Response& response) {
  require_consistent(sources);
  const double half = 0.5 * sources.shortest_length(), reach2 = reach_ == Reach::half_box ? half * half : INFINITY;
  resize(response, sources.size());
  team.for_each(sources.size(), [&](int i) { store(i, field_within(sources, i, reach2), response); });
  response.energy = energy_of(sources, all_of(sources), response);
}

// All threads compute the terms of the pairs; one thread adds them in order, for reproducible sums.
void ShiftedForce::evaluate(const Sources& sources, std::span<const Pair> pairs, parallel::Team& team,
                            Response& response) {
  require_consistent(sources);
  if (!sources.dipole.empty()) throw InputError("the shifted force is defined for charges only, not for dipoles");
  if (!(cutoff_ > 0 && 2 * cutoff_ <= sources.shortest_length()))
    throw InputError(fmt::format(
        "the shifted force ends at {}: it must be above 0 and at most half of the box's shortest length, {}", cutoff_,
        sources.shortest_length()));
  const ShiftedCharge unit(cutoff_, alpha_);
  const auto separation = [&](Pair p) {
    return nearest_image(sources.position_of(p.j) - sources.position_of(p.i), sources.lengths);
  };
  constexpr std::size_t chunk = 1024;
  std::vector<Shifted> term(pairs.size());
  team.for_each(static_cast<int>((pairs.size() + chunk - 1) / chunk), [&](int c) {
    for (std::size_t k = c * chunk; k < std::min(pairs.size(), (c + 1) * chunk); ++k)
      term[k] = unit.at(norm2(separation(pairs[k])));
  });

  response = {};
  resize(response, sources.size());
  for (int i = 0; i < sources.size(); ++i) response.potential[i] = unit.self_potential() * sources.charge[i];
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    const auto [i, j] = pairs[k];
    const double qi = sources.charge[i], qj = sources.charge[j];
    const Vec3 field = term[k].field * separation(pairs[k]);
    response.potential[i] += qj * term[k].potential;
    response.potential[j] += qi * term[k].potential;
    add(response.field, i, -qj * field);
    add(response.field, j, qi * field);
  }
  for (int k = 0; k < 3 * sources.size(); ++k) response.force[k] = sources.charge[k / 3] * response.field[k];
  response.energy = energy_of(sources, all_of(sources), response);
}

}  // namespace lichtenberg::periodic
