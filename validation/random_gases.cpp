// Random small gases: compares mesh sums of charges with Ewald's, and multirate steps with CVODE.
//
//   random_gases         ten of each
//   random_gases long    ten thousand
//   random_gases N [M]   N, from seed M on
//   random_gases N M sums    sums only; N M steps: motions only
//
// `fuzz gases` runs random scene files.

#include <cstdlib>
#include <string_view>

#include "solvers/neighbours/pairs.hpp"
#include "solvers/periodic/accuracy.hpp"
#include "solvers/periodic/dipoles.hpp"
#include "solvers/periodic/ewald.hpp"
#include "solvers/periodic/mesh.hpp"
#include "solvers/random.hpp"
#include "src/effects/coulomb.hpp"
#include "src/effects/linear_contact.hpp"
#include "tests/grains.hpp"
#include "validation/harness.hpp"
#include "validation/program.hpp"

namespace random_gases_validation {

using namespace lichtenberg;
using namespace lichtenberg::validation;

namespace {

class Sampler {
 public:
  explicit Sampler(std::uint64_t seed) : random_({.seed = seed, .purpose = RandomPurpose::population}) {}
  double uniform(double from, double to) { return random_.uniform(from, to); }
  double decades(double from, double to) { return std::pow(10.0, uniform(from, to)); }
  int whole(int from, int to) { return from + static_cast<int>(random_.uniform() * (to - from + 1.0)); }
  bool chance(double p) { return uniform(0, 1) < p; }
  double normal() { return random_.normal(); }
  Vec3 direction() {
    Vec3 v;
    for (int k = 0; k < 3; ++k) v[k] = normal();
    return (1 / norm(v)) * v;
  }

 private:
  Random random_;
};

/// Charges in a box, at least 1 apart.
struct ChargedGas {
  Vec3 lengths;
  std::vector<double> position, charge;
  double accuracy = 0;
  std::optional<double> polarizability;

