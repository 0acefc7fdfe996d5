// Tests of an effect outside the program, added through its headers with one declaration and a list that names it.
#include <doctest/doctest.h>
#include <fmt/format.h>

#include <algorithm>
#include <any>
#include <cmath>
#include <string>

#include "solvers/error.hpp"
#include "src/effects/effects.hpp"
#include "src/effects/read_scene.hpp"
#include "src/mechanics/simulation.hpp"
#include "src/model/checkpoint.hpp"
#include "src/record/hdf5.hpp"
#include "src/record/recorder.hpp"
#include "src/record/result.hpp"
#include "tests/folder.hpp"
#include "tests/line_charges.hpp"
#include "tests/spheres.hpp"

namespace added_effect_test {

using namespace lichtenberg;

namespace {

struct TetherOptions {
  double stiffness = 0;  ///< N/m
  double wear = 0;       ///< Path (m) after which the tether has half its stiffness.
  static const EffectKind& kind();
};

/// Ties each body to its initial position. A tether wears as its body moves: this is state of its own.
class Tether : public Effect {
 public:
  explicit Tether(const Scene& scene)
      : options_(*scene.effects.find<TetherOptions>()),
        anchor_(make_bodies(scene).position),
        before_(anchor_),
        travel_(scene.conductors.size()) {}

  const EffectKind& kind() const override { return TetherOptions::kind(); }
  void add_forces(const State& state, std::span<double> force) const override {
    for (std::size_t c = 0; c < force.size(); ++c)
      force[c] -= stiffness(c / state.bodies.dimension) * (state.bodies.position[c] - anchor_[c]);
  }
  void accept(const State& state, double dt) override {
    for (std::size_t c = 0; c < before_.size(); ++c)
      travel_[c / state.bodies.dimension] += std::abs(state.bodies.position[c] - before_[c]);
    before_ = state.bodies.position;
    age_ += dt;
  }
  void save(Checkpoint& checkpoint) const override {
    checkpoint.reals["travel"] = travel_;
    checkpoint.reals["before"] = before_;
    checkpoint.reals["age"] = {age_};
  }
  void restore(const Checkpoint& checkpoint) override {
    travel_ = reals(checkpoint, "travel", travel_.size());
    before_ = reals(checkpoint, "before", before_.size());
    age_ = reals(checkpoint, "age", 1).front();
  }
  void add_columns(const State&, Frame& frame) const override {
    frame.add_particles("tether_travel", "m", travel_);
    frame.add_system("tether_age", "s", age_);
  }
  void summarize(const State&, Summary& summary) const override {
    const double longest = *std::ranges::max_element(travel_);
    summary.lines.push_back({"tethers", fmt::format("{:.3g} m at most", longest)});
    summary.quantities.push_back({"tether_longest", longest, "m"});
  }

 private:
  double stiffness(std::size_t i) const { return options_.stiffness / (1 + travel_[i] / options_.wear); }

