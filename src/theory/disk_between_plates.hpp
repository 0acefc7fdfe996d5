#pragma once

namespace lichtenberg::theory {

/// A circular conductor between two unbounded plates in the plane, a strip of width `distance`: the two-dimensional
/// shuttle. Plates at +voltage/2 (x = -distance/2) and -voltage/2 (x = distance/2); charges and forces per metre of
/// depth.
struct DiskBetweenPlates {
  double radius = 0;        ///< m
  double distance = 0;      ///< m, between the plates
  double voltage = 0;       ///< V
  double permittivity = 0;  ///< F/m

  double field() const { return voltage / distance; }           ///< V/m, far from the disk
  double way() const { return distance - 2 * radius; }          ///< m, the disk's, from plate to plate
  double place(double gap) const { return 0.5 * way() - gap; }  ///< m: x at which `gap` is left to the plate ahead
};

/// Charge (C/m) of a disk at the potential of a plate, `gap` (m) away from it, the other plate far away:
///   2 pi eps E sqrt(h^2 - R^2) / acosh(h / R),  h = R + gap,
/// which is 2 pi eps R E at contact and grows by gap / 3R of itself (by reciprocity from the bipolar field, D 6.37).
double charge_near_plate(const DiskBetweenPlates& disk, double gap);

/// Force (N/m) with which a plate repels a disk that touches it, the other plate far away: eps R E^2 (pi^3/9 + pi/3).
/// By residues from the complex potential pi R E coth(pi R / z) of a disk tangent to a line.
double repulsion_at_plate(const DiskBetweenPlates& disk);

/// Force (N/m) toward x on a charge (C/m) on the disk's axis, in place of the disk: what D 4.3 is in two dimensions,
///   charge E + charge^2 / (4 eps H) tan(pi x / H).
double line_charge_force(const DiskBetweenPlates& disk, double charge, double x);

/// What the disk at x (m from the middle) holds and feels, exactly: its surface charge from the integral equation with
/// the strip's Green function (G = ln |sin(pi (z + z'*) / 2H) / sin(pi (z - z') / 2H)| / 2 pi), by Kress's quadrature
/// for logarithmic kernels, in as many points as the nearest gap needs for seven digits. Throws InputError unless there
/// is a gap to both plates.
struct DiskState {
  double charge = 0;     ///< C/m
  double potential = 0;  ///< V
  double force = 0;      ///< N/m, toward x
};
DiskState with_charge(const DiskBetweenPlates& disk, double x, double charge);
DiskState at_potential(const DiskBetweenPlates& disk, double x, double potential);

}  // namespace lichtenberg::theory
