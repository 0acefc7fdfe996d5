#include "src/effects/floating_conductors.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "solvers/error.hpp"
#include "solvers/laplace/circuit.hpp"
#include "solvers/parallel/petsc.hpp"
#include "src/effects/contact_discharge.hpp"
#include "src/effects/current_injection.hpp"
#include "src/effects/field_choice.hpp"
#include "src/effects/floating_sides.hpp"
#include "src/effects/hertz_contact.hpp"
#include "src/effects/wall_contact.hpp"
#include "src/field_methods/field_method.hpp"
#include "src/model/neighbours.hpp"
#include "src/scene/ground.hpp"
#include "src/scene/touching.hpp"

namespace lichtenberg::effects {

namespace {

void add_sides(const Scene& scene, const NodeCharges& charges, laplace::LaplaceProblem& problem) {
  const std::array<double, 6> potential = side_potentials(scene, charges);
  for (std::size_t s = 0; s < problem.sides.size(); ++s) {
    using Kind = laplace::Side::Kind;
    problem.sides[s].kind = scene.domain.sides[s].electrode ? Kind::electrode : Kind::insulating;
    problem.sides[s].potential = potential[s];
  }
}

/// Returns half of `cells`, the number of grid cells along the longer side. Returns 0 if a side of this coarser grid
/// would have no whole number of cells. `size`: lengths of the domain (m).
int halved(Vec2 size, int cells) {
  const double shorter = cells * std::min(size.x, size.y) / std::max(size.x, size.y);
  return cells % 2 == 0 && std::lround(shorter) % 2 == 0 ? cells / 2 : 0;
}

/// Returns true if the centres of all bodies are inside the domain; false for a coordinate that is not a number.
bool all_inside(const Bodies& bodies) {
  const std::size_t d = bodies.dimension;
  bool inside = true;
  for (std::size_t k = 0; k < d; ++k) {
    if (bodies.box.periodic(static_cast<int>(k))) continue;
    const double length = bodies.box.lengths[k];
    for (std::size_t c = k; c < bodies.position.size(); c += d)
      inside &= bodies.position[c] >= 0 && bodies.position[c] <= length;
  }
  return inside;
}

/// Throws Failure for a body whose centre is outside the domain, where no field is defined.
void check_inside(const Scene& scene, const Bodies& bodies) {
  if (scene.domain.open || all_inside(bodies)) return;
  for (int i = 0; i < bodies.size(); ++i) {
    const int d = bodies.dimension;
    const Vec3 p = position_in_space(bodies, i);
    bool inside = true;
    for (int k = 0; k < d; ++k) inside &= bodies.box.periodic(k) || (p[k] >= 0 && p[k] <= bodies.box.lengths[k]);
    if (inside) continue;
    throw Failure(fmt::format(
        "conductor {} has left the domain and is at [{:g}] m{}", i,
        fmt::join(bodies.position.begin() + i * d, bodies.position.begin() + (i + 1) * d, ", "),
        scene.effects.has<WallContactOptions>() ? "" : ": [effects.wall_contact] in the scene would hold it"));
  }
}

/// Returns a message about an overlap of more than 1 % of a radius, which the field of spheres cannot solve and contact
/// forces should prevent; empty if there is none.
std::string overlap_message(const Scene& scene, const Bodies& bodies) {
  using laplace::deepest_contact;
  const auto message = [&](const std::string& subject, double depth, const std::string& effect, bool there) {
    return fmt::format(
        "{} by {:.3g} m, more than 1 % of the radius, which the field of spheres cannot solve: {}", subject, depth,
        there ? fmt::format("a larger effects.{}.young or a slower approach would keep them apart", effect)
              : fmt::format("[effects.{}] in the scene would keep them apart", effect));
  };
  for (const Pair pair : pairs_closer_than(bodies, 0)) {
    const double radius = std::min(bodies.radius[pair.i], bodies.radius[pair.j]);
    const Vec3 separation = bodies.box.difference(position_in_space(bodies, pair.i), position_in_space(bodies, pair.j));
    const double depth = bodies.radius[pair.i] + bodies.radius[pair.j] - norm(separation);
    if (depth > deepest_contact * radius)
      return message(fmt::format("conductors {} and {} overlap", pair.i, pair.j), depth, "hertz_contact",
                     scene.effects.has<HertzContactOptions>());
  }
  const bool walls = scene.effects.has<WallContactOptions>();
  const std::vector<Surface> sides = sides_of(scene.domain);
  for (int i = 0; i < bodies.size(); ++i) {
    const auto depth_in = [&](const Surface& surface) {
      return bodies.radius[i] - view(surface, position_in_space(bodies, i)).distance;
    };
    for (std::size_t s = 0; s < sides.size() && !scene.domain.open; ++s)
      if (const double depth = depth_in(sides[s]);
          !scene.domain.sides[s].periodic && depth > deepest_contact * bodies.radius[i])
        return message(fmt::format("conductor {} is pressed into the {} side of the domain", i, side_names[s]), depth,
                       "wall_contact", walls);
    for (const Electrode& electrode : scene.electrodes)
      if (const double depth = depth_in(surface_of(electrode, scene.domain));
          depth > deepest_contact * bodies.radius[i])
        return message(fmt::format("conductor {} is pressed into the electrode \"{}\"", i, electrode.name), depth,
                       "wall_contact", walls);
  }
  return "";
}

/// Returns the names of two touching bodies at different potentials, between which the force is unbounded; empty if
/// there are none. contact_discharge prevents such contacts.
std::string contact_at_different_potentials(const Bodies& bodies, const ElectricalGroups& groups,
                                            const std::vector<Terminal>& terminals) {
  for (const Pair pair : pairs_closer_than(bodies, 0))
    if (groups.id[pair.i] != groups.id[pair.j]) return fmt::format("conductors {} and {}", pair.i, pair.j);
  for (int i = 0; i < bodies.size(); ++i)
    for (const Terminal& terminal : terminals)
      if (!shares_group(groups, i, terminal) &&
          view(terminal.surface, position_in_space(bodies, i)).distance <= bodies.radius[i])
        return fmt::format("conductor {} and {}", i, terminal.name);
  return "";
}

/// Returns true if a field problem has resistors and they are its only connection to a potential source. At an instant
/// they carry no charge, so that the level of the potentials is undetermined.
bool is_only_behind_resistors(const auto& problem) { return !problem.couplings.empty() && !problem.has_ground(); }

/// Scales a correction of the predictor by the ratio of the force `now` to the force `then` (N) at the correction, at
/// most by 1. After a group merge forces differ, and a correction of the old force's size would be wrong.
Vec3 scaled_correction(Vec3 correction, double then, Vec3 now) {
  return then > 0 ? std::min(1.0, norm(now) / then) * correction : correction;
}

/// Returns the difference a - b of two field results for the conductors, with the terminals and resistors of a.
Electrostatics difference(Electrostatics a, const Electrostatics& b) {
  a.energy -= b.energy;
  for (std::size_t i = 0; i < b.force.size(); ++i) {
    a.force[i] -= b.force[i];
    a.charge[i] -= b.charge[i];
    a.potential[i] -= b.potential[i];
  }
  return a;
}

void check_floating_conductors(const Draft& draft) {
  if (!draft.permittivity && !draft.relative_permittivity)
    refuse_effect(draft, "floating_conductors", "medium.relative_permittivity, or medium.permittivity in F/m");
  check_resistors(draft);
  const int dimension = draft.domain_size.count == 3 ? 3 : 2;
  if (const FieldMethodKind* method = draft.field.method; method && !method->solves(dimension))
    refuse(draft.scene.path, draft.line("field.method"),
           fmt::format("field.method = \"{}\" is not allowed in {} dimensions: methods that are allowed: {}",
                       method->name, dimension == 3 ? "three" : "two",
                       field_methods_that(dimension, [](const FieldMethodKind&) { return true; })));
  if (dimension == 3) check_spheres(draft);
}

void complete_floating_conductors(const Draft& draft, Scene& scene) {
  const auto* source = scene.effects.find<CurrentInjectionOptions>();
  const bool fed =
      std::ranges::any_of(scene.circuits, [](const Circuit& circuit) { return circuit.current.has_value(); });
  check_ground(draft, scene,
               source && source->current != 0 ? "effects.current_injection"
               : fed                          ? "circuit.current"
                                              : "");
  if (!scene.effects.has<ContactDischargeOptions>()) check_touching(draft, scene);
  auto* field = std::get_if<FieldOptions>(&scene.field_table);
  if (field && field->method->moving_by_positions && !draft.field.moving_tolerance)
    field->moving_tolerance = usual_moving_tolerance(scene);
}

}  // namespace

laplace::LaplaceProblem make_laplace_problem(const Scene& scene, const Bodies& bodies, const ElectricalGroups& groups,
                                             const NodeCharges& charges) {
  ProblemBuffer buffer;
  fill_laplace_problem(scene, bodies, groups, charges, buffer);
  return std::move(buffer.problem);
}

void fill_laplace_problem(const Scene& scene, const Bodies& bodies, const ElectricalGroups& groups,
                          const NodeCharges& charges, ProblemBuffer& buffer) {
  auto& [problem, nodes] = buffer;
  check_dimension(bodies, 2);
  problem.size = plane(scene.domain.size);
  problem.permittivity = scene.medium.permittivity;
  add_sides(scene, charges, problem);
  std::swap(problem.groups, nodes.groups);
  find_groups_of_nodes(groups, charges, scene.medium.depth, nodes);
  std::swap(problem.groups, nodes.groups);
  problem.bodies.resize(bodies.size() + scene.electrodes.size());
  auto body = problem.bodies.begin();
  for (int i = 0; i < bodies.size(); ++i, ++body) {
    // Written in place, because copying a separately constructed body is more expensive.
    Disk& disk = body->shape.emplace<Disk>();
    disk.centre = {bodies.position[2 * i], bodies.position[2 * i + 1]};
    disk.radius = bodies.radius[i];
    body->group = nodes.group_of_node[i];
  }
  int node = bodies.size(), supply = -1;
  const int first_circuit = node_count(scene) - static_cast<int>(scene.circuits.size());
  for (const Electrode& electrode : scene.electrodes) {
    ++supply;
    if (electrode.circuit >= 0 || electrode.series_resistance > 0) {
      const int own = electrode.circuit >= 0 ? first_circuit + electrode.circuit : node++;
      *body++ = {electrode.shape, nodes.group_of_node[own]};
      continue;
    }
    *body++ = {electrode.shape, static_cast<int>(problem.groups.size())};
    problem.groups.push_back({.floating = false, .potential = charges.potential_of(supply, electrode.potential.value)});
  }
  problem.movable = bodies.size();
  problem.couplings.clear();
  add_couplings(groups, charges, nodes.group_of_node, scene.medium.depth, problem.groups, problem.couplings);
}

const FieldMethodKind* method_of(const FieldTable& table) {
  return std::visit([](const auto& field) { return field.method; }, table);
}

void check_device(FieldDevice device, const FieldMethodKind* method) {
  if (device != FieldDevice::cpu && method && !method->on_device)
    throw InputError(
        fmt::format("field.device = \"{}\" is not allowed with field.method = \"{}\", which runs on the CPU: "
                    "methods that can use another device: {}",
                    name_of(device), method->name,
                    field_methods_that(2, [](const FieldMethodKind& other) { return other.on_device; })));
}

void check_device(const Scene& scene) {
  if (!scene.effects.has<FloatingConductorsOptions>()) return;
  const FieldDevice device = std::visit([](const auto& field) { return field.device; }, scene.field_table);
  check_device(device, method_of(scene.field_table));
}

int predictor_cells(const Scene& scene) {
  const MechanicsOptions& mechanics = scene.mechanics;
  if (!mechanics.predictor || !mechanics.kind().reads("predictor")) return 0;
  if (!scene.field().method->follow || scene.conductors.empty()) return 0;
  if (has_circuit(scene)) return 0;     // small errors of potentials are large errors of currents
  constexpr double least_radius = 1.9;  // cells
  const double smallest = scene.smallest_radius();
  const double side = std::max(scene.domain.size.x, scene.domain.size.y);
  int cells = scene.field().cells;
  for (int next = cells; next > 0 && smallest * next >= least_radius * side;
       next = halved(plane(scene.domain.size), next))
    cells = next;
  return cells <= scene.field().cells / 4 ? cells : 0;
}

std::unique_ptr<laplace::LaplaceSolver> make_field_solver(const FieldOptions& options) {
  check_device(options.device, options.method);
  return options.method->make(options);
}

bool is_inside_integrator(const Scene& scene) { return scene.mechanics.kind().solves_field_inside; }

void check_can_move(const Scene& scene) {
  const FieldMethodKind* method = method_of(scene.field_table);
  if (!method || !method->only_separate || !scene.effects.has<FloatingConductorsOptions>()) return;
  if (scene.effects.has<HertzContactOptions>() && scene.effects.has<WallContactOptions>()) return;
  throw InputError(
      fmt::format("{}: field.method = \"{}\" in a run needs [effects.{}]: it cannot solve disks that overlap {}, which "
                  "no other effect prevents; methods without this need: {}",
                  scene.path, method->name, scene.effects.has<HertzContactOptions>() ? "wall_contact" : "hertz_contact",
                  scene.effects.has<HertzContactOptions>() ? "a side or an electrode" : "each other",
                  field_methods_that(2, [](const FieldMethodKind& other) { return !other.only_separate; })));
}

void check_processes(const FieldTable* field) {
  const int processes = parallel::process_count();
  if (processes == 1) return;
  std::string what = "a scene without a field", instead = "leave mpirun out";
  if (field) {
    const FieldMethodKind* method = method_of(*field);
    const auto device = std::visit([](const auto& table) { return table.device; }, *field);
    const auto linear_solver = std::visit([](const auto& table) { return table.linear_solver; }, *field);
    const bool shares = device == FieldDevice::cpu || linear_solver == FieldLinearSolver::assembled;
    if (method && method->on_processes && shares) return;
    what = !method                ? "field.accuracy without a field.method"
           : method->on_processes ? fmt::format("field.device = \"{}\"", name_of(device))
                                  : fmt::format("field.method = \"{}\"", method->name);
    instead = "set field.method = \"cut-cell\" without a device, or leave mpirun out";
  }
  throw InputError(
      fmt::format("{} runs on one process, and mpirun started {} processes: {}", what, processes, instead));
}

const EffectKind& FloatingConductorsOptions::kind() {
  static const EffectKind kind = {
      .name = "floating_conductors",
      .description = "the electric field between conductors with given charges, and its forces",
      .help =
          "Electrostatics of conductors of given charges: the potential between them, from Laplace's equation, and the "
          "forces on them (Stephenson 2018, eq. 5.3).",
      .options = FloatingConductorsOptions{},
      .dimensions = {2, 3},
      .periodic = true,
      .field = true,
      .check = check_floating_conductors,
      .complete = complete_floating_conductors,
      .check_run = [](const Scene& scene) { check_device(scene), check_can_move(scene); },
      .make = [](const Scene& scene) { return make_floating_conductors(scene); }};
  return kind;
}

std::unique_ptr<FloatingConductors> make_floating_conductors(const Scene& scene) {
  FieldOptions moving = scene.field();
  const bool in_space = scene.dimension() == 3;
  if (!(in_space && is_inside_integrator(scene))) moving.tolerance = moving.moving_tolerance;
  if (in_space) return std::make_unique<FloatingConductors>(scene, make_sphere_solver(moving, scene.conductors.size()));
  const int cells = predictor_cells(scene);
  auto solver = make_field_solver(moving);
  if (cells == 0) return std::make_unique<FloatingConductors>(scene, std::move(solver));
  moving.cells = cells;
  moving.cuda_devices.clear();                          // too few cells for several
  moving.tolerance = std::max(moving.tolerance, 1e-3);  // the grid's own error is at least ten times this value
  auto predictor = make_field_solver(moving);
  moving.method->follow(*solver, *predictor);
  auto effect = std::make_unique<FloatingConductors>(scene, std::move(solver));
  effect->set_predictor(std::move(predictor));
  return effect;
}

FloatingConductors::FloatingConductors(const Scene& scene, std::unique_ptr<laplace::LaplaceSolver> solver)
    : scene_(scene), solver_(std::move(solver)), terminals_(terminals_of(scene)) {}

FloatingConductors::FloatingConductors(const Scene& scene, laplace::SphereSolver solver)
    : scene_(scene), spheres_(std::move(solver)), terminals_(terminals_of(scene)) {}

void FloatingConductors::add_forces(const State& state, std::span<double> force) const {
  if (!extrapolated_) return;
  for_each_requested(state, [&](int i) {
    const Vec3 extrapolated = extrapolated_->force_at(i, state.time);
    for (int k = 0; k < state.bodies.dimension; ++k) force[i * state.bodies.dimension + k] += extrapolated[k];
  });
}

Electrostatics FloatingConductors::solve(const Bodies& bodies, const ElectricalGroups& groups,
                                         const NodeCharges& charges) {
  if (spheres_) return solve_in_space(bodies, groups, charges);
  fill_problem(bodies, groups, charges, problem_);
  const std::vector<FloatingSides> floating = floating_sides(scene_, problem_.nodes.group_of_node);
  const laplace::LaplaceSolution solution = floating.empty()
                                                ? solver_->solve(problem_.problem)
                                                : solve_with_floating_sides(problem_.problem, floating, *solver_);
  if (scene_.field_accuracy()) last_problem_ = problem_.problem;
  ++solves_;
  iterations_ += solution.iterations;
  return in_si(problem_, solution, groups, charges);
}

Electrostatics FloatingConductors::solve_in_space(const Bodies& bodies, const ElectricalGroups& groups,
                                                  const NodeCharges& charges) {
  check(bodies, groups);
  if (const std::string message = overlap_message(scene_, bodies); !message.empty()) {
    if (solves_ == 0) throw InputError(message);
    throw Failure(message);
  }
  laplace::SphereProblem problem = make_sphere_problem(scene_, bodies, groups, charges);
  if (is_only_behind_resistors(problem)) neutralize(problem.groups);
  const std::vector<int> group_of_node = groups_of_nodes(groups, charges, 1).group_of_node;
  const std::vector<FloatingSides> floating = floating_sides(scene_, group_of_node);
  const laplace::SphereSolution solution =
      floating.empty() ? spheres_->solve(problem) : solve_with_floating_sides(problem, floating, *spheres_);
  ++solves_;
  iterations_ += solution.iterations;
  Electrostatics result = electrostatics_of(scene_, problem, solution);
  result.carried = carried_by_resistors(
      groups, charges, floating.empty() ? solution.coupling_charge : coupling_charges(problem, solution), 1);
  add_circuits(terminals_, charges,
               circuit_potentials(solution.group_potential, group_of_node, scene_.conductors.size()), result);
  if (is_only_behind_resistors(problem)) set_level(result, charges);
  return result;
}

Electrostatics FloatingConductors::predict(const Bodies& bodies, const ElectricalGroups& groups,
                                           const NodeCharges& charges) {
  fill_problem(bodies, groups, charges, predicted_problem_);
  coarse_ = predictor_->solve(predicted_problem_.problem);
  ++predictions_;
  Electrostatics predicted = in_si(predicted_problem_, coarse_, groups, charges);
  predicted.energy += correction_.energy;
  const std::size_t n = corrected_norm_.size();
  for (std::size_t i = 0; i < n; ++i)
    predicted.force[i] += scaled_correction(correction_.force[i], corrected_norm_[i], predicted.force[i]);
  for (std::size_t i = 0; i < n; ++i) predicted.charge[i] += correction_.charge[i];
  for (std::size_t i = 0; i < n; ++i) predicted.potential[i] += correction_.potential[i];
  return predicted;
}

void FloatingConductors::forget() {
  if (solver_) solver_->forget();
  if (spheres_) spheres_->forget();
  if (predictor_) predictor_->forget();
}

void FloatingConductors::correct(const Electrostatics& solved) {
  const Electrostatics coarse = conductor_results(predicted_problem_, coarse_);
  correction_ = difference(solved, coarse);
  corrected_norm_.clear();
  for (const Vec3 force : coarse.force) corrected_norm_.push_back(norm(force));
}

void FloatingConductors::check(const Bodies& bodies, const ElectricalGroups& groups) const {
  check_inside(scene_, bodies);
  check_contacts(bodies, groups);
}

void FloatingConductors::fill_problem(const Bodies& bodies, const ElectricalGroups& groups, const NodeCharges& charges,
                                      ProblemBuffer& buffer) const {
  check(bodies, groups);
  fill_laplace_problem(scene_, bodies, groups, charges, buffer);
  if (is_only_behind_resistors(buffer.problem)) neutralize(buffer.problem.groups);
}

/// Converts a solution per metre of depth to the scene's depth, for conductors only, without terminals and resistors.
Electrostatics FloatingConductors::conductor_results(const ProblemBuffer& buffer,
                                                     const laplace::LaplaceSolution& solution) const {
  const double depth = scene_.medium.depth;
  const std::size_t n = scene_.conductors.size();
  Electrostatics result{.force = std::vector<Vec3>(n),
                        .charge = std::vector<double>(n),
                        .potential = std::vector<double>(n),
                        .energy = depth * solution.energy};
  for (std::size_t i = 0; i < n; ++i) result.force[i] = in_space(depth * solution.body_force[i]);
  for (std::size_t i = 0; i < n; ++i) result.charge[i] = depth * solution.body_charge[i];
  for (std::size_t i = 0; i < n; ++i) result.potential[i] = solution.group_potential[buffer.nodes.group_of_node[i]];
  return result;
}

Electrostatics FloatingConductors::in_si(const ProblemBuffer& buffer, const laplace::LaplaceSolution& solution,
                                         const ElectricalGroups& groups, const NodeCharges& charges) const {
  const double depth = scene_.medium.depth;
  const laplace::LaplaceProblem& problem = buffer.problem;
  const std::size_t n = scene_.conductors.size();
  Electrostatics result = conductor_results(buffer, solution);
  result.carried = carried_by_resistors(groups, charges, laplace::coupling_charges(problem, solution), depth);
  for (std::size_t b = n; b < problem.bodies.size(); ++b) {
    result.terminal_charge.push_back(depth * solution.body_charge[b]);
    result.terminal_potential.push_back(solution.group_potential[problem.bodies[b].group]);
  }
  for (std::size_t s = 0; s < problem.sides.size(); ++s) {
    if (problem.sides[s].kind != laplace::Side::Kind::electrode) continue;
    result.terminal_charge.push_back(depth * solution.side_charge[s]);
    result.terminal_potential.push_back(problem.sides[s].potential);
  }
  add_circuits(terminals_, charges, circuit_potentials(solution.group_potential, buffer.nodes.group_of_node, n),
               result);
  if (is_only_behind_resistors(problem)) set_level(result, charges);
  return result;
}

void FloatingConductors::check_contacts(const Bodies& bodies, const ElectricalGroups& groups) const {
  if (scene_.effects.has<ContactDischargeOptions>()) return;
  const std::string touching = contact_at_different_potentials(bodies, groups, terminals_);
  if (touching.empty()) return;
  const std::string message = touching +
                              " touch at different potentials, and the force between them has no limit: "
                              "[effects.contact_discharge] in the scene would connect them";
  if (solves_ == 0) throw InputError(message);
  throw Failure(message);
}

}  // namespace lichtenberg::effects