  int size() const { return static_cast<int>(charge.size()); }
  double volume() const { return lengths.x * lengths.y * lengths.z; }
  periodic::Sources sources() const { return {lengths, position, charge}; }
  Box<3> box() const {
    Box<3> periodic_box{lengths};
    periodic_box.sides.fill(Boundary::periodic);
    return periodic_box;
  }
};

void add_position(ChargedGas& gas, Vec3 position) {
  for (int k = 0; k < 3; ++k)
    gas.position.push_back(position[k] - gas.lengths[k] * std::floor(position[k] / gas.lengths[k]));
}

bool is_free(const ChargedGas& gas, Vec3 position) {
  const Box<3> box = gas.box();
  for (std::size_t i = 0; 3 * i < gas.position.size(); ++i)
    if (norm(box.difference(position, {gas.position[3 * i], gas.position[3 * i + 1], gas.position[3 * i + 2]})) < 1)
      return false;
  return true;
}

/// Draws positions anywhere, or in contact with an existing charge.
void draw_positions(ChargedGas& gas, int wanted, Sampler& sampler) {
  const double touching = sampler.chance(0.5) ? 0 : sampler.uniform(0, 1);
  for (int attempt = 0; attempt < 50 * wanted && gas.position.size() < 3 * static_cast<std::size_t>(wanted);
       ++attempt) {
    Vec3 position = {sampler.uniform(0, gas.lengths.x), sampler.uniform(0, gas.lengths.y),
                     sampler.uniform(0, gas.lengths.z)};
    if (!gas.position.empty() && sampler.chance(touching)) {
      const int other = sampler.whole(0, static_cast<int>(gas.position.size() / 3) - 1);
      position = Vec3{gas.position[3 * other], gas.position[3 * other + 1], gas.position[3 * other + 2]} +
                 sampler.uniform(1, 1.02) * sampler.direction();
    }
    if (is_free(gas, position)) add_position(gas, position);
  }
}

/// Draws charges: of one size and both signs, all equal, Gaussian, of many sizes, or a single charge; in a unit from
/// 1e-3 to 1e3.
void draw_charges(ChargedGas& gas, Sampler& sampler) {
  const double unit = sampler.decades(-3, 3);
  const int n = static_cast<int>(gas.position.size() / 3), kind = sampler.whole(0, 4);
  for (int i = 0; i < n; ++i) {
    const double sign = i % 2 == 0 ? 1 : -1;
    const double sizes[] = {sign, 1, sampler.normal(), sign * sampler.decades(-4, 0), i == 0 ? 1.0 : 0.0};
    gas.charge.push_back(unit * sizes[kind]);
  }
}

ChargedGas draw_gas(Sampler& sampler) {
  ChargedGas gas{.accuracy = sampler.decades(-6, -1)};
  const int wanted = static_cast<int>(sampler.decades(0.31, 2.5));  // 2 to 316
  const double edge = std::max(std::cbrt(wanted / sampler.decades(-3, -0.5)), 2.5);
  for (int k = 0; k < 3; ++k) gas.lengths[k] = edge * sampler.uniform(1, sampler.chance(0.5) ? 1 : 2.5);
  draw_positions(gas, wanted, sampler);
  draw_charges(gas, sampler);
  if (sampler.chance(0.2)) gas.polarizability = sampler.uniform(0.001, 0.05);
  return gas;
}

std::vector<double> forces_by(periodic::Sum& sum, const ChargedGas& gas, parallel::Team& team) {
  const std::vector<double> radius(gas.charge.size());
  std::vector<Pair> pairs;
  if (sum.cutoff() > 0) pairs = pairs_closer_than(Spheres<3>{gas.position, radius, gas.box()}, sum.cutoff());
  periodic::Response response;
  std::vector<double> dipole;
  if (gas.polarizability)
    periodic::InducedDipoles(sum, periodic::DipoleSum::ewald, *gas.polarizability, 0.01 * gas.accuracy)
        .evaluate(gas.sources(), pairs, team, dipole, response);
  else
    sum.evaluate(gas.sources(), pairs, team, response);
  return response.force;
}

double rms(const std::vector<double>& force) {
  double squares = 0;
  for (const double f : force) squares += f * f;
  return std::sqrt(3 * squares / static_cast<double>(force.size()));
}

double rms_difference(std::vector<double> a, const std::vector<double>& b) {
  for (std::size_t k = 0; k < a.size(); ++k) a[k] -= b[k];
  return rms(a);
}

/// Returns the larger of the rms force and of that expected at random positions. The errors of near pairs are of the
/// size of the latter.
double scale_of(const ChargedGas& gas, const std::vector<double>& exact) {
  double charge2 = 0;
  for (const double q : gas.charge) charge2 += q * q;
  return std::max(rms(exact), periodic::random_force(charge2, gas.size(), gas.volume(), 1));
}

/// Ratios of the realised to the estimated error, and to the largest admissible error.
struct Estimated {
  SampleBySeed ratio, over_bound;
};

/// Returns the largest admissible ratio to an estimate, which is an rms over all positions. The truncation error of the
/// cloud is largest just beyond the cut-off. For a pair there it is sqrt(band limit cutoff) of the estimate over the
/// pair's own force (by quadrature). This part is half of the squared estimate, or all of it if the mesh is finer than
/// necessary. Dipoles induced there are negligible. Otherwise a few pairs determine the error, with squares near the
/// mean: the largest of n exponentially distributed values is ln n, and rarely ln n + 4.
double bound_for(const periodic::MeshChoice& choice, int cases) {
  return std::sqrt(std::max(2 * choice.band_limit * choice.cutoff, std::log(cases) + 4));
}

struct SumErrors {
  Estimated in_double, in_single, with_dipoles;
  SampleBySeed measured;
  int cases = 0;
  int refused = 0, threads_differ = 0;
};

periodic::MeshRequest request_for(const ChargedGas& gas) {
  return {.accuracy = gas.accuracy,
          .charges = gas.size(),
          .lengths = gas.lengths,
          .contact = 1,
          .polarizability = gas.polarizability};
}

void compare_sums(const ChargedGas& gas, std::uint64_t seed, SumErrors& errors) {
  parallel::Team one(1), two(2);
  periodic::Ewald ewald(1e-11);
  const std::vector<double> exact = forces_by(ewald, gas, one);
  const double scale = scale_of(gas, exact);
  const auto found = [&](const periodic::MeshChoice& choice, const std::vector<double>& force) {
    return rms_difference(force, exact) / choice.error;
  };
  periodic::MeshRequest request = request_for(gas);
  for (const bool only_double : {true, false}) {
    request.only_double = only_double;
    const periodic::MeshChoice choice = periodic::choose_quick_mesh(request);
    const auto sum = periodic::make_mesh_sum(choice);
    const std::vector<double> force = forces_by(*sum, gas, one);
    if (forces_by(*sum, gas, two) != force) ++errors.threads_differ;
    Estimated& estimated =
        gas.polarizability ? errors.with_dipoles : (choice.single ? errors.in_single : errors.in_double);
    const double ratio = found(choice, force) / scale;
    estimated.ratio.add(ratio, seed);
    estimated.over_bound.add(ratio / bound_for(choice, errors.cases), seed);
  }
  constexpr double rounding = 1e-9;  // forces on an isolated charge are below this
  if (gas.polarizability || gas.size() < 2 || rms(exact) < rounding * scale) return;
  const periodic::MeshChoice choice = periodic::choose_measured_mesh(request, gas.sources());
  const auto sum = periodic::make_mesh_sum(choice);
  errors.measured.add(
      rms_difference(forces_by(*sum, gas, one), exact) / rms(exact) / std::max(choice.error, gas.accuracy), seed);
}

void sums(Report& report, std::uint64_t first, int count) {
  report.section(fmt::format("sums of {} random gases of charges: error of forces over the requested error", count));
  SumErrors errors{.cases = count};
  for (std::uint64_t seed = first; seed < first + count; ++seed) {
    Sampler sampler(seed);
    const ChargedGas gas = draw_gas(sampler);
    try {
      compare_sums(gas, seed, errors);
    } catch (const std::exception& error) {
      ++errors.refused;
      fmt::print("seed {}: {}\n", seed, error.what());
    }
  }
  const auto judge = [&](const std::string& what, const Estimated& found) {
    const std::vector<double>& ratios = found.ratio.values;
    if (ratios.empty()) return;
    double squares = 0;
    for (const double ratio : ratios) squares += ratio * ratio / static_cast<double>(ratios.size());
    report.at_most(what, spread(ratios), std::nullopt, found.ratio.note());
    report.at_most("  root mean square", std::sqrt(squares), 1);
    report.at_most("  over the largest admissible error", spread(found.over_bound.values), 1, found.over_bound.note());
  };
  judge("mesh, by estimate", errors.in_double);
  judge("mesh in single precision, by estimate", errors.in_single);
  judge("with induced dipoles, by estimate", errors.with_dipoles);
  // The reference of the measurement has 1/30 of the requested error, and twice that in clusters.
  if (!errors.measured.values.empty())
    report.at_most("as a run has it, measured at the start", spread(errors.measured.values), 1 + 1.0 / 15,
                   errors.measured.note());
  report.at_most("one thread and two: other bits", errors.threads_differ, 0);
  report.at_most("without an answer", errors.refused, 0);
}

/// Draws a few grains that meet once or twice.
Scene draw_motion(Sampler& sampler, double& end) {
  Scene scene = grains::cube(sampler.uniform(4, 8));
  const int count = sampler.whole(2, 8);
  const double temperature = sampler.decades(-2, 1);
  if (sampler.chance(0.7))
    scene.effects.add(effects::ViscoelasticContactOptions{
        .elastic = sampler.decades(2.3, 4), .dissipative = sampler.chance(0.2) ? 0 : sampler.decades(0, 1.5)});
  else
    scene.effects.add(
        effects::LinearContactOptions{.stiffness = sampler.decades(2.5, 4), .restitution = sampler.uniform(0.3, 1)});
  if (sampler.chance(0.7))
    scene.effects.add(effects::CoulombOptions{
        .strength = temperature * sampler.decades(-2, 0.5), .sum = effects::CoulombSum::ewald, .accuracy = 1e-9});
  grains::add_gas(scene, count, scene.domain.size.x, temperature,
                  static_cast<std::uint64_t>(sampler.whole(1, 1 << 30)));
  for (std::size_t i = 0; i < scene.conductors.size(); ++i) scene.conductors[i].charge = i % 2 == 0 ? 1 : -1;
  end = std::min(2.0, 2 / std::sqrt(temperature));
  // Longer steps than granular::max_outer_step allows for constant slow forces would be refused.
  scene.mechanics.step = std::min(0.02 * end, 0.9 * granular::max_outer_step(granular::Gas(scene)));
  return scene;
}

std::vector<double> positions_at_end(Scene scene, Integrator integrator, int finer, double end) {
  scene.mechanics.integrator = integrator;
  scene.mechanics.step /= finer;
  scene.mechanics.contact_steps *= finer;
  grains::Run run(scene);
  run.to(end);
  const Bodies& b = run.gas.bodies();
  std::vector<double> positions = b.position;
  for (std::size_t k = 0; k < positions.size(); ++k)
    positions[k] += b.image[k] * b.box.lengths[static_cast<int>(k % 3)];
  return positions;
}

/// Compares motions. Steps are of second order: halving them changes the result by three times the remaining error.
void steps(Report& report, std::uint64_t first, int count) {
  report.section(
      fmt::format("{} random motions of few grains, multirate against cvode: rms distance of a grain", count));
  SampleBySeed coarse, ratio;
  int refused = 0;
  // Contacts with 45 substeps have an error of about 1e-6, depending on the phase of onset
  // (docs/measurements/granular.json).
  constexpr double contact_error = 1e-6;
  for (std::uint64_t seed = first; seed < first + count; ++seed) {
    Sampler sampler(seed + 1'000'000'000);
    double end = 0;
    const Scene scene = draw_motion(sampler, end);
    try {
      const std::vector<double> exact = positions_at_end(scene, Integrator::cvode, 1, end);
      const std::vector<double> one = positions_at_end(scene, Integrator::multirate, 1, end),
                                half = positions_at_end(scene, Integrator::multirate, 2, end);
      coarse.add(rms_difference(one, exact), seed);
      ratio.add(rms_difference(half, exact) / (rms_difference(half, one) + contact_error), seed);
    } catch (const std::exception& error) {
      ++refused;
      fmt::print("seed {}: {}\n", seed, error.what());
    }
  }
  report.at_most("at the scene's step (d0)", spread(coarse.values), std::nullopt, coarse.note());
  report.at_most("at half of it, over the change by halving", spread(ratio.values), 1, ratio.note());
  report.at_most("without an end", refused, 0);
}

}  // namespace

int validate(int argc, char** argv) {
  const bool all = long_run_requested(argc, argv);
  const int requested = argc > 1 && !all ? std::atoi(argv[1]) : 0, count = all ? 10000 : requested > 0 ? requested : 10;
  const std::uint64_t first = argc > 2 ? static_cast<std::uint64_t>(std::atoll(argv[2])) : 0;
  const std::string_view only = argc > 3 ? argv[3] : "";
  Report report("Random small gases");
  if (only != "steps") sums(report, first, count);
  if (only != "sums") steps(report, first, count);
  return report.exit_status();
}

const lichtenberg::validation::Program program("random_gases", validate);

}  // namespace random_gases_validation
