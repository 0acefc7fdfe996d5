#include "solvers/neighbours/pairs.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "solvers/error.hpp"

namespace lichtenberg {
namespace {

/// Particle in the order of cells, close in memory to those that it is compared with.
template <int d>
struct SortedParticle {
  Vec<d> position;    ///< Position (m), inside the box along periodic axes
  double radius = 0;  ///< Radius (m)
  int particle = 0;
};

/// Range of columns of cells, from `first` to `last`, along one axis. Along a periodic axis the indices may be below 0
/// or above the number of columns by up to one period; no column occurs twice.
struct Columns {
  int first = 0, last = 0;
};

/// Particles sorted into rectangular cells at least `width` wide.
template <int d>
class Cells {
 public:
  Cells(const Spheres<d>& spheres, double width) : spheres_(spheres) {
    const int n = spheres.size();
    double zero = 0;  // NaN if a coordinate is not finite
    for (const double x : spheres.position) zero += 0 * x;
    if (std::isnan(zero)) throw Failure("the neighbours of particles without finite positions are not defined");
    // At most one cell per particle, so that a single distant particle does not cost memory.
    const int most = std::max(1, static_cast<int>(std::pow(n, 1.0 / d)));
    for (int k = 0; k < d; ++k) {
      if (spheres.box.periodic(k)) {
        period_[k] = spheres.box.lengths[k];
        count_[k] = std::clamp(static_cast<int>(std::min(period_[k] / (width * (1 + slack)), 1e9)), 1, most);
        side_[k] = period_[k] / count_[k];
        columns_a_metre_[k] = 1 / side_[k];
        continue;
      }
      double high = low_[k] = spheres.position[k];
      for (int i = 0; i < n; ++i) {
        low_[k] = std::min(low_[k], spheres.position[i * d + k]);
        high = std::max(high, spheres.position[i * d + k]);
      }
      side_[k] = std::max(width * (1 + slack), (high - low_[k]) / most * (1 + 1e-12));
      count_[k] = static_cast<int>((high - low_[k]) / side_[k]) + 1;
      columns_a_metre_[k] = 1 / side_[k];
    }
    sort();
  }

  const SortedParticle<d>& sorted(int s) const { return sorted_[s]; }

  /// Returns the squared distance of the image of b nearest to a.
  template <bool periodic>
  double distance_squared(const SortedParticle<d>& a, const SortedParticle<d>& b) const {
    double sum = 0;
    for (int k = 0; k < d; ++k) {
      double separation = a.position[k] - b.position[k];
      if constexpr (periodic) {
        // Both are inside the box. Along other axes the period is 0.
        if (separation > 0.5 * period_[k]) separation -= period_[k];
        if (separation < -0.5 * period_[k]) separation += period_[k];
      }
      sum += separation * separation;
    }
    return sum;
  }

  /// Calls visit(particles) with spans that contain all particles in cells within `distance` (m) of a centre, along
  /// each axis.
  template <class Visit>
  void for_each_near(const SortedParticle<d>& centre, double distance, Visit visit) const {
    std::array<Columns, 3> columns{};
    for (int k = 0; k < d; ++k) columns[k] = columns_within(centre.position[k], distance, k);
    for (int z = columns[2].first; z <= columns[2].last; ++z)
      for (int y = columns[1].first; y <= columns[1].last; ++y) {
        const int row = (wrapped_column(z, 2) * count_[1] + wrapped_column(y, 1)) * count_[0];
        const auto visit_columns = [&](int first, int last) {
          const int begin = start_[row + first];
          visit(std::span(sorted_.data() + begin, start_[row + last + 1] - begin));
        };
        const auto [first, last] = columns[0];
        if (first < 0) visit_columns(first + count_[0], count_[0] - 1);
        visit_columns(std::max(first, 0), std::min(last, count_[0] - 1));
        if (last >= count_[0]) visit_columns(0, last - count_[0]);
      }
  }

 private:
  /// Margin in units of a cell's side: more than the rounding of positions relative to the cells' borders.
  static constexpr double slack = 1e-9;

