// Sums of charges and dipoles in a periodic box: lattice constants of crystals, twenty charges in quadruple precision,
// independence of the splitting, and truncation errors against estimates. Forces are compared with energy differences,
// induced dipoles with closed sums.
//
//   periodic         seconds
//   periodic long    also the energy of fifty polarizable elastic grains over 1e4 steps; minutes

#include "solvers/periodic/dipoles.hpp"

#include <fstream>
#include <nlohmann/json.hpp>
#include <numbers>

#include "solvers/periodic/screened.hpp"
#include "solvers/periodic/short_range.hpp"
#include "tests/periodic_sources.hpp"
#include "tests/source_folder.hpp"
#include "validation/harness.hpp"
#include "validation/program.hpp"

namespace periodic_validation {

using namespace lichtenberg;
using namespace lichtenberg::periodic;
using namespace lichtenberg::validation;
using std::numbers::pi;

namespace {

parallel::Team& alone = parallel::Team::single();

/// Relative error of sums of terms of order 1, each with about ten rounding errors.
constexpr double rounding = 4e-15;

double relative(double value, double exact) { return std::abs(value / exact - 1); }

double relative(const std::vector<double>& value, const std::vector<double>& exact) {
  return largest_difference(value, exact) / largest(exact);
}

double root_mean_square(const std::vector<double>& vectors) {
  double sum = 0;
  for (const double x : vectors) sum += x * x;
  return std::sqrt(3 * sum / static_cast<double>(vectors.size()));
}

double rms_difference(std::vector<double> a, const std::vector<double>& b) {
  for (std::size_t k = 0; k < a.size(); ++k) a[k] -= b[k];
  return root_mean_square(a);
}

// Constants.

void constants(Report& report) {
  report.section("constants, relative error");
  report.at_most("Madelung's constant of NaCl, 1.7475645946331822",
                 relative(by_ewald(rock_salt()).energy / 4, -1.7475645946331822), rounding);
  const SourceSet caesium_chloride = lattice(1, {{0, 0, 0}, {0.5, 0.5, 0.5}}, {1, -1});
  report.at_most("of CsCl, 1.7626747730709884",
                 relative(std::sqrt(0.75) * by_ewald(caesium_chloride).energy, -1.7626747730709884), rounding);
  const SourceSet charge = lattice(1, {{0.1, 0.2, 0.3}}, {1});
  report.at_most("one charge in its background, -2.8372974794806195",
                 relative(2 * by_ewald(charge).energy, -2.8372974794806195), rounding);
  SourceSet dipole = lattice(1, {{0.1, 0.2, 0.3}}, {0});
  dipole.dipole = {0, 0, 1};
  report.at_most("an isolated dipole's own field, 4 pi / 3", relative(by_ewald(dipole).field[2], 4 * pi / 3), rounding);
}

std::vector<double> numbers(const nlohmann::json& texts) {
  std::vector<double> result;
  for (const auto& text : texts.flatten())
    result.push_back(text.is_string() ? std::stod(text.get<std::string>()) : text.get<double>());
  return result;
}

void twenty_charges(Report& report) {
  std::ifstream file(source_folder() + "/validation/data/periodic/ewald20.json");
  const nlohmann::json exact = nlohmann::json::parse(file);
  const double length = exact["length"];
  const SourceSet sources{{length, length, length}, numbers(exact["position"]), numbers(exact["charge"])};
  report.section("twenty charges, 23 digits");
  for (const double alpha : {0.0, 7.0 / length, 13.7 / length}) {
    const Response response = by_ewald(sources, 1e-15, alpha);
    const std::string name = alpha == 0 ? "alpha chosen" : fmt::format("alpha L = {:.1f}", alpha * length);
    report.at_most(name + ": potentials", largest_difference(response.potential, numbers(exact["potential"])),
                   rounding);
    report.at_most(name + ": forces", largest_difference(response.force, numbers(exact["force"])), rounding);
    report.at_most(name + ": energy, relative",
                   relative(response.energy, std::stod(exact["energy"].get<std::string>())), rounding);
  }
}

/// Compares alpha L = 1.5, 5, 8 with 3: largest differences relative to the largest values.
void splitting(Report& report) {
  report.section("alpha from 1.5 to 8, in a box of 1 x 1.25 x .75; relative");
  for (const bool dipoles : {false, true}) {
    const SourceSet sources = random_sources(30, {1, 1.25, 0.75}, 0.05, dipoles, 1);
    const Response expected = by_ewald(sources, 1e-14, 3);
    std::vector<double> potential, force, energy;
    for (const double alpha : {1.5, 5.0, 8.0}) {
      const Response response = by_ewald(sources, 1e-14, alpha);
      potential.push_back(relative(response.potential, expected.potential));
      force.push_back(relative(response.force, expected.force));
      energy.push_back(relative(response.energy, expected.energy));
    }
    const std::string name = dipoles ? "charges, not neutral, with dipoles: " : "charges, not neutral: ";
    report.at_most(name + "potential", spread(potential), rounding);
    report.at_most(name + "force", spread(force), rounding);
    report.at_most(name + "energy", spread(energy), rounding);
  }
}

// Cut-offs.

/// Returns the difference in per cent of the rms force error at random positions from its estimate, for charges of +-1
/// in a unit cube (Kolafa and Perram 1992). The errors of 600 components scatter by about 3 %, and more if few pairs or
/// waves just beyond the cut-off contribute most.
template <class CutOff, class Estimate>
double off_estimate(double alpha, const CutOff& cut_off, const Estimate& estimate) {
  double measured2 = 0;
  constexpr int samples = 4, n = 200;
  for (int seed = 0; seed < samples; ++seed) {
    SourceSet sources = random_sources(n, {1, 1, 1}, 0, false, 10 + seed);
    for (double& q : sources.charge) q = q > 0 ? 1 : -1;
    Splitting split = splitting_for(sources, 1e-13, alpha);
    Ewald exact(split);
    cut_off(split);
    Ewald cut(split);
    measured2 += std::pow(rms_difference(evaluated(cut, sources).force, evaluated(exact, sources).force), 2) / samples;
  }
  return 100 * std::abs(std::sqrt(measured2) / estimate(n) - 1);
}

void estimates(Report& report) {
  report.section("rms force errors of cut-offs against their estimates, %");
  for (const double s : {1.5, 2.0, 2.5, 3.0, 3.5}) {
    const double cutoff = 0.4, alpha = s / cutoff;
    report.at_most(fmt::format("real space, alpha r_c = {}", s),
                   off_estimate(
                       alpha, [&](Splitting& split) { split.cutoff = cutoff; },
                       [&](int n) { return 2 * std::sqrt(n / cutoff) * std::exp(-s * s); }),
                   15);
  }
  for (const double s : {1.5, 2.0, 2.5, 3.0, 3.5}) {
    const int most = 8;
    const double alpha = pi * most / s;
    report.at_most(fmt::format("waves up to 8, pi n / (alpha L) = {}", s),
                   off_estimate(
                       alpha, [&](Splitting& split) { split.wave_cutoff = 2 * pi * (most + 1e-9); },
                       [&](int n) { return 2 * alpha * std::sqrt(n / (pi * most)) * std::exp(-s * s); }),
                   15);
  }
}

/// Returns a dense ball of grains of diameter 1 with charges of both signs, in a much larger box.
SourceSet cluster(double length) {
  const SourceSet random = random_sources(400, {1, 1, 1}, 0, false, 20);
  SourceSet sources{.lengths = {length, length, length}};
  for (int x = -4; x <= 4; ++x)
    for (int y = -4; y <= 4; ++y)
      for (int z = -4; z <= 4; ++z) {
        if ((x + y + z) % 2 != 0 || x * x + y * y + z * z > 12) continue;
        for (const int k : {x, y, z}) sources.position.push_back(k / std::sqrt(2.0));
        sources.charge.push_back(random.charge[sources.charge.size()]);
      }
  return sources;
}

void accuracy(Report& report) {
  report.section("largest field error over the requested error, in units of q / d^2");
  for (const bool clustered : {false, true}) {
    const SourceSet sources = clustered ? cluster(12) : random_sources(150, {12, 12, 12}, 1, false, 21);
    const Response exact = by_ewald(sources, 1e-15);
    const double unit = std::pow(sources.size() / Sources(sources).volume(), 2.0 / 3);
    for (const double tolerance : {1e-3, 1e-6, 1e-9, 1e-12})
      report.at_most(fmt::format("{} {}, tolerance {:.0e}", sources.size(),
                                 clustered ? "in a cluster" : "at random positions", tolerance),
                     largest_difference(by_ewald(sources, tolerance).field, exact.field) / unit / tolerance, 1);
  }
}

const std::pair<DipoleSum, std::string> variants[] = {{DipoleSum::ewald, "ewald"},
                                                      {DipoleSum::mixed_consistent, "mixed-consistent"},
                                                      {DipoleSum::minimum_image, "minimum-image"},
                                                      {DipoleSum::source, "source"}};

// Force derivatives.

/// Returns the largest deviation of the forces from fourth-order energy differences with displacements of 2e-3
/// diameters, relative to the largest force.
template <class Evaluate>
double slope_error(SourceSet sources, const Evaluate& evaluate) {
  const std::vector<double> force = evaluate(sources).force;
  double worst = 0;
  for (std::size_t k = 0; k < force.size(); ++k)
    worst = std::max(
        worst, std::abs(energy_slope(sources.position[k], 2e-3, [&] { return evaluate(sources).energy; }) + force[k]));
  return worst / largest(force);
}

Response with_induced(const SourceSet& sources, DipoleSum variant, double polarizability = 0.075) {
  Ewald ewald(1e-14);
  Response response;
  std::vector<double> dipole;
  InducedDipoles(ewald, variant, polarizability, 1e-13).evaluate(sources, {}, alone, dipole, response);
  return response;
}

/// Returns the asymmetry of the force derivatives, dF_i/dx_k - dF_k/dx_i, relative to the largest derivative.
double crosswise(SourceSet sources, DipoleSum variant) {
  const std::size_t n = sources.position.size();
  const double step = 1e-4;
  std::vector<std::vector<double>> slope(n);
  for (std::size_t k = 0; k < n; ++k) {
    const double at = std::exchange(sources.position[k], sources.position[k] + step);
    slope[k] = with_induced(sources, variant).force;
    sources.position[k] = at - step;
    const std::vector<double> below = with_induced(sources, variant).force;
    sources.position[k] = at;
    for (std::size_t i = 0; i < n; ++i) slope[k][i] = (slope[k][i] - below[i]) / (2 * step);
  }
  double difference = 0, most = 0;
  for (std::size_t k = 0; k < n; ++k)
    for (std::size_t i = 0; i < n; ++i) {
      most = std::max(most, std::abs(slope[k][i]));
      difference = std::max(difference, std::abs(slope[k][i] - slope[i][k]));
    }
  return difference / most;
}

void slopes(Report& report) {
  report.section("forces against slopes of the energy, of the largest force");
  // step^4 / 30 times the fifth derivative of 1/r, 120 / r^6 (of 1/r^3 2520 / r^8), of grains .9 apart: 1e-10 and 3e-9.
  const Vec3 box{4, 4.5, 5};
  report.at_most("8 charges",
                 slope_error(random_sources(8, box, 0.9, false, 8), [](const SourceSet& c) { return by_ewald(c); }),
                 1e-9);
  report.at_most("8 charges with dipoles",
                 slope_error(random_sources(8, box, 0.9, true, 8), [](const SourceSet& c) { return by_ewald(c); }),
                 5e-9);
  const SourceSet grains = random_sources(8, box, 0.9, false, 8);
  for (const auto& [variant, name] : variants) {
    const bool conservative = variant != DipoleSum::source;
    const auto evaluate = [v = variant](const SourceSet& sources) { return with_induced(sources, v); };
    report.at_most("induced dipoles, A = .075, " + name, slope_error(grains, evaluate),
                   conservative ? std::optional(1e-9) : std::nullopt);
    // step^2 / 6 times the energy's fourth derivative, 24 / .9^5, over its second, 2 / .9^3.
    const double uneven = crosswise(grains, variant);
    if (conservative)
      report.at_most("  its slopes crosswise, of the largest", uneven, 3e-8);
    else
      report.at_least("  its slopes crosswise, of the largest: no energy", uneven, 1e-4);
  }
}

// Induced dipoles.

void induced(Report& report) {
  report.section("induced dipoles against closed sums, relative");
  const double sum = 4 * 1.2020569031595942;
  SourceSet grain{
      .lengths = {7, 7, 1}, .position = {0, 0, 0}, .charge = {0}};  // the field of other rows is exp(-14 pi)
  Ewald ewald(1e-14);
  const DipoleField chain = field_by(ewald, grain, {}, alone);
  for (const double polarizability : {0.005, 0.075, 0.12, 0.2}) {
    std::vector<double> dipole(3);
    solve_dipoles(chain, std::vector<double>{0, 0, 1}, polarizability, 1e-13, dipole);
    report.at_most(fmt::format("touching chain, A = {}: A / (1 - 4 zeta(3) A)", polarizability),
                   relative(dipole[2], polarizability / (1 - sum * polarizability)),
                   1e-13 / (1 - sum * polarizability));
  }
  report.at_most("touching chain: largest A, 1 / (4 zeta(3))", relative(largest_polarizability(chain, 1), 1 / sum),
                 1e-9);
  const SourceSet packed =
      lattice(std::sqrt(2.0), {{0, 0, 0}, {0, 0.5, 0.5}, {0.5, 0, 0.5}, {0.5, 0.5, 0}}, {0, 0, 0, 0});
  report.at_most("dense packing (fcc): largest A, 3 / (4 pi sqrt(2))",
                 relative(largest_polarizability(field_by(ewald, packed, {}, alone), 4), 3 / (4 * pi * std::sqrt(2.0))),
                 1e-9);
}

void make_neutral(SourceSet& sources) {
  double sum = 0;
  for (const double q : sources.charge) sum += q;
  for (double& q : sources.charge) q -= sum / sources.size();
}

/// Returns the evaluations of the dipoles' field per step at a tolerance of 1e-4: from a zero initial guess, and from
/// the predictor's. Grains move by `stride` in fixed directions per step.
std::pair<double, double> applications_a_step(SourceSet sources, double stride) {
  const SourceSet velocity = random_sources(sources.size(), {1, 1, 1}, 0, true, 22);
  Ewald ewald(1e-6);
  const InducedDipoles induced(ewald, DipoleSum::ewald, 0.075, 1e-4);
  DipolePredictor predictor;
  Response response;
  double cold = 0, predicted = 0;
  constexpr int steps = 12, first = 4;  // the predictor's history is complete from then on
  for (int step = 0; step < steps; ++step) {
    std::vector<double> none, dipole = predictor.predict();
    if (step >= first) cold += induced.evaluate(sources, {}, alone, none, response);
    const int applications = induced.evaluate(sources, {}, alone, dipole, response);
    if (step >= first) predicted += applications;
    predictor.keep(dipole);
    for (std::size_t k = 0; k < sources.position.size(); ++k) sources.position[k] += stride * velocity.dipole[k];
  }
  return {cold / (steps - first), predicted / (steps - first)};
}

void predictor(Report& report) {
  report.section("fields of dipoles a step at A = .075, tolerance 1e-4");
  for (const bool clustered : {false, true}) {
    const SourceSet sources = clustered ? cluster(12) : random_sources(80, {9, 9, 9}, 1, false, 23);
    for (const double stride : {0.005, 0.0005}) {
      const auto [cold, predicted] = applications_a_step(sources, stride);
      const std::string name = fmt::format("{}, {} diameters a step", clustered ? "cluster" : "gas", stride);
      report.at_most(name + ": without a start", cold, std::nullopt);
      report.at_most(name + ": from the predictor's", predicted, cold - 1);  // the predictor must save evaluations
    }
  }
}

// Energy of moving grains.

/// Grains of diameter 1 with elastic contacts (Hertz, 278.6 xi^(3/2)), charges of +-1 and polarizability A = .075.
struct Elastic {
  SourceSet sources = random_sources(50, {7, 7, 7}, 1, false, 30);
  std::vector<double> velocity = random_sources(50, {1, 1, 1}, 0, true, 31).dipole;  // variance 1/3 per component

