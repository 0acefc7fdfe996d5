#pragma once

#include <array>
#include <span>
#include <vector>

#include "solvers/granular_flow/flow.hpp"
#include "solvers/granular_flow/potential.hpp"

namespace lichtenberg::granular_flow {

/// Rates of the unknowns n, c, n u and ln T, stored one quantity after another.
/// Finite volumes: the flux through a face is that of Kurganov and Tadmor (2000) between the values on its two sides.
/// These come from five cells each (WENO, Jiang and Shu 1996, with the weights of Borges and others 2008) of ln n, ln
/// T, u and c/n, so that n and T are positive there too. Viscous stress and heat flux are centred differences of fourth
/// order. Waves of small amplitude are of fourth order, products of large ones of second. Sums of n, c and n u change
/// by rounding only. All other changes of T either heat or vanish with T, also in supersonic flow. In exchange, energy
/// is conserved only to the order of the scheme.
class Rates {
 public:
  Rates(const Gas& gas, const Grid& grid, parallel::Team& team);

  /// Number of unknowns per cell: 0 n, 1 c, 2 ... n u, last ln T.
  int unknowns() const { return grid_.dimension + 3; }
  /// Converts fields to unknowns, with velocities relative to the mean.
  std::vector<double> pack(const Fields& fields) const;
  Fields unpack(std::span<const double> y) const;

  /// Computes the rates; they are not finite where n is not positive.
  void operator()(double time, std::span<const double> y, std::span<double> rate);

 private:
  struct Side;
  using Around = std::array<std::size_t, 6>;

  /// Calls work(cell) for all cells.
  template <class Work>
  void for_cells(const Work& work) const;
  template <class Number>
  std::span<Number> part(std::span<Number> y, int which) const {
    return y.subspan(which * size_, size_);
  }
  std::span<double> flow(int which) { return part(std::span(flow_), which); }
  std::size_t neighbour(std::size_t cell, int axis, int far) const;
  Around around(std::size_t cell, int axis) const;
  /// Calls work(first) for the first cell of each line along the last axis.
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
  std::vector<double> log_density_, log_temperature_, temperature_, root_temperature_, charge_;  ///< charge_: c/n
  std::array<std::vector<double>, 3> velocity_;
  /// Values of n, T, c/n, u on the two sides of the face after each cell, one quantity after another.
  std::vector<double> below_, above_;
  std::array<std::array<std::vector<double>, 3>, 3> gradient_;  ///< Layout [by axis][of velocity]
  // Values at the face after each cell along an axis: `flow_` are the fluxes of mass, charge, momentum ... and (3/2) n
  // T, and `face_velocity_` is the velocity across the face. `heating_` is the heat (per volume and time) from the loss
  // of kinetic energy there.
  std::vector<double> flow_, face_velocity_, heating_;
};

}  // namespace lichtenberg::granular_flow
