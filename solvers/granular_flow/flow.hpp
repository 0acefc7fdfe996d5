#pragma once

#include <array>
#include <cstddef>
#include <functional>
#include <span>
#include <vector>

#include "solvers/parallel/team.hpp"

namespace lichtenberg::granular_flow {

// Hydrodynamic equations of a dilute cooling gas of charged grains (G 6.26, corrected). Units are the scales of the
// homogeneous cooling gas: density n_0, temperature T_h(t), speed v_h = sqrt(2 T_h / m), charge density rho_0, length
// l_0, time t_0(t) = l_0 / v_h. The scaled time is d tau = dt / t_0(t). The other quantities are u = V / v_h, c = rho_q
// / rho_0 and s = eta* sqrt(T) (grad u + grad u' - (2/3) div u 1). The equations are:
//   dn/dtau + div(n u) = 0, dc/dtau + div(c u) = 0, lap psi = -(c - mean c)
//   d(n u)/dtau + div(n u u + (n T/2) 1 - s) = (zeta*/4) n u - R c grad psi
//   de/dtau + div((e + n T) u - 2 s.u - q) = (zeta*/2) e - (3 zeta*/4) n^2 T^(3/2) - 2 R c u.grad psi
//   e = (3/2) n T + n u^2, q = (15/4) sqrt(T) (kappa* grad T + mu* (T/n) grad n)
// Terms that grow with zeta* arise because the unit of speed decreases.

/// Coefficients zeta*, eta*, kappa*, mu* and R = 2 pi K rho_0^2 l_0^2 / (n_0 T_h). `src/theory/stability.hpp` computes
/// them from the restitution coefficient, K, density and charge.
struct Gas {
  double cooling = 0, viscosity = 0, conduction = 0, density_conduction = 0;
  double charge_number = 0;   ///< R at tau = 0
  bool charges_last = false;  ///< True: charges are constant, so that R grows as 1/T_h; false: they decrease like the
                              ///< speed and R is constant, as in G 6.29
};

/// Square or cubic grid, periodic along all axes.
struct Grid {
  int dimension = 2;  ///< Number of dimensions: 2 or 3
  int cells = 0;      ///< Cells along an edge, at least 6
  double length = 0;  ///< Length of an edge, in l_0

  std::size_t size() const;  ///< Total number of cells
  double step() const { return length / cells; }
};

/// Fields of each cell, with the last axis fastest: in two dimensions cell (x, y) is at x * cells + y, with its centre
/// at (x + 1/2) h.
struct Fields {
  std::vector<double> density, temperature, charge;  ///< n, T, c
  std::array<std::vector<double>, 3> velocity;       ///< u, one component per dimension
};

/// Returns a homogeneous gas at rest. Density n, temperature T and charge density c are 1.
Fields homogeneous(const Grid& grid);

/// Options of `evolve`.
struct EvolveOptions {
  double tolerance = 1e-5;  ///< Error tolerance of a step
  std::function<void(double tau)> report =
      {};  ///< Called with each time at which rates are computed, to report progress
};

/// Returns the fields at these times tau (ascending, >= 0). The mean velocity is subtracted at the start. Sums of
/// density, charge and momentum are conserved to rounding. T is always positive, and n as long as it is resolved.
/// Results are bitwise identical for any number of threads. Throws InputError for an invalid grid or invalid fields,
/// Failure if a step cannot reach its tolerance.
std::vector<Fields> evolve(const Gas& gas, const Grid& grid, const Fields& start, std::span<const double> times,
                           const EvolveOptions& options = {}, parallel::Team& team = parallel::Team::single());

}  // namespace lichtenberg::granular_flow
