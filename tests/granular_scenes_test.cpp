// Tests of scenes of grains: charges drawn by populations, contacts in SI units, and error messages.
#include <doctest/doctest.h>

#include <fmt/format.h>

#include <cmath>
#include <numeric>

#include "solvers/error.hpp"
#include "src/effects/charge_exchange.hpp"
#include "src/effects/read_scene.hpp"
#include "src/effects/viscoelastic_contact.hpp"
#include "src/granular/gas.hpp"
#include "src/granular/granular_motion.hpp"
#include "src/granular/restitution_check.hpp"
#include "tests/folder.hpp"
#include "tests/message.hpp"

namespace granular_scenes_test {

using namespace lichtenberg;
using doctest::Approx;

namespace {

const std::string periodic = R"(
left = "periodic"
right = "periodic"
bottom = "periodic"
top = "periodic"
)";
const std::string box = "[units]\n[domain]\nsize = [12, 12, 12]" + periodic + R"(
front = "periodic"
back = "periodic"
)";
const std::string grains = "[[population]]\ncount = 200\ntemperature = 1\n";
const std::string contact = "[effects.viscoelastic_contact]\n";
const std::string coulomb = "[effects.coulomb]\n";
const std::string exchange = "[effects.charge_exchange]\n";

Scene parse(const std::string& text) { return parse_scene(text, "gas.toml"); }

/// Error message of a run of the scene up to its end; empty if there is none.
std::string error_message_of(const std::string& text) {
  return message_of([&] {
    GranularMotion motion(parse(text));
    while (!motion.finished()) motion.advance_to(motion.next_frame(), {});
  });
}

std::vector<double> charges_of(const std::string& keys, int count) {
  const std::string population = "[[population]]\nmin_gap = 0\ncount = " + std::to_string(count) + "\n" + keys;
  std::vector<double> charges;
  for (const Conductor& grain : parse(replaced(box, "[12, 12, 12]", "[30, 30, 30]") + population + contact).conductors)
    charges.push_back(grain.charge);
  return charges;
}

double sum(const std::vector<double>& values) { return std::accumulate(values.begin(), values.end(), 0.0); }

/// <q^2> and <q^4> / <q^2>^2.
std::pair<double, double> moments(const std::vector<double>& charges) {
  double square = 0, fourth = 0;
  for (const double q : charges) square += q * q, fourth += q * q * q * q;
  const auto n = static_cast<double>(charges.size());
  return {square / n, fourth * n / (square * square)};
}

}  // namespace

TEST_CASE("population charges: equal, Gaussian or exp(-|q|^z) with known moments") {
  CHECK(sum(charges_of("charge = 0.5\n", 100)) == 50);
  constexpr int n = 4000;
  struct ChargeCase {
    std::string keys;
    double square, kurtosis;
  };
  // Gamma(3/z) / Gamma(1/z) and Gamma(5/z) Gamma(1/z) / Gamma(3/z)^2.
  const auto shape = [](double z) {
    return std::pair{std::tgamma(3 / z) / std::tgamma(1 / z),
                     std::tgamma(5 / z) * std::tgamma(1 / z) / std::pow(std::tgamma(3 / z), 2)};
  };
  const std::string power = "charge_distribution = \"exponential-power\"\ncharge_exponent = ";
  for (const auto& [keys, square, kurtosis] : {ChargeCase{"charge_distribution = \"gaussian\"\n", 1, 3},
                                               ChargeCase{power + "1\n", shape(1).first, shape(1).second},
                                               ChargeCase{power + "2\n", shape(2).first, shape(2).second},
                                               ChargeCase{power + "8\n", shape(8).first, shape(8).second}}) {
    const std::vector<double> one = charges_of("charge = 1\n" + keys, n), two = charges_of("charge = 2\n" + keys, n);
    CHECK(sum(one) == 0);
    const auto [found, fourth] = moments(one);
    // The mean of n squares has a standard deviation of sqrt((kurtosis - 1) / n); the bound is four of these.
    CHECK(found == Approx(square).epsilon(4 * std::sqrt((kurtosis - 1) / n)).scale(0));
    CHECK(fourth == Approx(kurtosis).epsilon(kurtosis > 5 ? 0.5 : 0.2).scale(0));
    for (std::size_t k = 0; k < one.size(); ++k) REQUIRE(two[k] == 2 * one[k]);
  }
}

