#pragma once

#include <functional>

namespace lichtenberg::periodic {

/// Splitting of the Coulomb potential 1/r by a charge cloud (screening function). In the smooth part of a sum, computed
/// on a mesh, the cloud replaces a point charge. The near part is the remainder, 1/r minus the cloud's potential; it is
/// neglected beyond `cutoff`. Lengths are in any unit, charges are 1.
struct Cloud {
  double cutoff = 0;                        ///< Cut-off of the near part (length)
  std::function<double(double)> potential;  ///< Potential of a unit cloud at the distance r; finite at r = 0
  std::function<double(double)> transform;  ///< Fourier transform of a unit cloud at wave number k; 1 at k = 0
  double band_limit = 0;                    ///< Wave number beyond which the transform is taken as 0; may be infinite
  double background = 0;                    ///< Integral of the near part over all space
  /// Field of a unit dipole's cloud at its centre, opposite to the dipole: -potential''(0).
  double dipole_field = 0;
  double neglected = 0;  ///< Integral over space of the square of the neglected force between unit charges
  /// Integrals of the squared first and second derivatives of the neglected force, for dipoles.
  double neglected_slope = 0, neglected_curvature = 0;
};

/// Makes Ewald's Gaussian cloud, with density proportional to exp(-alpha^2 r^2); its near part is erfc(alpha r) / r.
/// The neglected force is the near part beyond the cut-off (Kolafa and Perram 1992, eq. 18). Throws InputError unless
/// both arguments are positive.
Cloud gauss_cloud(double alpha, double cutoff);

/// Makes the cloud that ends at the cut-off and has the smallest transform beyond the wave number band_limit / cutoff.
/// Its density, integrated over planes, is the prolate spheroidal wave function psi_0 of that band limit (Osipov,
/// Rokhlin and Xiao 2013). The neglected force is that of waves beyond the band limit. Throws InputError unless the
/// band limit (without unit) is from 1 to 100 and the cut-off positive.
Cloud prolate_cloud(double band_limit, double cutoff);

}  // namespace lichtenberg::periodic
