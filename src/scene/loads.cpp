#include "src/scene/loads.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "solvers/geometry/box.hpp"
#include "src/scene/effect_kind.hpp"

namespace lichtenberg {
namespace {

/// Returns the index in side_names of the plate.
int plate_side(const CompressionOptions& compression) {
  return static_cast<int>(std::ranges::find(side_names, compression.plate) - side_names.begin());
}

void check_sides_of_loads(const Draft& draft) {
  const Domain& domain = draft.scene.domain;
  const CompressionOptions& compression = draft.scene.compression;
  const std::string with = "is not allowed with [compression], which moves the sides of the domain: leave one out";
  refuse_if_given(draft, "wall", with);
  if (!domain.walled)
    refuse(draft.scene.path, draft.line("effects.soft_repulsion.box"), "effects.soft_repulsion.box = false " + with);
  if (compression.plate.empty()) return;
  const int side = plate_side(compression), line = draft.line("compression.plate");
  if (side >= 2 * draft.domain_size.count)
    refuse(draft.scene.path, line,
           fmt::format("compression.plate = \"{}\" is not allowed in two dimensions: right and top are",
                       compression.plate));
  if (domain.sides[side].periodic)
    refuse(draft.scene.path, line,
           fmt::format("compression.plate = \"{0}\" is not allowed with domain.{0} = \"periodic\": a plate is a wall",
                       compression.plate));
}

}  // namespace

void check_load_keys(const Draft& draft) {
  const CompressionOptions& compression = draft.scene.compression;
  const int line = draft.line("compression");
  if (line == 0) return;
  if (!draft.scene.effects.has(&EffectKind::packing))
    refuse(draft.scene.path, line, "[compression] needs the table [effects.soft_repulsion]: add it, or leave this out");
  const int lists = !compression.pressure.empty() + !compression.filling.empty() + !compression.excess.empty();
  if (lists != 1)
    refuse(draft.scene.path, line,
           fmt::format("[compression] has {} of the lists pressure, filling and excess: it must have one",
                       lists == 0 ? "none" : "several"));
  if (!compression.filling.empty())
    refuse_if_given(draft, "compression.tolerance",
                    "is not allowed with compression.filling, as no pressure is sought: leave it out");
  refuse_if_given(draft, "minimize.record_every",
                  "is not allowed with [compression], which records each load: leave it out");
  check_sides_of_loads(draft);
  if (draft.scene.effects.has("gravity") && !compression.excess.empty())
    refuse(draft.scene.path, draft.line("compression.excess"),
           "compression.excess is not allowed with [effects.gravity]: weight presses particles together at any packing "
           "fraction; pressure and filling are allowed");
}

int plate_axis(const CompressionOptions& compression) {
  return compression.plate.empty() ? -1 : plate_side(compression) / 2;
}

double packing_fraction(const Scene& scene) {
  const bool spheres = scene.dimension() == 3;
  double content = 0;
  for (const Conductor& c : scene.conductors)
    content += std::numbers::pi * c.radius * c.radius * (spheres ? 4.0 / 3.0 * c.radius : 1);
  const Vec3 size = scene.domain.size;
  return content / (size.x * size.y * (spheres ? size.z : 1));
}

Scene resized(Scene scene, Vec3 size) {
  const Vec3 before = scene.domain.size;
  for (int k = 0; k < scene.dimension(); ++k) {
    for (Conductor& c : scene.conductors) c.position[k] *= size[k] / before[k];
    for (Wall& wall : scene.walls)
      if (wall.point[k] != 0) wall.point[k] = size[k];
    scene.domain.size[k] = size[k];
  }
  return scene;
}

}  // namespace lichtenberg
