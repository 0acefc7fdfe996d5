#pragma once

#include "solvers/geometry/shape.hpp"

namespace lichtenberg::theory {

/// Two circular conductors in the unbounded plane, with charges +Q and -Q (per metre of depth). Their field is the
/// bipolar field of two line charges, +Q and -Q, inside them (the circles are circles of Apollonius of the two points).
/// Equal disks are the case of D 6.5.4 (figure 6.4).
struct DiskPair {
  Disk positive;            ///< carries +Q
  Disk negative;            ///< carries -Q
  double permittivity = 0;  ///< F/m; must be set
};

/// Returns the capacitance Q / (phi_positive - phi_negative), F/m: 2 pi eps / acosh((d^2 - R1^2 - R2^2) / (2 R1 R2)).
/// For equal disks it is pi eps / acosh(d / 2R) (D 6.37).
double capacitance(const DiskPair& pair);

/// Returns the potential (V) at p for the charge `charge` (C/m) of `positive`. Outside the disks it is Q / (2 pi eps)
/// ln(r- / r+), zero at infinity and on the perpendicular bisector of the line charges. Inside a disk it is the
/// potential of the surface.
double potential(const DiskPair& pair, double charge, Vec2 p);

/// Potentials (V) of the disks' surfaces, with the same zero.
double positive_potential(const DiskPair& pair, double charge);
double negative_potential(const DiskPair& pair, double charge);

/// Returns the force (N/m) on `positive`; the force on `negative` is opposite. The stress on any plane between the
/// disks is that of the line charges. The force is therefore their attraction Q^2 / (2 pi eps 2a), with 2a their
/// distance.
Vec2 force(const DiskPair& pair, double charge);

/// Returns the rate lambda (D 6.38, per iteration) at which the error decreases when one group of self-capacitance
/// `capacitance` floats. Each step multiplies the missing charge by 1 - eta C and the error by its square, so lambda =
/// -2 ln|1 - eta C|.
double error_decay_rate(double eta, double capacitance);

/// Returns that rate for eta C << 1: 2 eta C (D 6.39).
double small_step_decay_rate(double eta, double capacitance);

}  // namespace lichtenberg::theory
