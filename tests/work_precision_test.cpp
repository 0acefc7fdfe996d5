// Tests of the sweeps of `work-precision` on scenes that take milliseconds.
#include "src/commands/work_precision.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <thread>

#include "solvers/error.hpp"
#include "src/effects/floating_conductors.hpp"
#include "src/effects/read_scene.hpp"
#include "validation/benchmarks/decay.hpp"

namespace work_precision_test {

using namespace lichtenberg;
using namespace lichtenberg::work_precision;

namespace {

Scene two_disks(const std::string& more = "") {
  return parse_scene(R"(
    [domain]
    size = [16e-3, 16e-3]
    bottom = { potential = 0.0 }
    [medium]
    permittivity = 4e-11
    viscosity = 0.7
    [[conductor]]
    position = [5.13e-3, 8.07e-3]
    radius = 1e-3
    charge = 1e-10
    [[conductor]]
    position = [11.02e-3, 7.91e-3]
    radius = 1e-3
    charge = -0.7e-10
    [effects.floating_conductors]
    [effects.stokes_drag]
    [field]
    cells = 64
    [stop]
    time = 0.5
  )" + more,
                     "two-disks.toml");
}

struct Measured : Point {
  std::string method;
  Settings settings;
};

struct LeftOut {
  std::string method, reason;
};

struct Swept : Diagram {
  std::vector<Measured> points;
  std::vector<LeftOut> left_out;
};

/// All candidates. Of each method, those after the first that takes longer than `seconds` are left out.
Swept swept(void (*sweep)(const Scene&, const Request&), const Scene& scene, Request request, double seconds = 10) {
  Swept result;
  request.serve = [&](const Diagram& diagram, const std::vector<Method>& methods) {
    static_cast<Diagram&>(result) = diagram;
    for (const Method& method : methods)
      for (const Candidate& candidate : method.candidates) try {
          result.points.push_back({measure(candidate), method.name, candidate.settings});
          if (result.points.back().seconds > seconds) break;
        } catch (const InputError& error) {
          result.left_out.push_back({method.name, error.what()});
        }
  };
  sweep(scene, request);
  return result;
}

std::vector<Measured> points_of(const Swept& diagram, const std::string& method) {
  std::vector<Measured> points;
  std::ranges::copy_if(diagram.points, std::back_inserter(points),
                       [&](const Measured& point) { return point.method == method; });
  return points;
}

double setting(const Settings& settings, const std::string& name) {
  const auto found = std::ranges::find(settings, name, [](const auto& entry) { return entry.first; });
  REQUIRE(found != settings.end());
  return found->second;
}

/// Trial that sleeps for a given time and has a given error.
class SleepTrial : public Trial {
 public:
  SleepTrial(double seconds, double error) : seconds_(seconds), error_(error) {}
  void run() override { std::this_thread::sleep_for(std::chrono::duration<double>(seconds_)); }
  std::vector<double> errors() const override { return {error_}; }
  std::int64_t work() const override { return 1; }

 private:
  double seconds_, error_;
};

}  // namespace

TEST_CASE("measure: time, cores and errors of a work-precision candidate") {
  const Point point = measure({{}, 1, [] { return std::make_unique<SleepTrial>(2e-3, 0.1); }});
  CHECK(point.seconds >= 2e-3);
  CHECK(point.cores < 0.9);  // The trial slept.
  CHECK(point.errors == std::vector<double>{0.1});
}

TEST_CASE("work-precision: cut-cell error falls with cells, multipole is accurate") {
  const Swept diagram = swept(sweep_field, two_disks(),
                              {.methods = {"cut-cell", "cut-cell-cholmod", "multipole"}, .sizes = {128, 32, 64}});
  CHECK(diagram.quantities == std::vector<std::string>{"potentials", "charges", "forces"});
  // Second order gives a factor of 4 per doubling. The disks' positions in their cells may change it by up to 2 (FIELD:
  // mean and largest error over positions in validation/two_disks). The charges of the disks are given; only that of
  // the bottom side is free.
  std::vector<Measured> tight = points_of(diagram, "cut-cell");
  std::erase_if(tight, [](const Measured& p) { return setting(p.settings, "tolerance") > 1e-7; });
  REQUIRE(tight.size() == 3);
  for (const std::size_t quantity : {0, 2})
    for (const std::size_t finer : {1, 2}) {
      CHECK(setting(tight[finer].settings, "S") == 2 * setting(tight[finer - 1].settings, "S"));
      CHECK(tight[finer].errors[quantity] < 0.5 * tight[finer - 1].errors[quantity]);
    }
  // The factorized form of the system has the same error within the tolerances, 1e-8 each.
  for (const Measured& direct : points_of(diagram, "cut-cell-cholmod")) {
    const auto same = std::ranges::find_if(
        tight, [&](const Measured& p) { return setting(p.settings, "S") == setting(direct.settings, "S"); });
    REQUIRE(same != tight.end());
    CHECK(std::abs(direct.errors[0] - same->errors[0]) < 1e-7);
  }
  const std::vector<Measured> spectral = points_of(diagram, "multipole");
  REQUIRE(spectral.size() == 9);
  for (const Measured& p : spectral)
    for (const double error : p.errors) CHECK(error <= setting(p.settings, "tolerance"));
}

