#include "src/commands/start_from.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <vector>

#include "solvers/error.hpp"
#include "src/record/result.hpp"

namespace lichtenberg {
namespace {

int frame_of(const Result& result, std::optional<int> asked) {
  const int last = result.frames() - 1, frame = asked.value_or(last);
  if (frame < 0 || frame > last)
    throw InputError(fmt::format("--frame {} is not in {}: it has frames 0 to {}", frame, result.path(), last));
  return frame;
}

void check_bodies(const Result& result, const Scene& scene, const StopRequest& stop) {
  const std::vector<double> radius = result.radius();
  const auto refuse_it = [&](const std::string& why) {
    throw InputError(fmt::format("--from {}: {}; only the same bodies can start where those are", result.path(), why));
  };
  if (radius.size() != scene.conductors.size())
    refuse_it(fmt::format("it has {} bodies, {} has {}", radius.size(), scene.path, scene.conductors.size()));
  for (std::size_t i = 0; i < radius.size(); ++i)
    if (radius[i] != scene.conductors[i].radius)
      refuse_it(fmt::format("body {} has a radius of {:g}, in {} one of {:g}", i, radius[i], scene.path,
                            scene.conductors[i].radius));
  const Scene there = result.scene(effects::all_kinds(), stop);
  if (there.dimension() != scene.dimension() || there.reference.has_value() != scene.reference.has_value())
    refuse_it(fmt::format("it is of another kind of scene than {}", scene.path));
}

/// Row i of numbers that come `width` a body.
Vec3 vector_at(const std::vector<double>& numbers, std::size_t i) {
  return {numbers.at(3 * i), numbers.at(3 * i + 1), numbers.at(3 * i + 2)};
}

void set_charges(const std::vector<double>& charge, Scene& scene) {
  for (PrescribedGroup& wire : scene.groups) wire.charge = 0;
  for (std::size_t i = 0; i < charge.size(); ++i) {
    Conductor& conductor = scene.conductors[i];
    if (conductor.group < 0)
      conductor.charge = charge[i];
    else if (!scene.groups[conductor.group].potential)
      scene.groups[conductor.group].charge += charge[i];
  }
}

}  // namespace

void start_from(const std::string& path, std::optional<int> asked, Scene& scene, const StopRequest& stop) {
  const Result result(path);
  const int index = frame_of(result, asked);
  check_bodies(result, scene, stop);
  const Frame frame = result.frame(index);
  const std::vector<double> position = frame.reals("position"), velocity = frame.reals("velocity");
  for (std::size_t i = 0; i < scene.conductors.size(); ++i) {
    scene.conductors[i].position = vector_at(position, i);
    if (!velocity.empty()) scene.conductors[i].velocity = vector_at(velocity, i);
  }
  if (const std::vector<double> charge = frame.reals("charge"); !charge.empty()) set_charges(charge, scene);
  scene.started_from = fmt::format("{}, frame {}", path, index);
}

}  // namespace lichtenberg
