#pragma once

#include <vector>

#include "solvers/periodic/charge_mesh.hpp"
#include "solvers/periodic/near.hpp"
#include "solvers/periodic/sum.hpp"

namespace lichtenberg::periodic {

/// Coulomb sums by a near part, pair by pair, and a smooth part on a mesh (Hockney and Eastwood 1988): the work grows
/// with N log N. Potential, field and force are what its energy says, but for the mean force of the mesh, which is
/// taken off the forces: they add up to 0. `choose_mesh` finds parameters for an accuracy.
class ParticleMesh : public Sum {
 public:
  /// Throws InputError where ChargeMesh or NearPart do.
  ParticleMesh(const Mesh& mesh, const Cloud& cloud);

  double cutoff() const override { return near_.cutoff(); }
  /// Throws InputError if the box is not the mesh's, if there are dipoles and the splines' order is below
  /// lowest_dipole_order, or if the energy is no number, as it is for sources at the same place.
  void evaluate(const Sources& sources, std::span<const Pair> pairs, parallel::Team& team, Response& response) override;
  /// Takes about as long as the field of charges.
  void dipole_field(const Sources& sources, std::span<const Pair> pairs, parallel::Team& team,
                    std::span<double> field) override;
  SumSeconds seconds() const override { return seconds_; }

 private:
  void require_usable(const Sources& sources) const;
  void sum(const Sources& sources, std::span<const Pair> pairs, Kind kind, parallel::Team& team);

  Vec3 lengths_;
  NearPart near_;
  ChargeMesh mesh_;
  Tiles tiles_;
  std::vector<double> field_, force_;  ///< FeltSums
  SumSeconds seconds_;
};

}  // namespace lichtenberg::periodic
