#pragma once

namespace lichtenberg::theory {

/// A circular conductor between two unbounded plates in two dimensions, a strip of width `distance`: the
/// two-dimensional shuttle. The plates are at +voltage/2 (x = -distance/2) and -voltage/2 (x = distance/2). Charges and
/// forces are per metre of depth.
struct DiskBetweenPlates {
  double radius = 0;        ///< m
  double distance = 0;      ///< m, between the plates
  double voltage = 0;       ///< V
  double permittivity = 0;  ///< F/m

  double field() const { return voltage / distance; }      ///< V/m, far from the disk
  double travel() const { return distance - 2 * radius; }  ///< m, displacement of the disk from plate to plate
  /// m, x at which the gap to the plate ahead is `gap`
  double position_at_gap(double gap) const { return 0.5 * travel() - gap; }
};

/// Returns the charge (C/m) of a disk at the potential of a plate, `gap` (m) away from it, with the other plate far
/// away:
///
///   2 pi eps E sqrt(h^2 - R^2) / acosh(h / R),  h = R + gap.
///
/// The charge is 2 pi eps R E at contact and increases by the fraction gap / 3R (by reciprocity from the bipolar field,
/// D 6.37).
double charge_near_plate(const DiskBetweenPlates& disk, double gap);

/// Returns the force (N/m) with which a plate repels a disk that touches it, with the other plate far away: eps R E^2
/// (pi^3/9 + pi/3). It follows by residues from the complex potential pi R E coth(pi R / z) of a disk tangent to a
/// line.
double repulsion_at_plate(const DiskBetweenPlates& disk);

/// Returns the force (N/m) toward x on a line charge (C/m) on the disk's axis instead of the disk. This is D 4.3 in two
/// dimensions, charge E + charge^2 / (4 eps H) tan(pi x / H).
double line_charge_force(const DiskBetweenPlates& disk, double charge, double x);

/// Charge, potential and force of the disk at x (m from the middle), to seven digits. The surface charge solves the
/// integral equation with the strip's Green function G = ln |sin(pi (z + z'*) / 2H) / sin(pi (z - z') / 2H)| / 2 pi.
/// The quadrature for logarithmic kernels is that of Kress; the smaller gap determines the number of points.
/// The functions below throw InputError unless there is a gap to both plates.
struct DiskState {
  double charge = 0;     ///< C/m
  double potential = 0;  ///< V
  double force = 0;      ///< N/m, toward x
};
DiskState with_charge(const DiskBetweenPlates& disk, double x, double charge);
DiskState at_potential(const DiskBetweenPlates& disk, double x, double potential);

}  // namespace lichtenberg::theory
