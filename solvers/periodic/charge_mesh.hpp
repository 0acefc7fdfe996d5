#pragma once

#include <array>
#include <span>

#include "solvers/periodic/convolution.hpp"
#include "solvers/periodic/influence.hpp"
#include "solvers/periodic/tiles.hpp"

namespace lichtenberg::periodic {

/// Field and potential at each charge, four numbers x, y, z, potential.
using FieldAndPotential = std::span<double>;

/// Charges taken for clouds, on a mesh: `spread` the charges, `solve` for the potential, `add` what it is at the
/// charges, in this order. Each is the same bits for any number of threads.
class ChargeMesh {
 public:
  /// Orders from 4 to 7; at least twice the order in points along each axis. Throws InputError.
  ChargeMesh(const Mesh& mesh, const Cloud& cloud);

  /// How far the points that a charge is spread to are from it along an axis, at most: half a spline.
  double reach() const;
  /// The tiles' reach is at least this one's.
  void spread(const Tiles& tiles, parallel::Team& team);
  void solve(parallel::Team& team);
  /// In the order of the tiles; without what a charge sees of its own cloud at its centre.
  void add(const Tiles& tiles, FieldAndPotential sum, parallel::Team& team) const;

 private:
  template <int order>
  struct Rows;
  /// Calls work(std::integral_constant) of the mesh's order.
  template <class Work>
  void with_order(Work&& work) const;
  template <int order>
  void spread_charge(const double* place_and_charge);
  template <int order>
  void add_to(double* sum, const double* place_and_charge) const;
  void take_self_off(double* sum, const std::array<double, 3>& behind, double charge) const;

  Mesh mesh_;
  Influence influence_;
  double self_;        ///< potential that a unit charge sees, on average, at the centre of its cloud; to be taken off
  double background_;  ///< potential that a unit of total charge adds everywhere
  double total_ = 0;   ///< charge, of what was spread last
  Convolution grid_;
  std::array<double, 4> over_spacing_;           ///< along x, y, z; and -1
  std::array<std::array<double, 4>, 2> wave_{};  ///< Influence::self_wave, seen from the middle between two points
};

}  // namespace lichtenberg::periodic
