#pragma once

#include "solvers/geometry/shape.hpp"

namespace lichtenberg::theory {

/// Pair of circular conductors in the unbounded plane, with charges +Q and -Q (per metre of depth). Their field is the
/// bipolar field of two line charges, +Q and -Q, inside them (the circles are circles of Apollonius of the two points).
/// Equal disks are the case of Stephenson 2018, D 6.5.4 (figure 6.4).
struct DiskPair {
  Disk positive;            ///< Disk with the charge +Q
  Disk negative;            ///< Disk with the charge -Q
  double permittivity = 0;  ///< Permittivity (F/m); must be set
};

/// Computes the capacitance of the pair, Q / (phi_positive - phi_negative) (F/m): 2 pi eps / acosh((d^2 - R1^2 - R2^2)
/// / (2 R1 R2)) for radii R1, R2 and distance d of the centres. For equal disks it is pi eps / acosh(d / 2R) (D 6.37).
double capacitance(const DiskPair& pair);

/// Computes the potential (V) at p (m) for the charge `charge` (C/m) of the disk `positive`. Outside the disks it is Q
/// / (2 pi eps) ln(r- / r+) with the distances r- and r+ from the line charges. It is zero at infinity and on the
/// perpendicular bisector of the line charges. Inside a disk it is the potential of the surface.
double potential(const DiskPair& pair, double charge, Vec2 p);

/// Computes the potential (V) of the disk `positive`, with the zero of potential().
double positive_potential(const DiskPair& pair, double charge);
/// Computes the potential (V) of the disk `negative`, with the zero of potential().
double negative_potential(const DiskPair& pair, double charge);

/// Computes the force (N/m) on the disk `positive`; the force on `negative` is opposite. The stress on any plane
/// between the disks is that of the line charges. The force is therefore their attraction Q^2 / (2 pi eps 2a), with 2a
/// their distance.
Vec2 force(const DiskPair& pair, double charge);

/// Computes the decay rate lambda of the error (per iteration, D 6.38) in the gradient descent of the relaxation
/// method. One group of self-capacitance C = `capacitance` floats, and the step is eta. Each step multiplies the
/// missing charge by 1 - eta C and the error by its square, so lambda = -2 ln|1 - eta C|.
double error_decay_rate(double eta, double capacitance);

/// Computes the decay rate of the error for eta C << 1: 2 eta C (D 6.39).
double small_step_decay_rate(double eta, double capacitance);

}  // namespace lichtenberg::theory
