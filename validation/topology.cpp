// Tests D's chapter 7 on trees: degree relations (7.6-7.9), the largest degree, the degrees of Euclidean minimum
// spanning trees (7.16) and of the experiments (7.10), Strahler numbers (7.18).
//
// Bounds apply to derived or proven results only. D's claims are printed with a verdict and do not fail this program.
//
//   topology         seconds
//   topology long    trees of a million points for three digits, and final trees of runs of 100 conductors: minutes

#include <fmt/format.h>

#include <fstream>
#include <limits>
#include <numbers>
#include <sstream>

#include "src/analysis/topology.hpp"
#include "src/effects/contact_discharge.hpp"
#include "src/effects/read_scene.hpp"
#include "src/mechanics/simulation.hpp"
#include "tests/source_folder.hpp"
#include "validation/harness.hpp"
#include "validation/program.hpp"
#include "validation/random_trees.hpp"

namespace topology_validation {

using namespace lichtenberg;
using namespace lichtenberg::analysis;
using namespace lichtenberg::validation;

namespace {

constexpr double least_angle = 60 - 1e-4;  // degrees; edges with lengths equal to rounding may be closer
constexpr double sure = 4;                 // standard errors; a true statement fails once in 16000 times
constexpr double source_f[] = {0, 0.253, 0.527, 0.204, 0.016};        // D 7.16
constexpr double source_f_error[] = {0, 0.003, 0.006, 0.004, 0.001};  // its +- 0.3, 0.6, 0.4, 0.1, read as per cent
constexpr double experiment_f[] = {0, 0.252, 0.511, 0.222, 0.015};    // D 7.10
constexpr double experiment_sigma[] = {0, 0.455, 0.275, 0.169};       // D 7.18
// The experiments have no uncertainties. Those of one network of 324 conductors are used: the scatter of f_j and
// sigma_j / N between trees at the dendrite's start (`topology long`: standard errors of 300 trees, times sqrt(300)).
constexpr double experiment_f_error[] = {0, 0.014, 0.026, 0.016, 0.007};
constexpr double experiment_sigma_error[] = {0, 0.02, 0.035, 0.05};
constexpr double dendrite_spacing = 1.65e-3 / 5.12e-2 * 18;  // least distance of 324 conductors, in units of rho^(-1/2)

/// Prints D's value, the computed value, and their difference in standard errors.
void claim(const std::string& what, double printed, double printed_error, const Mean& found) {
  const double error = std::hypot(printed_error, found.error());
  const double deviation = std::abs(printed - found.value()) / error;
  fmt::print("{:<40}{:>9.3f}{:>12.4f} +- {:.4f}{:>9.1f} s.e.  {}\n", what, printed, found.value(), found.error(),
             deviation, deviation <= 3 ? "agrees" : "does not hold");
}

void print_claims(const std::string& heading) {
  fmt::print("\n{}\n{:<40}{:>9}{:>12}{:>19}\n", heading, "", "D", "found", "apart");
}

/// Prints five degree fractions and their sum rule.
void print_fractions(const std::string& what, const TreeFractions& f) {
  fmt::print("{:<34}", what);
  for (int j = 1; j <= 4; ++j) fmt::print(" {:.4f}({:>2.0f})", f.degree[j].value(), 1e4 * f.degree[j].error());
  fmt::print("  {:.0e}", f.degree[5].value());
  for (int j = 1; j <= 3; ++j) fmt::print(" {:.3f}({:>1.0f})", f.strahler[j].value(), 1e3 * f.strahler[j].error());
  fmt::print("\n");
  std::fflush(stdout);
}

void print_fractions_head(const std::string& heading) {
  fmt::print("\n{} (standard errors of the last digits in brackets)\n{:<34}", heading, "");
  for (const char* name : {"f1", "f2", "f3", "f4"}) fmt::print(" {:^10}", name);
  fmt::print("  {:^5} {:^8} {:^8} {:^8}\n", "f5", "sigma1", "sigma2", "sigma3");
}

/// Accumulated checks of necessary properties of trees.
struct Checks {
  Mean triangle_side, nearest, mutual;
  double edges_a_point = 0, sum_rule = 0, smallest_angle = 180;
  int missing_nearest = 0, largest_degree = 0;

