#pragma once

#include <array>
#include <vector>

#include "solvers/periodic/cloud.hpp"
#include "solvers/periodic/influence.hpp"

namespace lichtenberg::periodic::device {

/// Terms of the near part's polynomials: what is not needed is 0.
constexpr int most_terms = 20;

/// The near part: with x = 2 (r / cutoff)^2 - 1 the field of a unit charge over r is r^-3 + sum slope[n] x^n, its
/// potential 1/r - sum value[n] x^n.
struct NearTable {
  float cutoff2 = 0, turn = 0;  ///< turn: 2 / cutoff^2
  float length[3] = {};         ///< of the box, over 2^32
  float slope[most_terms] = {}, value[most_terms] = {};
  int terms = 0;
};

/// The same between dipoles, of their own polynomial: B_1 = r^-3 + sum slope[n] x^n and B_0 as above, B_2 = 3 r^-5 +
/// sum second[n] x^n, B_3 = 15 r^-7 + sum third[n] x^n (../README.md).
struct MultipoleTable {
  NearTable charges;
  float second[most_terms] = {}, third[most_terms] = {};
};

/// What a mesh of charges is made of, from the CPU's parameters and functions.
struct MeshTables {
  Mesh mesh;
  NearTable near;
  MultipoleTable multipoles;  ///< without terms: there can be no dipoles
  std::vector<float> window;  ///< of t^d in the c-th weight: [d * order + c] (Weigher)
  std::vector<float> factor;  ///< of mode (x * points[1] + y) * (points[2] / 2 + 1) + z
  float over_spacing[3] = {};
  float self = 0;         ///< potential of a unit charge's own cloud
  float self_field = 0;   ///< field of a unit dipole's own cloud, against it
  double reach = 0;       ///< ChargeMesh::reach
  float wave[2][3] = {};  ///< Influence::self_wave, seen from the middle between two points
  double cutoff = 0;
  double background = 0;  ///< potential that a unit of total charge adds everywhere
};

/// Throws InputError where ParticleMesh does but that windows may be prolate, for charges alone, and for an accuracy
/// beyond single precision.
MeshTables make_tables(const Mesh& mesh, const Cloud& cloud);

}  // namespace lichtenberg::periodic::device
