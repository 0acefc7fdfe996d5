// Tests of a gas's output: history, theory, restitution, and identical output of a resumed run.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "src/effects/read_scene.hpp"
#include "src/granular/granular_motion.hpp"
#include "src/granular/note.hpp"
#include "src/granular/summary.hpp"
#include "src/theory/restitution.hpp"
#include "tests/folder.hpp"
#include "tests/gas_text.hpp"

namespace granular_notes_test {

using namespace lichtenberg;
using namespace lichtenberg::granular;
using doctest::Approx;

namespace {

/// Scene of 120 grains that exchange charge, with a volume fraction of 0.13.
const std::string text = gas_text(120, 8, 4, 0.5, "[[equilibration]]\nduration = 1\nstiffness = 10\ntemperature = 1\n");

Scene scene() { return parse_scene(text, "gas.toml"); }

double value(const Summary& summary, const std::string& name) {
  const auto found = std::ranges::find(summary.quantities, name, &Quantity::name);
  REQUIRE(found != summary.quantities.end());
  return found->value;
}

std::vector<double> reals_of(const ColumnGroup& group, const std::string& name) {
  const auto found = std::ranges::find(group.columns, name, &lichtenberg::Column::name);
  REQUIRE(found != group.columns.end());
  return std::get<std::vector<double>>(found->values);
}

void continue_to(GranularMotion& motion, double until) {
  while (motion.time() < until) motion.advance_to(motion.next_frame(), {});
}

/// Collision of grain 1 with grain 0.
Collision collision(double speed, double release_speed, double tangential_speed = 0) {
  return {{{0, 1}, 1, speed}, release_speed, 2, tangential_speed};
}

}  // namespace

TEST_CASE("RestitutionCheck: isolated central collisions are counted by speed") {
  Bodies bodies{.dimension = 3};
  bodies.mass = {1, 1};
  bodies.radius = {0.5, 0.5};
  const GrainContactLaw law = ViscoelasticLaw{278.6, 27.7};
  const double at_02 = theory::collision({278.6, 27.7}, 0.2).restitution;
  const double at_03 = theory::collision({278.6, 27.7}, 0.3).restitution;
  std::vector<Collision> ended = {collision(0.2, 0.2 * (at_02 + 0.01)), collision(0.3, 0.3 * (at_03 - 0.03)),
                                  // This speed is below all decades and counts with the lowest one.
                                  collision(2e-9, 0),
                                  collision(0.2, 0, std::sqrt(2.1e-4)),  // u^2 t = 2.1e-4 exceeds 1e-3 of 0.2.
                                  collision(0.2, 0)};
  ended.back().contact.alone = false;
  RestitutionCheck check;
  check.count(ended, bodies, law, 0);
  check.count(ended, bodies, law, 1.5);  // All contacts began earlier.
  const RestitutionCheck::Decade& found = check.by_speed()[-1 - RestitutionCheck::first_decade];
  CHECK(found.collisions == 2);
  CHECK(found.mean() == Approx(0.02).epsilon(1e-10).scale(0));
  CHECK(found.worst == Approx(0.03).epsilon(1e-10).scale(0));
  CHECK(check.by_speed()[0].collisions == 1);
  CHECK(check.all().collisions == 3);
  Checkpoint checkpoint;
  check.save(checkpoint);
  RestitutionCheck restored;
  restored.restore(checkpoint);
  CHECK(restored.all().sum == check.all().sum);
  CHECK(restored.by_speed()[0].collisions == 1);

  Gas gas(scene()), resumed(scene());
  gas.restitution = check;
  resumed.restore(gas.save());
  CHECK(resumed.restitution.all().collisions == 3);
  Checkpoint wrong_grains = gas.save(), wrong_stage = gas.save();
  wrong_grains.integers.at("contact_pairs") = {0, gas.bodies().size(), 1};
  wrong_grains.reals.at("contact_touches") = {0, 0};
  CHECK_THROWS_AS(resumed.restore(wrong_grains), Failure);
  wrong_grains.integers.at("contact_pairs") = {1, 1, 1};
  CHECK_THROWS_AS(resumed.restore(wrong_grains), Failure);
  wrong_grains.integers.at("contact_pairs") = {0, 1, 1, 0};
  CHECK_THROWS_AS(resumed.restore(wrong_grains), Failure);
  wrong_stage.integers.at("stage") = {2};
  CHECK_THROWS_AS(resumed.restore(wrong_stage), Failure);

  // For heavier and larger grains E and D are multiplied by sqrt(R_eff / (d0/4)) = sqrt(2), and m_eff = 4.
  bodies.mass = {8, 8};
  bodies.radius = {1, 1};
  const double heavy = theory::collision({278.6 * std::numbers::sqrt2, 27.7 * std::numbers::sqrt2, 4}, 0.2).restitution;
  RestitutionCheck heavy_check;
  heavy_check.count(std::vector{collision(0.2, 0.2 * heavy)}, bodies, law, 0);
  CHECK(heavy_check.all().worst < 1e-12);  // Rounding.
  // The restitution of a linear contact does not depend on the speed: G 3.6 with A = 278.6, B = 10
  // (docs/theory/grains.md), 10 digits.
  CHECK(expected_collision(LinearSpringLaw{278.6, 10}, 0.5, 1, 3).restitution ==
        Approx(0.3464297011).epsilon(2e-10).scale(0));
}

TEST_CASE("contact that ends: normal and tangential relative speeds are recorded") {
  Bodies bodies{.dimension = 3};
  bodies.position = {0, 0, 0, 1.01, 0, 0};
  bodies.momentum = {0, 0, 0, 0.3, 0.4, 0};
  bodies.mass = {1, 1};
  bodies.radius = {0.5, 0.5};
  std::vector<GrainContact> contacts;
  ContactRecord record;
  note({{.contact = {{0, 1}, 1, 0.5}, .open = false}}, bodies, 2, contacts, record);
  REQUIRE(record.ended.size() == 1);
  CHECK(record.ended[0].release_speed == Approx(0.3));
  CHECK(record.ended[0].tangential_speed == Approx(0.4));
}

TEST_CASE("HomogeneousGas: collisions, temperature and charges equal the theory's") {
  Gas gas(scene());
  std::optional<HomogeneousGas> theory = HomogeneousGas::of(gas);
  REQUIRE(theory);
  const double density = 120 / 512.0;
  const GrainContactLaw law = gas.law();
  const double omega = theory::collision_frequency(density, 1);
  const double duration =
      theory::impact_mean(1, [&](double speed, double) { return expected_collision(law, 0.5, 1, speed).duration; });
  gas.follow_contacts(gas.instant(), 0.04);
  theory->follow(gas, gas.time(), 1);
  // The stage is elastic and keeps the temperature: omega / (1 + omega t_c) N t / 2, within the quadrature's 1e-13 and
  // rounding.
  CHECK(theory->collisions() == Approx(omega / (1 + omega * duration) * 60 * 0.04).epsilon(1e-10).scale(0));
  CHECK(theory->temperature() == Approx(1).epsilon(1e-12).scale(0));
  CHECK(*theory->charge_square() == 0);

  gas.leave_stage();
  theory->begin(gas);
  const theory::Impacts impacts{
      .restitution = [&](double speed) { return expected_collision(gas.law(), 0.5, 1, speed).restitution; },
      .duration =
          [&](double temperature) {
            return theory::impact_mean(temperature, [&](double speed, double) {
              return expected_collision(gas.law(), 0.5, 1, speed).duration;
            });
          },
      .charge_square = [](double speed) { return theory::impact_charge_square(4.5e-3, 0.83, 0.5, speed); }};
  const double start = theory->temperature();
  const std::vector<double> times = {0.06};
  for (const double end : {0.05, 0.08, 0.1}) {
    gas.follow_contacts(gas.instant(), end);
    theory->follow(gas, gas.time(), 0.5);
  }
  // In three parts as in one: cool() has an error of 1e-9.
  const theory::CoolingState whole = theory::cool(density, impacts, start, times).front();
  CHECK(theory->temperature() == Approx(whole.temperature).epsilon(1e-8).scale(0));
  CHECK(*theory->charge_square() == Approx(whole.charge_square).epsilon(1e-8).scale(0));
}

TEST_CASE("theory in a gas's history: continues over cooling, restarts after mixing") {
  const std::string mixing = "duration = 1\nstiffness = 10\ntemperature = 1", cooling = "duration = 1\nelastic = false";
  const auto temperatures = [](const std::string& with) {
    GranularMotion motion(parse_scene(with, "gas.toml"));
    continue_to(motion, 2);
    return std::pair{reals_of(motion.take_history(), "haff_temperature"), motion.summary()};
  };
  const auto [staged, summary] = temperatures(replaced(text, mixing, cooling));
  const auto [plain, other] = temperatures(replaced(text, "[[equilibration]]\n" + mixing, ""));
  REQUIRE(staged.size() == plain.size());
  // cool() has an error of 1e-9 for any division into parts.
  for (std::size_t k = 0; k < plain.size(); ++k) CHECK(staged[k] == Approx(plain[k]).epsilon(1e-8).scale(0));
  CHECK(value(summary, "temperature") == value(other, "temperature"));
  const std::vector<double> mixed = temperatures(text).first;
  CHECK(mixed[mixed.size() / 2] == Approx(1).epsilon(1e-9).scale(0));
}

TEST_CASE("HomogeneousGas::of: none for few, unequal, driven or resting grains") {
  CHECK_FALSE(HomogeneousGas::of(Gas(parse_scene(replaced(text, "120", "99"), "gas.toml"))));
  CHECK(HomogeneousGas::of(Gas(scene())));
  CHECK_FALSE(HomogeneousGas::of(Gas(parse_scene(text + "[effects.gas_drag]\n", "gas.toml"))));
  Scene different = scene();
  different.conductors[3].radius = 0.4;
  CHECK_FALSE(HomogeneousGas::of(Gas(different)));
  Scene at_rest = scene();
  for (Conductor& grain : at_rest.conductors) grain.velocity = {};
  CHECK_FALSE(HomogeneousGas::of(Gas(at_rest)));
}

TEST_CASE("gas summary: warns if stop.time lies within the equilibration stages") {
  Scene short_run = scene();
  CHECK_EQ(stages_warning(short_run), "");
  short_run.stop.time = 1;  // The end of the stage.
  CHECK(stages_warning(short_run).starts_with("stages alone: stop.time = 1 t0 counts from the start"));
  GranularMotion motion(short_run);
  continue_to(motion, 1);
  CHECK(std::ranges::count(motion.summary().warnings, stages_warning(short_run)) == 1);
  short_run.stages.clear();
  CHECK_EQ(stages_warning(short_run), "");
}

TEST_CASE("gas summary: warns of energy errors above 1 % and overlaps above 10 %") {
  Gas gas(scene());
  std::optional<HomogeneousGas> no_theory;
  double seconds = 0;
  const Note now = take_note(gas, no_theory, seconds);
  const auto warnings = [&](double share_of_error) {
    return summarize(gas, now, now.energy.total() - share_of_error * now.energy.kinetic).warnings;
  };
  CHECK(warnings(0).empty());
  CHECK(warnings(0.009).empty());
  REQUIRE(warnings(-0.02).size() == 1);
  CHECK(warnings(-0.02)[0].starts_with("energy balance off by 2 %"));
  gas.largest_overlap = 0.09;
  CHECK(warnings(0).empty());
  gas.largest_overlap = 0.11;
  REQUIRE(warnings(0).size() == 1);
  CHECK(warnings(0)[0].starts_with("grains overlap by 11 % of a diameter"));
}

TEST_CASE("gas summary: energy errors below those of the potential do not warn") {
  const std::string start = "[units]\n[domain]\nsize = [8, 8, 8]\n";
  const std::string charged = "[effects.linear_contact]\n[effects.coulomb]\ncoupling_constant = 2\n";
  const auto warns = [](const std::string& text, double share_of_potential) {
    Gas gas(parse_scene(text, "rest.toml"));
    std::optional<HomogeneousGas> no_theory;
    double seconds = 0;
    const Note now = take_note(gas, no_theory, seconds);
    REQUIRE(now.energy.kinetic < 1e-9 * std::abs(now.energy.potential));
    const double at_start = now.energy.total() - share_of_potential * std::abs(now.energy.potential);
    return summarize(gas, now, at_start).warnings.size() == 1;
  };
  const auto grain = [](double x, double charge) {
    return fmt::format("[[conductor]]\nradius = 0.5\nposition = [{}, 4, 4]\nvelocity = [1e-9, 0, 0]\ncharge = {}\n", x,
                       charge);
  };
  // The sum rounds by 2 n epsilon = 8.9e-16.
  const std::string open = start + "unbounded = true\n" + grain(2, 1) + grain(6, 1) + charged;
  CHECK_FALSE(warns(open, 4e-16));
  CHECK(warns(open, 1e-14));
  std::string sides;
  for (const char* side : {"left", "right", "bottom", "top", "front", "back"})
    sides += fmt::format("{} = \"periodic\"\n", side);
  const std::string periodic =
      start + sides + grain(2, 1) + grain(5, -1) + charged + "sum = \"ewald\"\naccuracy = 1e-3\n";
  CHECK_FALSE(warns(periodic, 0.9e-3));
  CHECK(warns(periodic, 1.1e-3));
}

TEST_CASE("cooling and charging gas: summary and history have equal end values") {
  GranularMotion motion(scene());
  continue_to(motion, 4);
  const Summary summary = motion.summary();
  CHECK(value(summary, "total_charge") == 0);
  CHECK(value(summary, "mean_charge_magnitude") > 0);
  CHECK(value(summary, "temperature") < 1);
  CHECK(value(summary, "clusters") <= 120);
  CHECK(value(summary, "collisions") > 100);
  // The grains of the stage are so fast that they overlap deeply; no other warning is expected.
  for (const std::string& warning : summary.warnings) CHECK(warning.starts_with("grains overlap by "));
  const ColumnGroup notes = motion.take_history();
  CHECK(reals_of(notes, "time").front() == 0);
  CHECK(reals_of(notes, "time").back() == 4);
  CHECK(reals_of(notes, "temperature").back() == value(summary, "temperature"));
  const auto collisions = std::ranges::find(notes.columns, "collisions", &lichtenberg::Column::name);
  REQUIRE(collisions != notes.columns.end());
  CHECK(static_cast<double>(std::get<std::vector<std::int64_t>>(collisions->values).back()) ==
        value(summary, "collisions"));
  CHECK(reals_of(notes, "haff_temperature").back() == value(summary, "haff_temperature"));
  for (const double error : {value(summary, "energy_error"), value(summary, "contact_energy_error")})
    CHECK(std::abs(error) < 0.02 * value(summary, "dissipated_energy"));
}

TEST_CASE("resumed gas: summary and history are identical, also with extra output") {
  GranularMotion whole(scene());
  continue_to(whole, 2);
  whole.take_history();
  continue_to(whole, 4);

  GranularMotion first(scene());
  continue_to(first, 2);
  first.progress();
  const Checkpoint checkpoint = first.checkpoint();
  GranularMotion second(scene());
  second.restore(checkpoint);
  second.progress();
  second.summary();
  continue_to(second, 4);
  const Summary one = whole.summary(), other = second.summary();
  for (std::size_t k = 0; k < one.quantities.size(); ++k) {
    const double a = one.quantities[k].value, b = other.quantities[k].value;
    CHECK_MESSAGE((a == b || (std::isnan(a) && std::isnan(b))), one.quantities[k].name);
  }
  const ColumnGroup a = whole.take_history(), b = second.take_history();
  for (const char* name : {"time", "temperature", "haff_temperature", "expected_collisions", "expected_square_charge"})
    CHECK(reals_of(a, name) == reals_of(b, name));
}

TEST_CASE("resumed gas: the number of force evaluations does not depend on output") {
  for (const bool exchange : {true, false}) {
    Scene charged = parse_scene(gas_text(120, 8, 1, 0.5), "gas.toml");
    if (!exchange) charged.effects.remove("charge_exchange");
    GranularMotion whole(charged), first(charged), second(charged);
    const auto computed = [](GranularMotion& motion) {
      return motion.checkpoint().integers.at("effects.coulomb.counters")[0];
    };
    continue_to(whole, 0.5);
    continue_to(first, 0.5);
    first.frame();
    CHECK(computed(first) == computed(whole));
    second.restore(first.checkpoint());
    second.frame();
    CHECK(computed(second) == computed(whole));
    continue_to(whole, 1);
    continue_to(second, 1);
    CHECK(computed(second) == computed(whole));
    CHECK(computed(whole) > 10);
  }
}

TEST_CASE("gas paused after each step: its history has the times of a full run") {
  GranularMotion whole(scene()), paused(scene());
  continue_to(whole, 1);
  int pauses = 0;
  const auto pause = [&] { return ++pauses > 0; };
  std::vector<double> times;
  while (paused.time() < 1) {
    paused.advance_to(paused.next_frame(), pause);
    for (const double time : reals_of(paused.take_history(), "time")) times.push_back(time);
    paused.restore(paused.checkpoint());
  }
  CHECK(pauses > 10);
  CHECK(times == reals_of(whole.take_history(), "time"));
}

}  // namespace granular_notes_test