  void add(const std::vector<Vec2>& point, const TorusTriangulation& triangulation, const std::vector<Edge>& tree) {
    const int n = static_cast<int>(point.size());
    const auto edges = static_cast<double>(triangulation.edge.size());
    double length = 0;
    for (const double side : triangulation.length) length += side;
    triangle_side.add(length / edges * std::sqrt(n));
    edges_a_point = std::max(edges_a_point, std::abs(edges / n - 3));
    add_nearest(point, triangulation, tree);
    add_degrees(point, tree);
  }

 private:
  void add_nearest(const std::vector<Vec2>& point, const TorusTriangulation& triangulation,
                   const std::vector<Edge>& tree) {
    const int n = static_cast<int>(point.size());
    std::vector<double> distance(n, std::numeric_limits<double>::infinity());
    std::vector<int> neighbour(n);
    for (std::size_t k = 0; k < triangulation.edge.size(); ++k)
      for (const auto& [i, j] :
           {triangulation.edge[k], Edge{triangulation.edge[k].second, triangulation.edge[k].first}})
        if (triangulation.length[k] < distance[i]) distance[i] = triangulation.length[k], neighbour[i] = j;
    std::vector<Edge> sorted = tree;
    std::ranges::sort(sorted);
    double sum = 0, in_pairs = 0;
    for (int i = 0; i < n; ++i) {
      sum += distance[i];
      in_pairs += neighbour[neighbour[i]] == i;
      missing_nearest += !std::ranges::binary_search(sorted, Edge(std::minmax(i, neighbour[i])));
    }
    nearest.add(sum / n * std::sqrt(n));
    mutual.add(in_pairs / n);
  }