TEST_CASE("work-precision: an impossible method is left out with a reason") {
  const Scene scene = two_disks(R"(
    [[electrode]]
    shape = "bar"
    from = [8e-3, 12e-3]
    to = [8e-3, 14e-3]
    width = 1e-3
    potential = 100.0
  )");
  const Swept diagram = swept(sweep_field, scene, {.methods = {"multipole", "cut-cell"}, .sizes = {32}});
  CHECK(diagram.reference.find("S = 64") != std::string::npos);
  CHECK(points_of(diagram, "multipole").empty());
  REQUIRE(diagram.left_out.size() == 9);
  CHECK(diagram.left_out[0].reason.find("is no disk") != std::string::npos);
  CHECK(points_of(diagram, "cut-cell").size() == 5);
  // Compared with a grid twice as fine, a second-order error appears as 3/4 of itself. The reference has 1/4, a third
  // of that.
  CHECK(diagram.reference_errors[0] ==
        doctest::Approx(points_of(diagram, "cut-cell").back().errors[0] / 3).epsilon(1e-3));
}

TEST_CASE("work-precision: sums next to open sides reach their accuracy") {
  const std::string cloud = R"(
    [[population]]
    count = 100
    charge = 1
    charge_distribution = "gaussian"
    [effects.viscoelastic_contact]
    [effects.coulomb]
  )";
  const std::string open = "[units]\n[domain]\nsize = [9, 9, 9]\n", walls = "[effects.flat_walls]\n";
  const std::string grounded = "top = { potential = 0 }\n", also = "bottom = { potential = 0 }\n";
  struct Case {
    std::string text, reference;
  };
  for (const auto& [text, reference] : std::vector<Case>{{open + "unbounded = true\n" + cloud, "all pairs"},
                                                         {open + grounded + cloud + walls, "all pairs"},
                                                         {open + grounded + also + cloud + walls, "the mesh"}}) {
    CAPTURE(text);
    const Swept diagram = swept(sweep_charges, parse_scene(text, "cloud.toml"), {.methods = {"mesh"}});
    CHECK(diagram.reference.find(reference) != std::string::npos);
    REQUIRE(diagram.points.size() >= 7);
    for (const Measured& p : diagram.points) CHECK(p.errors[0] <= setting(p.settings, "accuracy"));
  }
}

TEST_CASE("work-precision --time: Euler first order, split error falls with work") {
  const Swept diagram = swept(sweep_time, two_disks(), {.methods = {"euler", "split"}}, 0.15);
  CHECK(diagram.reference_errors[0] < 1e-6);
  const std::vector<Measured> euler = points_of(diagram, "euler"), split = points_of(diagram, "split");
  REQUIRE(euler.size() >= 2);
  // error = C dt (1 + O(dt)). These steps are at most 1/15 of the run, over which the force changes by about its own
  // size.
  for (std::size_t k = 1; k < euler.size(); ++k)
    CHECK(euler[k - 1].errors[0] / euler[k].errors[0] == doctest::Approx(2).epsilon(0.1));
  REQUIRE(split.size() >= 4);
  for (std::size_t k = 1; k < split.size(); ++k) {
    CHECK(split[k].errors[0] < split[k - 1].errors[0]);
    CHECK(split[k].work > split[k - 1].work);
  }
}

TEST_CASE("work-precision: wrong names and sizes are refused early") {
  const auto refused = [](const Scene& scene, const Request& request) {
    try {
      sweep_field(scene, request);
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  CHECK(refused(two_disks(), {.methods = {"cutcell"}}).find("did you mean cut-cell?") != std::string::npos);
  CHECK(refused(two_disks(), {.sizes = {64, 4}}).find("--sizes 4") != std::string::npos);
  Scene oblong = two_disks();
  oblong.domain.size.y = 12e-3;
  CHECK(refused(oblong, {.sizes = {50}}).find("would have 37.5") != std::string::npos);
  Scene neutral = two_disks();
  neutral.effects.remove<effects::FloatingConductorsOptions>();
  CHECK(refused(neutral, {}).find("floating_conductors") != std::string::npos);
  CHECK_THROWS_AS(sweep_time(two_disks(), {.methods = {"multipole"}}), InputError);
}

TEST_CASE("end_of_decay: time of an exponential at a value; none if far or rising") {
  const auto decay = [](double t) { return benchmarks::Sample{t, 3 * std::exp(-0.1 * t)}; };
  const auto end = benchmarks::end_of_decay(decay(20), decay(40), decay(100).value);
  REQUIRE(end);
  CHECK(*end == doctest::Approx(100));
  CHECK_FALSE(benchmarks::end_of_decay(decay(20), decay(40), decay(401).value));  // More than ten times 40.
  CHECK_FALSE(benchmarks::end_of_decay({20, 1}, {40, 1.1}, 0.1));                 // The error grows.
  CHECK_FALSE(benchmarks::end_of_decay({20, 1}, {40, 1}, 0.1));
  CHECK_FALSE(benchmarks::end_of_decay({20, 1}, {20, 0.5}, 0.1));  // There is no interval.
  CHECK_FALSE(benchmarks::end_of_decay({20, 1}, {40, NAN}, 0.1));
  CHECK_FALSE(benchmarks::end_of_decay({0, 0}, {40, 0.5}, 0.1));  // There is no sample in the middle.
}

}  // namespace work_precision_test
