#pragma once

#include "solvers/geometry/shape.hpp"

namespace lichtenberg::theory {

/// Two circular conductors in the unbounded plane, with charges +Q and -Q (per metre of depth). Their field is that of
/// two line charges, +Q and -Q, inside them (the circles of Apollonius of the two points): the bipolar field. Equal
/// disks are the case of D 6.5.4 (figure 6.4).
struct DiskPair {
  Disk positive;            ///< carries +Q
  Disk negative;            ///< carries -Q
  double permittivity = 0;  ///< F/m; has to be given
};

/// Capacitance Q / (phi_positive - phi_negative), F/m: 2 pi eps / acosh((d^2 - R1^2 - R2^2) / (2 R1 R2)), which for
/// equal disks is pi eps / acosh(d / 2R) (D 6.37).
double capacitance(const DiskPair& pair);

/// Potential (V) at p outside the disks when the charge of `positive` is `charge` (C/m); zero at infinity and on the
/// perpendicular bisector of the line charges: Q / (2 pi eps) ln(r- / r+), inside a disk the constant of its surface.
double potential(const DiskPair& pair, double charge, Vec2 p);

/// Potentials (V) of the disks' surfaces, same zero.
double positive_potential(const DiskPair& pair, double charge);
double negative_potential(const DiskPair& pair, double charge);

/// Force (N/m) on `positive`; on `negative` it is the opposite. The attraction of the two line charges,
/// Q^2 / (2 pi eps 2a) with 2a their distance: the stress on any plane between the disks sees only them.
Vec2 force(const DiskPair& pair, double charge);

/// Rate lambda (D 6.38, per iteration) at which the error falls when one group of self-capacitance `capacitance`
/// floats: each step multiplies the missing charge by 1 - eta C, the error by its square, so lambda = -2 ln|1 - eta C|.
double error_decay_rate(double eta, double capacitance);

/// That rate for eta C << 1: 2 eta C (D 6.39).
double small_step_decay_rate(double eta, double capacitance);

}  // namespace lichtenberg::theory