  double wrapped(double x, int k) const {
    if (period_[k] == 0 || (x >= 0 && x < period_[k])) return x;
    const double inside = x - period_[k] * std::floor(x / period_[k]);
    return inside >= 0 && inside < period_[k] ? inside : 0;
  }
  int column(double x, int k) const {
    // Not std::clamp: for an infinite distance, infinity times 0 is NaN, and the only column is 0.
    const double at = (x - low_[k]) * columns_a_metre_[k];
    return at > 0 ? static_cast<int>(std::min(at, count_[k] - 1.0)) : 0;
  }
  Columns columns_within(double x, double distance, int k) const {
    const double far = distance + slack * side_[k];
    if (period_[k] == 0) return {column(x - far, k), column(x + far, k)};
    const auto unwrapped_column = [&](double at) {
      return static_cast<int>(std::floor(std::clamp(at * columns_a_metre_[k], -1.0 * count_[k], 2.0 * count_[k])));
    };
    const Columns columns{unwrapped_column(x - far), unwrapped_column(x + far)};
    return columns.last - columns.first + 1 < count_[k] ? columns : Columns{0, count_[k] - 1};
  }
  int wrapped_column(int column, int k) const {
    return column < 0 ? column + count_[k] : column >= count_[k] ? column - count_[k] : column;
  }
  int cell_of(const SortedParticle<d>& sorted) const {
    const auto along = [&](int k) { return k < d ? column(sorted.position[k], k) : 0; };
    return (along(2) * count_[1] + along(1)) * count_[0] + along(0);
  }
  SortedParticle<d> make_sorted(int i) const {
    SortedParticle<d> sorted{.radius = spheres_.radius[i], .particle = i};
    for (int k = 0; k < d; ++k) sorted.position[k] = wrapped(spheres_.position[i * d + k], k);
    return sorted;
  }

  /// Counting sort: cell c contains sorted_[start_[c]] ... sorted_[start_[c + 1] - 1], in ascending order of particles.
  void sort() {
    const int n = spheres_.size();
    start_.assign(static_cast<std::size_t>(count_[0]) * count_[1] * count_[2] + 1, 0);
    std::vector<int> cell(n);
    for (int i = 0; i < n; ++i) ++start_[(cell[i] = cell_of(make_sorted(i))) + 1];
    std::partial_sum(start_.begin(), start_.end(), start_.begin());
    std::vector<int> next(start_.begin(), start_.end() - 1);
    sorted_.resize(n);
    for (int i = 0; i < n; ++i) sorted_[next[cell[i]]++] = make_sorted(i);
  }

