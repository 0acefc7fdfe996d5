// Static packings: an exact case, an independently computed packing, and general properties.
#include <Eigen/Core>
#include <array>
#include <fstream>
#include <nlohmann/json.hpp>
#include <random>
#include <set>

#include "solvers/error.hpp"
#include "src/analysis/packing.hpp"
#include "src/effects/contact_law.hpp"
#include "src/effects/effects.hpp"
#include "src/effects/read_scene.hpp"
#include "src/effects/soft_repulsion.hpp"
#include "src/statics/minimization.hpp"
#include "tests/dense_algebra.hpp"
#include "tests/source_folder.hpp"
#include "validation/harness.hpp"
#include "validation/program.hpp"

namespace packing_validation {

using namespace lichtenberg;
using namespace lichtenberg::validation;

namespace {

const std::array methods = {"lbfgs-newton", "lbfgs", "newton-cg", "fire", "gradient-descent"};

std::string head(const std::string& size, const std::string& method, double tolerance) {
  return fmt::format(
      "[domain]\nsize = {}\n[effects.soft_repulsion]\n[minimize]\nmethod = \"{}\"\nforce_tolerance = {}\n", size,
      method, tolerance);
}

struct Result {
  Scene scene;
  Bodies bodies;
  double energy = 0, largest_force = 0;
  std::int64_t iterations = 0, evaluations = 0;
  analysis::Packing packing;
};

Result relaxed(const std::string& text) {
  Result result{.scene = parse_scene(text, "packing")};
  Minimization minimization(result.scene);
  while (!minimization.at_rest() && minimization.iterate()) {
  }
  if (!minimization.at_rest()) throw Failure("the minimization found no rest");
  result.bodies = minimization.bodies();
  result.energy = minimization.energy();
  result.largest_force = minimization.largest_force();
  result.iterations = minimization.iteration();
  result.evaluations = minimization.evaluations();
  result.packing = analysis::packing(result.bodies, result.scene, effects::SoftRepulsion(result.scene));
  return result;
}

/// Returns a scene of random particles that fill `filled` of a square or cube.
std::string random_scene(int dimension, int count, double filled, const std::string& method, double tolerance) {
  const double content = dimension == 3 ? 4.0 / 3 * M_PI * count * 0.127 : M_PI * count * 0.25;  // means of r^3, r^2
  const double side = std::pow(content / filled, 1.0 / dimension);
  const std::string size = dimension == 3 ? fmt::format("[{0}, {0}, {0}]", side) : fmt::format("[{0}, {0}]", side);
  return head(size, method, tolerance) +
         fmt::format("[[population]]\ncount = {}\nradius = [0.4, 0.6]\noverlapping = true\n", count);
}

/// Disks of radius 1 in a slot of 3.6 x 1.8 rest by symmetry at (s, .9) and (3.6 - s, .9). The forces at the walls and
/// between the disks balance there, w'(s) = w'((3.6 - 2s) / 2) / 2.
void check_slot(Report& report) {
  constexpr double s = 0.93100859599774623, tolerance = 1e-12;
  report.section("Two disks in a slot: distance from the exact place");
  for (const std::string method : methods) {
    const Result r = relaxed(head("[3.6, 1.8]", method, tolerance) +
                             "[[conductor]]\nposition = [0.7, 0.8]\nradius = 1\n"
                             "[[conductor]]\nposition = [2.5, 1.1]\nradius = 1\n");
    const std::vector<double> exact = {s, 0.9, 3.6 - s, 0.9};
    double worst = 0;
    for (std::size_t i = 0; i < exact.size(); ++i) worst = larger(worst, std::abs(r.bodies.position[i] - exact[i]));
    // The softest direction has a curvature above k / R^2 (two walls alone give 2 * 2.35 k across), so an unbalanced
    // force of 1e-12 k / R moves no disk by more than 1e-12 R. The rest is rounding of positions.
    report.at_most(method, worst, 3e-12);
  }
}

/// Compares forces with energy differences, and their derivatives with force differences. Returns the ratios to their
/// bounds: truncation h^2 / 6 times the third (fourth) derivative plus rounding of the values over h.
Spread ratios(int dimension, bool second) {
  const Scene scene = parse_scene(random_scene(dimension, 60, 0.9, "lbfgs", 1e-8), "packing");
  Model model = effects::make_model(scene);
  const effects::SoftRepulsion potential(scene);
  const auto state = [&] {
    update(*model.neighbours, model.bodies);
    return State{0, model.bodies, model.neighbours->pairs()};
  };
  const int n = model.bodies.size(), size = n * dimension;
  // Derivatives of (q - 1) ln q of order m grow as m! / q^m; derivatives of a distance add no larger powers of 1 / (q
  // R). The factor 60 covers their number at third and fourth order.
  double steepest = 0, closest = 1;
  for (const effects::Overlap& o : potential.overlaps(state())) {
    steepest = std::max(steepest, 1 / o.distance);
    closest = std::min(closest, (1 - o.q) * o.reach);
  }
  const double h = std::min(1e-5, 0.2 * closest);  // avoids differences across contact onset, where w'' jumps
  const double energy = potential.energy(state());
  std::vector<double> force(size), up(size), down(size), ratio;
  model.forces(0, force);
  ForceJacobian jacobian(dimension);
  model.jacobian(0, jacobian);
  Eigen::MatrixXd derivative = Eigen::MatrixXd::Zero(size, size);
  for (const ForceJacobian::Entry& e : jacobian.by_position) derivative(e.row, e.column) += e.value;
  const double largest = *std::ranges::max_element(force, {}, [](double f) { return std::abs(f); });
  for (int c = 0; c < size; ++c) {
    double& x = model.bodies.position[c];
    const double kept = x;
    x = kept + h;
    const double above = potential.energy(state());
    model.forces(0, up);
    x = kept - h;
    const double below = potential.energy(state());
    model.forces(0, down);
    x = kept;
    constexpr double rounding = 1e-14;  // of a sum of some hundred terms
    const double third = 60 * std::pow(steepest, 3), fourth = 60 * std::pow(steepest, 4);
    if (!second) {
      const double bound = h * h / 6 * third + rounding * energy / h;
      ratio.push_back(std::abs(force[c] + (above - below) / (2 * h)) / bound);
      continue;
    }
    const double bound = h * h / 6 * fourth + rounding * std::abs(largest) / h;
    for (int row = 0; row < size; ++row)
      ratio.push_back(std::abs(derivative(row, c) - (up[row] - down[row]) / (2 * h)) / bound);
  }
  return spread(ratio);
}

void check_derivatives(Report& report) {
  report.section("Derivatives compared with central differences: difference over its bound (truncation and rounding)");
  for (const int dimension : {2, 3}) {
    report.at_most(fmt::format("forces and slopes of the energy, {}D", dimension), ratios(dimension, false), 1);
    report.at_most(fmt::format("their derivatives and slopes of the forces, {}D", dimension), ratios(dimension, true),
                   1);
  }
}

/// Returns the smallest eigenvalue of the energy's Hessian for particles that are no rattlers, in units of k / R^2.
double smallest_eigenvalue(const Result& r) {
  const int d = r.bodies.dimension, n = r.bodies.size();
  Model model = effects::make_model(r.scene);
  model.bodies.position = r.bodies.position;
  ForceJacobian jacobian(d);
  model.jacobian(0, jacobian);
  std::vector<int> index(n, -1);
  int kept = 0;
  for (int i = 0; i < n; ++i)
    if (!r.packing.rattler[i]) index[i] = kept++;
  Eigen::MatrixXd hessian = Eigen::MatrixXd::Zero(kept * d, kept * d);
  for (const ForceJacobian::Entry& e : jacobian.by_position) {
    const int i = index[e.row / d], j = index[e.column / d];
    if (i >= 0 && j >= 0) hessian(i * d + e.row % d, j * d + e.column % d) -= e.value;
  }
  return symmetric_eigenvalues(hessian)(0);
}

std::vector<std::array<int, 2>> edges_of(const Result& r) {
  const int n = r.bodies.size();
  std::set<std::array<int, 2>> edges;
  for (const analysis::PackingContact& c : r.packing.contacts) {
    if (c.partner < n) {
      edges.insert({c.particle + 2, c.partner + 2});
    } else if (const std::string& wall = r.scene.walls[c.partner - n].name; wall == "bottom" || wall == "top") {
      edges.insert({wall == "top", c.particle + 2});
    }
  }
  return {edges.begin(), edges.end()};
}

nlohmann::json read_json(const std::string& name) {
  std::ifstream file(source_folder() + "/validation/data/packing/" + name);
  return nlohmann::json::parse(file);
}

void check_reference(Report& report) {
  const auto data = read_json("n100-packing.json");
  const auto radius = data["r"].get<std::vector<double>>(), start = data["x0"].get<std::vector<double>>(),
             rest = data["x"].get<std::vector<double>>();
  std::string text = head("[10.0, 10.0]", "gradient-descent", 1e-10);
  for (std::size_t i = 0; i < radius.size(); ++i)
    text += fmt::format("[[conductor]]\nposition = [{}, {}]\nradius = {}\n", start[2 * i], start[2 * i + 1], radius[i]);
  const Result r = relaxed(text);
  double worst = 0;
  for (std::size_t i = 0; i < rest.size(); ++i) worst = larger(worst, std::abs(r.bodies.position[i] - rest[i]));
  std::vector<std::array<int, 2>> expected;
  const auto networks = read_json("n100-networks.json");
  for (const auto& link : networks["n100/particle_one"]["edge_list"]) {
    const int a = link[0].get<int>(), b = link[1].get<int>();
    expected.push_back({std::min(a, b), std::max(a, b)});
  }
  std::ranges::sort(expected);
  report.section("100 disks by gradient descent, compared with an independent gradient flow");
  // Net forces of at most 1e-10 / 1.06 on each of 100 disks with a curvature of at least 1e-3: |dx| <= 10 * 1e-10 /
  // 1e-3. The energy error is half of 10 * 1e-10 times that, less than its rounding.
  report.at_least("smallest eigenvalue of the Hessian, k / m^2", smallest_eigenvalue(r), 1e-3);
  report.at_most("energy", std::abs(r.energy - data["U"].get<double>()), 1e-14);
  report.at_most("places", worst, 1e-6);
  report.at_most("contacts that differ", edges_of(r) == expected ? 0 : 1, 0);
}

void check_every_method(Report& report, int dimension, int count, double filled) {
  constexpr double tolerance = 1e-10;  // of k / R, with R = 1
  report.section(fmt::format("{} {} that fill {:.2f}, by every method from one start", count,
                             dimension == 3 ? "spheres" : "disks", filled));
  for (const std::string method : methods) {
    const Result r = relaxed(random_scene(dimension, count, filled, method, tolerance));
    const analysis::Packing& p = r.packing;
    const double side = r.scene.domain.size.x;
    fmt::print(
        "{}: {} iterations, U = {:.10g} k, {} contacts, z = {:.3f} ({:.3f} without {} rattlers), smallest q = {:.3f}\n",
        method, r.iterations, r.energy, p.contacts.size(), p.coordination, p.backbone_coordination, p.rattlers,
        p.smallest_q);
    // Pair forces have no net force, so the walls' net force is that on the particles: at most `tolerance` from each.
    for (int k = 0; k < dimension; ++k)
      report.at_most(fmt::format("  walls' net force along {}", "xyz"[k]),
                     std::abs(p.wall_force[2 * k] - p.wall_force[2 * k + 1]), count * tolerance);
    // d V (p - p_virial) = sum of x . net force, with |x| at most half a diagonal from the middle.
    report.at_most("  pressure on the walls and from inside", std::abs(*p.pressure - *p.virial_pressure),
                   count * tolerance * 0.5 * side * std::sqrt(dimension) / (dimension * std::pow(side, dimension)));
    // Rigidity: at least as many contacts as the backbone has degrees of freedom (Maxwell 1864).
    const int backbone = count - p.rattlers;
    int held = 0;
    for (const analysis::PackingContact& c : p.contacts)
      held += !p.rattler[c.particle] && !(c.partner < count && p.rattler[c.partner]);
    report.at_least("  contacts of the backbone over its degrees of freedom", held / (double(dimension) * backbone),
                    1.0);
    report.at_least("  smallest eigenvalue of the Hessian, k / R^2", smallest_eigenvalue(r), 0.0);
  }
}

}  // namespace

int validate(int argc, char** argv) {
  Report report("Static packings under U = k sum (q - 1) ln q");
  check_slot(report);
  check_reference(report);
  check_derivatives(report);
  check_every_method(report, 2, 100, 0.92);
  check_every_method(report, 3, 100, 0.72);
  if (long_run_requested(argc, argv)) {
    check_every_method(report, 2, 400, 0.9);
    check_every_method(report, 3, 400, 0.72);
  }
  return report.exit_status();
}

const lichtenberg::validation::Program program("packing", validate);

}  // namespace packing_validation
