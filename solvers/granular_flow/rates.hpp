#pragma once

#include <array>
#include <span>
#include <vector>

#include "solvers/granular_flow/flow.hpp"
#include "solvers/granular_flow/potential.hpp"

namespace lichtenberg::granular_flow {

/// Right-hand side of the hydrodynamic equations (flow.hpp) by finite volumes. It computes the rates of density n,
/// charge density c, momentum n u and ln T in each cell. u is the velocity, T the temperature.
/// The flux through a face is the central flux of Kurganov and Tadmor (2000) between the values on its two
/// sides. WENO interpolation computes each value from five cells (Jiang and Shu 1996, weights of Borges and others
/// 2008). It interpolates ln n, ln T, u and c/n, so that n and T are positive at faces too.
/// The viscous stress tensor and the heat flux are centred differences of fourth order. The heat flux is limited in
/// steep gradients, so that T stays positive. The scheme is of fourth order for waves of small amplitude. For large
/// amplitudes it is of second order, because nonlinear functions are computed from cell means. Sums of n, c and n u
/// change by rounding only. T stays positive also in supersonic flow; in exchange, energy is conserved only to the
/// order of the scheme.
class Rates {
 public:
  /// Prepares the rates on a grid; the threads of `team` share the loops over cells.
  Rates(const Gas& gas, const Grid& grid, parallel::Team& team);

  /// Returns the number of unknowns per cell. The quantities are stored one after another: n, c, the components of n u,
  /// ln T.
  int unknowns() const { return grid_.dimension + 3; }
  /// Converts fields to unknowns [quantity][cell]. The mean velocity, weighted by density, is subtracted.
  std::vector<double> pack(const Fields& fields) const;
  /// Converts the unknowns [quantity][cell] of the time integration to fields of density, charge, velocity and
  /// temperature.
  Fields unpack(std::span<const double> y) const;

  /// Computes the rates of the unknowns y [quantity][cell] at the scaled time `time` (tau). If n is not positive in a
  /// cell, some rates are not finite.
  void operator()(double time, std::span<const double> y, std::span<double> rate);

 private:
  struct Side;
  using Around = std::array<std::size_t, 6>;  ///< Indices of the six cells around a face, in the order of the axis

  /// Calls work(cell) for all cells, on the threads of the team.
  template <class Work>
  void for_cells(const Work& work) const;
  /// Returns the values of quantity `which` in all cells.
  template <class Number>
  std::span<Number> part(std::span<Number> y, int which) const {
    return y.subspan(which * size_, size_);
  }
  std::span<double> flow(int which) { return part(std::span(flow_), which); }
  /// Returns the cell `far` cells after the given one along an axis (before it if negative), with periodic wrap.
  std::size_t neighbour(std::size_t cell, int axis, int far) const;
  Around around(std::size_t cell, int axis) const;
  /// Calls work(first) for the first cell of each line of cells along the last axis, on the threads of the team.
  template <class Work>
  void for_lines(const Work& work) const;

  void find_primitives(std::span<const double> y);
  void find_gradients();
  void find_sides(int which, std::size_t first, int axis);
  Side side(std::size_t cell, bool above) const;
  void set_advection(std::size_t cell, std::size_t next, int axis, const Side& below, const Side& above);
  void add_diffusion(const Around& cells, int axis);
  void find_flows(int axis);
  void subtract_outflow(int axis, std::span<double> rate) const;
  void finish(double time, std::span<const double> y, std::span<double> rate);

  Gas gas_;
  Grid grid_;
  parallel::Team& team_;
  std::size_t size_;
  std::array<std::size_t, 3> stride_{};
  Potential potential_;
  std::array<std::vector<std::size_t>, 3> next_, before_;  ///< Neighbours of each cell, by axis, with periodic wrap
  /// Values of each cell: ln n, ln T, T, sqrt(T) and, in charge_, c/n.
  std::vector<double> log_density_, log_temperature_, temperature_, root_temperature_, charge_;
  std::array<std::vector<double>, 3> velocity_;
  /// Values of n, T, c/n, u on the two sides of the face after each cell, one quantity after another.
  std::vector<double> below_, above_;
  std::array<std::array<std::vector<double>, 3>, 3> gradient_;  ///< Velocity gradients [axis][component][cell]
  // Values at the face after each cell along an axis. `flow_` contains the fluxes of mass, charge, momentum and (3/2) n
  // T.
  // `face_velocity_` is the velocity across the face. `heating_` is the heat (per volume and time) from the loss of
  // kinetic energy there.
  std::vector<double> flow_, face_velocity_, heating_;
};

}  // namespace lichtenberg::granular_flow
