#pragma once

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "tests/source_folder.hpp"
#include "validation/harness.hpp"

namespace lichtenberg::validation {

using namespace lichtenberg::laplace;
using nlohmann::json;

/// Reference case of disks from a file in data/reference-disks, with its field problem.
struct Reference {
  std::string name;
  json data;  ///< Content of the file, with the reference results
  LaplaceProblem problem{.permittivity = 1};
  Vec2 shift;          ///< Displacement from the file's coordinates to the problem's
  bool plane = false;  ///< True for a case in the unbounded plane
};

/// Returns the index of the conductor (group) that contains a disk.
inline int group_of(const json& conductors, int disk) {
  for (std::size_t g = 0; g < conductors.size(); ++g)
    for (const int member : conductors[g]["disks"])
      if (member == disk) return static_cast<int>(g);
  throw std::runtime_error("a disk of the reference case belongs to no conductor");
}

/// Encloses a pair of disks in the unbounded plane in a box with a margin of two radii, with the exact potential on its
/// sides.
inline void enclose(Reference& reference) {
  const auto first = std::get<Disk>(reference.problem.bodies[0].shape);
  const auto second = std::get<Disk>(reference.problem.bodies[1].shape);
  const double side = norm(second.centre - first.centre) + 6 * first.radius;
  reference.shift = Vec2{0.5 * side, 0.5 * side} - 0.5 * (first.centre + second.centre);
  for (Body& body : reference.problem.bodies) std::get<Disk>(body.shape).centre += reference.shift;
  reference.problem.size = {side, side};

  const theory::DiskPair pair = {std::get<Disk>(reference.problem.bodies[0].shape),
                                 std::get<Disk>(reference.problem.bodies[1].shape), 1};
  const double charge = reference.problem.groups[0].charge;
  const double ground = theory::negative_potential(pair, charge);  // the file has the second disk at 0
  const auto profile = [=](Vec2 p) { return theory::potential(pair, charge, p) - ground; };
  reference.problem.sides.fill({.kind = Side::Kind::electrode, .profile = profile});
}

/// Reads a reference case from a file.
inline Reference read(const std::filesystem::path& path) {
  Reference reference;
  reference.data = json::parse(std::ifstream(path));
  const json& data = reference.data;
  reference.name = data["name"];
  LaplaceProblem& problem = reference.problem;
  for (const json& conductor : data["conductors"]) {
    const bool floating = conductor["kind"] == "floating";
    problem.groups.push_back({.floating = floating,
                              .charge = floating ? conductor["Q"].get<double>() : 0,
                              .potential = floating ? 0 : conductor["phi"].get<double>()});
  }
  for (std::size_t k = 0; k < data["disks"].size(); ++k) {
    const json& disk = data["disks"][k];
    problem.bodies.push_back(
        {Disk{{disk["x"], disk["y"]}, disk["R"]}, group_of(data["conductors"], static_cast<int>(k))});
  }
  reference.plane = data["bc"] == "plane";
  if (reference.plane) {
    enclose(reference);
  } else {
    const double side = data["box"]["L"];
    problem.size = {side, side};
    if (data["bc"] == "bottom_dirichlet") problem.sides[bottom].kind = Side::Kind::electrode;
  }
  return reference;
}

/// Reads all reference cases, sorted by file name.
inline std::vector<Reference> read_all() {
  const std::filesystem::path folder = std::filesystem::path(source_folder()) / "validation/data/reference-disks";
  std::vector<std::filesystem::path> paths;
  for (const auto& entry : std::filesystem::directory_iterator(folder))
    if (entry.path().extension() == ".json") paths.push_back(entry.path());
  std::sort(paths.begin(), paths.end());
  std::vector<Reference> cases;
  for (const auto& path : paths) cases.push_back(read(path));
  return cases;
}

}  // namespace lichtenberg::validation