TEST_CASE("charge_exchange with a sign: explanation states saturation and growth") {
  const auto text = [&](const std::string& keys) {
    const Scene scene =
        parse(box + grains + contact + exchange + "model = \"size\"\ntransfer_prefactor = 0.01\n" + keys);
    return effects::ChargeExchangeOptions::kind().explain(scene).at(0).text;
  };
  CHECK(
      text("feedback = -4\nmemory = 9\n") ==
      "0.01 q0 times the drive per collision of energy 1 m0 v0^2, by size; two grains saturate at a difference of 0.25 "
      "q0 times the drive; 1/e of it after 9 collisions");
  CHECK(text("feedback = 4\ncapacity = 2\n").ends_with("grow by 1.08 per collision, up to charges of 2 q0"));
  const Scene random = parse(box + grains + contact + exchange);
  CHECK(effects::ChargeExchangeOptions::kind().explain(random).empty());
}

TEST_CASE("charge_exchange.model = \"none\": population charges stay constant") {
  const std::string charged =
      "[[population]]\ncount = 60\ntemperature = 1\ncharge = 1\ncharge_distribution = \"gaussian\"\n";
  const Scene scene =
      parse(box + charged + contact + "[effects.charge_exchange]\nmodel = \"none\"\n[stop]\ntime = 1\n");
  GranularMotion motion(scene);
  motion.advance_to(1, {});
  const std::vector<double> after = motion.frame().reals("charge");
  for (std::size_t k = 0; k < after.size(); ++k) REQUIRE(after[k] == scene.conductors[k].charge);
}

TEST_CASE("viscoelastic_contact in SI units: gives the published scaled numbers") {
  // G table 5.3: alpha = 2.67e4, beta = 12.8 with d0 = 4.78e-3, m0 = 1.52e-4, v0 = 1 give E = 277.5, D = 27.83. With nu
  // = 0.25, alpha = Y 2 sqrt(d0/4) / (3 (1 - nu^2)) and gamma = beta / alpha.
  const double young = 2.67e4 * 3 * (1 - 0.0625) / (2 * std::sqrt(4.78e-3 / 4));
  const Scene scene =
      parse(box + grains + contact +
            fmt::format("young = {:.17g}\npoisson = 0.25\nviscosity = {:.17g}\n", young, 12.8 / 2.67e4));
  const auto& options = *scene.effects.find<effects::ViscoelasticContactOptions>();
  CHECK(options.elastic == Approx(277.5).epsilon(2e-4).scale(0));  // Four digits.
  CHECK(options.dissipative == Approx(27.83).epsilon(2e-4).scale(0));
}

TEST_CASE("contacts too short for any step: the error names the responsible keys") {
  const std::string stage = "[[equilibration]]\nduration = 0.5\nstiffness = ";
  const auto said = [](const std::string& text, const std::string& part) {
    const std::string sentence = error_message_of(box + grains + contact + text);
    CAPTURE(sentence);
    CHECK(sentence.find(part) != std::string::npos);
  };
  said(stage + "1e300\n", "equilibration.stiffness = 1e+300");
  said(stage + "1e300\n", "at most 1e+15");
  said("stiffness = 1e60\n", "softer contacts (stiffness)");  // E to the power -2/5: 1e-24 of about 0.2 t0.
  said("stiffness = 1e60\n" + stage + "10\n", "softer contacts (equilibration.stiffness, stiffness)");
}

TEST_CASE("equilibration.stiffness: restitution is kept and energy balances") {
  for (const std::string law : {"[effects.viscoelastic_contact]\n", "[effects.linear_contact]\nrestitution = 0.6\n"}) {
    const std::string stage = "[[equilibration]]\nduration = 0.5\nelastic = false\nstiffness = 10\n";
    granular::Gas gas(parse(box + grains + law + stage)), plain(parse(box + grains + law));
    for (const double speed : {0.1, 5.0}) {
      const auto stiff = granular::expected_collision(gas.law(), 0.5, 1, speed);
      const auto soft = granular::expected_collision(plain.law(), 0.5, 1, speed);
      // Accurate to the smoothness of the table in k: both look up the same k.
      CHECK(stiff.restitution == Approx(soft.restitution).epsilon(1e-12).scale(0));
      CHECK(stiff.duration < 0.5 * soft.duration);  // By 10^(2/5) and 10^(1/2)
    }
    const double before = gas.energy().total();
    CHECK_FALSE(gas.in_elastic_stage());
    gas.follow_contacts(gas.instant(), 0.2);
    REQUIRE(!gas.contacts().empty());
    const double followed = gas.energy().total();
    const double stored = gas.energy().contact;
    gas.leave_stage();
    CHECK(gas.energy().contact < 0.2 * stored);  // 10 %
    CHECK(gas.energy().total() == Approx(followed).epsilon(1e-12).scale(before));
  }
}

