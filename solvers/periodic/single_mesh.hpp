#pragma once

#include <vector>

#include "solvers/periodic/single_charge_mesh.hpp"
#include "solvers/periodic/single_near.hpp"
#include "solvers/periodic/sum.hpp"

namespace lichtenberg::periodic {

/// What ParticleMesh does with charges, in single precision and without pairs from outside: several times faster, good
/// for relative errors of single_precision and more. Places and charges are rounded to 2^-32 of the box and to single
/// precision; which instructions the processor has changes the last digits of the result.
class SingleMesh : public Sum {
 public:
  /// For about so many charges. Throws InputError where ChargeMesh and SingleNear do, and for a cut-off longer than
  /// SingleNear::longest_cutoff.
  SingleMesh(const Mesh& mesh, const Cloud& cloud, int charges);

  double cutoff() const override { return 0; }
  /// Throws InputError if the box is not the mesh's, for dipoles, and if the energy is no number, as it is for charges
  /// at the same place.
  void evaluate(const Sources& sources, std::span<const Pair> pairs, parallel::Team& team, Response& response) override;
  /// Without the potentials of near pairs. Throws what `evaluate` throws.
  void forces(const Sources& sources, std::span<const Pair> pairs, parallel::Team& team,
              std::vector<double>& force) override;
  SumSeconds seconds() const override { return seconds_; }

 private:
  void require_usable(const Sources& sources) const;
  void compute(const Sources& sources, bool potentials, parallel::Team& team);
  void fill(const Sources& sources, parallel::Team& team, std::vector<double>& force, Response* rest);

  Vec3 lengths_;
  double cutoff_;
  SingleNear near_;
  SingleChargeMesh mesh_;
  Columns columns_;
  std::vector<float> sums_;  ///< field x, y, z and potential, four numbers of each sorted charge
  SumSeconds seconds_;
};

}  // namespace lichtenberg::periodic
