#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "solvers/parallel/team.hpp"
#include "src/effects/soft_repulsion.hpp"
#include "src/model/bodies.hpp"
#include "src/model/pair_loop.hpp"

namespace lichtenberg::statics {

/// Computes energy and gradient of the soft repulsion of overlapping particles that move little between evaluations. A
/// Verlet neighbour list with a wide skin is rebuilt rarely. Each evaluation uses only the pairs of the list within a
/// narrow margin beyond contact. The margin adapts to the displacements of the particles. The energy and the gradient
/// do not depend on when the lists were made, nor on the number of threads. Positions are unwrapped: across periodic
/// sides the nearest images interact.
class CloseContacts {
 public:
  /// Prepares the evaluation for particles with the radii and the dimension of `bodies`. `team`: threads. All arguments
  /// must outlive this object.
  CloseContacts(const effects::SoftRepulsion& potential, const Bodies& bodies, parallel::Team& team);

  /// Returns the energy (J) of all overlaps of particles and walls at the positions x (m, [N * dimension]), and
  /// overwrites `gradient` (N, [N * dimension]). The energy is infinite and the gradient undefined if two centres
  /// coincide or a centre is on or beyond a wall.
  double evaluate(std::span<const double> x, std::span<double> gradient);
  /// Returns candidate pairs in ascending order: all pairs that overlap at the positions x (m), and others that are
  /// close.
  std::span<const Pair> pairs(std::span<const double> x);

 private:
  /// Candidate contacts of a range of particles, with arrays by candidate pair. One task evaluates one range.
  struct Range {
    std::vector<int> i, j;
    std::vector<double> per_reach;              ///< 1/m, inverse of the sum of radii
    std::vector<Pair> walls;                    ///< particle and wall
    std::vector<ParticleForce> outside_forces;  ///< gradient of particles of later ranges
    double energy = 0;                          ///< energy over the stiffness
    bool valid = false;
  };
  template <class Task>
  void for_each_range(const Task& task);
  /// Calls f with the dimension, and with true if the domain has periodic sides, as constants.
  template <class F>
  decltype(auto) in_kind_of_box(const F& f) const;
  template <int d, bool periodic>
  double evaluate(std::span<const double> x, std::span<double> gradient);
  template <int d, bool periodic>
  void evaluate_range(Range& range, int first, int end, std::span<const double> x, std::span<double> gradient) const;
  template <int d>
  bool is_valid_for(int first, int end, std::span<const double> x) const;
  template <int d>
  bool add_walls(Range& range, std::span<const double> x, std::span<double> gradient) const;
  template <int d, bool periodic>
  void add_pairs(Range& range, int end, std::span<const double> x, std::span<double> gradient) const;
  template <int d, bool periodic>
  void update(std::span<const double> x);
  template <int d>
  double largest_move(std::span<const double> x) const;
  template <int d, bool periodic>
  void collect(Range& range, int first, int end, std::span<const double> x) const;

  const effects::SoftRepulsion& potential_;
  const Bodies& bodies_;
  parallel::Team& team_;
  double skin_, wanted_margin_, margin_ = 0;  ///< m
  std::vector<Pair> pairs_;                   ///< pairs within skin_ at search_positions_
  std::vector<double> search_positions_;      ///< m, positions at the last list rebuild
  std::vector<double> collection_positions_;  ///< m, positions at which `ranges_` contained all pairs within margin_
  std::vector<Range> ranges_;
  std::int64_t uses_ = 0;  ///< evaluations with `ranges_` since they were collected
};

}  // namespace lichtenberg::statics
