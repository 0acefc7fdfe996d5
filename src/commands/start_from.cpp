#include "src/commands/start_from.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "solvers/error.hpp"
#include "src/commands/reading.hpp"
#include "src/record/result.hpp"
#include "src/scene/effect_kind.hpp"
#include "src/scene/placing.hpp"

namespace lichtenberg {
namespace {

int frame_of(const Result& result, std::optional<int> requested_frame) {
  const int last = result.frames() - 1, frame = requested_frame.value_or(last);
  if (frame < 0 || frame > last)
    throw InputError(
        fmt::format("--frame {} is not in the result file {}: it has frames 0 to {}", frame, result.path(), last));
  return frame;
}

/// Returns the keys of [units] whose scales differ, with both values; empty if all are equal.
std::string differing_units(const Reference& there, const Reference& here) {
  std::vector<std::string> differing;
  for (const auto& [key, unit] : {std::pair{"length", &Reference::length},
                                  {"mass", &Reference::mass},
                                  {"velocity", &Reference::velocity},
                                  {"charge", &Reference::charge}})
    if (there.*unit != here.*unit)
      differing.push_back(fmt::format("units.{} is {} there and {} here", key, there.*unit, here.*unit));
  return fmt::format("{}", fmt::join(differing, ", "));
}

void check_bodies(const Result& result, const Scene& scene, const StopRequest& stop) {
  const auto refuse_it = [&](const std::string& why) {
    throw InputError(
        fmt::format("--from {} is not allowed: {}; only equal bodies can start from that result", result.path(), why));
  };
  if (result.radius().size() != scene.conductors.size())
    refuse_it(fmt::format("it has {} bodies, {} has {}", result.radius().size(), scene.path, scene.conductors.size()));
  const Scene there = result.scene(effects::all_kinds(), stop);
  // A packing has no velocities and charges, so its unit of length is also valid for grains.
  const bool from_packing = there.effects.has(&EffectKind::packing);
  if (there.dimension() != scene.dimension() ||
      (!from_packing && there.reference.has_value() != scene.reference.has_value()))
    refuse_it(fmt::format("it is of another kind of scene than {}", scene.path));
  if ((scene.in_si || there.in_si) && there.reference != scene.reference)
    refuse_it(
        fmt::format("its reduced units are not those of {}, which follow from its sizes, speeds and charges: add "
                    "[units] with the scales of that result",
                    scene.path));
  if (there.reference && scene.reference && there.reference != scene.reference)
    refuse_it(fmt::format("its units are not those of {}, and numbers in other units are other quantities ({})",
                          scene.path, differing_units(*there.reference, *scene.reference)));
}

/// Throws InputError for a frame of a packing with loads whose domain is not that of the scene.
void check_size(const Result& result, int index, const Scene& scene) {
  std::vector<double> size;
  bool equal = true;
  for (int k = 0; k < scene.dimension(); ++k) {
    const std::vector<double> side = result.observable(fmt::format("size_{}", "xyz"[k]), index);
    if (side.empty()) return;
    size.push_back(side.front());
    equal = equal && std::abs(size[k] - scene.domain.size[k]) <= 1e-9 * size[k];
  }
  if (equal || scene.domain.open) return;
  throw InputError(
      fmt::format("--from {} is not allowed: the load of frame {} has another domain than the scene {}; give the scene "
                  "domain.size = [{}]",
                  result.path(), index, scene.path, fmt::join(size, ", ")));
}

/// Throws InputError for positions outside the domain and for grains that overlap by more than a radius. Contacts never
/// reach such overlaps, but a smaller periodic domain can produce them.
void check_positions(const std::string& path, const Scene& scene) {
  const auto refuse_it = [&](const std::string& why) {
    throw InputError(
        fmt::format("--from {} is not allowed: {}; the domain.size of the scene {} must be large enough for all bodies",
                    path, why, scene.path));
  };
  const Box<3> box = scene.domain.box();
  for (std::size_t i = 0; i < scene.conductors.size() && !scene.domain.open; ++i)
    for (int k = 0; k < scene.dimension(); ++k)
      if (const double x = scene.conductors[i].position[k]; !box.periodic(k) && !(x >= 0 && x <= box.lengths[k]))
        refuse_it(fmt::format("the centre of body {} lies outside the domain", i));
  if (!scene.reference) return;
  SphereGrid grid(2 * std::ranges::max(scene.conductors, {}, &Conductor::radius).radius, scene.conductors.size(),
                  scene.domain);
  for (std::size_t i = 0; i < scene.conductors.size(); ++i) {
    const Sphere sphere = sphere_of(scene.conductors[i]);
    if (const auto other = grid.conflict(sphere, -sphere.radius))
      refuse_it(fmt::format("bodies {} and {} overlap by more than a radius in this domain", *other, i));
    grid.insert(sphere);
  }
}

/// Returns the numbers of a column of a frame; empty if there is no such column. Throws InputError unless each of
/// `bodies` has `width` of them.
std::vector<double> numbers_in(const Frame& frame, const char* column, std::size_t bodies, std::size_t width,
                               const std::string& path) {
  std::vector<double> numbers = frame.reals(column);
  if (!numbers.empty() && numbers.size() != width * bodies)
    throw InputError(
        fmt::format("the result file {} is damaged and cannot be started from ({} has {} numbers for {} bodies)", path,
                    column, numbers.size(), bodies));
  return numbers;
}

/// Returns the three components of row i.
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

std::vector<Conductor> bodies_in(const std::string& path, std::optional<int> requested_frame) {
  const Result result(path);
  return result.bodies(frame_of(result, requested_frame));
}

void start_from(const std::string& path, std::optional<int> requested_frame, Scene& scene, const StopRequest& stop) {
  const Result result(path);
  warn_if_changed(result.file());
  const int index = frame_of(result, requested_frame);
  check_bodies(result, scene, stop);
  check_size(result, index, scene);
  const Frame frame = result.frame(index);
  const auto numbers = [&, bodies = scene.conductors.size()](const char* column, std::size_t width) {
    return numbers_in(frame, column, bodies, width, path);
  };
  const std::vector<double> position = numbers("position", 3), velocity = numbers("velocity", 3),
                            rotation = numbers("angular_velocity", 3);
  for (std::size_t i = 0; i < scene.conductors.size(); ++i) {
    scene.conductors[i].position = vector_at(position, i);
    if (!velocity.empty()) scene.conductors[i].velocity = vector_at(velocity, i);
    if (!rotation.empty()) scene.conductors[i].angular_velocity = vector_at(rotation, i);
  }
  check_positions(path, scene);
  if (const std::vector<double> charge = numbers("charge", 1); !charge.empty()) set_charges(charge, scene);
  scene.started_from = fmt::format("{}, frame {}", path, index);
}

Scene read_started(const std::string& result, std::optional<int> frame,
                   const std::function<Scene(const std::vector<Conductor>&)>& read, const StopRequest& stop) {
  if (result.empty() && frame) throw InputError("--frame needs --from, because it is a frame of that result");
  if (result.empty()) return read({});
  try_reading(result, [&] { bodies_in(result, frame); });
  Scene scene = read(bodies_in(result, frame));
  try_reading(result, [&] {
    Scene copy = scene;
    start_from(result, frame, copy, stop);
  });
  start_from(result, frame, scene, stop);
  return scene;
}

std::vector<Argument> from_arguments(std::string& result, std::optional<int>& frame) {
  return {{"--from", &result, "result (.h5) from whose positions, velocities and charges the scene starts"},
          frame_argument(frame)};
}

}  // namespace lichtenberg
