#pragma once

#include <memory>
#include <string>
#include <vector>

#include "src/model/motion.hpp"
#include "src/scene/scene.hpp"

namespace lichtenberg {

/// Declaration of how the bodies of one kind of scene move.
struct MotionKind {
  /// Returns true for scenes of this kind.
  bool (*takes)(const Scene&);
  std::unique_ptr<Motion> (*make)(const Scene&);
  /// Throws InputError if the scene's device cannot run it. Null: nothing to check.
  void (*check_device)(const Scene&) = nullptr;
  /// Returns a warning about a scene; empty if there is none. Null: never one.
  std::string (*warning)(const Scene&) = nullptr;
};

/// Returns the kinds of motion of this program. The first that takes a scene moves its bodies.
const std::vector<MotionKind>& motion_kinds();

/// Returns the motion of conductors, which takes each scene.
MotionKind conductor_motion();

/// Throws InputError if a scene of conductors or a packing is for a CUDA device but has no field, which alone such a
/// device computes.
void check_field_device(const Scene& scene);

}  // namespace lichtenberg
