#include "src/granular/grain_statistics.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace lichtenberg::granular {
namespace {

constexpr int grains_a_task = 2048;

/// Kinetic energy, and squares of the largest speed and of the largest velocity change, of a range of grains.
struct PartialStatistics {
  double kinetic = 0, speed2 = 0, change2 = 0;
};

PartialStatistics combined(const std::vector<PartialStatistics>& parts) {
  PartialStatistics all;
  for (const PartialStatistics& part : parts) {
    all.kinetic += part.kinetic;
    all.speed2 = std::max(all.speed2, part.speed2);
    all.change2 = std::max(all.change2, part.change2);
  }
  return all;
}

template <class Work>
PartialStatistics over_ranges(int grains, parallel::Team& team, const Work& work) {
  std::vector<PartialStatistics> parts((grains + grains_a_task - 1) / grains_a_task);
  team.for_each(static_cast<int>(parts.size()), [&](int task) {
    work(task * grains_a_task, std::min(grains, (task + 1) * grains_a_task), parts[task]);
  });
  return combined(parts);
}

/// Calls visit(i, square of vector i) for the grains first <= i < last; v: vectors, [N * dimension].
template <class Visit>
void for_each_square(const Bodies& b, const double* v, int first, int last, const Visit& visit) {
  if (b.dimension == 3)
    for (int i = first; i < last; ++i)
      visit(i, v[3 * i] * v[3 * i] + v[3 * i + 1] * v[3 * i + 1] + v[3 * i + 2] * v[3 * i + 2]);
  else
    for (int i = first; i < last; ++i) visit(i, v[2 * i] * v[2 * i] + v[2 * i + 1] * v[2 * i + 1]);
}

/// Number of independent partial sums. A single sum would be slower, because each addition waits for the previous one.
constexpr int grains_at_once = 8;
/// Partial sums of twice the kinetic energy, and squares of the largest speeds, one for each of grains_at_once grains.
struct Sums {
  std::array<double, grains_at_once> energy{}, speed2{};

  template <int d>
  void add(const double* momentum, const double* mass, int count) {
    for (int lane = 0; lane < count; ++lane) {
      double square = momentum[lane * d] * momentum[lane * d];
      for (int k = 1; k < d; ++k) square += momentum[lane * d + k] * momentum[lane * d + k];
      const double per_mass = 1 / mass[lane], twice = per_mass * square, faster = per_mass * twice;
      energy[lane] += twice;
      speed2[lane] = speed2[lane] < faster ? faster : speed2[lane];
    }
  }
};

template <int d>
Sums sums_of(const Bodies& b, int first, int last) {
  Sums sums;
  const double *momentum = b.momentum.data(), *mass = b.mass.data();
  int i = first;
  for (; i + grains_at_once <= last; i += grains_at_once) sums.add<d>(momentum + i * d, mass + i, grains_at_once);
  sums.add<d>(momentum + i * d, mass + i, last - i);
  return sums;
}

/// Adds the kinetic energy and largest speed of the grains first <= i < last to `part`. The function is not inlined, so
/// that its results are bitwise identical with and without a preceding kick.
[[gnu::noinline]] void add_range(const Bodies& b, int first, int last, PartialStatistics& part) {
  const Sums sums = b.dimension == 3 ? sums_of<3>(b, first, last) : sums_of<2>(b, first, last);
  for (const double one : sums.energy) part.kinetic += 0.5 * one;
  part.speed2 = std::max(part.speed2, *std::ranges::max_element(sums.speed2));
}

/// Impulse on the grains: dt times the change of the forces from `before` to `now` ([N * dimension]).
struct Kick {
  double dt;
  const double *before, *now;
};

[[gnu::noinline]] void kick_range(Bodies& b, const Kick& kick, int first, int last, PartialStatistics& part) {
  const auto [dt, before, now] = kick;
  const int d = b.dimension;
  for (int i = first; i < last; ++i) {
    double square = 0;
    for (int k = i * d; k < (i + 1) * d; ++k) {
      const double change = dt * (now[k] - before[k]);
      b.momentum[k] += change;
      square += change * change;
    }
    part.change2 = std::max(part.change2, square / (b.mass[i] * b.mass[i]));
  }
}

GrainStatistics statistics_of(const PartialStatistics& all) {
  return {.kinetic = all.kinetic, .fastest = std::sqrt(all.speed2)};
}

}  // namespace

GrainStatistics grain_statistics(const Bodies& bodies, parallel::Team& team) {
  return statistics_of(over_ranges(bodies.size(), team, [&](int first, int last, PartialStatistics& part) {
    add_range(bodies, first, last, part);
  }));
}

KickResult kick(Bodies& bodies, double dt, std::span<const double> before, std::span<const double> now,
                parallel::Team& team) {
  const PartialStatistics all = over_ranges(bodies.size(), team, [&](int first, int last, PartialStatistics& part) {
    kick_range(bodies, {dt, before.data(), now.data()}, first, last, part);
    add_range(bodies, first, last, part);
  });
  return {.most = std::sqrt(all.change2), .after = statistics_of(all)};
}

double largest_acceleration(const Bodies& bodies, std::span<const double> force, parallel::Team& team) {
  if (force.empty()) return 0;
  const PartialStatistics all = over_ranges(bodies.size(), team, [&](int first, int last, PartialStatistics& part) {
    for_each_square(bodies, force.data(), first, last, [&](int i, double square) {
      part.change2 = std::max(part.change2, square / (bodies.mass[i] * bodies.mass[i]));
    });
  });
  return std::sqrt(all.change2);
}

}  // namespace lichtenberg::granular
