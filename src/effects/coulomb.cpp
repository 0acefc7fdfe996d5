#include "src/effects/coulomb.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "solvers/error.hpp"
#include "solvers/neighbours/pairs.hpp"
#include "src/effects/coulomb_sum.hpp"
#include "src/effects/induced_dipoles.hpp"
#include "src/effects/multipole_truncation.hpp"
#include "src/model/checkpoint.hpp"
#include "src/model/frame.hpp"
#include "src/model/motion.hpp"
#include "src/scene/si.hpp"

namespace lichtenberg::effects {
namespace {

std::vector<double> scaled(std::vector<double> values, double factor) {
  for (double& value : values) value *= factor;
  return values;
}

/// Returns the relative accuracy of Coulomb forces (rms error over rms force). Sums over pairs alone have no error
/// bound; 1e-2 is their assumed accuracy.
double force_accuracy(const Scene& scene) {
  const auto& options = *scene.effects.find<CoulombOptions>();
  constexpr double pair_accuracy = 1e-2;
  return options.sum == CoulombSum::mesh || options.sum == CoulombSum::ewald ? options.accuracy : pair_accuracy;
}

std::string precision_in_words(const periodic::MeshChoice& choice, const periodic::MeshRequest& request) {
  if (choice.single) return "single precision";
  const std::string reason = periodic::why_not_single(request);
  return "double precision" + (reason.empty() ? "" : ", as " + reason);
}

/// Returns a line of `explain` about the truncation error of the multipole expansions; empty without an estimate.
std::vector<ExplanationLine> explain_degree(const Scene& scene) {
  const auto truncation =
      with_table_name(scene, "effects.induced_dipoles", [&] { return multipole_truncation(scene); });
  if (!truncation) return {};
  return {{"multipoles",
           fmt::format("effects.induced_dipoles.degree = {} leaves {}the attraction of two opposite charges in contact "
                       "off by {:.1e} of itself",
                       scene.effects.find<InducedDipolesOptions>()->degree,
                       truncation->at_start ? fmt::format("forces at the start off by {:.1e} of the largest, and ",
                                                          *truncation->at_start)
                                            : "",
                       truncation->in_contact)}};
}

/// Returns lines of `explain` about the mesh and the cutoff for the required accuracy; empty for other sums.
std::vector<ExplanationLine> explain_mesh(const Scene& scene) {
  const auto& options = *scene.effects.find<CoulombOptions>();
  if (options.sum != CoulombSum::mesh) return {};
  const periodic::MeshChoice choice = with_table_name(scene, "effects.coulomb", [&] { return mesh_for(scene); });
  const bool is_fixed = mesh_request(scene).fixed.complete();
  std::vector<ExplanationLine> explanation = {
      {"charges",
       fmt::format("forces {}: pairs up to {:.3g} d0, the rest on {} x {} x {} points with {} of order {}, in "
                   "{}; error {:.1e} of the rms force {}",
                   is_fixed ? "with the given parameters" : fmt::format("to {:g} of the rms force", options.accuracy),
                   choice.cutoff, choice.mesh.points[0], choice.mesh.points[1], choice.mesh.points[2],
                   choice.mesh.window == periodic::Window::prolate ? "prolate windows" : "splines", choice.mesh.order,
                   precision_in_words(choice, mesh_request(scene)), choice.error,
                   is_fixed || scene.domain.open ? "at random positions" : "where the grains are")}};
  if (const std::string warning = accuracy_warning(scene, choice); !warning.empty())
    explanation.push_back({"warning", warning});
  if (const std::string sides = sides_in_words(scene); !sides.empty()) explanation.push_back({"sides", sides});
  return explanation;
}

/// Throws InputError if the mutual polarization of the grains diverges at the start of a run.
void check_polarization(const Scene& scene) {
  if (scene.conductors.empty() || scene.effects.find<InducedDipolesOptions>()->degree > 1) return;
  Bodies bodies = make_bodies(scene);
  bodies.charge = initial_charges(scene);
  const Coulomb coulomb(scene);
  std::vector<Pair> pairs;
  if (const auto range = coulomb.needs().neighbour_range) pairs = pairs_closer_than(spheres<3>(bodies), *range);
  coulomb.stored_energy({.bodies = bodies, .neighbours = pairs});
}

/// Returns the relative permittivity of the grains, or its least and largest value.
std::string permittivities_in_words(const InducedDipolesOptions& dipoles, const Scene& scene) {
  double least = INFINITY, largest = 0;
  for (std::size_t i = 0; i < scene.conductors.size(); ++i) {
    const double permittivity = dipoles.relative_permittivity(i, scene.conductors[i].radius);
    least = std::min(least, permittivity), largest = std::max(largest, permittivity);
  }
  const std::string most = fmt::format("{:.3g}", largest);
  return least < largest ? fmt::format("{:.3g} to {}", least, most) : most;
}

std::vector<ExplanationLine> explain(const Scene& scene) {
  const auto* dipoles = scene.effects.find<InducedDipolesOptions>();
  if (!dipoles) return explain_mesh(scene);
  std::vector<ExplanationLine> explanation;
  if (dipoles->degree > 1)
    explanation.push_back(
        {"charges",
         fmt::format(
             "forces of dielectric spheres of relative permittivity {}, multipoles to degree {}, to {:g}, instead "
             "of effects.coulomb.sum; a run takes longer than the estimate below, which is for pairs and a mesh",
             permittivities_in_words(*dipoles, scene), dipoles->degree, dipoles->tolerance)});
  else
    explanation = explain_mesh(scene);
  check_polarization(scene);
  std::ranges::move(explain_degree(scene), std::back_inserter(explanation));
  return explanation;
}

void check_cutoff(const Draft& draft, Scene& scene) {
  const auto& options = *scene.effects.find<CoulombOptions>();
  constexpr double rounding = 1e-8;
  const double most = longest_cutoff(scene);
  if (!options.cutoff || *options.cutoff <= most * (1 + rounding)) return;
  refuse(scene.path, draft.line("effects.coulomb.cutoff"),
         fmt::format("effects.coulomb.cutoff = {:g} is not allowed in this box: at most {:g} is, half of its shortest "
                     "side minus the difference of the largest and the smallest diameter, because a charge would "
                     "otherwise meet two images of another",
                     *options.cutoff, most));
}

/// Throws InputError for sums that need a box in space with periodic sides.
void check_sides(const Draft& draft) {
  const auto& options = *draft.scene.effects.find<CoulombOptions>();
  if (enclosure_of(draft.scene.domain).is_periodic() || options.sum == CoulombSum::mesh) return;
  refuse(draft.scene.path, draft.line("effects.coulomb.sum"),
         fmt::format(
             "effects.coulomb.sum = \"{}\" is not allowed {}: \"mesh\" is", name_of(options.sum),
             draft.scene.dimension() == 2 ? "in two dimensions" : "in a domain that is not periodic along all axes"));
}

void check_coulomb(const Draft& draft) {
  const auto& options = *draft.scene.effects.find<CoulombOptions>();
  check_sides(draft);
  const auto only_with = [&](const std::string& key, bool allowed, const std::string& sums) {
    if (!allowed)
      refuse_if_given(
          draft, "effects.coulomb." + key,
          fmt::format("is not allowed with effects.coulomb.sum = \"{}\": it is for {}", name_of(options.sum), sums));
  };
  const bool far = options.sum == CoulombSum::mesh || options.sum == CoulombSum::ewald;
  const bool shifted = options.sum == CoulombSum::shifted_force;
  only_with("accuracy", far, "\"mesh\" and \"ewald\"");
  const bool mesh = options.sum == CoulombSum::mesh;
  only_with("cutoff", shifted || mesh, "\"mesh\" and \"shifted-force\"");
  for (const std::string key : {"alpha", "mesh", "order"}) only_with(key, mesh, "\"mesh\"");
  if (mesh && options.cutoff && options.mesh && options.order)
    refuse_if_given(
        draft, "effects.coulomb.accuracy",
        "is not allowed together with effects.coulomb.cutoff, mesh and order: they leave nothing to choose");
  constexpr double finest = 1e-8;  // of a mesh
  if (mesh && options.accuracy < finest)
    refuse(draft.scene.path, draft.line("effects.coulomb.accuracy"),
           fmt::format("effects.coulomb.accuracy = {:g} is not allowed with effects.coulomb.sum = \"mesh\": at least "
                       "{:g} and at most 0.1 is allowed",
                       options.accuracy, finest));
  only_with("damping", shifted, "\"shifted-force\"");
  if (shifted && draft.scene.effects.has("induced_dipoles"))
    refuse(draft.scene.path, draft.line("effects.coulomb.sum"),
           "effects.coulomb.sum = \"shifted-force\" is not allowed with effects.induced_dipoles, which it does not "
           "include: use \"mesh\", \"ewald\" or \"minimum-image\"");
}

void complete_coulomb(const Draft& draft, Scene& scene) {
  if (scene.in_si) scene.effects.find<CoulombOptions>()->strength = coupling_constant(*scene.reference);
  check_cutoff(draft, scene);
}

/// Returns the time (s) per grain of one evaluation, from an estimated mesh. The sphere solver replaces this sum.
double cost_of_charges(const Scene& scene) {
  const auto* dipoles = scene.effects.find<InducedDipolesOptions>();
  constexpr double usual = 1.6e-7;  // of a gas of 50016 grains at an accuracy of 1e-4
  if (dipoles) return dipoles->degree > 1 ? 0 : usual;
  if (scene.effects.find<CoulombOptions>()->sum != CoulombSum::mesh || scene.conductors.empty()) return usual;
  periodic::MeshRequest request = mesh_request(scene);
  request.accuracy = std::max(0.5 * request.accuracy, 1e-8);  // as choose_measured_mesh() tries first
  const periodic::Enclosure enclosure = enclosure_of(scene.domain);
  if (!enclosure.is_periodic()) request = enclosure.request(request);
  const periodic::MeshChoice choice = scene.domain.open ? mesh_for(scene) : periodic::choose_quick_mesh(request);
  return periodic::seconds_of(choice, request) / static_cast<double>(scene.conductors.size());
}

double strength_in(const Scene& scene) { return scene.effects.find<CoulombOptions>()->strength; }

std::vector<Key> keys() {
  return {
      {.name = "coupling_constant",
       .target = target<&CoulombOptions::strength>,
       .range = {.low = 0, .high = 1e100},
       .help = "strength of the Coulomb interaction between grains, K = k_e q0^2 / (m0 v0^2 d0) with Coulomb's "
               "constant k_e and the scales of [units]. A scene without [units] has its own K",
       .old_name = "strength",
       .scale = Key::Scale::reduced},
      {.name = "sum",
       .target = target<&CoulombOptions::sum>,
       .help =
           "method that sums the Coulomb forces of the grains. mesh: near pairs directly, far ones on a mesh; ewald: "
           "direct Ewald sum, the reference; minimum-image, shifted-force: pairs only, without an error bound"},
      {.name = "accuracy",
       .target = target<&CoulombOptions::accuracy>,
       .range = {.low = 1e-12, .high = 0.1},
       .help = "for sum = \"mesh\" or \"ewald\": rms error of the Coulomb forces over their rms value; determines the "
               "parameters of the sum that are not given; at least 1e-8 for \"mesh\""},
      {.name = "cutoff",
       .target = target<&CoulombOptions::cutoff>,
       .unit = "d0",
       .range = ranges::positive,
       .computed_default =
           "from the accuracy; for \"shifted-force\" 7, or 0.9 of the largest allowed value if that is less",
       .help = "for sum = \"mesh\" or \"shifted-force\": largest distance of pairs whose Coulomb force is summed "
               "directly, in reduced units (d0)"},
      {.name = "alpha",
       .target = target<&CoulombOptions::alpha>,
       .unit = "1/d0",
       .range = ranges::positive,
       .computed_default = "none: a prolate splitting",
       .help = "for sum = \"mesh\": Ewald's splitting parameter alpha, in reduced units (1/d0), with the near part "
               "erfc(alpha r) / r of 1 / r; without it the splitting is by prolate spheroidal functions"},
      {.name = "mesh",
       .target = target<&CoulombOptions::mesh>,
       .range = {.low = 8, .high = 1024},
       .computed_default = "from the accuracy",
       .help = "for sum = \"mesh\": number of mesh points along the longest side of the domain"},
      {.name = "order",
       .target = target<&CoulombOptions::order>,
       .range = {.low = 4, .high = 8},
       .computed_default = "from the accuracy",
       .help = "for sum = \"mesh\": order of the window functions that spread charges on the mesh. Where cutoff, mesh "
               "and order are all given, effects.coulomb.accuracy is not allowed"},
      {.name = "damping",
       .target = target<&CoulombOptions::damping>,
       .unit = "1/d0",
       .range = ranges::not_negative,
       .help = "for sum = \"shifted-force\": damping parameter alpha, in reduced units (1/d0), of the potential "
               "erfc(alpha r) / r; 0: the undamped 1 / r"}};
}

}  // namespace

const EffectKind& CoulombOptions::kind() {
  static const EffectKind kind = {
      .name = "coulomb",
      .description = "charges of grains attract and repel each other and periodic images",
      .help =
          "Charges of grains act on each other and, with sum = \"mesh\" or \"ewald\", on all their periodic images, in "
          "tin-foil boundaries (Singh 2019, equations 3.13 to 3.20, corrected). If the charges do not add up to 0, a "
          "uniform background then neutralizes the box. The other sums include nearest images only. Beyond insulating "
          "sides, and out of the plane in two dimensions, space is empty; a side { potential = 0 } is a grounded "
          "conductor with image charges.",
      .options = CoulombOptions{},
      .keys = keys(),
      .dimensions = {2, 3},
      .periodic = true,
      .grains = true,
      .check = check_coulomb,
      .complete = complete_coulomb,
      .make = [](const Scene& scene) { return std::make_unique<Coulomb>(scene); },
      .explain = explain,
      .charge_strength = strength_in,
      .steps = {.force_accuracy = force_accuracy,
                .contact_attraction =
                    [](const Scene& scene) { return ContactAttraction{.by_charge = strength_in(scene)}; }},
      .cost = {.seconds = cost_of_charges, .bytes = 850},  // at an accuracy of 1e-4
      .device = coulomb_on_device};
  return kind;
}

struct Coulomb::Implementation {
  explicit Implementation(const Scene& scene)
      : options(*scene.effects.find<CoulombOptions>()),
        sum(make_sum(scene, warning)),
        range(std::min(sum->cutoff(), longest_cutoff(scene)) - 2 * scene.smallest_radius()),
        wants_potentials(scene.effects.has("induced_dipoles") || scene.effects.has("charge_exchange")) {
    const auto* found = scene.effects.find<InducedDipolesOptions>();
    if (!found) return;
    polarization = *found;
    if (found->degree > 1)
      spheres.emplace(laplace::SphereOptions{.accuracy = found->tolerance, .degree = found->degree});
    else
      induced.emplace(*sum, found->sum, found->polarizability, found->tolerance, found->each);
  }