  void add_degrees(const std::vector<Vec2>& point, const std::vector<Edge>& tree) {
    const int n = static_cast<int>(point.size());
    const ContactGraph graph = contact_graph(n, std::vector<Edge>(tree.begin(), tree.end()));
    double degrees = 0;
    for (int i = 0; i < n; ++i) {
      const std::vector<int>& next = graph.neighbours[i];
      degrees += static_cast<double>(next.size());
      largest_degree = std::max(largest_degree, static_cast<int>(next.size()));
      for (std::size_t a = 0; a < next.size(); ++a)
        for (std::size_t b = 0; b < a; ++b) {
          const Vec2 u = on_torus(point[i], point[next[a]]), v = on_torus(point[i], point[next[b]]);
          const double angle = std::atan2(std::abs(cross(u, v)), dot(u, v)) * 180 / std::numbers::pi;
          smallest_angle = std::min(smallest_angle, angle);
        }
    }
    sum_rule = std::max(sum_rule, std::abs(degrees / n - 2.0 * (n - 1) / n));
  }
};

struct RandomTrees {
  TreeFractions fractions;
  Checks checks;
};

/// Returns random trees. `spacing`: least distance of two points in units of rho^(-1/2); 0: none.
RandomTrees trees_on_torus(int points, int samples, double spacing, UniformRandom& random) {
  RandomTrees result;
  for (int k = 0; k < samples; ++k) {
    const std::vector<Vec2> point =
        spacing > 0 ? hard_core_points(points, spacing / std::sqrt(points), random) : uniform_points(points, random);
    const TorusTriangulation triangulation = triangulate_on_torus(point);
    const std::vector<Edge> tree = spanning_tree_on_torus(points, triangulation);
    result.checks.add(point, triangulation, tree);
    result.fractions.add(tree, point);
  }
  return result;
}

void report_checks(Report& report, const Checks& checks) {
  report.section("Minimum spanning trees of uniform points on a torus: necessary properties");
  const auto off = [&](const std::string& what, const Mean& found, double exact) {
    report.at_most(fmt::format("{}, {:.5f} for {:.5f}: s.e. off", what, found.value(), exact),
                   std::abs(found.value() - exact) / found.error(), sure);
  };
  report.at_most("Delaunay's edges a point less 3 (Euler, on a torus)", checks.edges_a_point, 0);
  // Miles 1970; Clark and Evans 1954; Pickard 1982. Lengths in units of rho^(-1/2).
  off("mean Delaunay edge", checks.triangle_side, 32 / (9 * std::numbers::pi));
  off("mean nearest distance", checks.nearest, 0.5);
  const double pi = std::numbers::pi;
  off("points in nearest pairs", checks.mutual, 6 * pi / (8 * pi + 3 * std::sqrt(3)));
  // The shortest edge from a point is in every minimum spanning tree.
  report.at_most("nearest neighbours that the tree does not join", checks.missing_nearest, 0);
  report.at_most("sum j f_j less 2 (N - 1) / N", checks.sum_rule, 1e-12);
  // If two edges make an angle below 60 degrees, the longer exceeds the third side, which would replace it.
  report.at_least("smallest angle between two edges (degrees)", checks.smallest_angle, least_angle);
  report.at_most("largest degree (360 / 60 without ties: 5)", checks.largest_degree, 5);
}

/// Reports trees of uniform points, of points with a minimum distance, and of the start of the source's main run.
RandomTrees report_random(Report& report, bool large) {
  UniformRandom random(2018);
  const RandomTrees uniform = large ? trees_on_torus(1000000, 10, 0, random) : trees_on_torus(10000, 10, 0, random);
  report_checks(report, uniform.checks);

  print_fractions_head("Minimum spanning trees: degrees, Strahler numbers a point");
  print_fractions(large ? "uniform, torus, N = 1e6, 10 trees" : "uniform, torus, N = 1e4, 10 trees", uniform.fractions);
  for (const int n : {1000, 324, 100}) {
    const int trees = (large ? 1000000 : 50000) / n;
    print_fractions(fmt::format("uniform, torus, N = {}", n), trees_on_torus(n, trees, 0, random).fractions);
  }
  TreeFractions square;
  for (int k = 0; k < (large ? 3000 : 150); ++k) {
    const std::vector<Vec2> point = uniform_points(324, random);
    square.add(euclidean_minimum_spanning_tree(point), point);
  }
  print_fractions("uniform, square, N = 324", square);

  print_claims("D 7.16, said to be the limit for many uniform points (+- read as per cent)");
  for (int j = 1; j <= 4; ++j)
    claim(fmt::format("f_{}", j), source_f[j], source_f_error[j], uniform.fractions.degree[j]);
  double sum = 0, mean = 0;
  for (int j = 1; j <= 4; ++j) sum += source_f[j], mean += j * source_f[j];
  // Sum j f_j = 2 - 2/N for every spanning tree without a ground.
  fmt::print("7.16 sums to {:.3f}; sum j f_j = {:.3f}, which is that of trees of about {:.0f} points, not of many\n",
             sum, mean, 2 / (2 - mean));
  return uniform;
}

/// Returns scenes/dendrite.toml with replaced text.
Scene dendrite(const std::vector<std::pair<std::string, std::string>>& changes) {
  std::ifstream file(source_folder() + "/scenes/dendrite.toml");
  std::stringstream stream;
  stream << file.rdbuf();
  std::string text = stream.str();
  for (const auto& [from, to] : changes) {
    const std::size_t at = text.find(from);
    if (at == std::string::npos) throw std::runtime_error("scenes/dendrite.toml has no " + from);
    text.replace(at, from.size(), to);
  }
  return parse_scene(text, "dendrite.toml, changed");
}

TreeFractions dendrite_starts(int trees) {
  TreeFractions fractions;
  for (int seed = 1; seed <= trees; ++seed) {
    std::vector<Vec2> point;
    for (const Conductor& conductor : dendrite({{"seed = 1 ", fmt::format("seed = {} ", seed)}}).conductors)
      point.push_back(plane(conductor.position));
    fractions.add(euclidean_minimum_spanning_tree(point), point);
  }
  return fractions;
}

void report_hard_core(Report& report, bool large, const TreeFractions& uniform) {
  UniformRandom random(7);
  print_fractions_head("The same of points that keep a distance d (spheres do); d in units of rho^(-1/2)");
  for (const double spacing : {0.2, 0.4, 0.7, 0.8})
    print_fractions(fmt::format("torus, d = {}", spacing),
                    trees_on_torus(large ? 100000 : 10000, 4, spacing, random).fractions);
  const RandomTrees like = trees_on_torus(large ? 100000 : 10000, large ? 20 : 5, dendrite_spacing, random);
  print_fractions(fmt::format("torus, d = {:.2f}, the dendrite's", dendrite_spacing), like.fractions);
  const TreeFractions start = dendrite_starts(large ? 300 : 15);
  print_fractions("first instants of the dendrite", start);
  for (const auto& [name, source, error] :
       {std::tuple{"7.16", source_f, source_f_error}, std::tuple{"7.10", experiment_f, experiment_f_error}}) {
    print_claims(fmt::format("D {} compared with trees of points that have at least the dendrite's spacing", name));
    for (int j = 1; j <= 4; ++j) claim(fmt::format("f_{}", j), source[j], error[j], like.fractions.degree[j]);
  }
  report.section("Degrees depend on how the points are distributed");
  const Mean &a = uniform.degree[1], &b = like.fractions.degree[1];
  report.at_least("f_1 of such points above f_1 of uniform ones, in s.e.",
                  (b.value() - a.value()) / std::hypot(a.error(), b.error()), sure);
  report.at_most("largest degree", like.checks.largest_degree, 5);
  report.at_least("smallest angle between two edges (degrees)", like.checks.smallest_angle, least_angle);
}

void report_strahler(const TreeFractions& uniform) {
  print_claims("D 7.18 (experiments) compared with minimum spanning trees of many uniform points");
  for (int j = 1; j <= 3; ++j)
    claim(fmt::format("sigma_{} / N", j), experiment_sigma[j], experiment_sigma_error[j], uniform.strahler[j]);
  fmt::print("Horton's law of stream numbers: streams of order j for one of order j + 1\n");
  for (int j = 1; j <= 4; ++j)
    fmt::print("  {} : {}  {:.2f}\n", j, j + 1, uniform.streams[j].value() / uniform.streams[j + 1].value());
}

/// Spheres of radius 1, in contact if centres are closer than 3, above a ground. D claims that at most four can touch
/// one without a loop.
void report_largest_degree(Report& report) {
  const auto star_positions = [](int arms, double distance) {
    std::vector<Vec2> position{{10, distance + 1.5}};
    for (int k = 0; k < arms; ++k) {
      const double angle = 2 * std::numbers::pi * k / arms;
      position.push_back(position[0] + distance * Vec2{std::sin(angle), -std::cos(angle)});
    }
    return position;
  };
  const auto star = [&](int arms, double distance) {
    const std::vector<Vec2> position = star_positions(arms, distance);
    const std::vector<double> radius(position.size(), 1.0);
    const Ground ground{{20, 20}, {false, false, true, false}, {}};
    return analysis::network(contacts(position, radius, 1.0, ground), position);
  };
  report.section("Largest degree of spheres in contact below 3 R (D: 4)");
  // Arms at distances below 3 R that do not touch each other are more than 60 degrees apart, because two sides are
  // shorter than the third. So five fit from 3 / (2 sin 36) = 2.552 R on, and six do not.
  report.at_least("degree of the middle of a star of five, 2.6 R", std::ssize(star(5, 2.6).degrees.number) - 1, 5);
  report.at_most("its loops", star(5, 2.6).degrees.loops, 0);
  report.at_least("loops of a star of six, 2.99 R", star(6, 2.99).degrees.loops, 1);
  // With loops: spheres without overlap, 2 R apart at a distance of 3 R, are 2 asin(1/3) = 38.9 degrees apart; the
  // angle is larger at smaller distances. So nine fit (at 2.95 R, 2 * 2.95 sin 20 = 2.02 R apart), and ten do not (2 *
  // 3 sin 18 = 1.85 R), also not at irregular positions.
  report.at_least("degree of the middle of nine, 2.95 R", std::ssize(star(9, 2.95).degrees.number) - 1, 9);
}

/// Returns 100 spheres in a box at the dendrite's density.
Scene small_dendrite(int seed) {
  return dendrite({{"seed = 1 ", fmt::format("seed = {} ", seed)},
                   {"count = 324", "count = 100"},
                   {"size = [5.12e-2, 5.12e-2]", "size = [2.84e-2, 2.84e-2]"},
                   {"at = 2.56e-2", "at = 1.42e-2"},
                   {"cells = 512", "cells = 288"}});
}

/// Returns the topology with the run's contacts.
Topology topology_of(const Simulation& simulation, const ConductorFrame& frame, const Scene& scene) {
  const int n = static_cast<int>(frame.position.size());
  std::vector<Edge> contacts;
  for (const auto& [conductor, partner] : simulation.contacts())
    contacts.emplace_back(conductor, partner < n ? partner : to_ground);
  return topology(analysis::network(std::move(contacts), frame.position), xy_projection(frame.position),
                  simulation.model().bodies.radius, ground_of(scene));
}

void report_runs(Report& report) {
  TreeFractions fractions;
  Mean shared, loops, feet;
  int exact_77 = 0, exact_78 = 0;  // runs that obey the relation as printed
  double general = 0;
  int largest = 0;
  for (int seed = 1; seed <= 16; ++seed) {
    const Scene scene = small_dendrite(seed);
    Simulation simulation(scene);
    while (!simulation.stationary() && simulation.time() < 60) simulation.advance_to(simulation.time() + 0.1);
    const ConductorFrame frame = simulation.now();
    const Topology t = topology_of(simulation, frame, scene);
    const DegreeRelations& r = t.relations;
    fractions.add(t.network.degrees.number, t.orders, t.network.degrees.connected);
    for (const double left : {r.normalization, r.branches, r.mean_degree, r.f3, r.f4})
      general = std::max(general, std::abs(left));
    exact_77 += std::abs(r.branches_printed) < 1e-12;
    exact_78 += std::abs(r.mean_degree_printed) < 1e-12;
    loops.add(t.network.degrees.loops);
    feet.add(t.network.degrees.grounded);
    shared.add(static_cast<double>(t.minimum.shared) / static_cast<double>(t.minimum.edges.size()));
    largest = std::max(largest, static_cast<int>(t.network.degrees.number.size()) - 1);
  }
  print_fractions_head("Trees that 16 runs of 100 conductors end in");
  print_fractions("anti-arborescence", fractions);
  fmt::print(
      "loops {:.2f}, conductors on the ground {:.2f}, largest degree {}; edges of the minimum spanning tree of the\n"
      "same positions that the tree has: {:.3f} +- {:.3f}\n",
      loops.value(), feet.value(), largest, shared.value(), shared.error());
  fmt::print("as printed, 7.7 holds in {} of the runs and 7.8 in {}: loops through two feet compensate the feet\n",
             exact_77, exact_78);
  print_claims("D 7.10 and 7.18");
  for (int j = 1; j <= 4; ++j)
    claim(fmt::format("f_{}", j), experiment_f[j], experiment_f_error[j], fractions.degree[j]);
  for (int j = 1; j <= 3; ++j)
    claim(fmt::format("sigma_{} / N", j), experiment_sigma[j], experiment_sigma_error[j], fractions.strahler[j]);
  report.section("Degree relations with the ground's contacts and the loops counted");
  report.at_most("largest residual of 7.6 to 7.9", general, 1e-12);
}

}  // namespace

int validate(int argc, char** argv) {
  const bool large = long_run_requested(argc, argv);
  Report report("Topology: D's chapter 7");
  report_largest_degree(report);
  const RandomTrees uniform = report_random(report, large);
  report_hard_core(report, large, uniform.fractions);
  report_strahler(uniform.fractions);
  if (large) report_runs(report);
  return report.exit_status();
}

const lichtenberg::validation::Program program("topology", validate);

}  // namespace topology_validation
