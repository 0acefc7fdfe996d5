// Key added from outside through headers alone, with a default that depends on other keys.
#include <doctest/doctest.h>

#include <algorithm>

#include "src/effects/effects.hpp"
#include "src/effects/read_scene.hpp"
#include "src/mechanics/simulation.hpp"
#include "tests/folder.hpp"
#include "tests/message.hpp"

namespace extend_key {

using namespace lichtenberg;

namespace {

struct SpringOptions {
  double stiffness = 0;  ///< N/m
  static const EffectKind& kind();
};

/// Ties every body to its initial position, F = -k (x - x_0).
class Spring : public Effect {
 public:
  explicit Spring(const Scene& scene)
      : stiffness_(scene.effects.find<SpringOptions>()->stiffness), start_(make_bodies(scene).position) {}
  const EffectKind& kind() const override { return SpringOptions::kind(); }
  void add_forces(const State& state, std::span<double> force) const override {
    for (std::size_t c = 0; c < force.size(); ++c) force[c] -= stiffness_ * (state.bodies.position[c] - start_[c]);
  }

 private:
  double stiffness_;
  std::vector<double> start_;  ///< m
};

const EffectKind& SpringOptions::kind() {
  static const EffectKind kind = {.name = "spring",
                                  .description = "bodies hang on springs",
                                  .help = "Each body is tied to where it starts.",
                                  .options = SpringOptions{},
                                  .keys = {{.name = "stiffness",
                                            .target = target<&SpringOptions::stiffness>,
                                            .unit = "N/m",
                                            .range = ranges::positive,
                                            .computed_default = "100 swings a second",
                                            .help = "of the spring"}},
                                  .complete =
                                      [](const Draft& draft, Scene& scene) {
                                        if (draft.line("effects.spring.stiffness") != 0) return;
                                        const std::vector<double> mass = make_bodies(scene).mass;
                                        constexpr double rate = 2 * 3.14159265358979 * 100;  // rad/s
                                        scene.effects.find<SpringOptions>()->stiffness =
                                            rate * rate * std::ranges::max(mass);
                                      },
                                  .make = [](const Scene& scene) { return std::make_unique<Spring>(scene); }};
  return kind;
}

EffectKinds kinds() {
  EffectKinds all = effects::all_kinds();
  all.push_back(&SpringOptions::kind());
  return all;
}

Scene swinging(const std::string& keys) {
  return parse_scene(
      "[domain]\nsize = [0.04, 0.02]\n[mechanics]\nintegrator = \"cvode\"\n[[conductor]]\n"
      "position = [0.02, 0.01]\nradius = 1e-3\nvelocity = [0.5, 0.0]\n[effects.spring]\n" +
          keys,
      "spring.toml", kinds());
}

}  // namespace

TEST_CASE("user-defined key: its default follows from masses and can be replaced") {
  const Scene scene = swinging("");
  // After a quarter of the period of 0.01 s the body is at rest at its largest displacement, v / omega.
  Simulation simulation(scene);
  simulation.advance_to(0.0025);
  const Frame frame = simulation.frame();
  CHECK(frame.vectors("position")[0].x - 0.02 == doctest::Approx(0.5 / 628.318530718).epsilon(1e-4));
  CHECK(swinging("stiffness = 2.0").effects.find<SpringOptions>()->stiffness == 2);
  CHECK(contains(message_of([] { swinging("stiffness = -2.0"); }), "effects.spring.stiffness = -2 is not allowed"));
  CHECK(contains(scene_help(kinds()), "default: 100 swings a second"));
}

}  // namespace extend_key