  const Spheres<d>& spheres_;
  std::array<double, 3> low_{}, side_{}, period_{};  ///< Lengths (m); period 0: not periodic
  std::array<double, 3> columns_a_metre_{};
  std::array<int, 3> count_{1, 1, 1};
  std::vector<int> start_;
  std::vector<SortedParticle<d>> sorted_;
};

/// Throws InputError if two images of one particle could be within range of another, which would be two pairs.
template <int d>
void check_box(const Box<d>& box, double within) {
  for (int k = 0; k < d; ++k)
    if (box.periodic(k) && !(box.lengths[k] >= 2 * within))
      throw InputError(
          fmt::format("the periodic box is {:g} long from {} to {}, but particles up to {:g} apart are neighbours: at "
                      "least twice that is needed, or a particle would meet two images of one other",
                      box.lengths[k], side_names[2 * k], side_names[2 * k + 1], within));
}

/// Collects the pairs that find_partners(particle, others) finds for each particle, in the order of the particles.
/// find_partners writes the partners to `others` and returns their number.
template <int d, class FindPartners>
std::vector<Pair> collect(const Cells<d>& cells, int n, parallel::Team& team, const FindPartners& find_partners) {
  constexpr int particles_a_task = 2048;
  const int tasks = (n + particles_a_task - 1) / particles_a_task;
  std::vector<std::vector<Pair>> found(tasks);
  std::vector<int> start(n + 1, 0);
  const auto for_each_particle = [&](int task, const auto& visit) {
    for (int s = task * particles_a_task; s < std::min(n, (task + 1) * particles_a_task); ++s) visit(cells.sorted(s));
  };
  team.for_each(tasks, [&](int task) {
    std::vector<int> others;
    for_each_particle(task, [&](const SortedParticle<d>& here) {
      const int count = find_partners(here, others);
      std::sort(others.begin(), others.begin() + count);
      for (int k = 0; k < count; ++k)
        found[task].push_back({std::min(here.particle, others[k]), std::max(here.particle, others[k])});
      start[here.particle + 1] = count;
    });
  });
  std::partial_sum(start.begin(), start.end(), start.begin());
  std::vector<Pair> pairs(start[n]);
  team.for_each(tasks, [&](int task) {
    auto next = found[task].begin();
    for_each_particle(task, [&](const SortedParticle<d>& here) {
      const int count = start[here.particle + 1] - start[here.particle];
      std::copy_n(next, count, pairs.begin() + start[here.particle]);
      next += count;
    });
  });
  return pairs;
}

/// Appends the particles of `particles` for which `is_near` is true to the first `count` of `others`.
template <int d, class IsNear>
int append_near(std::span<const SortedParticle<d>> particles, int count, std::vector<int>& others,
                const IsNear& is_near) {
  if (others.size() < count + particles.size()) others.resize(2 * (count + particles.size()));
  for (const SortedParticle<d>& there : particles) {  // Without a branch, which would be hard to predict
    others[count] = there.particle;
    count += is_near(there);
  }
  return count;
}

template <int d, bool periodic>
std::vector<Pair> search(const Spheres<d>& spheres, const Cells<d>& cells, double largest, double range,
                         parallel::Team& team) {
  return collect(cells, spheres.size(), team, [&](const SortedParticle<d>& here, std::vector<int>& others) {
    int count = 0;
    cells.for_each_near(here, here.radius + largest + range, [&](std::span<const SortedParticle<d>> particles) {
      count = append_near<d>(particles, count, others, [&](const SortedParticle<d>& there) {
        const double within = here.radius + there.radius + range;
        return (here.particle < there.particle) & (within > 0) &
               (cells.template distance_squared<periodic>(here, there) < within * within);
      });
    });
    return count;
  });
}

/// Finds pairs within individual reaches. Of each pair the particle with the longer reach finds the other, so that a
/// fast particle does not extend the searches of all others.
template <int d>
std::vector<Pair> search_within_reach(const Spheres<d>& spheres, const Cells<d>& cells, double largest, double range,
                                      std::span<const double> reach, parallel::Team& team) {
  const auto has_longer_reach = [&](int i, int j) { return reach[j] < reach[i] || (reach[j] == reach[i] && i < j); };
  std::vector<Pair> pairs =
      collect(cells, spheres.size(), team, [&](const SortedParticle<d>& here, std::vector<int>& others) {
        const double own = reach[here.particle];
        int count = 0;
        cells.for_each_near(
            here, here.radius + largest + range + 2 * own, [&](std::span<const SortedParticle<d>> particles) {
              count = append_near<d>(particles, count, others, [&](const SortedParticle<d>& there) {
                if (!has_longer_reach(here.particle, there.particle)) return false;
                const double within = here.radius + there.radius + range + own + reach[there.particle];
                return within > 0 && cells.template distance_squared<true>(here, there) < within * within;
              });
            });
        return count;
      });
  std::ranges::sort(pairs);  // The particle that finds a pair may be the second one
  return pairs;
}

}  // namespace

template <int d>
std::vector<Pair> pairs_closer_than(const Spheres<d>& spheres, double range, parallel::Team& team) {
  if (spheres.size() == 0) return {};
  const double largest = *std::ranges::max_element(spheres.radius), width = 2 * largest + range;
  if (!(width > 0)) return {};
  check_box(spheres.box, width);
  const Cells<d> cells(spheres, width);
  return spheres.box.any_periodic() ? search<d, true>(spheres, cells, largest, range, team)
                                    : search<d, false>(spheres, cells, largest, range, team);
}

template <int d>
std::vector<Pair> pairs_within_reach(const Spheres<d>& spheres, double range, std::span<const double> reach,
                                     parallel::Team& team) {
  if (spheres.size() == 0) return {};
  const double largest = *std::ranges::max_element(spheres.radius), shortest = *std::ranges::min_element(reach);
  const double width = 2 * (largest + shortest) + range;
  if (!(width > 0)) return {};
  check_box(spheres.box, 2 * largest + range);
  const Cells<d> cells(spheres, width);
  return search_within_reach(spheres, cells, largest, range, reach, team);
}

template std::vector<Pair> pairs_closer_than(const Spheres<2>&, double, parallel::Team&);
template std::vector<Pair> pairs_closer_than(const Spheres<3>&, double, parallel::Team&);
template std::vector<Pair> pairs_within_reach(const Spheres<2>&, double, std::span<const double>, parallel::Team&);
template std::vector<Pair> pairs_within_reach(const Spheres<3>&, double, std::span<const double>, parallel::Team&);

}  // namespace lichtenberg
