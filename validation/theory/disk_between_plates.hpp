#pragma once

namespace lichtenberg::theory {

/// Model of the charge shuttle in two dimensions: a circular conductor between two unbounded parallel plates. The
/// plates are at +voltage/2 (x = -distance/2) and -voltage/2 (x = distance/2). Charges and forces are per metre of
/// depth.
struct DiskBetweenPlates {
  double radius = 0;        ///< Radius of the disk (m)
  double distance = 0;      ///< Distance of the plates (m)
  double voltage = 0;       ///< Voltage between the plates (V)
  double permittivity = 0;  ///< Permittivity (F/m)

  double field() const { return voltage / distance; }      ///< Field far from the disk (V/m)
  double travel() const { return distance - 2 * radius; }  ///< Displacement of the disk from plate to plate (m)
  /// Returns the position x (m) at which the gap to the plate ahead is `gap` (m).
  double position_at_gap(double gap) const { return 0.5 * travel() - gap; }
};

/// Computes the charge (C/m) of a disk at the potential of the plate at a distance `gap` (m), with the other plate far
/// away:
///
///   2 pi eps E sqrt(h^2 - R^2) / acosh(h / R),  h = R + gap.
///
/// The charge is 2 pi eps R E at contact and increases by the fraction gap / 3R (by reciprocity from the bipolar field,
/// D 6.37).
double charge_near_plate(const DiskBetweenPlates& disk, double gap);

/// Computes the force (N/m) with which a plate repels a disk that touches it, with the other plate far away: eps R E^2
/// (pi^3/9 + pi/3). It follows by residues from the complex potential pi R E coth(pi R / z) of a disk tangent to a
/// line.
double repulsion_at_plate(const DiskBetweenPlates& disk);

/// Computes the force (N/m) along x on a line charge (C/m) at x (m), in place of the disk, between the plates at a
/// distance H. It is the two-dimensional version of D 4.3: charge E + charge^2 / (4 eps H) tan(pi x / H).
double line_charge_force(const DiskBetweenPlates& disk, double charge, double x);

/// Charge, potential and force of the disk at a position between the plates, to seven digits. The surface charge solves
/// the boundary integral equation with the strip's Green function G = ln |sin(pi (z + z'*) / 2H) / sin(pi (z - z') /
/// 2H)| / 2 pi. The quadrature for logarithmic kernels is that of Kress; the smaller gap determines the number of
/// points.
struct DiskState {
  double charge = 0;     ///< Charge (C/m)
  double potential = 0;  ///< Potential (V)
  double force = 0;      ///< Force along x (N/m)
};
/// Computes the state of a disk with the given charge (C/m) at x (m from the middle). Throws InputError unless there is
/// a gap to both plates.
DiskState with_charge(const DiskBetweenPlates& disk, double x, double charge);
/// Computes the state of a disk with the given potential (V) at x (m from the middle). Throws InputError unless there
/// is a gap to both plates.
DiskState at_potential(const DiskBetweenPlates& disk, double x, double potential);

}  // namespace lichtenberg::theory
