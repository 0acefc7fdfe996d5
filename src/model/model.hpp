#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "src/model/effect.hpp"

namespace lichtenberg {

/// Bodies and the effects that act on them. Charges and a neighbour list exist only if an effect needs them.
struct Model {
  /// `charge`: C, [N]; taken over only if an effect needs charges.
  Model(Bodies bodies, std::vector<std::unique_ptr<Effect>> effects, const std::vector<double>& charge);

  Bodies bodies;
  std::vector<std::unique_ptr<Effect>> effects;
  std::optional<NeighbourList> neighbours;

  /// Sum of all forces on the bodies as they are (N, [N * dimension], overwritten).
  void forces(double time, std::span<double> force);
  /// The derivatives of the same sum (overwritten).
  void jacobian(double time, ForceJacobian& jacobian);
  /// Sum of all currents fed into the bodies (A, [N], overwritten).
  void currents(double time, std::span<double> current);

  /// Sum of the energies that the effects have stored (J).
  double stored_energy(double time);
  /// Sum of m v^2 / 2 (J).
  double kinetic_energy() const;

  /// The least of the effects' Needs::largest_move as a length (m); infinite if none sets one.
  double largest_move() const;

  /// The effect of type E, or null if it is not in the scene.
  template <class E>
  E* find() const {
    for (const auto& effect : effects)
      if (auto* found = dynamic_cast<E*>(effect.get())) return found;
    return nullptr;
  }

 private:
  State state(double time);
};

}  // namespace lichtenberg
