#pragma once

#include <algorithm>
#include <span>
#include <vector>

#include "solvers/geometry/vec.hpp"

namespace lichtenberg::periodic {

/// Properties of sources that a sum takes into account.
enum class Kind {
  charges,     ///< field and potential of charges
  dipoles,     ///< field of dipoles alone: charges are taken for 0, and potentials are undefined
  multipoles,  ///< field, potential and force of charges with dipoles
};

/// Point charges, and point dipoles if there are any, in a box that is periodic on all its sides and surrounded by a
/// conductor ("tin-foil" boundary). A box whose charges do not add up to zero is filled with the uniform background
/// that makes it neutral. Units: any of length and charge, with Coulomb's constant 1.
struct Sources {
  Vec3 lengths;                      ///< of the box
  std::span<const double> position;  ///< [3 N]; any image of a source stands for it
  std::span<const double> charge;    ///< [N]
  std::span<const double> dipole{};  ///< [3 N]; empty: there are none

  int size() const { return static_cast<int>(charge.size()); }
  Vec3 place(int i) const { return {position[3 * i], position[3 * i + 1], position[3 * i + 2]}; }
  double volume() const { return lengths.x * lengths.y * lengths.z; }
  double shortest_length() const { return std::min({lengths.x, lengths.y, lengths.z}); }
};

/// Throws InputError unless the lengths of the box are positive numbers and those of the arrays fit each other.
void require_consistent(const Sources& sources);

/// What the sources do to each other: each feels all others, their images, its own images and the background.
struct Response {
  std::vector<double> potential;  ///< [N], at the sources
  std::vector<double> field;      ///< [3 N], at the sources
  std::vector<double> force;      ///< [3 N]: charge times field, and (dipole . grad) field
  double energy = 0;  ///< of charges and dipoles held as they are: 1/2 sum (charge * potential - dipole . field)
};

}  // namespace lichtenberg::periodic