  bool polarizes() const { return induced || spheres; }

  auto with_remedy(const auto& work) {
    try {
      return work();
    } catch (const InputError& error) {
      const std::string message = std::string("effects.induced_dipoles: ") + error.what();
      if (evaluations == 0) throw InputError(message);
      throw Failure(message + "; a lower temperature or a stiffer contact keeps grains from overlapping so deeply");
    }
  }

  /// Computes potentials, fields, forces and energy for the current positions and charges, unless the last call did.
  const periodic::Response& response_for(const State& state) {
    const Bodies& bodies = state.bodies;
    if (bodies.position == position && bodies.charge == charge) return response;
    const periodic::Sources sources = sources_of(bodies);
    if (spheres) {
      iterations += with_remedy([&] { return polarize_spheres(bodies); });
    } else if (induced) {
      // Charges may change at constant positions, which is no step for the predictor.
      const bool moved = bodies.position != position;
      // Symmetry can hide growing dipole modes from the charges, so that evaluate() does not detect them.
      if (moved && evaluations % evaluations_a_check == 0)
        with_remedy([&] { induced->check_stability(sources, state.neighbours, state.team); });
      if (moved) dipole = predictor.predict();
      iterations +=
          with_remedy([&] { return induced->evaluate(sources, state.neighbours, state.team, dipole, response); });
      moved ? predictor.keep(dipole) : predictor.replace(dipole);
    } else {
      sum->evaluate(sources, state.neighbours, state.team, response);
      flatten(bodies, response.force);
    }
    position = bodies.position, charge = bodies.charge;
    if (state.time != forces_at) count();
    return response;
  }

