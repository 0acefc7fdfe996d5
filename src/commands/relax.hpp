#pragma once

#include "src/record/recorder.hpp"
#include "src/scene/scene.hpp"

namespace lichtenberg {

/// The run of a scene with a contact potential: brings its particles to rest and records how. Prints a summary unless
/// `quiet`.
void relax(const Scene& scene, Recorder recorder, bool quiet);

}  // namespace lichtenberg
