// Tests of the contact network of D 7.2-7.3 on configurations with known results. Lengths are in units of the radius: R
// = 1 and contact_gap = 1. Conductors are in contact when their centres are closer than 3 (D 7.1). A conductor is in
// contact with the bottom, the electrode, when its centre is lower than 2.
#include <doctest/doctest.h>

#include <cmath>
#include <random>

#include "src/analysis/circuit.hpp"
#include "src/analysis/network.hpp"
#include "src/analysis/statistics.hpp"
#include "src/effects/contact_discharge.hpp"

namespace analysis_test {

using namespace lichtenberg;
using namespace lichtenberg::analysis;

namespace {

const Ground bottom{{30, 30}, {false, false, true, false}, {}};

std::vector<double> ones(size_t n) { return std::vector<double>(n, 1.0); }

ContactNetwork network_on(const Ground& ground, const std::vector<Vec2>& position) {
  return analysis::network(contacts(position, ones(position.size()), 1, ground), position);
}
ContactNetwork network_on_bottom(const std::vector<Vec2>& position) { return network_on(bottom, position); }

}  // namespace

TEST_CASE("contacts: exist where the surface gap is below the contact gap") {
  const Ground none{{30, 30}, {}, {}};
  const auto in_contact = [&](double distance, double r1, double r2, double gap) {
    const std::vector<Vec2> position{{5, 5}, {5 + distance, 5}};
    return contacts(position, std::vector<double>{r1, r2}, gap, none) == std::vector<Edge>{{0, 1}};
  };
  CHECK(in_contact(2.999, 1, 1, 1));
  CHECK_FALSE(in_contact(3.001, 1, 1, 1));
  CHECK(in_contact(5.499, 1, 4, 0.5));  // 1 + 4 + 0.5
  CHECK_FALSE(in_contact(5.501, 1, 4, 0.5));
  CHECK(in_contact(1.5, 1, 1, 1));  // Overlapping, as Hertz contacts are.
}

TEST_CASE("contacts(): lists each contact once, in ascending order of conductors") {
  const std::vector<Vec2> position{{5, 4}, {5, 1.5}, {20, 1.5}};
  CHECK_EQ(contacts(position, ones(3), 1, bottom), std::vector<Edge>{{0, 1}, {1, to_ground}, {2, to_ground}});
}

TEST_CASE("contact_graph: builds neighbour lists and ground flags from contacts") {
  const ContactGraph graph = contact_graph(3, std::vector<Edge>{{0, 2}, {2, to_ground}});
  CHECK_EQ(graph.neighbours, std::vector<std::vector<int>>{{2}, {}, {0}});
  CHECK_EQ(graph.grounded, std::vector<bool>{false, false, true});
}

TEST_CASE("gap to ground: smallest one to electrode sides, disks, bars and rings") {
  const Disk disk{{5, 8}, 1};
  CHECK_EQ(gap(disk, Ground{{30, 10}, {true, false, false, false}, {}}), 4);  // 5 - 1
  CHECK_EQ(gap(disk, Ground{{30, 10}, {true, false, false, true}, {}}), 1);   // 10 - 8 - 1
  CHECK_EQ(gap(disk, Ground{{30, 10}, {}, {Disk{{5, 4}, 2}}}), 1);            // 4 - 2 - 1
  CHECK_EQ(gap(disk, Ground{{30, 10}, {}, {Bar{{0, 3}, {10, 3}, 2}}}), 3);    // 5 - 1 - 1
  CHECK_EQ(gap(disk, Ground{{30, 10}, {}, {Ring{{5, 5}, 5}}}), 1);            // 5 - 3 - 1
  CHECK(std::isinf(gap(disk, Ground{{30, 10}, {}, {}})));
}

TEST_CASE("ground_of: contains electrodes and electrode sides, no insulating sides") {
  Scene scene;
  scene.domain.size = {3, 2};
  scene.domain.sides[3].electrode = true;  // The top
  scene.electrodes.push_back({"needle", Disk{{1, 1}, 0.5}, 0});
  const Ground ground = ground_of(scene);
  CHECK_EQ(ground.size, Vec2{3, 2});
  CHECK_EQ(ground.side, std::array<bool, 4>{false, false, false, true});
  REQUIRE_EQ(ground.bodies.size(), 1);
  CHECK_EQ(std::get<Disk>(ground.bodies[0]).radius, 0.5);
}

// a touches the electrode; b and c touch a (at 2.973 and 2.879) and each other (at 2.476); d touches b (at 2.502) and c
// (at 2.062). In the first round only a has a successor, so c takes a although b is nearer. In the second round d takes
// c. e and f touch only each other.
const std::vector<Vec2> rounds{{0, 1.5}, {2.8, 2.5}, {1.0, 4.2}, {2.9, 5.0}, {20, 10}, {22.5, 10}};

TEST_CASE("successors (next towards ground): assigned in rounds from the ground") {
  CHECK_EQ(network_on_bottom(rounds).successor, std::vector<int>{to_ground, 0, 0, 2, unconnected, unconnected});
}

TEST_CASE("successors (next towards ground): independent of conductor numbering") {
  const std::vector<int> number{3, 5, 0, 2, 4, 1};  // Numbers of a, b, ... f.
  std::vector<Vec2> position(rounds.size());
  for (size_t k = 0; k < number.size(); ++k) position[number[k]] = rounds[k];
  const std::vector<int> successor = network_on_bottom(position).successor;
  CHECK_EQ(successor[3], to_ground);
  CHECK_EQ(successor[5], 3);
  CHECK_EQ(successor[0], 3);
  CHECK_EQ(successor[2], 0);
  CHECK_EQ(successor[4], unconnected);
  CHECK_EQ(successor[1], unconnected);
}

TEST_CASE("successors (next towards ground): the first of two equally near is taken") {
  // 0 and 2 are on the electrode, 1 is above the middle between them.
  const std::vector<Vec2> position{{10, 1.5}, {12, 3.5}, {14, 1.5}};
  CHECK_EQ(network_on_bottom(position).successor, std::vector<int>{to_ground, 0, to_ground});
  // One round later: 3 is on 0 and 2 on 1, and 4 touches both.
  const std::vector<Vec2> arch{{10, 1.5}, {15, 1.5}, {15, 4}, {10, 4}, {12.5, 5.5}};
  CHECK_EQ(network_on_bottom(arch).successor, std::vector<int>{to_ground, to_ground, 1, 0, 2});
}

TEST_CASE("degree distribution: counts contacts, ground contacts and loops") {
  const DegreeDistribution degrees = network_on_bottom(rounds).degrees;
  // a: ground, b, c; b: a, c, d; c: a, b, d; d: b, c. There are 5 contacts and one with the ground, two more than in a
  // tree of 4.
  CHECK_EQ(degrees.connected, 4);
  CHECK_EQ(degrees.grounded, 1);
  CHECK_EQ(degrees.number, std::vector<int>{0, 0, 1, 3});
  CHECK_EQ(degrees.loops, 2);
  CHECK_EQ(degrees.endpoints(), 0);
  CHECK_EQ(degrees.branch_points(), 3);
  CHECK_EQ(degrees.fraction(3), 0.75);
  CHECK_EQ(degrees.branching(), 0.75);
}

TEST_CASE("tree with one ground contact: degree fractions obey the sum rules") {
  // A stem of three conductors, the third of which carries three arms. Contacts are 2.5 long, diagonals 3.54.
  const std::vector<Vec2> position{{10, 1.5}, {10, 4}, {10, 6.5}, {12.5, 6.5}, {7.5, 6.5}, {10, 9}};
  const ContactNetwork tree = network_on_bottom(position);
  CHECK_EQ(tree.successor, std::vector<int>{to_ground, 0, 1, 2, 2, 2});
  const DegreeDistribution& degrees = tree.degrees;
  CHECK_EQ(degrees.number, std::vector<int>{0, 3, 2, 0, 1});
  CHECK_EQ(degrees.loops, 0);
  CHECK_EQ(degrees.endpoints(), 3);
  double sum = 0, weighted = 0;
  for (int j = 0; j <= 4; ++j) {
    sum += degrees.fraction(j);
    weighted += (j - 2) * degrees.fraction(j);
  }
  const double m = 6, f1 = degrees.fraction(1), b = degrees.branching();
  CHECK_EQ(sum, doctest::Approx(1));               // 7.6
  CHECK_EQ(weighted + 1 / m, doctest::Approx(0));  // 7.7
  // 7.9 follows from both; for finite M the 1/M of 7.7 stays in f3 and f4.
  CHECK_EQ(degrees.fraction(2), doctest::Approx(1 - (f1 + b)));
  CHECK_EQ(degrees.fraction(3), doctest::Approx(2 * b - f1 + 1 / m));
  CHECK_EQ(degrees.fraction(4), doctest::Approx(f1 - b - 1 / m));
}

TEST_CASE("no ground: all conductors are unconnected and degree fractions are zero") {
  const ContactNetwork none = network_on(Ground{{30, 30}, {}, {}}, rounds);
  CHECK_EQ(none.successor, std::vector<int>(rounds.size(), unconnected));
  CHECK_EQ(none.degrees.connected, 0);
  CHECK_EQ(none.degrees.endpoints(), 0);
  CHECK_EQ(none.degrees.fraction(1), 0);
  CHECK_EQ(none.degrees.branching(), 0);
  CHECK(network_on_bottom({}).successor.empty());
}

TEST_CASE("chain of 20000 conductors: each successor is the next one towards ground") {
  std::vector<Vec2> position;
  for (int i = 0; i < 20000; ++i) position.push_back({1, 1.5 + 2.5 * i});
  const std::vector<int> successor = network_on_bottom(position).successor;
  for (int i = 0; i < 20000; ++i) REQUIRE_EQ(successor[i], i - 1);  // to_ground is -1.
}

TEST_CASE("random networks: degree sum rule holds, successors lead to the ground") {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> uniform(0, 60);
  std::vector<Vec2> position(400);
  for (Vec2& p : position) p = {uniform(random), uniform(random)};
  const Ground ground{{60, 60}, {true, false, true, false}, {}};
  const ContactNetwork net = network_on(ground, position);
  const ContactGraph graph = contact_graph(static_cast<int>(position.size()), net.contacts);
  REQUIRE_GT(net.degrees.connected, 100);
  REQUIRE_GT(net.degrees.grounded, 1);

  double weighted = 0;
  for (int j = 0; j < static_cast<int>(net.degrees.number.size()); ++j) weighted += (j - 2) * net.degrees.fraction(j);
  const double m = net.degrees.connected;
  CHECK_EQ(weighted + (net.degrees.grounded - 2 * net.degrees.loops) / m, doctest::Approx(0));

  const auto steps = [&](int i) {
    int n = 0;
    for (; i >= 0; i = net.successor[i]) ++n;
    return n;
  };
  for (size_t i = 0; i < position.size(); ++i) {
    if (net.successor[i] == unconnected) continue;
    CHECK_EQ(net.successor[i] == to_ground, graph.grounded[i]);
    for (const int j : graph.neighbours[i]) {
      REQUIRE_NE(net.successor[j], unconnected);
      CHECK_LE(steps(static_cast<int>(i)), steps(j) + 1);
    }
  }
}

TEST_CASE("Student's factors: equal tabulated values for 95 % confidence") {
  CHECK(student_factor(1) == doctest::Approx(12.706).epsilon(1e-4));
  CHECK(student_factor(4) == doctest::Approx(2.776).epsilon(2e-4));
  CHECK(student_factor(30) == doctest::Approx(2.042).epsilon(2e-4));
}

TEST_CASE("mean: known 95 % confidence interval, none for a single value") {
  // 1, 2, 3, 4, 5: mean 3, variance 10/4, standard error sqrt(2.5/5); the factor is 2.776 for 4 degrees of freedom.
  const Estimate estimate = mean(std::vector<double>{1, 2, 3, 4, 5});
  CHECK(estimate.value == 3);
  CHECK(estimate.sample == 5);
  CHECK(estimate.deviation == doctest::Approx(std::sqrt(2.5)));
  CHECK(*estimate.half_width == doctest::Approx(2.776 * std::sqrt(0.5)).epsilon(2e-4));
  CHECK_FALSE(mean(std::vector<double>{7}).half_width);  // A single run does not determine the scatter.
}

TEST_CASE("slope through the origin: known data give the 95 % confidence interval") {
  const std::vector<double> x{1, 4, 5};
  const Estimate exact = slope(x, std::vector<double>{2, 8, 10});
  CHECK(exact.value == 2);
  CHECK(*exact.half_width == doctest::Approx(0));
  // y = 2, 10, 8: slope 20/10, residuals 0, 2, -2, so s^2 = (4/4 + 4/5) / 2 = 0.9 and the error is sqrt(0.9 / 10) =
  // 0.3.
  const Estimate scattered = slope(x, std::vector<double>{2, 10, 8});
  CHECK(scattered.value == 2);
  CHECK(*scattered.half_width == doctest::Approx(student_factor(2) * 0.3));
}

TEST_CASE("confidence intervals of 95 %: 95 % of them contain the true value") {
  // Binomial counts of x independent events of probability 1/4. For 2000 ensembles the share is 95 % +- 1.5 % (three
  // standard deviations).
  std::mt19937_64 random(1);
  const std::vector<double> x{64, 64, 100, 100, 144, 144, 196, 196};
  int slopes = 0, means = 0;
  for (int ensemble = 0; ensemble < 2000; ++ensemble) {
    std::vector<double> counts, fractions;
    for (const double n : x) {
      counts.push_back(std::binomial_distribution<int>(static_cast<int>(n), 0.25)(random));
      fractions.push_back(std::binomial_distribution<int>(100, 0.25)(random) / 100.0);
    }
    const auto holds = [](const Estimate& e) { return std::abs(e.value - 0.25) <= *e.half_width; };
    slopes += holds(slope(x, counts));
    means += holds(mean(fractions));
  }
  CHECK(slopes / 2000.0 == doctest::Approx(0.95).epsilon(0.015));
  CHECK(means / 2000.0 == doctest::Approx(0.95).epsilon(0.015));
}

TEST_CASE("energy_account: adds stored and dissipated, subtracts supplied energy") {
  ConductorFrame frame{.energy = 1};
  frame.energy_balance = {.kinetic = 10, .elastic = 100, .flows = {1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9}};
  CHECK_EQ(energy_account(frame), 1111100000 + 111 - 11000);
}

TEST_CASE("allowed energy imbalance: sum of time-step and grid contributions") {
  Scene scene;
  scene.conductors = {{.radius = 2}, {.radius = 1}};
  scene.mechanics.position_tolerance = 4e-3;
  scene.domain.size = {8, 4};
  scene.field().cells = 128;  // h = 1/16
  const double steps = 0.04;  // (2 x 4e-3)^(2/3)
  // 0.04 sqrt(h/R), times (h/gap)^(3/2) if the gap exceeds a cell. Without contacts there is no second factor.
  CHECK_EQ(allowed_energy_imbalance(scene), doctest::Approx(steps + 0.01));
  scene.effects.add(effects::ContactDischargeOptions{.contact_distance = 0.25});
  CHECK_EQ(allowed_energy_imbalance(scene), doctest::Approx(steps + 0.01 / 8));
  scene.field().method = &multipole_method();
  CHECK_EQ(allowed_energy_imbalance(scene), doctest::Approx(steps));
}

}  // namespace analysis_test
