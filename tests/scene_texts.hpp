#pragma once

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <initializer_list>
#include <string>

#include "solvers/error.hpp"
#include "solvers/neighbours/pairs.hpp"
#include "src/effects/read_scene.hpp"
#include "src/scene/electrodes.hpp"
#include "src/scene/scene.hpp"
#include "tests/message.hpp"
#include "tests/source_folder.hpp"

/// Parts of scene files and functions that read them.
namespace lichtenberg::scene_texts {

inline const std::string box = "domain = { size = [0.04, 0.02] }\nmedium = { relative_permittivity = 2.0 }\n";
inline const std::string electrostatics = "effects.floating_conductors = {}\nfield = { cells = 64 }\n";
inline const std::string grounded =
    "[[electrode]]\nshape = \"disk\"\ncentre = [0.02, 0.01]\nradius = 0.002\npotential = 0.0\n";

inline std::string disk(const std::string& position, const std::string& more = "") {
  return "[[conductor]]\nposition = " + position + "\nradius = 0.001\n" + more;
}

inline Scene parse(const std::string& text) { return parse_scene(text, "test.toml"); }

/// Error message of a refused scene; empty if it is accepted.
inline std::string refusal(const std::string& text) {
  return message_of<InputError>([&] { parse(text); });
}

inline bool has(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

/// Checks that the scene is refused with one line that contains each part.
inline void check_refused(const std::string& text, std::initializer_list<std::string> parts) {
  const std::string sentence = refusal(text);
  CAPTURE(text);
  CAPTURE(sentence);
  CHECK(has(sentence, "test.toml"));
  CHECK_FALSE(has(sentence, "\n"));
  for (const std::string& part : parts) {
    CAPTURE(part);
    CHECK(has(sentence, part));
  }
}

inline std::filesystem::path shipped_scenes() { return std::filesystem::path(source_folder()) / "scenes"; }

inline double least_gap(const Scene& scene) {
  double least = INFINITY;
  for (std::size_t i = 0; i < scene.conductors.size(); ++i) {
    const Conductor& a = scene.conductors[i];
    for (std::size_t j = 0; j < i; ++j)
      least = std::min(least, norm(a.position - scene.conductors[j].position) - a.radius - scene.conductors[j].radius);
    for (const Electrode& electrode : scene.electrodes) least = std::min(least, gap(a, electrode, scene.domain));
    for (int k = 0; k < scene.dimension(); ++k)
      least = std::min({least, a.position[k] - a.radius, scene.domain.size[k] - a.position[k] - a.radius});
  }
  return least;
}

/// Number of pairs of overlapping spheres, also across periodic sides.
inline std::size_t overlaps_in_space(const Scene& scene) {
  std::vector<double> position, radius;
  for (const Conductor& c : scene.conductors) {
    position.insert(position.end(), {c.position.x, c.position.y, c.position.z});
    radius.push_back(c.radius);
  }
  return pairs_closer_than(Spheres<3>{position, radius, scene.domain.box()}, 0).size();
}

}  // namespace lichtenberg::scene_texts
