#pragma once

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "solvers/laplace/spheres/spheres.hpp"
#include "tests/source_folder.hpp"

namespace lichtenberg::sphere_references {

using nlohmann::json;

/// A case of data/reference-spheres as a problem.
struct SphereReference {
  std::string name;
  json data;
  laplace::SphereProblem problem{.permittivity = 1};

  const json& exact() const { return data["reference"]; }
};

inline void read_walls(const json& domain, laplace::SphereProblem& problem) {
  problem.box.lengths = {domain["size"][0], domain["size"][1], domain["size"][2]};
  const char* names[] = {"xmin", "xmax", "ymin", "ymax", "zmin", "zmax"};
  for (int side = 0; side < 6; ++side) {
    const json& wall = domain["walls"][names[side]];
    if (wall == "periodic") problem.box.sides[side] = Boundary::periodic;
    if (!wall.is_object()) continue;
    problem.box.sides[side] = Boundary::electrode;
    problem.side_potential[side] = wall["potential"];
  }
}

inline SphereReference read_spheres(const std::filesystem::path& path) {
  SphereReference reference;
  reference.data = json::parse(std::ifstream(path));
  const json& data = reference.data;
  reference.name = data["name"];
  laplace::SphereProblem& problem = reference.problem;
  problem.permittivity = data["eps"];
  problem.free_space = data["domain"]["type"] == "free";
  if (!problem.free_space) read_walls(data["domain"], problem);
  for (const json& sphere : data["spheres"])
    problem.spheres.push_back({{sphere["x"], sphere["y"], sphere["z"]}, sphere["R"]});
  for (const json& conductor : data["conductors"]) {
    const bool floating = conductor["kind"] == "floating";
    for (const int member : conductor["spheres"])
      problem.spheres[member].group = static_cast<int>(problem.groups.size());
    problem.groups.push_back({.floating = floating,
                              .charge = floating ? conductor["Q"].get<double>() : 0,
                              .potential = floating ? 0 : conductor["phi"].get<double>()});
  }
  return reference;
}

inline std::vector<SphereReference> read_all_spheres() {
  const std::filesystem::path folder = std::filesystem::path(source_folder()) / "validation/data/reference-spheres";
  std::vector<std::filesystem::path> paths;
  for (const auto& entry : std::filesystem::directory_iterator(folder))
    if (entry.path().extension() == ".json") paths.push_back(entry.path());
  std::sort(paths.begin(), paths.end());
  std::vector<SphereReference> cases;
  for (const auto& path : paths) cases.push_back(read_spheres(path));
  return cases;
}

/// Largest error of a quantity over its largest value.
class RelativeError {
 public:
  void add(double computed, double exact) {
    largest_ = std::max(largest_, std::abs(exact));
    error_ = larger(error_, std::abs(computed - exact));
  }
  void add(Vec3 computed, const json& exact) {
    for (int k = 0; k < 3; ++k) add(computed[k], exact[k].get<double>());
  }
  double value() const { return error_ / largest_; }

 private:
  static double larger(double a, double b) { return std::isnan(b) || b > a ? b : a; }
  double largest_ = 0, error_ = 0;
};

/// Errors of a solution by the names of the reference's quantities, each over the largest of its kind.
struct SphereErrors {
  double potential = 0, charge = 0, force = 0, dipole = 0, energy = 0, capacitance = 0, probe_potential = 0,
         probe_field = 0;
  int iterations = 0, degree = 0;
  laplace::Timings seconds;
  double worst() const {
    double most = 0;
    for (const double e : {potential, charge, force, dipole, energy, capacitance, probe_potential, probe_field})
      most = std::isnan(e) || e > most ? e : most;
    return most;
  }
};

inline SphereErrors errors_of(const SphereReference& reference, double accuracy) {
  using namespace laplace;
  const json& exact = reference.exact();
  SphereSolver solver({.accuracy = accuracy});
  const SphereSolution solution = solver.solve(reference.problem);
  RelativeError potential, charge, force, dipole, capacitance, value, field;
  for (std::size_t i = 0; i < reference.problem.spheres.size(); ++i) {
    potential.add(solution.group_potential[reference.problem.spheres[i].group], exact["phi_sphere"][i]);
    charge.add(solution.sphere_charge[i], exact["Q_sphere"][i]);
    force.add(solution.sphere_force[i], exact["force"][i]);
    if (exact.contains("dipole")) dipole.add(solution.sphere_dipole[i], exact["dipole"][i]);
  }
  std::vector<Vec3> points;
  for (const json& probe : exact["probes"]) points.push_back({probe["x"], probe["y"], probe["z"]});
  const std::vector<PointField> at_points = solver.field(points);
  for (std::size_t p = 0; p < points.size(); ++p) {
    const json& probe = exact["probes"][p];
    value.add(at_points[p].potential, probe["V"]);
    field.add(at_points[p].field, json::array({probe["Ex"], probe["Ey"], probe["Ez"]}));
  }
  const std::vector<double> matrix = solver.capacitance_matrix(reference.problem);
  const std::size_t n = reference.problem.groups.size();
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = 0; j < n; ++j) capacitance.add(matrix[i * n + j], exact["capacitance_conductor"][i][j]);
  return {.potential = potential.value(),
          .charge = charge.value(),
          .force = force.value(),
          .dipole = exact.contains("dipole") ? dipole.value() : 0,
          .energy = std::abs(solution.energy / exact["energy"].get<double>() - 1),
          .capacitance = capacitance.value(),
          .probe_potential = value.value(),
          .probe_field = field.value(),
          .iterations = solution.iterations,
          .degree = solution.degree,
          .seconds = solution.seconds};
}

}  // namespace lichtenberg::sphere_references
