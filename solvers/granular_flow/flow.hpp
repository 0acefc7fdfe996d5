#pragma once

#include <array>
#include <cstddef>
#include <functional>
#include <span>
#include <vector>

#include "solvers/parallel/team.hpp"

namespace lichtenberg::granular_flow {

// Hydrodynamic equations of a dilute cooling gas of charged grains (Singh 2019, G 6.26, corrected). Units are the
// scales of the homogeneous cooling gas: density n_0, temperature T_h(t), speed v_h = sqrt(2 T_h / m), charge density
// rho_0, length l_0, time t_0(t) = l_0 / v_h. The scaled time is d tau = dt / t_0(t). The other quantities are u = V /
// v_h, c = rho_q / rho_0 and s = eta* sqrt(T) (grad u + grad u' - (2/3) div u 1). The equations are:
//   dn/dtau + div(n u) = 0, dc/dtau + div(c u) = 0, lap psi = -(c - mean c);
//   d(n u)/dtau + div(n u u + (n T/2) 1 - s) = (zeta*/4) n u - R c grad psi;
//   de/dtau + div((e + n T) u - 2 s.u - q) = (zeta*/2) e - (3 zeta*/4) n^2 T^(3/2) - 2 R c u.grad psi;
//   e = (3/2) n T + n u^2, q = (15/4) sqrt(T) (kappa* grad T + mu* (T/n) grad n).
// Terms with zeta* other than the cooling -(3 zeta*/4) n^2 T^(3/2) arise because the unit of speed decreases.

/// Reduced transport coefficients of a charged granular gas. They are the cooling rate zeta*, viscosity eta*,
/// thermal conductivity kappa*, density-gradient coefficient mu* of the heat flux, and charge number R. R = 2 pi K
/// rho_0^2 l_0^2 / (n_0 T_h) with the Coulomb constant K and the units of the equations above.
/// `src/theory/stability.hpp` computes the coefficients.
struct Gas {
  double cooling = 0, viscosity = 0, conduction = 0, density_conduction = 0;  ///< zeta*, eta*, kappa*, mu*
  double charge_number = 0;                                                   ///< R at tau = 0
  /// True: charges are constant, so that R grows as 1/T_h. False: charges decrease like the speed and R is constant, as
  /// in G 6.29.
  bool charges_last = false;
};

/// Square or cubic grid of finite-volume cells, periodic along all axes.
struct Grid {
  int dimension = 2;  ///< Number of dimensions: 2 or 3
  int cells = 0;      ///< Cells along an edge, at least 6
  double length = 0;  ///< Length of an edge, in l_0

  std::size_t size() const;                       ///< Total number of cells
  double step() const { return length / cells; }  ///< Edge length of a cell h, in l_0
};

/// Hydrodynamic fields of a gas: values of each cell, with the last axis fastest. In two dimensions the value of cell
/// (x, y) has the index x * cells + y; the cell's centre is at ((x + 1/2) h, (y + 1/2) h) with the cell length h.
struct Fields {
  std::vector<double> density, temperature, charge;  ///< Density n, temperature T, charge density c
  std::array<std::vector<double>, 3> velocity;       ///< Velocity u, [axis][cell]
};

/// Returns the fields of the homogeneous gas at rest: density n, temperature T and charge density c are 1, the velocity
/// is 0.
Fields homogeneous(const Grid& grid);

/// Options of evolve(), the integration of a granular flow in time: error tolerance of its steps, report of progress.
struct EvolveOptions {
  double tolerance = 1e-5;  ///< Error tolerance of a time step, relative and absolute
  /// Function to report progress; called with the scaled time at each computation of rates.
  std::function<void(double tau)> report = {};
};

/// Integrates the hydrodynamic equations of the gas from the fields `start` at scaled time 0. Returns the fields at
/// each of `times` (scaled times tau, ascending, >= 0). The mean velocity is subtracted at the start.
/// Sums of density, charge and momentum are conserved to rounding. Temperatures stay positive; densities do so as long
/// as the grid resolves them. Results have identical bits for any number of threads of `team`. Throws InputError for an
/// invalid grid or invalid fields, Failure if a step cannot reach its tolerance.
std::vector<Fields> evolve(const Gas& gas, const Grid& grid, const Fields& start, std::span<const double> times,
                           const EvolveOptions& options = {}, parallel::Team& team = parallel::Team::single());

}  // namespace lichtenberg::granular_flow