  double kinetic() const {
    double sum = 0;
    for (const double v : velocity) sum += 0.5 * v * v;
    return sum;
  }
};

void add_contacts(const SourceSet& sources, Response& response) {
  const Sources view = sources;
  for (int i = 0; i < sources.size(); ++i)
    for (int j = i + 1; j < sources.size(); ++j) {
      const Vec3 r = nearest_image(view.position_of(j) - view.position_of(i), sources.lengths);
      const double overlap = 1 - norm(r);
      if (!(overlap > 0)) continue;
      response.energy += 0.4 * 278.6 * std::pow(overlap, 2.5);
      const Vec3 push = 278.6 * std::pow(overlap, 1.5) / norm(r) * r;
      for (int k = 0; k < 3; ++k) {
        response.force[3 * i + k] -= push[k];
        response.force[3 * j + k] += push[k];
      }
    }
}

struct Drift {
  double largest = 0, last = 0;  ///< change of the energy over the initial kinetic energy
};

/// Integrates by velocity Verlet; the dipoles of each step start from the predictor's.
Drift energy_drift(DipoleSum variant, double tolerance, int steps) {
  Elastic gas;
  for (int i = 0; i < gas.sources.size(); ++i) gas.sources.charge[i] = i % 2 == 0 ? 1 : -1;
  Ewald ewald(1e-8);
  const InducedDipoles induced(ewald, variant, 0.075, tolerance);
  DipolePredictor predictor;
  const auto evaluate = [&] {
    Response response;
    std::vector<double> dipole = predictor.predict();
    induced.evaluate(gas.sources, {}, alone, dipole, response);
    predictor.keep(dipole);
    add_contacts(gas.sources, response);
    return response;
  };
  Response at = evaluate();
  const double dt = 0.005, scale = gas.kinetic(), start = scale + at.energy;
  Drift drift;
  for (int step = 0; step < steps; ++step) {
    for (std::size_t k = 0; k < gas.velocity.size(); ++k) {
      gas.velocity[k] += 0.5 * dt * at.force[k];
      gas.sources.position[k] += dt * gas.velocity[k];
    }
    at = evaluate();
    for (std::size_t k = 0; k < gas.velocity.size(); ++k) gas.velocity[k] += 0.5 * dt * at.force[k];
    drift.last = std::abs(gas.kinetic() + at.energy - start) / scale;
    drift.largest = larger(drift.largest, drift.last);
  }
  return drift;
}

void motion(Report& report) {
  report.section("fifty elastic grains over 1e4 steps of .005: energy lost or won, of the kinetic");
  for (const auto& [variant, name] : variants)
    for (const double tolerance : {1e-2, 1e-4, 1e-6}) {
      const Drift drift = energy_drift(variant, tolerance, 10000);
      const std::string what = fmt::format("{}, tolerance {:.0e}", name, tolerance);
      // Error of Verlet: (omega dt)^2 / 8 of each contact's energy, omega = pi / 0.2, which is 1e-3 if all energy were
      // in one contact.
      const std::optional<double> bound = variant == DipoleSum::ewald ? std::optional(1e-3) : std::nullopt;
      report.at_most(what + ": largest", drift.largest, bound, fmt::format("at the end {:.2g}", drift.last));
    }
}

/// Informative only: no bound exists.
void pairs_alone(Report& report) {
  report.section("sums over pairs alone, charges neutral in all: rms force error over rms force");
  for (const bool clustered : {false, true}) {
    SourceSet sources = clustered ? cluster(12) : random_sources(150, {12, 12, 12}, 1, false, 21);
    const std::string where = clustered ? " in a cluster" : " at random positions";
    make_neutral(sources);
    const std::vector<double> exact = by_ewald(sources).force;
    const auto error = [&](Sum& sum) {
      std::vector<Pair> pairs;
      for (int i = 0; i < sources.size(); ++i)
        for (int j = i + 1; j < sources.size(); ++j) pairs.push_back({i, j});
      Response response;
      sum.evaluate(sources, pairs, alone, response);
      return rms_difference(response.force, exact) / root_mean_square(exact);
    };
    MinimumImage half, all(MinimumImage::Reach::box);
    ShiftedForce shifted(6), damped(6, 0.3);
    report.at_most("nearest images within half a box" + where, error(half), std::nullopt);
    report.at_most("nearest images" + where, error(all), std::nullopt);
    report.at_most("shifted force" + where, error(shifted), std::nullopt);
    report.at_most("shifted force, damped, alpha r_c = 1.8" + where, error(damped), std::nullopt);
  }
}

}  // namespace

int validate(int argc, char** argv) {
  Report report("Charges and dipoles in a periodic box");
  constants(report);
  twenty_charges(report);
  splitting(report);
  estimates(report);
  accuracy(report);
  slopes(report);
  induced(report);
  predictor(report);
  pairs_alone(report);
  if (long_run_requested(argc, argv)) motion(report);
  return report.exit_status();
}

const lichtenberg::validation::Program program("periodic", validate);

}  // namespace periodic_validation
