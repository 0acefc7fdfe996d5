// Tests of scenes with changed keys, the members of an ensemble.
#include <doctest/doctest.h>

#include "solvers/error.hpp"
#include "src/effects/contact_discharge.hpp"
#include "src/effects/read_scene.hpp"
#include "src/scene/scene.hpp"
#include "src/scene/vary.hpp"

namespace vary_test {

using namespace lichtenberg;

namespace {

const std::string text = R"(
seed = 5  # a comment
[domain]
size = [16e-3, 8e-3]
bottom = { potential = 0.0 }
[medium]
relative_permittivity = 4.7
[[electrode]]
name = "left 'one'"
shape = "disk"
centre = [2e-3, 4e-3]
radius = 1e-3
potential = 10.0
[[electrode]]
shape = "disk"
centre = [14e-3, 4e-3]
radius = 1e-3
potential = -10.0
[[population]]
count = 3
radius = 0.3e-3
[effects.floating_conductors]
[effects.contact_discharge]
)";

Scene with(const std::vector<Setting>& settings) {
  return parse_scene(with_settings(text, "test.toml", settings), "varied.toml");
}

std::string refusal(const std::vector<Setting>& settings) {
  try {
    with_settings(text, "test.toml", settings);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

bool has(const std::string& sentence, const std::string& part) { return sentence.find(part) != std::string::npos; }

}  // namespace

TEST_CASE("with_settings: without settings the scene is unchanged") {
  const Scene before = parse_scene(text, "test.toml"), after = with({});
  CHECK(after.seed == 5);
  CHECK(after.domain.size.x == before.domain.size.x);
  CHECK(after.domain.sides[2].electrode);
  CHECK(after.electrodes[0].name == "left 'one'");
  CHECK(after.medium.permittivity == before.medium.permittivity);
  REQUIRE(after.conductors.size() == 3);
  for (int i = 0; i < 3; ++i) CHECK(after.conductors[i].position.x == before.conductors[i].position.x);
}

TEST_CASE("with_settings: sets keys in any table and adds tables") {
  const Scene scene = with({{"seed", "6"},
                            {"population.count", "4"},
                            {"electrode[1].radius", "1.5e-3"},
                            {"domain.bottom", "\"insulating\""},
                            {"effects.contact_discharge.contact_distance", "0.2e-3"},
                            {"mechanics.integrator", "\"euler\""}});
  CHECK(scene.seed == 6);
  CHECK(scene.conductors.size() == 4);
  CHECK(std::get<Disk>(scene.electrodes[0].shape).radius == 1e-3);
  CHECK(std::get<Disk>(scene.electrodes[1].shape).radius == 1.5e-3);
  CHECK_FALSE(scene.domain.sides[2].electrode);
  CHECK(scene.effects.find<effects::ContactDischargeOptions>()->contact_distance == 0.2e-3);
  CHECK(scene.mechanics.integrator == Integrator::euler);
}

TEST_CASE("with_settings: numbers keep all their digits") {
  const Scene scene = with({{"effects.contact_discharge.contact_distance", "0.00012345678901234567"}});
  CHECK(scene.effects.find<effects::ContactDischargeOptions>()->contact_distance == 0.00012345678901234567);
}

TEST_CASE("setting_of: a number may begin or end with its decimal point") {
  CHECK(setting_of("stop.time=.25").value == "0.25");
  CHECK(setting_of("stop.time=-.25").value == "-0.25");
  CHECK(setting_of("stop.time=2.").value == "2");
  CHECK(setting_of("output.file=.hidden").value == "\".hidden\"");
  CHECK(setting_of("output.file=1.2.3").value == "\"1.2.3\"");
}

TEST_CASE("with_settings: unknown or incomplete keys are refused with a message") {
  CHECK(has(refusal({{"effects.contact_discharge.contact_distanze", "1"}}),
            "nearest known key is effects.contact_discharge.contact_distance"));
  CHECK(has(refusal({{"effects.contact_discharge", "1"}}), "is no key of a scene but a table: name a key of it"));
  CHECK(has(refusal({{"domain.left.potential", "5"}}),
            "domain.left is a single value and is set as a whole: it must be "));
  CHECK(has(refusal({{"domain.left.potential", "5"}}), "{ potential = a number in V or a function of time }"));
  CHECK(has(refusal({{"seed.x", "5"}}), "seed is a single value and is set as a whole: it must be an integer"));
  CHECK(has(refusal({{"electrode.radius", "1e-3"}}), "say which, from electrode[0] to electrode[1]"));
  CHECK(has(refusal({{"electrode[2].radius", "1e-3"}}), "the scene has 2 tables [[electrode]]"));
  CHECK(has(refusal({{"electrode[x].radius", "1e-3"}}), "is no key of a scene"));
  CHECK(has(refusal({{"field[0].cells", "64"}}), "no index is allowed"));
  CHECK(has(refusal({{"conductor.radius", "1e-3"}}), "the scene has no table [[conductor]]"));
  CHECK(has(refusal({{"effects.current_injection.current", "1e-9"}}), "no table [effects.current_injection]"));
}

TEST_CASE("listed_values: splits lists of values, refuses other texts") {
  using Values = std::vector<std::string>;
  CHECK(listed_values("0.4e-3, 0.775e-3") == Values{"0.0004", "0.000775"});
  CHECK(listed_values("64") == Values{"64"});
  CHECK(listed_values("\"cvode\",\"euler\"") == Values{"\"cvode\"", "\"euler\""});
  CHECK(listed_values("[1, 2],[3.5, 4]") == Values{"[1, 2]", "[3.5, 4]"});
  CHECK(listed_values("{ potential = 0 },\"insulating\"") == Values{"{ potential = 0 }", "\"insulating\""});
  for (const std::string nonsense : {"", "cvode", "1,,2", "1]\nother = [2", "1;2"})
    CHECK_THROWS_AS(listed_values(nonsense), InputError);
}

}  // namespace vary_test
