#pragma once

#include <array>
#include <span>
#include <vector>

#include "solvers/periodic/columns.hpp"
#include "solvers/periodic/influence.hpp"
#include "solvers/periodic/convolution.hpp"

namespace lichtenberg::periodic {

/// What ChargeMesh does with charges, in single precision and with windows of either kind: `spread` them, `solve` for
/// the potential, `add` what it is at their places, in this order. Each is the same bits for any number of threads.
class SingleChargeMesh {
 public:
  /// Orders from 4 to 8; at least twice the order in points along each axis, an even number along z. Throws InputError.
  SingleChargeMesh(const Mesh& mesh, const Cloud& cloud)
      : SingleChargeMesh(mesh, cloud, optimal_influence(checked_even(mesh), cloud)) {}

  /// How far the points that a charge is spread to are from it along an axis, at most: half a spline.
  double reach() const;
  /// The columns' reach is at least this one's.
  void spread(const Columns& columns, parallel::Team& team);
  void solve(parallel::Team& team) { grid_.apply(team); }
  /// To field x, y, z and potential at each sorted charge, in units of the cut-off and Columns::charge_unit. Without
  /// what a charge sees of its own cloud at its centre.
  void add(const Columns& columns, std::span<float> sums, parallel::Team& team) const;

 private:
  SingleChargeMesh(const Mesh& mesh, const Cloud& cloud, const Influence& influence);
  static const Mesh& checked_even(const Mesh& mesh);
  template <int order>
  void spread_charge(const Columns& columns, int s);
  template <int order>
  void add_to(const Columns& columns, int s, float background, float* sum) const;

  Mesh mesh_;
  std::vector<float> window_;  ///< of s^d: weights of the points around a place, and their slopes; [d][2 x lanes]
  Convolution<float> grid_;
  // In units of the cut-off, as in ChargeMesh.
  std::array<float, 4> over_spacing_;
  std::array<std::array<float, 4>, 2> wave_;
  float self_;
  double background_, total_ = 0;
};

}  // namespace lichtenberg::periodic
