// Names of tables and keys in earlier versions.
#include <doctest/doctest.h>

#include <algorithm>
#include <map>
#include <string>

#include "solvers/error.hpp"
#include "src/effects/contact_discharge.hpp"
#include "src/effects/coulomb.hpp"
#include "src/effects/effects.hpp"
#include "src/effects/read_scene.hpp"
#include "src/effects/viscoelastic_contact.hpp"
#include "src/scene/effect_kind.hpp"
#include "src/scene/schema.hpp"

namespace scene_old_names_test {

using namespace lichtenberg;

namespace {

const std::string conductors = R"([domain]
size = [16e-3, 8e-3]
bottom = { potential = 0.0 }
[medium]
relative_permittivity = 4.7
viscosity = 1.0
[[conductor]]
position = [3e-3, 4e-3]
radius = 1e-3
held = true
[effects.floating_conductors]
[effects.current_source]
current = 1e-9
[effects.contact_discharge]
gap = 0.25e-3
[effects.stokes_drag]
)";

const std::string grains = R"([reference]
length = 1e-3
[domain]
size = [9, 9, 9]
left = "periodic"
right = "periodic"
bottom = "periodic"
top = "periodic"
front = "periodic"
back = "periodic"
[[stage]]
duration = 2.0
[[stage]]
duration = 3.0
[[population]]
count = 4
[effects.viscoelastic_contact]
elastic = 100.0
dissipative = 1.0
[effects.coulomb]
strength = 0.25
)";

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  return text.replace(text.find(from), from.size(), to);
}

}  // namespace

TEST_CASE("old names of keys: scene of conductors gets the values, with warnings") {
  const Scene scene = parse_scene(conductors, "old.toml");
  CHECK(scene.conductors.at(0).fixed);
  CHECK(scene.effects.has("current_injection"));
  CHECK(scene.effects.find<effects::ContactDischargeOptions>()->contact_distance == 0.25e-3);
  REQUIRE(scene.warnings.size() == 3);
  CHECK(std::ranges::count(scene.warnings,
                           "old.toml:10: conductor.held is an old name: it is called conductor.fixed now") == 1);
}

TEST_CASE("old names of keys: scene of grains gets the values, one warning each") {
  const Scene scene = parse_scene(grains, "old.toml");
  REQUIRE(scene.reference);
  CHECK(scene.reference->length == 1e-3);
  CHECK(scene.stages.size() == 2);
  CHECK(scene.effects.find<effects::CoulombOptions>()->strength == 0.25);
  CHECK(scene.warnings.size() == 5);  // reference, stage, elastic, dissipative, strength
}

TEST_CASE("old name of a key in several tables: gives one warning") {
  const std::string two =
      "[[conductor]]\nposition = [9e-3, 4e-3]\nradius = 1e-3\nheld = true\n[effects.floating_conductors]";
  const Scene scene = parse_scene(replaced(conductors, "[effects.floating_conductors]", two), "old.toml");
  CHECK(scene.conductors.at(1).fixed);
  CHECK(scene.warnings.size() == 3);
}

TEST_CASE("old names of keys: the complete list for results of earlier versions") {
  const std::map<std::string, std::string> expected = {{"reference", "units"},
                                                       {"stage", "equilibration"},
                                                       {"effects.contact_potential", "effects.soft_repulsion"},
                                                       {"effects.current_source", "effects.current_injection"},
                                                       {"conductor.held", "fixed"},
                                                       {"domain.open", "unbounded"},
                                                       {"effects.charge_exchange.strength", "transfer_prefactor"},
                                                       {"effects.contact_discharge.gap", "contact_distance"},
                                                       {"effects.contact_resistance.spot", "contact_radius"},
                                                       {"effects.coulomb.strength", "coupling_constant"},
                                                       {"effects.gas_drag.hold", "correlation_time"},
                                                       {"effects.viscoelastic_contact.dissipative", "damping"},
                                                       {"effects.viscoelastic_contact.elastic", "stiffness"},
                                                       {"field.links", "boundary_stencil"},
                                                       {"mechanics.contact_steps", "contact_substeps"},
                                                       {"mechanics.keep_height", "fix_z"},
                                                       {"network.between", "terminals"},
                                                       {"network.spot", "contact_radius"}};
  std::map<std::string, std::string> found;
  const Schema schema(effects::all_kinds());
  for (const Table& table : schema.tables()) {
    if (!table.old_path.empty()) found[table.old_path] = table.path;
    for (const Key& key : table.keys)
      if (!key.old_name.empty()) found[path_in(table, key.old_name)] = key.name;
  }
  CHECK(found == expected);
}

