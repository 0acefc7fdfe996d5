// Output column added from outside through headers alone: the gap to the nearest body.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "src/effects/effects.hpp"
#include "src/effects/read_scene.hpp"
#include "src/mechanics/simulation.hpp"
#include "src/record/hdf5.hpp"
#include "src/record/recorder.hpp"
#include "tests/folder.hpp"

namespace extend_column {

using namespace lichtenberg;

namespace {

struct NearestGapOptions {
  static const EffectKind& kind();
};

/// Exerts no force; adds the column `example_gap` [N] (m), measured between surfaces.
class NearestGap : public Effect {
 public:
  const EffectKind& kind() const override { return NearestGapOptions::kind(); }
  void add_columns(const State& state, Frame& frame) const override {
    const Bodies& bodies = state.bodies;
    std::vector<double> gap(bodies.size(), INFINITY);
    for (int i = 0; i < bodies.size(); ++i)
      for (int j = 0; j < bodies.size(); ++j)
        if (i != j) {
          const double* x = &bodies.position[2 * i];
          const double* y = &bodies.position[2 * j];
          gap[i] = std::min(gap[i], std::hypot(x[0] - y[0], x[1] - y[1]) - bodies.radius[i] - bodies.radius[j]);
        }
    frame.add_particles("example_gap", "m", gap);
  }
};

const EffectKind& NearestGapOptions::kind() {
  static const EffectKind kind = {.name = "example_gap",
                                  .description = "the gap to the nearest body is recorded",
                                  .help = "Adds a column; moves nothing.",
                                  .options = NearestGapOptions{},
                                  .make = [](const Scene&) { return std::make_unique<NearestGap>(); }};
  return kind;
}

Scene three_in_a_row() {
  EffectKinds kinds = effects::all_kinds();
  kinds.push_back(&NearestGapOptions::kind());
  return parse_scene(R"([domain]
size = [0.04, 0.02]
[medium]
viscosity = 0.01
[effects.stokes_drag]
[effects.example_gap]
[output]
file = "x.h5"
[[conductor]]
position = [0.010, 0.01]
radius = 1e-3
velocity = [0.1, 0.0]
[[conductor]]
position = [0.015, 0.01]
radius = 1e-3
[[conductor]]
position = [0.030, 0.01]
radius = 2e-3
)",
                     "row.toml", kinds);
}

}  // namespace

TEST_CASE("user-defined column: in every frame and in the result file with its unit") {
  const Folder folder;
  const Scene scene = three_in_a_row();
  const std::string path = (folder / "x.h5").string();
  Simulation simulation(scene);
  std::vector<double> expected;
  {
    Recorder recorder = Recorder::start(path, scene, make_bodies(scene).mass, false);
    for (const double time : {0.0, 0.001}) {
      simulation.advance_to(time);
      const Frame frame = simulation.frame();
      // The first body moves towards the second. The gap is the difference of the recorded positions minus both radii.
      const std::vector<Vec3> positions = frame.vectors("position");
      const double first = positions[1].x - positions[0].x - 2e-3, last = positions[2].x - positions[1].x - 3e-3;
      const std::vector<double> gap = frame.reals("example_gap");
      REQUIRE(gap.size() == 3);
      for (const auto& [found, right] : {std::pair{gap[0], first}, {gap[1], first}, {gap[2], last}})
        CHECK(found == doctest::Approx(right).epsilon(1e-12));
      expected.insert(expected.end(), gap.begin(), gap.end());
      recorder.add(frame);
    }
    Milestone end;
    end.checkpoint = simulation.checkpoint();
    recorder.save(end);
  }
  CHECK(expected[3] < expected[0]);
  const hdf5::Handle file = hdf5::load(path);
  CHECK(hdf5::get<double>(file, "particles/conductors/example_gap/value") == expected);
  const hdf5::Handle values(H5Dopen2(file, "particles/conductors/example_gap/value", H5P_DEFAULT));
  CHECK(hdf5::text(values, "unit") == "m");
}

}  // namespace extend_column
