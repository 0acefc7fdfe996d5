#pragma once

#include <vector>

#include "solvers/periodic/charge_mesh.hpp"
#include "solvers/periodic/near.hpp"
#include "solvers/periodic/sum.hpp"

namespace lichtenberg::periodic {

/// Coulomb sums of charges by a near part, pair by pair, and a smooth part on a mesh (Hockney and Eastwood 1988): the
/// work grows with N log N. Potential, field and force are what its energy says, but for the mean force of the mesh,
/// which is taken off: the net force is 0. `choose_mesh` finds parameters for an accuracy.
class ParticleMesh : public Sum {
 public:
  /// Throws InputError where ChargeMesh or NearPart do.
  ParticleMesh(const Mesh& mesh, const Cloud& cloud);

  double cutoff() const override { return near_.cutoff(); }
  /// Throws InputError if the box is not the mesh's, if there are dipoles, or if the energy is no number, as it is for
  /// charges at the same place.
  void evaluate(const Sources& sources, std::span<const Pair> pairs, parallel::Team& team, Response& response) override;

 private:
  void require_usable(const Sources& sources) const;

  Vec3 lengths_;
  NearPart near_;
  ChargeMesh mesh_;
  Tiles tiles_;
  std::vector<double> sum_;  ///< FieldAndPotential, in the order of the tiles
};

}  // namespace lichtenberg::periodic