TEST_CASE("new names of keys: give no warning") {
  std::string text = replaced(conductors, "held", "fixed");
  text = replaced(replaced(text, "current_source", "current_injection"), "gap =", "contact_distance =");
  CHECK(parse_scene(text, "new.toml").warnings.empty());
}

TEST_CASE("key or table under both its old and its new name: refused") {
  const std::string key = replaced(conductors, "gap =", "contact_distance = 1e-3\ngap =");
  CHECK_THROWS_WITH_AS(parse_scene(key, "old.toml"),
                       "old.toml:16: effects.contact_discharge.gap is an old name of "
                       "effects.contact_discharge.contact_distance, which is given too: leave one out",
                       InputError);
  const std::string table = conductors + "[effects.current_injection]\ncurrent = 1e-9\n";
  CHECK_THROWS_WITH_AS(parse_scene(table, "old.toml"), doctest::Contains("effects.current_source is an old name"),
                       InputError);
}

TEST_CASE("old names of keys: allowed in settings of the command line") {
  const std::string text = replaced(conductors, "held = true\n", "");
  for (const std::string key : {"conductor[0].held", "conductor[0].fixed"})
    CHECK(parse_scene(with_settings(text, "old.toml", {{key, "true"}}), "old.toml").conductors.at(0).fixed);
  const std::string gas =
      with_settings(grains, "old.toml", {{"reference.length", "2e-3"}, {"stage[1].duration", "5.0"}});
  CHECK(parse_scene(gas, "old.toml").reference->length == 2e-3);
  CHECK(parse_scene(gas, "old.toml").stages[1].duration == 5);
}

TEST_CASE("settings of one key under both its names: refused") {
  const std::vector<Setting> both = {{"conductor[0].held", "true"}, {"conductor[0].fixed", "false"}};
  CHECK_THROWS_WITH_AS(with_settings(conductors, "old.toml", both),
                       "conductor[0].held and conductor[0].fixed are names of one key: give one of them", InputError);
}

TEST_CASE("help scene: an old name shows the present table or key") {
  CHECK(scene_help("stage") == scene_help("equilibration"));
  CHECK(scene_help("conductor.held") == scene_help("conductor.fixed"));
}

TEST_CASE("user-defined effect: may have the old name of another effect") {
  struct Options {
    double current = 0;
  };
  static const EffectKind own = {.name = "current_source",
                                 .options = Options{},
                                 .keys = {{.name = "current", .target = target<&Options::current>}}};
  EffectKinds kinds = effects::all_kinds();
  kinds.push_back(&own);
  const Scene scene = parse_scene(replaced(conductors, "held = true\n", ""), "added.toml", kinds);
  CHECK(scene.effects.has("current_source"));
  CHECK_FALSE(scene.effects.has("current_injection"));
}

TEST_CASE("old names of keys: none is the present name of another key or table") {
  const Schema schema(effects::all_kinds());
  for (const Table& table : schema.tables()) {
    if (!table.old_path.empty()) CHECK(schema.find_table(table.old_path) == nullptr);
    for (const Key& key : table.keys)
      if (!key.old_name.empty()) CHECK(find_key(table, key.old_name) == nullptr);
  }
}

}  // namespace scene_old_names_test