  /// Computes forces bitwise identical to those of `response_for`; faster if potentials are not needed.
  const std::vector<double>& forces_for(const State& state) {
    const Bodies& bodies = state.bodies;
    if (wants_potentials || (bodies.position == position && bodies.charge == charge)) return response_for(state).force;
    sum->forces(sources_of(bodies), state.neighbours, state.team, force);
    flatten(bodies, force);
    count();
    forces_at = state.time;
    return force;
  }

  /// Returns the charges of the grains, in space.
  periodic::Sources sources_of(const Bodies& bodies) {
    if (bodies.dimension == 3) return {bodies.box.lengths, bodies.position, bodies.charge};
    in_space.assign(3 * bodies.charge.size(), 0);
    for (int i = 0; i < bodies.size(); ++i)
      for (int k = 0; k < 2; ++k) in_space[3 * i + k] = bodies.position[2 * i + k];
    return {bodies.box.lengths, in_space, bodies.charge};
  }

  /// Leaves the components of vectors in space along the axes of the bodies.
  static void flatten(const Bodies& bodies, std::vector<double>& vectors) {
    if (bodies.dimension == 3) return;
    for (int i = 0; i < bodies.size(); ++i)
      for (int k = 0; k < 2; ++k) vectors[2 * i + k] = vectors[3 * i + k];
    vectors.resize(2 * bodies.charge.size());
  }