  TetherOptions options_;
  std::vector<double> anchor_, before_;  ///< m
  std::vector<double> travel_;           ///< Path lengths (m).
  double age_ = 0;                       ///< s
};

const EffectKind& TetherOptions::kind() {
  static const EffectKind kind = {
      .name = "tether",
      .description = "bodies hang on tethers that wear",
      .help = "Each body is tied to where it starts.",
      .options = TetherOptions{},
      .keys = {{.name = "stiffness",
                .target = target<&TetherOptions::stiffness>,
                .unit = "N/m",
                .range = ranges::positive,
                .required = true,
                .help = "of a new tether"},
               {.name = "wear",
                .target = target<&TetherOptions::wear>,
                .unit = "m",
                .range = ranges::positive,
                .computed_default = "100 of the largest radius",
                .help = "distance after which half the stiffness is left"}},
      .needs = {{"stokes_drag", "which damps it"}},
      .check =
          [](const Draft& draft) {
            if (draft.viscosity && *draft.viscosity < 1e-3)
              refuse_effect(draft, "tether", "medium.viscosity of at least 1e-3 Pa s");
          },
      .complete =
          [](const Draft& draft, Scene& scene) {
            if (draft.line("effects.tether.wear") == 0)
              scene.effects.find<TetherOptions>()->wear =
                  100 * std::ranges::max(scene.conductors, {}, &Conductor::radius).radius;
          },
      .make = [](const Scene& scene) { return std::make_unique<Tether>(scene); },
      .explain = [](const Scene& scene) -> std::vector<ExplanationLine> {
        return {{"wear", fmt::format("half after {:g} m", scene.effects.find<TetherOptions>()->wear)}};
      }};
  return kind;
}

EffectKinds kinds() {
  EffectKinds all = effects::all_kinds();
  all.push_back(&TetherOptions::kind());
  return all;
}

Scene tethered(const std::string& keys, const std::string& more = "viscosity = 0.01\n[effects.stokes_drag]\n") {
  return parse_scene(fmt::format("[domain]\nsize = [0.04, 0.02]\n[medium]\n{}[field]\ncells = 64\n[output]\n"
                                 "file = \"tethered.h5\"\n[[conductor]]\nposition = [0.01, 0.01]\nradius = 1e-3\n"
                                 "velocity = [0.1, 0.05]\n[[conductor]]\nposition = [0.03, 0.01]\nradius = 2e-3\n"
                                 "velocity = [0.0, -0.1]\n[effects.tether]\n{}",
                                 more, keys),
                     "tethered.toml", kinds());
}

std::string refusal(const std::string& keys, const std::string& more = "viscosity = 0.01\n[effects.stokes_drag]\n") {
  try {
    tethered(keys, more);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

bool has(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

}  // namespace

TEST_CASE("user-defined effect: scene keys have units, ranges, defaults and help") {
  const Scene scene = tethered("stiffness = 2.0\n");
  CHECK(scene.effects.find<TetherOptions>()->stiffness == 2);
  CHECK(scene.effects.find<TetherOptions>()->wear == 0.2);
  CHECK(tethered("stiffness = 2.0\nwear = 0.1\n").effects.find<TetherOptions>()->wear == 0.1);
  CHECK(has(refusal(""), "effects.tether.stiffness is missing"));
  CHECK(has(refusal("stiffness = \"2 N/m\"\n"), "a number in N/m, greater than 0, written without the unit"));
  CHECK(has(refusal("stiffness = -1.0\n"), "effects.tether.stiffness = -1 is not allowed"));
  CHECK(has(refusal("stifness = 1.0\n"), "the nearest known key is effects.tether.stiffness"));
  CHECK(has(refusal("stiffness = 1.0\n", ""),
            "effects.tether needs the table [effects.stokes_drag], which damps it: add it, or leave the effect out"));
  CHECK(has(refusal("stiffness = 1.0\n", "viscosity = 1e-5\n[effects.stokes_drag]\n"),
            "effects.tether needs medium.viscosity of at least 1e-3 Pa s"));
  CHECK(has(scene_help(kinds()), "[effects.tether]\n  Each body is tied to where it starts."));
  CHECK(has(scene_help(kinds()), "a number in m, greater than 0; default: 100 of the largest radius"));
}

TEST_CASE("user-defined effect: summarize_effects lists its line of explanation") {
  const std::vector<effects::EffectSummary> all = effects::summarize_effects(tethered("stiffness = 2.0\n"));
  CHECK(all.back().name == "tether");
  REQUIRE(all.back().explanation.size() == 1);
  CHECK(all.back().explanation[0].text == "half after 0.2 m");
}

TEST_CASE("user-defined effect: adds columns to frames and a line to the summary") {
  Simulation simulation(tethered("stiffness = 2e-4\n"));
  simulation.advance_to(0.5);
  const Frame frame = simulation.frame();
  const std::vector<double> travel = frame.reals("tether_travel");
  REQUIRE(travel.size() == 2);
  CHECK(travel[0] > 0);
  CHECK(frame.number("tether_age") == 0.5);
  const Summary summary = simulation.summary();
  const auto quantity = std::ranges::find(summary.quantities, "tether_longest", &Quantity::name);
  REQUIRE(quantity != summary.quantities.end());
  CHECK(quantity->value == std::max(travel[0], travel[1]));
  CHECK(std::ranges::count(summary.lines, "tethers", &Summary::Line::label) == 1);
}

TEST_CASE("user-defined effect: its columns are stored in the result file") {
  const Folder folder;
  const Scene scene = tethered("stiffness = 2e-4\n");
  const std::string path = (folder / "tethered.h5").string();
  Simulation simulation(scene);
  {
    Recorder recorder = Recorder::start(path, scene, make_bodies(scene).mass, false);
    for (const double time : {0.0, 0.1}) {
      simulation.advance_to(time);
      recorder.add(simulation.frame());
    }
    Milestone milestone;
    milestone.checkpoint = simulation.checkpoint();
    recorder.save(milestone);
  }
  const Result result(path);
  CHECK(result.observable("tether_age", 1) == std::vector<double>{0.1});
  CHECK(result.scene(kinds()).effects.find<TetherOptions>()->stiffness == 2e-4);
  CHECK_THROWS_WITH_AS(result.scene(), doctest::Contains("unknown key effects.tether"), InputError);
}

TEST_CASE("user-defined effect: its field flag and contact gap reach the result") {
  const Folder folder;
  const EffectKind arcs = {
      .name = "arcs", .description = "", .help = "", .field = true, .contact_gap = [](const Scene& scene) {
        return 2 * scene.conductors[0].radius;
      }};
  Scene scene = tethered("stiffness = 1.0\n");
  CHECK(!scene.effects.has(&EffectKind::field));
  CHECK(!number_in(scene, &EffectKind::contact_gap));
  scene.effects.add(arcs, std::any(1));
  CHECK(scene.effects.has(&EffectKind::field));
  const std::string path = (folder / "arcs.h5").string();
  Recorder::start(path, scene, make_bodies(scene).mass, false).save({});
  const hdf5::Handle file = hdf5::load(path);
  CHECK(hdf5::get<double>(file, "scene/contact_gap") == std::vector<double>{2e-3});
  CHECK(hdf5::exists(file, "provenance/session-0/field"));
}

TEST_CASE("user-defined effect: a run restored from a checkpoint has identical bits") {
  const Scene scene = tethered("stiffness = 2e-3\nwear = 1e-3\n");
  Simulation whole(scene), resumed(scene);
  whole.advance_to(0.2);
  const Checkpoint checkpoint = whole.checkpoint();
  CHECK(checkpoint.reals.contains("effects.tether.travel"));
  resumed.restore(checkpoint);
  whole.advance_to(0.4);
  resumed.advance_to(0.4);
  CHECK(whole.model().bodies.position == resumed.model().bodies.position);
  CHECK(whole.model().bodies.momentum == resumed.model().bodies.momentum);
  CHECK(whole.frame().reals("tether_travel") == resumed.frame().reals("tether_travel"));
  Checkpoint without = checkpoint;
  without.reals.erase("effects.tether.travel");
  CHECK_THROWS_AS(resumed.restore(without), Failure);
}

TEST_CASE("user-defined effect: a run resumed from a result has identical bits") {
  const Folder folder;
  const Scene scene = tethered("stiffness = 2e-3\nwear = 1e-3\n");
  const std::string path = (folder / "tethered.h5").string();
  Simulation whole(scene), resumed(scene);
  whole.advance_to(0.2);
  {
    Recorder recorder = Recorder::start(path, scene, make_bodies(scene).mass, false);
    recorder.add(whole.frame());
    recorder.save({.checkpoint = whole.checkpoint()});
  }
  Recorder recorder = Recorder::resume(path, scene);
  resumed.restore(recorder.checkpoint().value());
  whole.advance_to(0.4);
  resumed.advance_to(0.4);
  recorder.add(resumed.frame());
  recorder.save({.checkpoint = resumed.checkpoint()});
  CHECK(resumed.model().bodies.position == whole.model().bodies.position);
  const Result result(path);
  CHECK(result.observable("tether_age", 1) == std::vector<double>{*whole.frame().number("tether_age")});
}

TEST_CASE("integrators: Effect::accept gets each accepted step exactly once") {
  struct Scheme {
    Integrator integrator;
    FieldCoupling coupling;
  };
  for (const Scheme scheme :
       {Scheme{Integrator::cvode, FieldCoupling::split}, Scheme{Integrator::cvode, FieldCoupling::monolithic},
        Scheme{Integrator::euler, FieldCoupling::split}}) {
    CAPTURE(name_of(scheme.coupling));
    CAPTURE(name_of(scheme.integrator));
    Scene scene = steel_spheres::random_spheres();
    scene.mechanics.integrator = scheme.integrator;
    scene.mechanics.coupling = scheme.coupling;
    scene.effects.add(TetherOptions{.stiffness = 1e-9, .wear = 1});
    Simulation simulation(scene, std::make_unique<LineCharges>());
    simulation.advance_to(0.02);
    // The lengths of steps sum to the time within rounding, for any number of rejected steps.
    CHECK(*simulation.frame().number("tether_age") == doctest::Approx(0.02).epsilon(1e-12));
  }
}

TEST_CASE("effect kinds: two of one name are refused when a scene is read") {
  EffectKinds twice = kinds();
  twice.push_back(&TetherOptions::kind());
  CHECK_THROWS_WITH_AS(parse_scene("", "scene.toml", twice), doctest::Contains("two kinds of effects are named"),
                       InputError);
}

TEST_CASE("scene effects: adding another kind with an existing name is refused") {
  Scene scene = tethered("stiffness = 1.0\n");
  const EffectKind other = {.name = "tether"};
  CHECK_THROWS_WITH_AS(scene.effects.add(other, std::any(1)), doctest::Contains("two kinds of effects are named"),
                       InputError);
  CHECK(scene.effects.add(TetherOptions{.stiffness = 2}).stiffness == 2);
}

TEST_CASE("make_model: a given effect must be in the scene and be given only once") {
  Scene scene = tethered("stiffness = 1.0\n");
  CHECK_THROWS_WITH_AS(
      effects::make_model(scene, effects::made(std::make_unique<Tether>(scene), std::make_unique<Tether>(scene))),
      doctest::Contains("is given two effects \"tether\""), InputError);
  auto tether = std::make_unique<Tether>(scene);
  const Effect* handed_over = tether.get();
  const Model model = effects::make_model(scene, effects::made(std::move(tether)));
  CHECK(std::ranges::count_if(model.effects, [&](const auto& effect) { return effect.get() == handed_over; }) == 1);
  auto another = std::make_unique<Tether>(scene);
  scene.effects.remove<TetherOptions>();
  CHECK_THROWS_WITH_AS(effects::make_model(scene, effects::made(std::move(another))),
                       doctest::Contains("no table [effects.tether]"), InputError);
}

TEST_CASE("user-defined effect for 2D only: a model in three dimensions refuses it") {
  Scene scene = tethered("stiffness = 1.0\n");
  std::vector<std::unique_ptr<Effect>> tether = effects::made(std::make_unique<Tether>(scene));
  const Bodies space{.dimension = 3, .position = {0, 0, 0}, .momentum = {0, 0, 0}, .mass = {1}, .radius = {1}};
  CHECK_THROWS_WITH_AS(Model(space, std::move(tether), {}),
                       "effects.tether is not allowed in 3 dimensions: it supports 2", InputError);
}

}  // namespace added_effect_test
