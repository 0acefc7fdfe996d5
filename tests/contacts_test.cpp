// Tests of contacts, electrical groups and charges.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "solvers/error.hpp"
#include "src/effects/charges.hpp"
#include "src/effects/contact_discharge.hpp"
#include "src/effects/groups.hpp"
#include "tests/conductors.hpp"

namespace contacts_test {

using namespace lichtenberg;
using namespace lichtenberg::conductors;
using namespace lichtenberg::effects;

TEST_CASE("electrical_groups: a group's number is its smallest member") {
  const Scene scene = scene_of(std::vector<Vec2>(6));
  const std::vector<Contact> contacts = {{1, 4}, {2, 3}, {3, 4}};
  const ElectricalGroups groups = electrical_groups(scene, contacts);
  CHECK(groups.id == std::vector<int>{0, 1, 1, 1, 1, 5});
  CHECK(std::ranges::none_of(groups.potential, [](const auto& p) { return p.has_value(); }));
}

TEST_CASE("electrical_groups: wires join separate conductors and fix potentials") {
  Scene scene = scene_of(std::vector<Vec2>(5));
  scene.groups = {{.name = "loose"}, {.name = "held", .potential = 3.0}};
  scene.conductors[1].group = scene.conductors[3].group = 0;
  scene.conductors[4].group = 1;
  CHECK(electrical_groups(scene, {}).id == std::vector<int>{0, 1, 2, 1, 4});
  const std::vector<Contact> contact = {{2, 4}};
  const ElectricalGroups groups = electrical_groups(scene, contact);
  CHECK(groups.potential[2] == 3.0);
  CHECK(!groups.potential[1]);
}

TEST_CASE("electrical_groups: electrodes fix potentials; short circuits are refused") {
  Scene scene = scene_of(std::vector<Vec2>(4));
  scene.electrodes = {electrode_of("ball", Disk{{0.05, 0.05}, 1e-3}, 5)};
  scene.domain.sides[2] = {.electrode = true, .potential = 5};
  const std::vector<Contact> contacts = {{0, 1}, {1, 4}, {3, 5}};  // 4: the ball; 5: the bottom side.
  const ElectricalGroups groups = electrical_groups(scene, contacts);
  CHECK(groups.id == std::vector<int>{0, 0, 2, 0});
  CHECK(groups.potential[3] == 5.0);
  CHECK(!groups.potential[2]);

  scene.domain.sides[2].potential = 6;
  scene.path = "scene.toml";
  CHECK(electrical_groups(scene, contacts).id == std::vector<int>{0, 0, 2, 3});
  const std::vector<Contact> shorted = {{0, 1}, {0, 4}, {1, 5}};
  CHECK_THROWS_WITH_AS(
      electrical_groups(scene, shorted),
      "the group of conductor 0 connects the electrode \"ball\" at 5 V with the bottom side of the domain at 6 V: a "
      "short circuit of perfect conductors, whose current has no limit, is not allowed: the scene scene.toml gives "
      "them these potentials, in electrode.potential, the side's potential in [domain] or group.potential",
      InputError);
}

TEST_CASE("splits_group: detects lost members and released or changed potentials") {
  const ElectricalGroups held = {{0, 0, 2}, {5.0, 5.0, {}}};
  CHECK(!splits_group(held, held));
  CHECK(!splits_group({{0, 1, 2}, {5.0, {}, {}}}, held));  // A merge.
  CHECK(splits_group(held, {{0, 1, 2}, {5.0, {}, {}}}));   // One member leaves.
  CHECK(splits_group(held, {{0, 0, 2}, {{}, {}, {}}}));    // Both members leave the electrode together.
  CHECK(splits_group(held, {{0, 0, 2}, {6.0, 6.0, {}}}));  // The electrode changes.
}

TEST_CASE("contact discharge: closes below the gap, opens above the release gap") {
  const Scene scene = scene_of({{0, 0}, {0, 0}});
  const effects::ContactDischarge discharge(scene);
  std::vector<Contact> contacts;
  CHECK(discharge.release_gap() == near(1.1 * radius));
  Bodies bodies = make_bodies(scene);
  const auto at_gap = [&](double gap) {
    bodies.position = {0, 0, 2 * radius + gap, 0};
    discharge.update(bodies, contacts);
    return contacts.size();
  };
  CHECK(at_gap(1.05 * radius) == 0);  // Between the two gaps the state does not change.
  CHECK(at_gap(0.99 * radius) == 1);
  CHECK(at_gap(1.05 * radius) == 1);
  CHECK(at_gap(1.11 * radius) == 0);
  CHECK(at_gap(1.05 * radius) == 0);
}

TEST_CASE("release gap: exceeds contact_distance by at least the position tolerance") {
  Scene scene = scene_of({{0, 0}});
  scene.effects.find<effects::ContactDischargeOptions>()->hysteresis = 0;
  scene.mechanics.position_tolerance = 3e-6;
  CHECK(effects::ContactDischarge(scene).release_gap() == near(radius + 3e-6));
}

TEST_CASE("ContactDischarge::update: gap within tolerance closes only on approach") {
  const Scene scene = scene_of({{0, 0}, {0, 0}});
  Bodies bodies = make_bodies(scene);
  bodies.position = {0, 0, 3 * radius + 0.5e-6, 0};  // Half a tolerance from the threshold.
  for (const double velocity : {-1e-3, 1e-3}) {
    std::vector<Contact> contacts;
    bodies.momentum = {0, 0, bodies.mass[1] * velocity, 0};
    CHECK(effects::ContactDischarge(scene).update(bodies, contacts).made.size() == (velocity < 0 ? 1 : 0));
  }
}

TEST_CASE("ContactDischarge: periodic box too short for the release gap is refused") {
  const Scene scene = scene_of({{0, 0}, {0, 0}});
  const effects::ContactDischarge discharge(scene);
  Bodies bodies = make_bodies(scene);
  bodies.position = {0, 0, 2.5 * radius, 0};
  bodies.box.sides[0] = bodies.box.sides[1] = Boundary::periodic;
  const double least = 2 * (2 * radius + discharge.release_gap());
  for (const double length : {0.999 * least, 1.01 * least}) {
    bodies.box.lengths.x = length;
    std::vector<Contact> contacts;
    if (length < least)
      CHECK_THROWS(discharge.update(bodies, contacts));
    else
      CHECK(discharge.update(bodies, contacts).made.size() == 1);
  }
}

TEST_CASE("ContactDischarge::gap: between surfaces, also of electrodes and sides") {
  Scene scene = scene_of({{0.03, 0.0021}, {0.03, 0.0021}});
  scene.conductors[1].radius = 3e-3;
  scene.conductors[1].position.y += 5.01e-3;  // The gap is 1.01 mm
  // The gap to conductor 0 is 0.99 mm.
  scene.electrodes = {electrode_of("ball", Disk{{0.03 + 3.99e-3, 0.0021}, 2e-3}, 0)};
  scene.domain.sides[2] = {.electrode = true, .potential = 0};  // The gap is 1.1 mm
  const effects::ContactDischarge discharge(scene);
  Bodies bodies = make_bodies(scene);
  CHECK(discharge.gap(bodies, {0, 1}) == near(1.01e-3));
  CHECK(discharge.gap(bodies, {0, 2}) == near(0.99e-3));
  CHECK(discharge.gap(bodies, {0, 3}) == near(1.1e-3));
  std::vector<Contact> contacts;
  discharge.update(bodies, contacts);
  CHECK(contacts == std::vector<Contact>{{0, 2}});
}

TEST_CASE("ContactDischarge::gap_rate: equals the time derivative of the gap") {
  Scene scene = scene_of({{0.03, 0.02}, {0.034, 0.023}});
  scene.electrodes = {electrode_of("ring", Ring{{0.03, 0.03}, 0.02}, 0)};
  scene.conductors[0].velocity = {1e-3, -2e-3};
  scene.conductors[1].velocity = {-3e-3, 1e-3};
  const effects::ContactDischarge discharge(scene);
  const Bodies bodies = make_bodies(scene);
  Bodies later = bodies;
  const double dt = 1e-6;
  for (int k = 0; k < 4; ++k) later.position[k] += dt * bodies.momentum[k] / bodies.mass[k / 2];
  for (const Contact contact : {Contact{0, 1}, Contact{1, 2}})  // The truncation error is v dt / distance = 1e-6.
    CHECK(discharge.gap_rate(bodies, contact) ==
          near((discharge.gap(later, contact) - discharge.gap(bodies, contact)) / dt, 1e-4));
}

TEST_CASE("ContactDischarge::watch: lists only contacts that can open or close") {
  Scene scene = scene_of({{0.02, 0.02}, {0.0232, 0.02}, {0.0264, 0.02}, {0.0264, 0.0229}});
  const effects::ContactDischarge discharge(scene);
  const Bodies bodies = make_bodies(scene);
  std::vector<Contact> contacts;
  discharge.update(bodies, contacts);
  REQUIRE(contacts == std::vector<Contact>{{2, 3}});  // The gaps are 1.2 mm, 1.2 mm and 0.9 mm.
  const auto watched = [&](double travel) {
    const std::vector<double> all(4, travel);
    return discharge.watch(bodies, contacts, electrical_groups(scene, contacts), all);
  };
  CHECK(watched(0.09e-3).empty());  // Closing and opening both take 0.1 mm per body.
  REQUIRE(watched(0.11e-3).size() == 3);
  CHECK(watched(0.11e-3)[0].contact == Contact{0, 1});
  CHECK(!watched(0.11e-3)[0].made);
  CHECK(watched(0.11e-3)[2].made);
  CHECK(discharge.excess(bodies, watched(0.11e-3)[0]) == near(0.2e-3));
  // A contact opens one tolerance beyond the release gap.
  CHECK(discharge.excess(bodies, watched(0.11e-3)[2]) == near(-0.2e-3 - scene.mechanics.position_tolerance));
  // If 1, 2 and 3 form a group, a contact between 1 and 2 changes nothing.
  contacts = {{1, 3}, {2, 3}};
  for (const auto& w : watched(0.11e-3)) CHECK(w.contact != Contact{1, 2});
}

TEST_CASE("deferred contact: waits on approach until the gap is 1/16 smaller") {
  const Scene scene = scene_of({{0.02, 0.02}, {0.05, 0.02}});
  const effects::ContactDischarge discharge(scene);
  Bodies bodies = make_bodies(scene);
  const effects::ContactDischarge::Watch pair = {{0, 1}, false};
  const auto waits = [&](double gap, double velocity) {
    bodies.position[2] = bodies.position[0] + 2 * radius + gap;
    bodies.momentum[2] = bodies.mass[1] * velocity;
    return discharge.excess_of_deferred(bodies, pair) > 0;
  };
  const double make = discharge.make_gap();
  for (const double velocity : {-1e-3, 1e-3}) CHECK(waits(1.001 * make, velocity));
  CHECK(waits(0.999 * make, -1e-3));
  CHECK(!waits(0.999 * make, 1e-3));
  CHECK(waits(0.938 * make, -1e-3));
  CHECK(!waits(0.937 * make, -1e-3));
}

TEST_CASE("watch: lists an electrode at equal potential only if behind a resistor") {
  Scene scene = scene_of({{0.046, 0.05}, {0.08, 0.08}});
  scene.electrodes = {electrode_of("ball", Disk{{0.05, 0.05}, radius}, 0)};
  scene.groups = {{.name = "wire", .potential = 0.0}};
  scene.conductors[0].group = 0;
  const std::vector<double> travel = {2e-3, 0};
  for (const double ohm : {0.0, 1e9}) {
    scene.electrodes[0].series_resistance = ohm;
    const effects::ContactDischarge discharge(scene);
    CHECK(discharge.watch(make_bodies(scene), {}, electrical_groups(scene, {}), travel).size() == (ohm > 0 ? 1 : 0));
  }
  // Conductor 1 touches both: all three form one group, and no contact needs watching.
  const effects::ContactDischarge discharge(scene);
  const std::vector<Contact> both = {{0, 1}, {1, 2}};
  CHECK(discharge.watch(make_bodies(scene), {}, electrical_groups(scene, both), travel).empty());
}

TEST_CASE("ContactDischarge::watch: a body's long travel lists only its contacts") {
  Scene scene = scene_of({{0.02, 0.02}, {0.08, 0.02}, {0.02, 0.08}, {0.08, 0.08}});
  scene.electrodes = {electrode_of("ball", Disk{{0.05, 0.05}, radius}, 0)};
  const effects::ContactDischarge discharge(scene);
  const std::vector<double> travel = {0, 0, 0.06, 0};
  std::vector<Contact> watched;
  for (const auto& w : discharge.watch(make_bodies(scene), {}, electrical_groups(scene, {}), travel))
    watched.push_back(w.contact);
  // The distances are 6 cm to 0 and 3, less 3 mm; 4.2 cm to the ball; 8.5 cm to 1.
  CHECK(watched == std::vector<Contact>{{0, 2}, {2, 3}, {2, 4}});
}

TEST_CASE("ContactDischarge: cached gaps of moving bodies equal a new search") {
  // Sixty bodies on 3 cm by 3 cm: some gaps, to bodies or the ball, are always close to the contact gap.
  std::mt19937 random(3);
  std::uniform_real_distribution<double> unit(-1, 1);
  Scene scene = scene_of(std::vector<Vec2>(60));
  scene.electrodes = {electrode_of("ball", Disk{{0.05, 0.05}, radius}, 0)};
  const effects::ContactDischarge discharge(scene);
  Bodies bodies = make_bodies(scene);
  for (double& x : bodies.position) x = 0.05 + 0.015 * unit(random);
  std::vector<Contact> contacts;
  Bodies bodies_before = bodies;
  std::vector<Contact> contacts_before;
  int made = 0, lost = 0;
  for (int step = 0; step < 2000; ++step) {
    if (step % 50 == 20) bodies_before = bodies, contacts_before = contacts;
    if (step % 50 == 40) bodies = bodies_before, contacts = contacts_before;
    std::vector<Contact> anew = contacts;
    const effects::ContactDischarge first(scene);
    first.update(bodies, anew);
    const auto changes = discharge.update(bodies, contacts);
    made += std::ssize(changes.made), lost += std::ssize(changes.lost);
    CHECK(contacts == anew);
    std::vector<double> travel(60);
    for (std::size_t i = 0; i < travel.size(); ++i) travel[i] = (i % 20 == 3 ? 1e-2 : 1e-5) * (1 + unit(random));
    const effects::ElectricalGroups groups = electrical_groups(scene, contacts);
    const auto watched = discharge.watch(bodies, contacts, groups, travel);
    const auto expected = effects::ContactDischarge(scene).watch(bodies, contacts, groups, travel);
    CHECK(std::ranges::equal(
        watched, expected, {}, [](auto& w) { return std::pair(w.contact, w.made); },
        [](auto& w) { return std::pair(w.contact, w.made); }));
    // A skin of 1/16 of a radius lasts for about forty steps.
    for (double& x : bodies.position) x += 1e-5 * unit(random);
  }
  CHECK(made > 20);
  CHECK(lost > 20);
}

TEST_CASE("undetected_travel: chord on which the gap dips by one tolerance") {
  // The path is a straight line whose minimum gap lies a tolerance below the threshold. Two checks at the threshold are
  // separated by at most the chord.
  Scene scene = scene_of({{0.05, 0.05}, {0.05, 0.05}});
  const effects::ContactDischarge discharge(scene);
  Bodies bodies = make_bodies(scene);
  const double tolerance = 1e-6, arm = 3 * radius;
  bodies.position = {0.05, 0.05, 0.05 + std::sqrt(arm * arm - std::pow(arm - tolerance, 2)), 0.05 + arm - tolerance};
  const effects::ContactDischarge::Watch pair = {{0, 1}, false};
  REQUIRE(std::abs(discharge.excess(bodies, pair)) < 1e-15);
  const double chord = 2 * (bodies.position[2] - 0.05);
  CHECK(discharge.undetected_travel(bodies, pair) == near(chord, tolerance / arm));
  // At a large distance the undetected travel is the gap itself.
  bodies.position = {0.05, 0.05, 0.05 + arm + 0.01, 0.05};
  CHECK(discharge.undetected_travel(bodies, pair) == near(0.01));
}

TEST_CASE("CompensatedSum: keeps digits that a plain sum loses") {
  // Adding 1e-11 C to 1 C rounds to a multiple of 2^-52, in the same direction each time.
  const double step = 1e-11 / 3;
  CompensatedSum sum(1.0);
  double plain = 1.0;
  for (int k = 0; k < 1000000; ++k) sum += step, plain += step;
  const double exact = 1.0 + 1e6 * step;
  CHECK(std::abs(sum.total() - exact) < 3e-16);
  CHECK(std::abs(plain - exact) > 1e-13);
}

TEST_CASE("Charges: stored + collected - injected charge is constant to 1e-15") {
  const int n = 20;
  std::mt19937 random(5);
  std::uniform_real_distribution<double> noise(-1, 1);
  std::uniform_int_distribution<int> pick(0, n - 1);
  const Scene scene = [&] {
    Scene s = scene_of(std::vector<Vec2>(n));
    s.electrodes = {electrode_of("ground", Disk{{0.05, 0.05}, 1e-3}, 0)};
    return s;
  }();
  std::vector<double> initial(n), current(n, 0.2e-9), by_field(n);
  for (double& q : initial) q = 1e-10 * noise(random);
  const double start = [&] {
    CompensatedSum sum;
    for (const double q : initial) sum += q;
    return sum.total();
  }();
  Charges charges(initial, 1);
  double time = 0;
  for (int step = 0; step < 20000; ++step) {
    const double dt = 1e-3 * (1 + noise(random));
    time += dt;
    charges.inject(current, dt);
    std::vector<Contact> contacts;
    for (int k = step % 12; k > 0; --k) {
      const int i = pick(random), j = pick(random);
      if (i != j) contacts.push_back({std::min(i, j), std::max(i, j)});
      if (k == 5) contacts.push_back({i, n});
    }
    std::ranges::sort(contacts);
    // The field solver's charges are independent of the stored charges.
    for (double& q : by_field) q = 1e-10 * noise(random);
    charges.distribute(electrical_groups(scene, contacts), by_field);
  }
  // Only adding the two parts of the sums rounds: a few 1e-16 of the largest one, the injected charge.
  CHECK(charges.injected() == near(n * 0.2e-9 * time, 1e-13));  // `time` itself is a plain sum.
  CHECK(std::abs(charges.stored() + charges.collected() - charges.injected() - start) < 1e-15 * charges.injected());
}

TEST_CASE("Charges::distribute: floating groups keep their sum, fixed ones do not") {
  Scene scene = scene_of(std::vector<Vec2>(4));
  scene.electrodes = {electrode_of("ground", Disk{{0.05, 0.05}, 1e-3}, 0)};
  const std::vector<double> initial = {1, 2, 3, 4};
  Charges charges(initial, 1);
  const std::vector<Contact> contacts = {{0, 1}, {2, 4}};
  // 0 and 1 together store 3; the field's charges exceed this by 0.2.
  const std::vector<double> by_field = {2.0, 1.2, -7, 99};
  charges.distribute(electrical_groups(scene, contacts), by_field);
  CHECK(charges.charge(0) == near(1.9));
  CHECK(charges.charge(1) == near(1.1));
  CHECK(charges.charge(0) + charges.charge(1) == 3);
  CHECK(charges.charge(2) == -7);
  CHECK(charges.collected() == 10);
  CHECK(charges.charge(3) == 4);  // A group of one keeps its charge.
}

TEST_CASE("Charges::distribute: the touched source collects a conductor's charge") {
  // 0 touches both electrodes at 5 V and discharges into the first. 1 touches the second. 2 is connected to 5 V outside
  // the box. 3 touches the side at 0 V.
  Scene scene = scene_of(std::vector<Vec2>(4));
  scene.electrodes = {electrode_of("a", Disk{{0.01, 0.05}, 1e-3}, 5), electrode_of("b", Disk{{0.05, 0.05}, 1e-3}, 5)};
  scene.domain.sides[0] = {.electrode = true, .potential = 0};
  scene.groups = {{.name = "floats"}, {.name = "wire", .potential = 5.0}};
  scene.conductors[2].group = 1;
  const std::vector<Contact> contacts = {{0, 4}, {0, 5}, {1, 5}, {3, 6}};
  const ElectricalGroups groups = electrical_groups(scene, contacts);
  CHECK(groups.id == std::vector<int>{0, 0, 0, 3});
  CHECK(groups.supply == std::vector<int>{0, 1, 3, 2});
  const std::vector<PotentialSource> supplies = potential_sources_of(scene);
  REQUIRE(supplies.size() == 4);
  CHECK(supplies[3].name == "the group \"wire\"");
  CHECK(supplies[3].potential == 5);
  Charges charges(std::vector<double>{1, 2, 3, 4}, supplies.size());
  charges.distribute(groups, std::vector<double>{0.5, -1, 10, 4});
  CHECK(charges.collected_by_source() == std::vector<double>{0.5, 3, 0, -7});
  CHECK(charges.collected() == -3.5);
  CHECK(charges.stored() + charges.collected() == 10);
}

TEST_CASE("Charges::after: predicted charges equal those after inject()") {
  // The last node receives no current.
  const std::vector<double> initial = {1e-10, -2e-10, 3e-10}, current = {1e-9, 0};
  for (const double relaxation_time : {double{INFINITY}, 0.3}) {
    Charges charges(initial, 1);
    const std::vector<double> forecast = charges.after(charge_step(0.1, 0, relaxation_time), current);
    charges.inject(current, 0.1, relaxation_time);
    // Both sum the same two products without cancellation: they differ by at most four roundings, 4 x 1.1e-16.
    for (int i = 0; i < 3; ++i) CHECK(charges.charge(i) == near(forecast[i], 4.5e-16));
  }
}

TEST_CASE("Charges: a state restored from save() continues with identical bits") {
  const std::vector<double> initial = {1e-10, -2e-10}, current = {1e-9 / 3, 1e-9 / 7};
  Charges charges(initial, 2), copy(initial, 2);
  for (int k = 0; k < 1000; ++k) charges.inject(current, 1e-3 / 3);
  charges.distribute({.id = {0, 1}, .potential = {7.0, {}}, .supply = {1, -1}}, std::vector<double>{1e-12 / 3, 0});
  copy.restore(charges.save());
  charges.inject(current, 0.1);
  copy.inject(current, 0.1);
  CHECK(copy.save() == charges.save());
  CHECK_THROWS_AS(copy.restore(std::vector<double>(6)), Failure);
}

}  // namespace contacts_test