  /// Counts an evaluation, unless it repeats an evaluation from before a checkpoint.
  void count() { evaluations += !std::exchange(found_again, false); }

  /// Solves the grains as dielectric spheres, in units with 4 pi eps = 1, and returns the number of iterations. The
  /// potential of other grains at a grain's centre is its potential minus q / R of its own charge. The field of other
  /// grains is its dipole divided by the polarizability.
  int polarize_spheres(const Bodies& bodies) {
    const laplace::SphereSolution solution = spheres->solve(dielectric_spheres(polarization, bodies));
    response = {.energy = solution.energy};
    dipole.clear();
    for (int i = 0; i < bodies.size(); ++i) {
      const double own = bodies.charge[i] / bodies.radius[i];
      response.potential.push_back(solution.group_potential[i] - own);
      response.energy -= 0.5 * bodies.charge[i] * own;
      for (int k = 0; k < 3; ++k) {
        dipole.push_back(solution.sphere_dipole[i][k]);
        response.field.push_back(dipole.back() / polarization.of(i));
        response.force.push_back(solution.sphere_force[i][k]);
      }
    }
    return solution.iterations;
  }

  /// Evaluations between two stability checks, each of which costs about as much as ten evaluations.
  static constexpr std::int64_t evaluations_a_check = 1000;

