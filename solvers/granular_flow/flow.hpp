#pragma once

#include <array>
#include <cstddef>
#include <functional>
#include <span>
#include <vector>

#include "solvers/parallel/team.hpp"

namespace lichtenberg::granular_flow {

// The hydrodynamic equations of a dilute gas of grains that cool and carry charges (G 6.26 without its slips), in the
// scales of the gas that is homogeneous and cools: density n_0, temperature T_h(t), speed v_h = sqrt(2 T_h / m), charge
// density rho_0, length l_0, time t_0(t) = l_0 / v_h. With its own time d tau = dt / t_0(t), u = V / v_h, c = rho_q /
// rho_0 and s = eta* sqrt(T) (grad u + grad u' - (2/3) div u 1):
//   dn/dtau + div(n u) = 0,   dc/dtau + div(c u) = 0,   lap psi = -(c - mean c)
//   d(n u)/dtau + div(n u u + (n T/2) 1 - s) = (zeta*/4) n u - R c grad psi
//   de/dtau + div((e + n T) u - 2 s.u - q) = (zeta*/2) e - (3 zeta*/4) n^2 T^(3/2) - 2 R c u.grad psi
//   e = (3/2) n T + n u^2,   q = (15/4) sqrt(T) (kappa* grad T + mu* (T/n) grad n)
// What grows by zeta* does so because it is measured by a speed that falls.

/// zeta*, eta*, kappa*, mu* and R = 2 pi K rho_0^2 l_0^2 / (n_0 T_h), which `src/theory/stability.hpp` has by
/// restitution and by K, density and charge.
struct Gas {
  double cooling = 0, viscosity = 0, conduction = 0, density_conduction = 0;
  double charge_number = 0;   ///< R at tau = 0
  bool charges_last = false;  ///< so that R grows as 1/T_h; else they fade as the speed does and R stays, as in G 6.29
};

/// A square or a cube, periodic in all its directions.
struct Grid {
  int dimension = 2;  ///< 2 or 3
  int cells = 0;      ///< along an edge, 6 at least
  double length = 0;  ///< of an edge, l_0

  std::size_t size() const;  ///< cells in all
  double step() const { return length / cells; }
};

/// Of each cell, the last direction fastest: of a plane's cell (x, y) at x * cells + y, whose centre is at (x + 1/2) h.
struct Fields {
  std::vector<double> density, temperature, charge;  ///< n, T, c
  std::array<std::vector<double>, 3> velocity;       ///< u, as many of them as there are dimensions
};

/// A gas at rest, n = T = c = 1.
Fields homogeneous(const Grid& grid);

/// How `evolve` goes.
struct Course {
  double tolerance = 1e-5;                  ///< of a step
  std::function<void(double tau)> at = {};  ///< told every time at which rates are asked for, to show how far it is
};

/// The fields at these times tau (rising, >= 0). Velocities are relative to the gas as a whole: at the start its mean
/// is taken off. Sums of density, charge and momentum stay to rounding, T is positive whatever happens, n as long as it
/// is resolved. The same bits for any number of threads. Throws InputError for a grid or fields that cannot be, Failure
/// if a step cannot reach its tolerance.
std::vector<Fields> evolve(const Gas& gas, const Grid& grid, const Fields& start, std::span<const double> times,
                           const Course& course = {}, parallel::Team& team = parallel::Team::single());

}  // namespace lichtenberg::granular_flow
