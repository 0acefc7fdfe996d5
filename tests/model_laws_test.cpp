// Laws of drag and of pairs that contradict themselves are refused when the model is made.
#include <doctest/doctest.h>

#include <cmath>
#include <memory>
#include <string>

#include "src/model/model.hpp"
#include "src/model/pair_effect.hpp"
#include "src/scene/effect_kind.hpp"
#include "tests/message.hpp"

namespace model_laws_test {

using namespace lichtenberg;

namespace {

bool contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

const EffectKind& kind_of_drag() {
  static const EffectKind kind = {.name = "swirl", .description = "", .help = ""};
  return kind;
}

/// Drag of a law that may wrongly depend on the velocity at which it is read.
struct Swirl : Effect {
  Swirl(double linear, bool reads_velocity) : linear(linear), reads_velocity(reads_velocity) {}
  const EffectKind& kind() const override { return kind_of_drag(); }
  DragLaw drag(const Bodies& bodies, int i) const override {
    return {.linear = linear * (reads_velocity ? 1 + norm(velocity_in_space(bodies, i)) : 1)};
  }
  double linear;
  bool reads_velocity;
};

std::string refusal_of_drag(double linear, bool reads_velocity) {
  Bodies bodies{.dimension = 2, .position = {0, 0}, .momentum = {0, 0}, .mass = {1}, .radius = {1}};
  return message_of([&] {
    std::vector<std::unique_ptr<Effect>> effects;
    effects.push_back(std::make_unique<Swirl>(linear, reads_velocity));
    Model(bodies, std::move(effects), {0});
  });
}

/// Linear spring between two bodies of radius 1 m from contact to the cutoff of 3 m, with faults.
struct Spring {
  static constexpr bool over_distance = false, charged = false;
  double factor = 1;  ///< of the force
  double jump = 0;    ///< J, energy at the cutoff
  double kink = 0;    ///< m, distance below which the spring is a hundred times as stiff
  double reach(double, double) const { return 3; }
  double energy_unit() const { return 1; }
  PairForce operator()(const PairGeometry& pair) const {
    const double depth = pair.reach - pair.distance, more = std::max(0.0, kink - pair.distance);
    return {depth * depth / 2 + more * more * 50 + jump, factor * (depth + 100 * more), 1};
  }
};

/// A Spring that divides its force by the distance.
struct SpringOverDistance : Spring {
  static constexpr bool over_distance = true;
  bool is_divided = true;
  PairForce operator()(const PairGeometry& pair) const {
    PairForce found = Spring::operator()(pair);
    if (is_divided) found.force /= pair.distance;
    return found;
  }
};

/// A Spring that does not state whether it uses charges.
struct Unstated {
  static constexpr bool over_distance = false;
  double reach(double, double) const { return 3; }
  double energy_unit() const { return 1; }
  PairForce operator()(const PairGeometry&) const { return {}; }
};
struct Stated : Unstated {
  static constexpr bool charged = true;
};

template <class Law>
std::string refusal_of_pair(const Law& law) {
  return message_of([&] { check_pair_law(law, 1, "spring"); });
}

}  // namespace

TEST_CASE("Effect::drag that depends on the velocity: refused with the effect") {
  CHECK(refusal_of_drag(1, false).empty());
  CHECK(contains(refusal_of_drag(1, true), "effects.swirl: Effect::drag depends on the velocity"));
  CHECK(contains(refusal_of_drag(-1, false), "effects.swirl: the drag of a body is -1 kg/s: it must be at least 0"));
}

TEST_CASE("check_pair_law: refuses a wrong force and an energy jump at the cutoff") {
  CHECK(refusal_of_pair(Spring{}).empty());
  CHECK(refusal_of_pair(SpringOverDistance{}).empty());
  CHECK(refusal_of_pair(Spring{.kink = 2.5}).empty());
  CHECK(refusal_of_pair(Spring{.kink = 2.05137}).empty());  // exactly at a point of the check
  const std::string wrong = "effects.spring: the law of the pair force contradicts itself";
  CHECK(contains(refusal_of_pair(Spring{.factor = -1}), wrong));
  CHECK(contains(refusal_of_pair(Spring{.factor = 1.0002}), wrong));
  CHECK(refusal_of_pair(Spring{.factor = 1.00005}).empty());
  CHECK(contains(refusal_of_pair(Spring{.factor = NAN}), wrong));
  SpringOverDistance undivided;
  undivided.is_divided = false;
  CHECK(contains(refusal_of_pair(undivided), wrong));
  // The largest energy at the points of the check is 0.45 J.
  CHECK(contains(refusal_of_pair(Spring{.jump = 1e-6}), "the energy of the pair force is 1e-06 at its cutoff 3"));
  CHECK(refusal_of_pair(Spring{.jump = 1e-7}).empty());
}

TEST_CASE("PairLaw: a law that does not state `charged` does not compile") {
  CHECK_FALSE(PairLaw<Unstated>);
  CHECK(PairLaw<Stated>);
}

}  // namespace model_laws_test
