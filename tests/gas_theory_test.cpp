// Tests of `lichtenberg theory`: printed and written results, and refused requests.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "src/record/hdf5.hpp"
#include "src/theory/haff.hpp"
#include "src/theory/restitution.hpp"
#include "tests/gas_text.hpp"
#include "tests/near.hpp"
#include "tests/program.hpp"

namespace gas_theory_test {

using namespace lichtenberg;
using nlohmann::json;

namespace {

std::string scene() {
  const std::string stage = "[[equilibration]]\nduration = 0.5\ntemperature = 2\n", sum = "sum = \"minimum-image\"";
  return replaced(replaced(gas_text(60, 6, 1.5, 0.25, stage), sum, "coupling_constant = 3\n" + sum), "[output]",
                  "[output]\npicture = false");
}

/// Copies the scene gas.toml and its result gas.h5, which is computed once for all tests.
void copy_result(const Folder& folder) {
  static const Folder made;
  if (!std::filesystem::exists(made / "gas.h5")) {
    made.write("gas.toml", scene());
    REQUIRE(run_program(made, "run gas.toml --quiet").status == 0);
  }
  for (const char* name : {"gas.toml", "gas.h5"}) std::filesystem::copy_file(made / name, folder / name);
}

json read_json(const Folder& folder, const std::string& name) { return json::parse(text_of(folder / name)); }

double figure(const json& answer, const std::string& name) {
  for (const json& f : answer["figures"])
    if (f["name"] == name) return f["value"];
  return NAN;
}

}  // namespace

TEST_CASE("theory haff --scene: prints a table, writes JSON, CSV and a picture") {
  const Folder folder;
  folder.write("gas.toml", scene());
  const Ended haff = run_program(folder, "theory haff --scene gas.toml --json haff.json --csv haff.csv --plot");
  REQUIRE_MESSAGE(haff.status == 0, haff.err);
  CHECK(contains(haff.out, "collision_frequency"));
  CHECK(contains(haff.out, "gas-haff.png shows it"));
  CHECK(std::filesystem::file_size(folder / "gas-haff.png") > 10'000);

  const json answer = read_json(folder, "haff.json");
  const double density = 60 / 216.0;
  CHECK(answer["of"] == "gas.toml");
  CHECK(figure(answer, "temperature") == 2);
  CHECK(figure(answer, "collision_frequency") == near(theory::collision_frequency(density, 2), 1e-12));
  const json& columns = answer["tables"][0]["columns"];
  CHECK(columns["time"]["values"].back() == 1);  // The time after a stage of 0.5.
  CHECK(columns["temperature"]["unit"] == "m0 v0^2");
  const theory::ViscoelasticPair pair{278.6, 27.7};
  const theory::Impacts impacts{[&](double v) { return theory::collision(pair, v).restitution; }};
  CHECK(columns["temperature"]["values"].back() ==
        near(theory::cool(density, impacts, 2, std::vector{1.0})[0].temperature, 1e-8));
  CHECK(text_of(folder / "haff.csv").starts_with("time (t0),temperature (m0 v0^2),"));
}

TEST_CASE("theory of a result: uses its scene and compares with measured values") {
  const Folder folder;
  copy_result(folder);
  const Ended kinetic = run_program(folder, "theory kinetic gas.h5 --json kinetic.json");
  REQUIRE_MESSAGE(kinetic.status == 0, kinetic.err);
  CHECK(contains(kinetic.out, "run: grains\n          time         found               temperature     ratio\n"));
  const json answer = read_json(folder, "kinetic.json");
  CHECK(figure(answer, "coupling") == near(3 * 4.5e-3 * 4.5e-3, 1e-12));
  const json& found = answer["tables"][0]["found"];
  REQUIRE(found.size() == 2);
  CHECK(found[0]["of"] == "temperature");
  CHECK(found[0]["x"].back() == near(1, 1e-12));
  for (const json& t : found[0]["x"]) CHECK(t.get<double>() > 0);
  CHECK(found[0]["x"].size() == found[0]["y"].size());
  CHECK(run_program(folder, "theory smoluchowski gas.h5").status == 0);
  REQUIRE(run_program(folder, "analyse gas.h5").status == 0);
  REQUIRE(run_program(folder, "theory kinetic gas.h5 --json analysed.json").status == 0);
  const json analysed = read_json(folder, "analysed.json")["tables"][0]["found"];
  REQUIRE(analysed.size() == 6);
  CHECK(analysed[4]["of"] == "density");
  CHECK(analysed[4]["y"][0] <= 60 / 216.0);
}

TEST_CASE("theory all: has Smoluchowski's cluster numbers and measured series") {
  const Folder folder;
  copy_result(folder);
  REQUIRE(run_program(folder, "analyse gas.h5").status == 0);
  REQUIRE(run_program(folder, "theory smoluchowski gas.h5 --json s.json").status == 0);
  const json paced = read_json(folder, "s.json")["tables"][1];
  REQUIRE(run_program(folder, "theory all gas.h5 --json all.json --plot").status == 0);
  CHECK(std::filesystem::file_size(folder / "gas-all.png") > 10'000);
  const json all = read_json(folder, "all.json")["tables"][0];
  const json &numbers = paced["columns"]["paced_number_neutral"]["values"], &same = all["columns"]["number"]["values"];
  REQUIRE(numbers.size() == same.size());
  CHECK(numbers == all["columns"]["number_smoluchowski"]["values"]);
  // While few clusters have merged, the numbers of the two theories agree to second order.
  const double merged = 1 - same.back().get<double>();
  CHECK(merged > 1e-6);
  CHECK(std::abs(numbers.back().get<double>() - same.back().get<double>()) < merged * merged + 1e-8);
  CHECK(all["columns"]["structure"]["values"][0] ==
        near(std::pow(1 - M_PI / 6 * 60 / 216, 4) / std::pow(1 + M_PI / 3 * 60 / 216, 2), 0.05));
  std::vector<std::string> found;
  for (const json& series : all["found"]) found.push_back(series["of"]);
  for (const char* name : {"temperature", "square_charge", "number", "size", "bjerrum", "structure"})
    CHECK_MESSAGE(std::ranges::find(found, name) != found.end(), name);

  // Another program may have written impossible values.
  const std::string none = "import h5py; h5py.File('gas.h5', 'r+')['analysis/bound_clusters'][...] = 0";
  REQUIRE(run_shell(folder, fmt::format("/usr/bin/python3 -c \"{}\"", none)).status == 0);
  const Ended damaged = run_program(folder, "theory all gas.h5");
  CHECK(damaged.status == 2);
  CHECK_MESSAGE(contains(damaged.err, "gas.h5 is damaged: it has frames without bound clusters"), damaged.err);
}

TEST_CASE("theory hydrodynamics: agrees with linear theory, states its grid error") {
  const Folder folder;
  const Ended flow = run_program(folder, "theory hydrodynamics --cells 16 --json h.json --field h.vtkhdf --plot");
  REQUIRE_MESSAGE(flow.status == 0, flow.err);
  CHECK(std::filesystem::file_size(folder / "theory-hydrodynamics.png") > 10'000);
  const json answer = read_json(folder, "h.json");
  // 70 d0, with l_0 = 0.12467 / n.
  CHECK(figure(answer, "length") == near(70 / (0.12467 * 343000 / 50016), 1e-4));
  CHECK(figure(answer, "end") == near(1.19e12, 1e-9));
  const json& columns = answer["tables"][0]["columns"];
  for (const json& least : columns["coldest"]["values"]) CHECK(least.get<double>() > 0);
  for (const json& least : columns["thinnest"]["values"]) CHECK(least.get<double>() > 0);
  // While the longest shear waves are small, here 0.01 to 0.03, they grow at zeta*/4 - eta* k^2. Linear theory neglects
  // their squares, 1e-3. A step's tolerance of 1e-5 is 1e-3 of them, and (kh)^4/90 for 16 cells per wave is smaller.
  const json &found = columns["shear_1"]["values"], &linear = columns["linear_shear_1"]["values"];
  CHECK(found[3].get<double>() > 2 * found[0].get<double>());
  CHECK(found[3].get<double>() == near(linear[3], 0.02));
  REQUIRE(answer["maps"].size() == 3);
  CHECK(answer["maps"][0]["title"].get<std::string>().starts_with("t/t_0 = 348,"));  // G A5.3
  CHECK(answer["maps"][2]["fields"][0]["values"].size() == 256);

  const hdf5::Handle file = hdf5::load(folder / "h.vtkhdf");
  const hdf5::Handle points = hdf5::open_group(file, "VTKHDF/PointData");
  CHECK(hdf5::shape(points, "velocity") == hdf5::Shape{2, 16, 16, 3});
  const std::vector<double> density = hdf5::get<double>(points, "density");
  double mass = 0;
  for (const double n : density) mass += n / 512;
  CHECK(mass == near(1, 1e-12));

  // The answer states the change of results at half the cells.
  REQUIRE(run_program(folder, "theory hydrodynamics --cells 8 --json 8.json").status == 0);
  const json coarse = read_json(folder, "8.json");
  for (const std::string name : {"temperature", "densest"}) {
    const json &before = coarse["tables"][0]["columns"][name]["values"], &after = columns[name]["values"];
    REQUIRE(before.size() == after.size());
    double most = 0;
    for (std::size_t k = 0; k < after.size(); ++k)
      most = std::max(most, std::abs(before[k].get<double>() / after[k].get<double>() - 1));
    CHECK(most > 1e-3);
    CHECK(figure(answer, "grid_change_" + name) == near(most, 1e-6));
  }
}

TEST_CASE("theory hydrodynamics: reproducible for a seed" * doctest::test_suite("long")) {
  const Folder folder;
  const auto tables = [&](const std::string& options) {
    REQUIRE(run_program(folder, "theory hydrodynamics --cells 8 --overwrite --json h.json" + options).status == 0);
    return read_json(folder, "h.json")["tables"];
  };
  const json first = tables("");
  CHECK(tables("") == first);
  CHECK(tables(" --seed 2") != first);
}

TEST_CASE("theory hydrodynamics --space: three dimensions, charge number 0") {
  const Folder folder;
  folder.write("gas.toml",
               replaced(replaced(scene(), "count = 60", "count = 2000"), "size = [6, 6, 6]", "size = [20, 20, 20]"));
  const Ended flow = run_program(folder, "theory hydrodynamics --scene gas.toml --space --cells 8 --json h.json");
  REQUIRE_MESSAGE(flow.status == 0, flow.err);
  const json answer = read_json(folder, "h.json");
  CHECK(figure(answer, "charge_number") == 0);  // Grains that exchange charge have a mean charge of zero.
  CHECK(figure(answer, "length") == near(20 / (0.12467 / 0.25), 1e-4));
  CHECK(answer["maps"][0]["fields"][0]["values"].size() == 64);
}

TEST_CASE("theory stability: default parameters are published, can be changed") {
  const Folder folder;
  REQUIRE(run_program(folder, "theory stability --json stability.json").status == 0);
  const json stability = read_json(folder, "stability.json");
  CHECK(figure(stability, "eta") == near(1.147863019, 1e-9));
  CHECK(figure(stability, "charge_number") == 0.9);
  REQUIRE(run_program(folder, "theory stability --restitution 0.5 --charge-number 0 --json s.json").status == 0);
  CHECK(figure(read_json(folder, "s.json"), "charge_number") == 0);
  CHECK(contains(run_program(folder, "theory monopolar").out, "barrier"));
  CHECK(contains(run_program(folder, "theory restitution").out, "0.330835"));
}

TEST_CASE("theory monopolar: fits the barrier to a run if it is measurable") {
  const Folder folder;
  const std::string repelling =
      replaced(replaced(replaced(replaced(scene(), "[effects.charge_exchange]\n", ""), "[effects.viscoelastic_contact]",
                                 "[effects.linear_contact]\nstiffness = 1000\nrestitution = 0.8"),
                        "temperature = 1\n", "temperature = 1\ncharge = 1\n"),
               "[[equilibration]]\nduration = 0.5\ntemperature = 2\n", "") +
      "[mechanics]\nstep = 0.02\n";
  folder.write("strong.toml", replaced(replaced(repelling, "coupling_constant = 3", "coupling_constant = 0.5"),
                                       "time = 1.5", "time = 40"));
  folder.write("weak.toml", replaced(repelling, "coupling_constant = 3", "coupling_constant = 1e-4"));
  for (const std::string name : {"strong", "weak"}) {
    const Ended run = run_program(folder, "run " + name + ".toml --quiet");
    REQUIRE_MESSAGE(run.status == 0, run.err);
    const Ended ended = run_program(folder, "theory monopolar " + name + ".h5 --json " + name + ".json");
    REQUIRE_MESSAGE(ended.status == 0, ended.err);
    CHECK(contains(ended.out, "none from 1e-4 U to 10 U fits") == (name == "weak"));
  }
  const json strong = read_json(folder, "strong.json"), weak = read_json(folder, "weak.json");
  // Neighbours on all sides repel as well: U is below that of a pair (Scheffler and Wolf 2002).
  CHECK(figure(strong, "fitted_barrier") > 0.05 * 0.5);
  CHECK(figure(strong, "fitted_barrier") < 0.5);
  const auto fitted = [](const json& answer) { return answer["tables"][0]["columns"].contains("temperature_fitted"); };
  CHECK(fitted(strong));
  CHECK_FALSE(fitted(weak));  // Without a barrier there is no fitted curve.
  for (const json& f : weak["figures"])
    if (f["name"] == "fitted_barrier") CHECK(f["value"].is_null());
}

TEST_CASE("theory --set: refused without --scene") {
  const Folder folder;
  folder.write("gas.toml", scene());
  for (const auto& [command, sentence] : std::vector<std::pair<std::string, std::string>>{
           {"theory haff --set nonsense.key=5",
            "--set changes a key of the scene that --scene names: it needs --scene"},
           {"theory haff gas.h5 --set stop.time=5", "it needs --scene"},
           {"theory haff --scene gas.toml --set nonsense.key=5", "nonsense.key is no key of a scene"}}) {
    const Ended ended = run_program(folder, command);
    INFO(ended.err);
    CHECK(ended.status == 2);
    CHECK(contains(ended.err, sentence));
  }
}

TEST_CASE("theory and analyse: inputs, results and links are not overwritten") {
  const Folder folder;
  copy_result(folder);
  const std::string before = text_of(folder / "gas.h5"), text = text_of(folder / "gas.toml");
  std::filesystem::create_symlink("elsewhere.csv", folder / "link.csv");
  folder.write("mine.csv", "mine");
  folder.write("theory-stability.png", "mine");
  for (const auto& [command, sentence] : std::vector<std::pair<std::string, std::string>>{
           {"theory haff gas.h5 --csv gas.h5", "is an input file"},
           {"theory haff gas.h5 --json=./gas.h5", "is an input file"},
           {"theory haff --scene gas.toml --csv gas.toml", "is an input file"},
           {"analyse gas.h5 --csv gas.h5", "is an input file"},
           {"theory haff --csv gas.h5", "is an HDF5 file, as results are"},
           {"theory haff --csv link.csv", "is no plain file"},
           {"theory haff --csv link.csv --overwrite", "is no plain file"},
           {"theory haff --csv mine.csv", "mine.csv exists: name another file, or give --overwrite"},
           {"analyse gas.h5 --csv mine.csv", "mine.csv exists"},
           {"theory stability --plot", "theory-stability.png exists"},
           {"theory haff --csv x --json=x", "cannot be written twice"},
           {"theory haff --out mine.csv", "must end in .png"}}) {
    const Ended ended = run_program(folder, command);
    CHECK_MESSAGE(ended.status == 2, command);
    CHECK_MESSAGE(contains(ended.err, sentence), command << ": " << ended.err);
  }
  CHECK(text_of(folder / "mine.csv") == "mine");
  CHECK(text_of(folder / "gas.h5") == before);
  for (const std::string command : {"theory haff --csv mine.csv", "analyse gas.h5 --csv mine.csv"})
    CHECK(run_program(folder, command + " --overwrite").status == 0);
  CHECK(text_of(folder / "gas.toml") == text);
}

TEST_CASE("theory: parameters out of range and unsuitable scenes are refused") {
  const Folder folder;
  folder.write("gas.toml", scene());
  const auto refused = [&](const std::string& arguments, const std::string& sentence) {
    const Ended ended = run_program(folder, "theory " + arguments);
    CHECK(ended.status == 2);
    CHECK_MESSAGE(contains(ended.err, sentence), ended.err);
  };
  refused("half", "not in");
  refused("monopolar --scene gas.toml", "theory monopolar is for a constant restitution");
  refused("haff --scene none.toml", "none.toml");
  refused("haff gas.h5 --scene gas.toml", "excludes");
  refused("haff --restitution 0.5",
          "--restitution is for theory stability and theory hydrodynamics, not for theory haff");
  refused("stability --cells 8", "--cells is for theory hydrodynamics, not for theory stability");
  refused("hydrodynamics --restitution 1", "of a restitution coefficient in (0, 1), not of 1");
  refused("hydrodynamics --charge-number 101",
          "theory hydrodynamics is for a charge number R in [0, 100], not for 101");
  refused("hydrodynamics --cells 7", "--cells is for 8 to 1024 cells along an edge, not for 7");
  refused("hydrodynamics --seed -1", "--seed -1 is not allowed: it must be 0 or more");
  refused("hydrodynamics --scene gas.toml",
          "the thermal noise of 60 grains makes the density or temperature of a cell");
  folder.write("narrow.toml", replaced(scene(), "count = 60", "count = 20"));
  refused("hydrodynamics --scene narrow.toml", "for boxes of 10 l_0 and more");
  refused("stability --restitution 1.5", "a restitution coefficient in (0, 1], not for 1.5");
  refused("stability --charge-number -1", "theory stability is for a charge number R in [0, 1e6), not for -1");
  refused("haff --json none/x.json", "none/x.json");
  refused("hydrodynamics --field gas.toml --scene gas.toml", "is an input file");
  folder.write("neutral.toml", replaced(scene(), "[effects.charge_exchange]", ""));
  for (const std::string theory : {"kinetic", "all"})
    refused(theory + " --scene neutral.toml", "theory kinetic is for grains that charge each other and attract");
  folder.write("area.toml",
               replaced(scene(), "[effects.charge_exchange]", "[effects.charge_exchange]\nmodel = \"contact-area\""));
  refused("haff --scene area.toml", "once a collision and without a capacity");
  folder.write("large.toml", replaced(scene(), "count = 60", "count = 60\nradius = 0.4"));
  refused("haff --scene large.toml", "equal grains of diameter and mass 1");
  folder.write("cold.toml", replaced(replaced(scene(), "temperature = 1", "temperature = 0"), "temperature = 2", ""));
  refused("haff --scene cold.toml", "for grains that move, T > 0");
  for (const char* key :
       {"charge_exchange.exponent=10", "charge_exchange.transfer_prefactor=1e50", "coulomb.coupling_constant=1e90"}) {
    const Ended ended = run_program(folder, fmt::format("theory kinetic --scene gas.toml --set effects.{}", key));
    CHECK(ended.status == 1);
    CHECK_MESSAGE(contains(ended.err, "kinetic theory has no course of a gas that charges so fast"), ended.err);
  }
  const std::string contact = "--set effects.viscoelastic_contact.";
  const std::string barely = contact + "damping=1e-50 " + contact + "elastic=1e100";
  CHECK(contains(run_program(folder, "theory restitution --scene gas.toml " + barely).out, "negative at no speed"));
  folder.write("early.toml", replaced(scene(), "time = 1.5", "time = 0.5"));
  refused("haff --scene early.toml", "the run ends before its warm-up");
}

}  // namespace gas_theory_test
