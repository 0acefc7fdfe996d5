#pragma once

#include <algorithm>
#include <span>
#include <vector>

#include "solvers/geometry/vec.hpp"

namespace lichtenberg::periodic {

/// Kind of sources that a sum takes into account.
enum class Kind {
  charges,     ///< Field and potential of charges
  dipoles,     ///< Field of dipoles alone: charges are taken as 0, and potentials are undefined
  multipoles,  ///< Field, potential and force of charges with dipoles
};

/// Sources of periodic Coulomb sums: point charges, and point dipoles if any, in a box that is periodic along all axes
/// and surrounded by a conductor ("tin-foil" boundary). A uniform background neutralizes a box whose charges do not add
/// up to zero. Short-range sums (short_range.hpp) leave out background and conductor. Units of length and charge are
/// arbitrary; Coulomb's constant is 1.
struct Sources {
  Vec3 lengths;                      ///< Lengths of the box
  std::span<const double> position;  ///< [3 N]; any image of a source may be given
  std::span<const double> charge;    ///< [N]
  std::span<const double> dipole{};  ///< [3 N]; empty: no dipoles

  /// Returns the number of sources.
  int size() const { return static_cast<int>(charge.size()); }
  /// Returns the position of source i.
  Vec3 position_of(int i) const { return {position[3 * i], position[3 * i + 1], position[3 * i + 2]}; }
  double volume() const { return lengths.x * lengths.y * lengths.z; }
  double shortest_length() const { return std::min({lengths.x, lengths.y, lengths.z}); }
};

/// Checks sources: throws InputError unless the lengths of the box are positive and finite and the array sizes match.
void require_consistent(const Sources& sources);

/// Results of a periodic Coulomb sum at the sources. In a full sum each source is subject to all others, their images,
/// its own images and the background.
struct Response {
  std::vector<double> potential;  ///< [N], at the sources
  std::vector<double> field;      ///< [3 N], at the sources
  std::vector<double> force;      ///< [3 N]: charge times field, plus (dipole . grad) field
  double energy = 0;  ///< Energy of fixed charges and dipoles: 1/2 sum (charge * potential - dipole . field)
};

}  // namespace lichtenberg::periodic
