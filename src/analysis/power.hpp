#pragma once

#include <optional>
#include <span>

#include "src/effects/conductor_frame.hpp"
#include "src/scene/scene.hpp"

namespace lichtenberg::analysis {

/// Powers and energies at an instant (W, J), as far as they follow from a frame and its scene.
struct Power {
  /// Power of current injection, where each current enters at the conductor's potential, sum_i J_i phi_i.
  double source = 0;
  double drag = 0;     ///< heat of drag, sum_i 6 pi eta R_i v_i^2 for Stokes drag
  double field = 0;    ///< work of the field's forces, sum_i F_i . v_i
  double kinetic = 0;  ///< J, kinetic energy
  /// Energy (J) that effects store: contacts of bodies and walls, and weight
  double elastic = 0;
};

/// Computes the powers and energies at the instant of a frame. `mass`: kg, [N].
Power power(const Scene& scene, const ConductorFrame& frame, std::span<const double> mass);

/// Computes the mean dissipated power (W) between two frames from the energy balance: the source's energy minus the
/// increase of the stored energy. With the source's power P, field energy W, kinetic energy K and elastic energy H it
/// is
///
///   (P_1 + P_2) / 2 - (W_2 - W_1 + K_2 - K_1 + H_2 - H_1) / (t_2 - t_1).
///
/// The result includes all irreversible losses: drag, and sparks when conductors make contact. The source's power is
/// assumed to change linearly between frames, although potentials jump at a contact. The error therefore decreases with
/// the interval. Empty if an electrode, a side or a group has a prescribed potential other than 0: frames do not
/// contain the energy of its source. Empty also if no time passes.
std::optional<double> dissipated_power(const Scene& scene, const ConductorFrame& before, const Power& power_before,
                                       const ConductorFrame& after, const Power& power_after);

}  // namespace lichtenberg::analysis
