#pragma once

#include <functional>

namespace lichtenberg::periodic {

/// What a charge is taken for where a sum is split: a cloud of its size, smooth enough for a mesh. The rest, 1/r minus
/// the cloud's potential, is near: it is left out beyond `cutoff`.
struct Cloud {
  double cutoff = 0;
  std::function<double(double)> potential;  ///< of a unit cloud, at distance r of its centre; finite at r = 0
  std::function<double(double)> transform;  ///< of a unit cloud, at wave number k: 1 at k = 0
  double band_limit = 0;                    ///< the transform is taken for 0 where k is larger; infinite if it never is
  double background = 0;                    ///< integral of the near rest over all space
  double dipole_field = 0;                  ///< in the middle of its own cloud, against it, by moment: -potential''(0)
  double lost = 0;  ///< integral over space of the square of the force between unit charges that is left out
  double lost_slope = 0, lost_curvature = 0;  ///< of the squares of that force's first and second derivatives, which
                                              ///< dipoles feel and make
};

/// Ewald's: exp(-alpha^2 r^2), whose near rest is erfc(alpha r) / r. What is lost lies beyond the cutoff (Kolafa and
/// Perram 1992, eq. 18). Throws InputError.
Cloud gauss_cloud(double alpha, double cutoff);

/// The cloud that ends at the cutoff and has least of its transform beyond band_limit / cutoff: across any plane its
/// density, summed, is the prolate spheroidal wave function psi_0 of that band limit (Osipov, Rokhlin and Xiao 2013).
/// What is lost lies beyond the band limit. Band limits from 1 to 100. Throws InputError.
Cloud prolate_cloud(double band_limit, double cutoff);

}  // namespace lichtenberg::periodic