  CoulombOptions options;
  std::string warning;  ///< warning about the accuracy; empty: none
  std::unique_ptr<periodic::Sum> sum;
  double range;           ///< range between surfaces (d0)
  bool wants_potentials;  ///< true: potentials are needed in each step, because charges move
  InducedDipolesOptions polarization;
  std::optional<periodic::InducedDipoles> induced;
  std::optional<laplace::SphereSolver> spheres;  ///< used instead of `induced` and `sum` above degree 1
  periodic::DipolePredictor predictor;
  periodic::Response response;
  std::vector<double> force;
  std::vector<double> position, charge, dipole;  ///< input of `response`
  std::vector<double> in_space;                  ///< positions in space of grains in a plane
  /// Time of the last forces without potentials, whose evaluation is not counted again
  double forces_at = NAN;
  bool found_again = false;  ///< true: the next evaluation repeats one from before a checkpoint
  std::int64_t evaluations = 0, iterations = 0;
};

Coulomb::Coulomb(const Scene& scene) : implementation_(std::make_unique<Implementation>(scene)) {}
Coulomb::~Coulomb() = default;

Needs Coulomb::needs() const {
  Needs needs{.charges = true};
  if (implementation_->sum->cutoff() > 0) needs.neighbour_range = implementation_->range;
  return needs;
}

void Coulomb::add_forces(const State& state, std::span<double> force) const {
  const std::vector<double>& found = implementation_->forces_for(state);
  for (std::size_t k = 0; k < force.size(); ++k) force[k] += implementation_->options.strength * found[k];
}

double Coulomb::stored_energy(const State& state) const {
  return implementation_->options.strength * implementation_->response_for(state).energy;
}

/// Saves the counters, and with induced dipoles also the complete response (dipoles, potentials, fields and forces),
/// because dipoles depend on the initial guess within their tolerance. Without dipoles the response follows from
/// positions and charges. The solver of spheres discards its initial guess, in this run and in the restored one.
void Coulomb::save(Checkpoint& checkpoint) const {
  Implementation& self = *implementation_;
  if (self.spheres) self.spheres->forget();
  checkpoint.integers["counters"] = {self.evaluations, self.iterations};
  if (!self.polarizes()) return;
  checkpoint.reals["position"] = self.position;
  checkpoint.reals["charge"] = self.charge;
  checkpoint.reals["dipole"] = self.dipole;
  checkpoint.reals["potential"] = self.response.potential;
  checkpoint.reals["field"] = self.response.field;
  checkpoint.reals["force"] = self.response.force;
  checkpoint.reals["energy"] = {self.response.energy};
  int step = 0;
  for (const std::vector<double>& earlier : self.predictor.history())
    checkpoint.reals[fmt::format("dipole_{}", step++)] = earlier;
}

bool Coulomb::saves_exactly() const { return !implementation_->spheres; }

void Coulomb::restore(const Checkpoint& checkpoint) {
  Implementation& self = *implementation_;
  const std::vector<std::int64_t>& counters = integers(checkpoint, "counters");
  if (counters.size() != 2)
    throw Failure(
        "the checkpoint's counters of effects.coulomb are not those of this program: another version wrote them");
  self.evaluations = counters[0], self.iterations = counters[1];
  self.position.clear();
  self.forces_at = NAN;
  self.found_again = !self.polarizes() && self.evaluations > 0;
  if (self.spheres) self.spheres->forget();
  if (!self.polarizes()) return;
  const std::size_t n = checkpoint.reals.contains("charge") ? checkpoint.reals.at("charge").size() : 0;
  self.position = reals(checkpoint, "position", 3 * n);
  self.charge = reals(checkpoint, "charge", n);
  self.dipole = reals(checkpoint, "dipole", 3 * n);
  self.response = {reals(checkpoint, "potential", n), reals(checkpoint, "field", 3 * n),
                   reals(checkpoint, "force", 3 * n), reals(checkpoint, "energy", 1).front()};
  std::vector<std::vector<double>> history;
  for (std::string name; checkpoint.reals.contains(name = fmt::format("dipole_{}", history.size()));)
    history.push_back(reals(checkpoint, name, 3 * n));
  self.predictor.restore(std::move(history));
}

std::map<std::string, double> Coulomb::seconds() const {
  if (implementation_->options.sum != CoulombSum::mesh) return {};
  const auto [near, mesh] = implementation_->sum->seconds();
  return {{"near", near}, {"mesh", mesh}};
}

std::vector<std::string> Coulomb::warnings() const {
  if (implementation_->warning.empty()) return {};
  return {implementation_->warning};
}

void Coulomb::add_columns(const State& state, Frame& frame) const {
  Implementation& self = *implementation_;
  const periodic::Response& response = self.response_for(state);
  frame.add_particles("coulomb_potential", "q0/d0", response.potential);
  frame.add_vectors("coulomb_force", "m0 v0^2/d0", scaled(response.force, self.options.strength),
                    state.bodies.dimension);
  if (self.polarizes()) frame.add_vectors("dipole", "q0 d0", self.dipole, 3);
}

void Coulomb::summarize(const State&, Summary& summary) const {
  const Implementation& self = *implementation_;
  std::string text = fmt::format("computed {} times", self.evaluations);
  if (self.polarizes() && self.evaluations > 0)
    text += fmt::format(", with {:.2f} fields of {} each",
                        static_cast<double>(self.iterations) / static_cast<double>(self.evaluations),
                        self.spheres ? fmt::format("multipoles to degree {}", self.polarization.degree) : "dipoles");
  summary.lines.push_back({"charges' field", text});
}

}  // namespace lichtenberg::effects
