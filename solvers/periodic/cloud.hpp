#pragma once

#include <functional>

namespace lichtenberg::periodic {

/// Charge cloud that replaces a point charge in the smooth part of a split sum. The near part is the remainder, 1/r
/// minus the cloud's potential, and is neglected beyond `cutoff`.
struct Cloud {
  double cutoff = 0;
  std::function<double(double)> potential;  ///< Potential of a unit cloud at distance r from its centre; finite at r =
                                            ///< 0
  std::function<double(double)> transform;  ///< Fourier transform of a unit cloud at wave number k; 1 at k = 0
  double band_limit = 0;                    ///< Wave number beyond which the transform is taken as 0; infinite if it
                                            ///< never is
  double background = 0;                    ///< Integral of the near part over all space
  double dipole_field = 0;                  ///< Field of a unit dipole's cloud at its centre, opposite to the dipole:
                                            ///< -potential''(0)
  double neglected = 0;  ///< Integral over space of the square of the neglected force between unit charges
  double neglected_slope = 0, neglected_curvature = 0;  ///< Integrals of the squared first and second derivatives of
                                                        ///< the neglected force, for dipoles
};

/// Makes Ewald's cloud, exp(-alpha^2 r^2), whose near part is erfc(alpha r) / r. The neglected force is that beyond the
/// cut-off (Kolafa and Perram 1992, eq. 18). Throws InputError unless both arguments are positive.
Cloud gauss_cloud(double alpha, double cutoff);

/// Makes the cloud that ends at the cut-off and has the least transform beyond band_limit / cutoff. Its density,
/// integrated over planes, is the prolate spheroidal wave function psi_0 of that band limit (Osipov, Rokhlin and Xiao
/// 2013). The neglected force is that of waves beyond the band limit. Throws InputError unless the band limit is from 1
/// to 100 and the cut-off positive.
Cloud prolate_cloud(double band_limit, double cutoff);

}  // namespace lichtenberg::periodic
