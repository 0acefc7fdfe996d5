#pragma once

#include <optional>
#include <span>
#include <vector>

#include "src/effects/conductor_frame.hpp"
#include "src/scene/scene.hpp"

namespace lichtenberg::analysis {

/// Where the energy goes at an instant (W, J), as far as a frame and its scene tell.
struct Power {
  /// Of what feeds currents into conductors: each brings its current at the conductor's potential, sum_i J_i phi_i.
  double source = 0;
  double drag = 0;     ///< heat of drag, sum_i 6 pi eta R_i v_i^2 of Stokes's
  double field = 0;    ///< what the field's forces do, sum_i F_i . v_i
  double kinetic = 0;  ///< J, energy of motion
  double elastic = 0;  ///< J, stored by effects, in contacts with each other and with walls, by weight
};

/// `mass`: kg, [N].
Power power(const Scene& scene, const ConductorFrame& frame, std::span<const double> mass);

/// Power dissipated between two frames, on average (W): what the source brought less what field, motion and elastic
/// contacts took up,
///   (P_1 + P_2) / 2 - (W_2 - W_1 + K_2 - K_1 + H_2 - H_1) / (t_2 - t_1).
/// All that does not come back is in it: drag, and sparks when conductors make contact. The source's power is taken to
/// change linearly from frame to frame, though potentials jump at a contact: the shorter the interval, the better.
/// Empty if an electrode, a side or a group is held at another potential than 0, because its supply then gives or takes
/// energy that frames do not tell, or if no time passes.
std::optional<double> dissipated_power(const Scene& scene, const ConductorFrame& before, const Power& power_before,
                                       const ConductorFrame& after, const Power& power_after);

}  // namespace lichtenberg::analysis
