#pragma once

#include <vector>

#include "solvers/periodic/charge_mesh.hpp"
#include "solvers/periodic/near.hpp"
#include "solvers/periodic/sum.hpp"

namespace lichtenberg::periodic {

/// Particle-mesh Ewald method (P3M) for periodic Coulomb sums: a near part, pair by pair, and a smooth part on a mesh
/// by FFT (Hockney and Eastwood 1988). At constant density the work grows with N log N. evaluate() finds the pairs
/// itself; choose_mesh() finds parameters for an accuracy.
/// Potential, field and force are derivatives of one energy. The net force due to the mesh is subtracted from the
/// forces, in shares proportional to the squared charges. Forces therefore add up to 0. Single precision supports
/// charges only, and adds a relative error of about error_of_single_precision to the forces. It rounds positions to
/// 2^-32 of the box, and the last digits of its results depend on the processor's instructions.
template <class Real>
class MeshSum : public Sum {
 public:
  /// Makes a mesh sum for a mesh and a charge cloud, which splits 1/r. Throws the exceptions of ChargeMesh and Near.
  MeshSum(const Mesh& mesh, const Cloud& cloud);

  double cutoff() const override { return 0; }
  /// Computes potentials, fields, forces and energy; `pairs` is not used. Throws InputError if the box is not the
  /// mesh's, and for dipoles in single precision or with windows below lowest_dipole_order. Throws InputError if the
  /// energy is not finite, as for two sources at the same position. Throws Failure if a position is not finite.
  void evaluate(const Sources& sources, std::span<const Pair> pairs, parallel::Team& team, Response& response) override;
  /// Computes the forces of evaluate() [3 N] at lower cost, without the potentials of near pairs. Throws the exceptions
  /// of evaluate().
  void forces(const Sources& sources, std::span<const Pair> pairs, parallel::Team& team,
              std::vector<double>& force) override;
  /// Computes the field [3 N] of the dipoles alone, at about the cost of the field of charges.
  void dipole_field(const Sources& sources, std::span<const Pair> pairs, parallel::Team& team,
                    std::span<double> field) override;
  SumSeconds seconds() const override { return seconds_; }

 private:
  void require_usable(const Sources& sources) const;
  void compute(const Sources& sources, Kind kind, bool potentials, parallel::Team& team);
  void fill(const Sources& sources, parallel::Team& team, std::vector<double>& force, Response* rest);
  std::array<double, 5> totals_of(const Sources& sources, int first, int end) const;
  struct Acting;
  Acting acting_on(const Sources& sources, int i) const;

  Vec3 lengths_;
  Near<Real> near_;
  ChargeMesh<Real> mesh_;
  Columns<Real> columns_;
  std::vector<Real> field_, force_;  ///< Storage of FieldSums
  SumSeconds seconds_;
};

using ParticleMesh = MeshSum<double>;
using SingleMesh = MeshSum<float>;

}  // namespace lichtenberg::periodic
