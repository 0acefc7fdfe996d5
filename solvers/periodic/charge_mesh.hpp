#pragma once

#include <array>
#include <span>

#include "solvers/periodic/convolution.hpp"
#include "solvers/periodic/influence.hpp"
#include "solvers/periodic/tiles.hpp"

namespace lichtenberg::periodic {

/// Field and potential at each charge, four numbers x, y, z, potential.
using FieldAndPotential = std::span<double>;

/// What sources are taken for.
enum class Kind {
  charges,     ///< field and potential are sought
  dipoles,     ///< their field alone is sought; charges are taken for 0, and what stands for the potential is no number
               ///< to be used
  multipoles,  ///< charges with dipoles: field, potential and force are sought
};

/// Of splines: below, their second derivatives jump, and with them the forces on dipoles.
constexpr int lowest_dipole_order = 5;

/// What sources feel, in the order of the tiles.
struct FeltSums {
  FieldAndPotential field;
  std::span<double> force{};  ///< four numbers each, the last without a meaning; only of Kind::multipoles
};

/// The mesh. Throws InputError unless there are windows of its order and enough points for them.
const Mesh& checked(const Mesh& mesh, int highest_order);

/// Charges and dipoles taken for clouds, on a mesh: `spread` them, `solve` for the potential, `add` what it is at their
/// places, in this order. A dipole is spread as a charge that is moved a little, with the splines' slopes: potentials,
/// fields and forces are all slopes of one energy. Each is the same bits for any number of threads.
class ChargeMesh {
 public:
  /// Splines of orders from 4 to 7; at least twice the order in points along each axis. Throws InputError.
  ChargeMesh(const Mesh& mesh, const Cloud& cloud);

  int order() const { return mesh_.order; }
  /// How far the points that a charge is spread to are from it along an axis, at most: half a spline.
  double reach() const;
  /// The tiles' reach is at least this one's.
  void spread(const Tiles& tiles, Kind kind, parallel::Team& team);
  void solve(parallel::Team& team);
  /// Without what a source sees of its own cloud at its centre.
  void add(const Tiles& tiles, Kind kind, const FeltSums& sums, parallel::Team& team) const;

 private:
  template <int order>
  struct Rows;
  /// Calls work(std::integral_constant, ...) of the mesh's order and the kind.
  template <class Work>
  void with_constants(Kind kind, Work&& work) const;
  template <int order, Kind kind>
  void spread_source(const Tiles& tiles, int s);
  template <int order, Kind kind>
  void add_to(const FeltSums& sums, const Tiles& tiles, int s) const;
  void take_self_off(double* sum, const std::array<double, 3>& behind, double charge) const;
  void take_multipole_off(double* sum, double* force, const std::array<double, 3>& behind, double charge,
                          const double* dipole) const;

  Mesh mesh_;
  Influence influence_;
  std::array<std::array<double, 4>, 2> wave_;
  double self_;        ///< potential that a unit charge sees, on average, at the centre of its cloud; to be taken off
  double self_field_;  ///< that a unit dipole sees there, against it
  double background_;  ///< potential that a unit of total charge adds everywhere
  double total_ = 0;   ///< charge, of what was spread last
  Convolution<double> grid_;
  std::array<double, 4> over_spacing_;  ///< along x, y, z; and -1
};

}  // namespace lichtenberg::periodic
