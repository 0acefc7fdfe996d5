#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "solvers/parallel/team.hpp"
#include "src/effects/contact_potential.hpp"
#include "src/model/bodies.hpp"
#include "src/model/pair_loop.hpp"

namespace lichtenberg::statics {

/// Energy and gradient of the contact potential for particles that move little between evaluations. Pairs within a wide
/// skin are searched for seldom. Only those of them within a narrow margin, which follows how far the particles move,
/// are evaluated each time. The results do not depend on when either list was made, nor on the number of threads.
class CloseContacts {
 public:
  /// Radii and dimension are those of `bodies`. All arguments must outlive this.
  CloseContacts(const effects::ContactPotential& potential, const Bodies& bodies, parallel::Team& team);

  /// Energy (J) at the positions x (m, [N * dimension]); overwrites `gradient` (N, [N * dimension]). Infinite, with a
  /// meaningless gradient, if two centres coincide or a centre is on or beyond a wall.
  double evaluate(std::span<const double> x, std::span<double> gradient);
  /// All pairs that overlap at x, and others, in ascending order.
  std::span<const Pair> pairs(std::span<const double> x);

 private:
  /// Candidates of a range of particles; arrays by candidate.
  struct Range {
    std::vector<int> i, j;
    std::vector<double> per_reach;  ///< 1/m
    std::vector<Pair> walls;        ///< particle and wall
    std::vector<Push> beyond;       ///< gradient of particles of later ranges
    double energy = 0;              ///< over the stiffness
    bool valid = false;
  };
  template <class Task>
  void for_each_range(const Task& task);
  template <int d>
  double evaluate(std::span<const double> x, std::span<double> gradient);
  template <int d>
  void evaluate_range(Range& range, int first, int end, std::span<const double> x, std::span<double> gradient) const;
  template <int d>
  bool covers(int first, int end, std::span<const double> x) const;
  template <int d>
  bool add_walls(Range& range, std::span<const double> x, std::span<double> gradient) const;
  template <int d>
  void add_pairs(Range& range, int end, std::span<const double> x, std::span<double> gradient) const;
  template <int d>
  void update(std::span<const double> x);
  template <int d>
  double largest_move(std::span<const double> x) const;
  template <int d>
  void collect(Range& range, int first, int end, std::span<const double> x) const;

  const effects::ContactPotential& potential_;
  const Bodies& bodies_;
  parallel::Team& team_;
  double skin_, wanted_margin_, margin_ = 0;  ///< m
  std::vector<Pair> pairs_;                   ///< within skin_ at searched_at_
  std::vector<double> searched_at_;           ///< m
  std::vector<double> collected_at_;          ///< m: where `ranges_` had all within margin_
  std::vector<Range> ranges_;
  std::int64_t uses_ = 0;  ///< of `ranges_` since they were collected
};

}  // namespace lichtenberg::statics