TEST_CASE("mechanics.step too long or too short: refused before any output") {
  const std::string still = "[mechanics]\nstep = 1e-300\n[stop]\ntime = 1\n";
  CHECK_THROWS_AS(GranularMotion(parse(box + grains + contact + still)), InputError);
  const std::string verlet = "[mechanics]\nintegrator = \"verlet\"\nstep = 0.1\n";
  CHECK_THROWS_AS(GranularMotion(parse(box + grains + contact + verlet)), InputError);
}

TEST_CASE("step below rounding of time: short stage refused, run ends with message") {
  const auto stage_scene = [](const std::string& duration, const std::string& more) {
    return box + grains + contact + "[[equilibration]]\nduration = 0.5\n[[equilibration]]\nduration = " + duration +
           "\n" + more + "[stop]\ntime = 0.6\n";
  };
  for (const std::string duration : {"1e-17", "4.9e-13"})
    CHECK_MESSAGE(error_message_of(stage_scene(duration, "")).find("is not allowed in a stage that ends at 0.5 t0") !=
                      std::string::npos,
                  error_message_of(stage_scene(duration, "")));
  CHECK(error_message_of(stage_scene("1e-12", "")).empty());
  const std::string still = error_message_of(stage_scene("0.01", "temperature = 1e49\n"));
  CHECK_MESSAGE(still.find("time does not advance any more: at t = 0.51 t0") != std::string::npos, still);
}

TEST_CASE("extreme parameters of grains: gases run without an error message") {
  const std::string end = "[stop]\ntime = 0.05\n";
  for (const std::string& scene :
       {box + "[[population]]\ncount = 100\ntemperature = 1e-50\n" + contact + end,
        box + grains + contact + "[effects.charge_exchange]\ntransfer_prefactor = 1e50\nexponent = 10\n" + end,
        box + grains + contact + coulomb + "sum = \"shifted-force\"\n" + end,
        box + grains + contact + coulomb + "cutoff = 6\nmesh = 32\norder = 5\n" + end,
        box + "[[population]]\ncount = 1\ntemperature = 1\n" + contact + end,
        box + grains + "[effects.linear_contact]\nrestitution = 1\n" + end}) {
    const std::string sentence = error_message_of(scene);
    CHECK_MESSAGE(sentence.empty(), scene << "\n=> " << sentence);
  }
}

TEST_CASE("given Coulomb mesh with a large error: gives one warning") {
  const std::string charged = box + "[[population]]\ncount = 100\ntemperature = 1\ncharge = 1\n" + contact + coulomb;
  GranularMotion coarse_mesh(parse(charged + "cutoff = 1.1\nmesh = 8\norder = 4\n"));
  const std::vector<std::string> warnings = coarse_mesh.warnings();
  REQUIRE(warnings.size() == 1);
  CHECK_MESSAGE(contains(warnings.front(), "effects.coulomb: the estimated force error is 0."), warnings.front());
  CHECK(coarse_mesh.warnings().empty());
  CHECK(GranularMotion(parse(charged + "cutoff = 3\nmesh = 32\norder = 6\n")).warnings().empty());
  CHECK(GranularMotion(parse(charged)).warnings().empty());
}

TEST_CASE("scenes of grains: impossible ones are refused with a one-line message") {
  struct Refused {
    std::string scene, sentence;
  };
  const std::string plane = "[units]\n[domain]\nsize = [12, 12]" + periodic;
  const std::string few = "[[population]]\ncount = 20\ntemperature = 1\n";
  const std::string si = "young = 1e6\npoisson = 0.2\n";
  std::string chain;
  for (const char* grain : {"[5, 6, 6]\ncharge = 1", "[6, 6, 6]", "[7, 6, 6]\ncharge = -1"})
    chain += fmt::format("[[conductor]]\nradius = 0.5\nposition = {}\n", grain);
  std::string ring;  // A ring around the box, with charges that do not excite the growing mode.
  for (int i = 0; i < 12; ++i)
    ring += fmt::format("[[conductor]]\nradius = 0.5\nposition = [{}.5, 6, 6]\ncharge = {}\n", i,
                        i == 0 ? 1 : (i == 6 ? -1 : 0));
  const std::string fast =
      "[[conductor]]\nposition = [4, 6, 6]\nradius = 0.5\nvelocity = [25, 0, 0]\n"
      "[[conductor]]\nposition = [6, 6, 6]\nradius = 0.5\nvelocity = [-25, 0, 0]\n";
  const std::vector<Refused> table = {
      {plane + few + contact + "[effects.wall_contact]\n",
       "effects.wall_contact is not allowed with [units], which makes the scene one of grains"},
      {replaced(box, "left = \"periodic\"\nright = \"periodic\"\n", "") + grains + contact,
       "domain.left = \"insulating\" is not allowed without the table [effects.flat_walls]"},
      {replaced(box, "left = \"periodic\"\nright = \"periodic\"\n", "left = { potential = 3 }\n") + grains + contact,
       "domain.left = { potential = 3 } is not allowed in a scene of grains: a conducting side is "
       "grounded"},
      {box + few + contact + "[mechanics]\nrelative_tolerance = 1e-6\n",
       "mechanics.relative_tolerance is not allowed with mechanics.integrator = \"multirate\": of grains it is for "
       "\"cvode\""},
      {box + few + contact + "[mechanics]\nlargest_step = 1.0\n",
       "mechanics.largest_step is not allowed in a scene of grains: it is for conductors"},
      {plane + few + contact + coulomb + "[effects.induced_dipoles]\n",
       "effects.induced_dipoles is not allowed in 2 dimensions: it supports 3"},
      {plane + few + contact + coulomb + "sum = \"ewald\"\n",
       "effects.coulomb.sum = \"ewald\" is not allowed in two dimensions: \"mesh\" is"},
      {box + "[[population]]\ncount = 1\nradius = 3.1\n" + contact,
       "at least twice that is needed, or it would meet two images of another"},
      {box + few + contact + "[stop]\ntime = 1e12\n[output]\nevery = 1.0\n",
       "output.every = 1 t0 is not allowed: up to stop.time = 1e+12 t0 that makes 1e+12 frames"},
      {box + few + "radius = 1e-40\n" + contact + coulomb,
       "domain.size = 12 d0 along its longest side is not allowed with a grain of diameter 2e-40 d0: at most 1e+09 "
       "times that is, or contacts would be lost in rounding"},
      {box + few + contact + coulomb + "sum = \"shifted-force\"\ncutoff = 7\n",
       "effects.coulomb.cutoff = 7 is not allowed in this box: at most 6 is"},
      {box + few + contact + coulomb + "cutoff = 6.1\n",
       "effects.coulomb.cutoff = 6.1 is not allowed in this box: at most 6 is"},
      {box + "[[population]]\ncount = 20\nradius = [0.3, 0.6]\n" + contact + coulomb + "cutoff = 5.8\n",
       "half of its shortest side minus the difference of the largest and the smallest diameter"},
      {box + few + contact + coulomb + "order = 8\naccuracy = 1e-7\n",
       "[effects.coulomb] are not valid: order = 8 is not allowed: forces are computed in double precision here, as "
       "single is good for an accuracy of 6e-07 and more, with splines of order 4 to 7"},
      {box + few + contact + coulomb + "order = 4\n[effects.induced_dipoles]\n", "with splines of order 5 to 7"},
      {box + few + contact + coulomb + "order = 8\ncutoff = 3\nmesh = 17\n", "single needs an even number of points"},
      {box + few + contact + coulomb + "order = 8\ncutoff = 5\nmesh = 32\n",
       "a cutoff of a third of the box, 4, or less"},
      {box + few + contact + coulomb + "order = 8\ncutoff = 3\nmesh = 12\n",
       "[effects.coulomb] are not valid: a mesh with 12 points"},
      {box + few + contact + coulomb + "coupling_constant = 1e101\n", "effects.coulomb.coupling_constant"},
      {box + few + "charge = 1\n" + contact + coulomb + "coupling_constant = 1e10\n",
       "a smaller effects.coulomb.coupling_constant"},
      {box + few + contact + "[effects.charge_exchange]\nexponent = 500\n", "at least 0 and at most 10"},
      {box + few + contact + "[effects.charge_exchange]\ntransfer_prefactor = 1e200\n",
       "greater than 0 and at most 1e+50"},
      {box + few + contact + "damping = 1e6\n",
       "effects.viscoelastic_contact.damping = 1e+06 is too large for its stiffness = 278.6"},
      {box + few + contact + "stiffness = 1e200\n", "effects.viscoelastic_contact.stiffness"},
      {box + few + contact + "stiffness = 1e60\n[stop]\ntime = 1\n", "too short for steps of"},
      {box + "[[population]]\ncount = 20\n" + contact + "[[equilibration]]\nduration = 0.1\ntemperature = 2\n",
       "equilibration.temperature = 2 is impossible: all grains are at rest"},
      {box + few + contact + coulomb + "[effects.induced_dipoles]\npolarizability = 0.5\n", "less than 0.5 is allowed"},
      {box + chain + contact + coulomb + "[effects.induced_dipoles]\npolarizability = 0.4\n", "it must be below 0.3"},
      {box + ring + contact + coulomb + "[effects.induced_dipoles]\npolarizability = 0.25\n", "it must be below 0.20"},
      {box + few + contact + coulomb + "[effects.induced_dipoles]\ndegree = 4\ntolerance = 1e-14\n",
       "effects.induced_dipoles.tolerance = 1e-14 is not allowed with a degree above 1: it must be at least 1e-12"},
      {box + few + contact + "[effects.induced_dipoles]\n",
       "effects.induced_dipoles needs the table [effects.coulomb]"},
      {box + few + "[effects.charge_exchange]\n", "needs effects.viscoelastic_contact or effects.linear_contact"},
      {box + few + contact + "[effects.linear_contact]\n", "one is allowed"},
      {box + few + "charge = 2\n" + contact + "[effects.charge_exchange]\ncapacity = 1\n",
       "a grain has the charge 2 at the start"},
      {box + "[[population]]\ncount = 3000\n" + contact, "3000"},
      {box + few + contact + coulomb + "coupling_constant = -1\n", "effects.coulomb.coupling_constant"},
      {box + few + contact + "[effects.charge_exchange]\ntransfer_prefactor = -1\n",
       "effects.charge_exchange.transfer_prefactor"},
      {box + few + contact + "damping = -1\n", "effects.viscoelastic_contact.damping"},
      {box + few + contact + "[effects.gas_drag]\nstokes = -1\n", "effects.gas_drag.stokes"},
      {box + few + contact + coulomb + "accuracy = 1e-11\n",
       "effects.coulomb.accuracy = 1e-11 is not allowed with effects.coulomb.sum = \"mesh\": at least 1e-08 and"},
      {box + few + contact + coulomb + "accuracy = 1e-13\n", "at least 1e-12 and at most 0.1"},
      {box + few + contact + "[mechanics]\nintegrator = \"verlet\"\nstep = 0.1\n", "would do"},
      {box + few + contact + "[mechanics]\nintegrator = \"gear\"\nstep = 0.1\n", "would do"},
      {box + fast + contact + "[stop]\ntime = 1\n", "times its stiffness would suffice"},
      {box + few + contact + "[effects.charge_exchange]\nmodel = \"none\"\ntransfer_prefactor = 1\n",
       "effects.charge_exchange.transfer_prefactor is not allowed with effects.charge_exchange.model = \"none\""},
      {box + grains + contact +
           "[effects.gas_drag]\nstokes = 1\nspeed = 1\ncorrelation_time = 1e-17\n[stop]\ntime = 1\n",
       "effects.gas_drag.correlation_time = 1e-17 is not allowed: it must be longer than 2.22e-16, stop.time"},
      {box + few + contact + exchange + "model = \"impact\"\nfeedback = 1\n",
       "effects.charge_exchange.feedback is not allowed with effects.charge_exchange.model = \"impact\": it is for "
       "\"size\", \"material\" and \"polarization\""},
      {box + few + contact + exchange + "model = \"size\"\neach_step = true\n", "each_step is not allowed with"},
      {box + few + contact + exchange + "model = \"size\"\nfield = [0, 0, 1]\n", "it is for \"polarization\""},
      {box + few + contact + exchange + "model = \"size\"\nfeedback = 1\n",
       "effects.charge_exchange.feedback = 1 is not allowed: charges that grow without limit need "
       "effects.charge_exchange.capacity"},
      {box + few + contact + exchange + "model = \"size\"\nmemory = 0\n", "effects.charge_exchange.memory"},
      {box + few + contact + exchange + "model = \"impact\"\npatches = 4\n", "it is for \"patches\""},
      {box + few + contact + exchange + "model = \"size\"\ndonors = [0.5]\n", "it is for \"patches\""},
      {box + few + contact + exchange + "model = \"patches\"\ndonors = [0.5, 0.5]\n",
       "effects.charge_exchange.donors has 2 numbers, and model = \"patches\" needs one for each [[conductor]]"},
      {box + few + contact + exchange + "model = \"patches\"\ndonors = [1.5]\n", "at least 0 and at most 1"},
      {box + few + contact + exchange + "model = \"patches\"\npatches = 1e7\n", "at most 1000000"},
      {box + few + contact + exchange + "model = \"patches\"\nrate = 2\n",
       "rate is not allowed with effects.charge_exchange.model = \"patches\""},
      {box + few + "relative_permittivity = 3\n" + contact + coulomb,
       "population.relative_permittivity needs the table [effects.induced_dipoles]"},
      {box + few + "relative_permittivity = 1\n" + contact + coulomb + "[effects.induced_dipoles]\n",
       "greater than 1 and at most 1000000"},
      {box + few + "relative_permittivity = 3\n" + contact + coulomb +
           "[effects.induced_dipoles]\npolarizability = 0.01\n",
       "effects.induced_dipoles.polarizability has no effect, because all grains have a relative_permittivity"},
      {box + few + contact + exchange + "model = \"material\"\naffinities = [1, 2]\n",
       "effects.charge_exchange.affinities has 2 numbers, and model = \"material\" needs one for each [[conductor]] "
       "and "
       "then for each [[population]], 1 in all"},
      {box + few + contact + exchange + "model = \"polarization\"\n",
       "effects.charge_exchange.field is missing: model = \"polarization\" needs it or effects.uniform_field"},
      {box + few + contact + exchange + "model = \"polarization\"\nfield = [0, 1]\n",
       "effects.charge_exchange.field has 2 numbers, but the domain has 3"},
      {box + few + contact + "stiffness = 1\n" + si + "viscosity = 1e-4\n", "leave one of the two out"},
      {box + few + contact + si, "effects.viscoelastic_contact.viscosity is missing"},
      {box +
           "[[conductor]]\nposition = [6, 6, 6]\nradius = 0.5\n[[conductor]]\nposition = [6.9, 6, 6]\nradius = 0.5\n" +
           contact,
       "overlaps the one at [6, 6, 6] d0 (line 11) by 0.1 d0"},
      {box + "[[conductor]]\nposition = [13, 6, 6]\nradius = 0.5\n" + contact,
       "reaches out of the domain by 1 d0: all of it, along periodic axes its centre, must lie in [0, 0, 0] to [12, "
       "12, 12] d0"},
      {box + few + "charge_distribution = \"gaussian\"\n" + contact, "needs population.charge, the width"},
      {box + few + "charge = 1\ncharge_distribution = \"exponential-power\"\n" + contact,
       "needs population.charge_exponent"},
      {box + few + "charge = 1\ncharge_exponent = 2\n" + contact, "does not use population.charge_exponent"},
      {box + few + "charge = 1\ncharge_distribution = \"exponential-power\"\ncharge_exponent = 0.1\n" + contact,
       "population.charge_exponent"},
      {box + "[[population]]\ncount = 1\ncharge = 1\ncharge_distribution = \"gaussian\"\n" + contact,
       "needs more than one grain"},
  };
  for (const auto& [scene, part] : table) {
    const std::string sentence = error_message_of(scene);
    CHECK_MESSAGE(contains(sentence, part), scene << "\n=> " << sentence);
    CHECK_MESSAGE(sentence.find('\n') == std::string::npos, sentence);
  }
}

}  // namespace granular_scenes_test
