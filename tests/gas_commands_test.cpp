// Tests of the built program on scenes of grains: run, analyse, plot and refused requests.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "solvers/geometry/box.hpp"
#include "src/record/hdf5.hpp"
#include "src/record/result_file.hpp"
#include "tests/gas_text.hpp"
#include "tests/program.hpp"

namespace gas_commands_test {

using namespace lichtenberg;
using doctest::Approx;
using nlohmann::json;

namespace {

const std::string scene = gas_text(60, 6, 1, 0.25);

/// Modifies a result, opened as `f`, outside the program.
void damage_by(const Folder& folder, const std::string& file, const std::string& lines) {
  const std::string script = fmt::format("import h5py; f = h5py.File('{}', 'r+'); {}", file, lines);
  REQUIRE(run_shell(folder, fmt::format("/usr/bin/python3 -c \"{}\"", script)).status == 0);
}

/// Replaces a list of numbers by a text.
void damage(const Folder& folder, const std::string& file, const std::string& dataset) {
  damage_by(folder, file, fmt::format("del f['{0}']; f['{0}'] = 'none'", dataset));
}

/// Checks that each missing number of a frame, in lists as well, has a reason.
void check_reasons(const json& found) {
  for (const json& frame : found["frames"])
    for (const auto& [name, value] : frame.items()) {
      const bool missing = value.is_null() || (value.is_array() && std::ranges::count(value, json()) > 0);
      if (missing) CHECK_MESSAGE(found["null"].contains(name), name);
    }
}

}  // namespace

TEST_CASE("gas: run, analyse and plot succeed and their numbers agree") {
  const Folder folder;
  folder.write("gas.toml", scene);
  const Ended run = run_program(folder, "run gas.toml");
  REQUIRE_MESSAGE(run.status == 0, run.err);
  CHECK(contains(run.out, "temperature"));
  CHECK(contains(run.out, "gas.png (grains), gas-series.png (over time)"));
  CHECK(std::filesystem::file_size(folder / "gas.png") > 10'000);
  CHECK(std::filesystem::file_size(folder / "gas-series.png") > 10'000);

  const Ended analysed = run_program(folder, "analyse gas.h5 --json --csv gas.csv");
  REQUIRE_MESSAGE(analysed.status == 0, analysed.err);
  const json found = json::parse(analysed.out);
  check_reasons(found);
  CHECK(found["grains"] == 60);
  CHECK(found["units"]["local_temperature"] == "m0 v0^2");
  REQUIRE(found["frames"].size() == 5);
  const json& last = found["frames"][4];
  CHECK(last["total_charge"] == 0);
  CHECK(last["clusters"].get<int>() <= 60);
  double integral = 0;
  for (const double density : last["speed_density"]) integral += density * 5 / 50;
  CHECK(integral == Approx(1).epsilon(1e-12));  // No grain is five times as fast as the rms.
  CHECK(found["frames"][0]["contact_persistence"].is_null());
  CHECK(contains(found["null"]["contact_persistence"].get<std::string>(), "the first frame"));
  CHECK(found["frames"][0]["mean_square_displacement"] == 0);
  CHECK(last["mean_square_displacement"] > 0.1);  // Ballistic motion: t^2 <v^2>.
  CHECK(last["density_structure"].size() == 6);
  CHECK(last["shape_grains"].size() >= 1);
  CHECK(last["shape_grains"].size() == last["shape_gyration"].size());
  CHECK(last["charge_by_speed"].size() == 20);
  // The energies equal the history's at the same instant.
  CHECK(last["kinetic_energy"] == found["notes"]["kinetic_energy"].back());
  CHECK(last["dissipated_energy"].get<double>() > found["frames"][3]["dissipated_energy"].get<double>());
  CHECK(last["kinetic_energy"].get<double>() == Approx(1.5 * 60 * last["temperature"].get<double>()).epsilon(1e-12));
  // Quantities that the scene does not have are left out with a reason.
  CHECK_FALSE(last.contains("induced_dipole"));
  CHECK(contains(found["null"]["induced_dipole"].get<std::string>(), "without [effects.induced_dipoles]"));
  CHECK(last["charge_dipole"][0].is_null());  // There is no cluster without grains.
  CHECK(found["frames"][0]["aggregate_local_slope"].is_null());
  CHECK(contains(found["growth"]["dense_cells"]["missing"].get<std::string>(), "fewer than five frames"));
  const std::string csv = text_of(folder / "gas.csv");
  CHECK(csv.starts_with("time (t0),temperature (m0 v0^2),"));
  CHECK(std::ranges::count(csv, '\n') == 6);

  // The history has the same values, computed from momenta instead of velocities: equal to rounding.
  const ResultFile file((folder / "gas.h5").string(), "read");
  for (const char* name : {"local_temperature", "temperature", "mean_square_charge", "mean_charge_magnitude"}) {
    const double noted = hdf5::get<double>(file.file(), std::string("gas/") + name).back();
    CHECK(last[name].get<double>() == Approx(noted).epsilon(1e-12).scale(0));
    CHECK(hdf5::get<double>(file.file(), std::string("analysis/") + name).back() == last[name].get<double>());
  }
  CHECK(contains(run_program(folder, "analyse gas.h5 --frame 2").out, "frame 2 at t = 0.5 t0"));
  CHECK(run_program(folder, "plot gas.h5 --frame 1").out == "gas-frame-1-charge.png shows frame 1 by charge\n");
  CHECK(run_program(folder, "plot gas.h5 --series --out curves.svg").status == 0);
  CHECK(contains(text_of(folder / "curves.svg"), "relative to it"));  // There are too few grains for the theory.
}

TEST_CASE("gas without charges: analyse leaves charge quantities out with a reason") {
  const Folder folder;
  std::string neutral = scene;
  for (const char* table : {"[effects.charge_exchange]\n", "[effects.coulomb]\n", "sum = \"minimum-image\"\n"})
    neutral = replaced(neutral, table, "");
  folder.write("gas.toml", replaced(neutral, "[output]", "[output]\npicture = false"));
  REQUIRE(run_program(folder, "run gas.toml --quiet").status == 0);
  const Ended analysed = run_program(folder, "analyse gas.h5 --json");
  REQUIRE_MESSAGE(analysed.status == 0, analysed.err);
  const json found = json::parse(analysed.out), last = found["frames"].back();
  check_reasons(found);
  CHECK(last["charge_speed_correlation"].is_null());
  CHECK(last["charge_kurtosis"].is_null());
  for (const char* name : {"charge_density", "charge_dipole", "charge_structure", "charge_by_speed"}) {
    CHECK_FALSE(last.contains(name));
    CHECK(found["null"][name] == "no grain is charged");
  }
  CHECK_FALSE(last.contains("bound_clusters"));
  CHECK(found["null"]["bound_clusters"] == "no forces between charges");
}

// The domain is smaller than the path of the grains, which leave it.
TEST_CASE("gas without sides: run, plot, analyse and view contain all grains") {
  const Folder folder;
  std::string cloud = replaced(scene, "sum = \"minimum-image\"\n", "");
  for (const std::string_view side : side_names) cloud = replaced(cloud, fmt::format("{} = \"periodic\"\n", side), "");
  folder.write("gas.toml", replaced(cloud, "[domain]", "[domain]\nunbounded = true"));
  const Ended run = run_program(folder, "run gas.toml");
  REQUIRE_MESSAGE(run.status == 0, run.err);
  const Ended analysed = run_program(folder, "analyse gas.h5 --json");
  REQUIRE_MESSAGE(analysed.status == 0, analysed.err);
  const json found = json::parse(analysed.out);
  check_reasons(found);
  CHECK(found["null"]["density_structure"] == "a side is not periodic");
  CHECK(run_program(folder, "view gas.h5").status == 0);
  const std::string script =
      "import h5py; p = h5py.File('gas.h5')['particles/conductors/position/value'][-1]; print((p < 0).any())";
  CHECK(contains(run_shell(folder, fmt::format("/usr/bin/python3 -c \"{}\"", script)).out, "True"));
}

TEST_CASE("analyse: a cluster's induced dipole is the sum over its grains") {
  const Folder folder;
  folder.write("gas.toml", replaced(scene, "[output]", "[output]\npicture = false") +
                               "[effects.induced_dipoles]\npolarizability = 0.01\n");
  REQUIRE(run_program(folder, "run gas.toml --quiet").status == 0);
  const Ended analysed = run_program(folder, "analyse gas.h5 --json");
  REQUIRE_MESSAGE(analysed.status == 0, analysed.err);
  const json found = json::parse(analysed.out), last = found["frames"].back();

  const ResultFile file((folder / "gas.h5").string(), "read");
  const std::string grains = "particles/conductors/";
  const auto dipole = hdf5::get<double>(file.file(), grains + "dipole/value");
  const auto cluster = hdf5::get<std::int64_t>(file.file(), grains + "cluster/value");
  std::map<std::int64_t, std::array<double, 4>> sums;  // Number of grains and dipole of each cluster in the last frame.
  for (int i = 0; i < 60; ++i) {
    auto& sum = sums[cluster[cluster.size() - 60 + i]];
    ++sum[0];
    for (int k = 0; k < 3; ++k) sum[1 + k] += dipole[dipole.size() - 180 + 3 * i + k];
  }
  double expected = 0, number = 0;
  for (const auto& [name, sum] : sums)
    if (sum[0] == 2) expected += std::hypot(sum[1], sum[2], sum[3]), ++number;
  REQUIRE(number > 0);
  CHECK(last["induced_dipole"][2].get<double>() == Approx(expected / number).epsilon(1e-12).scale(0));
}

TEST_CASE("ensemble of gases: means equal those of the summaries in the results") {
  const Folder folder;
  folder.write("gas.toml", replaced(scene, "[output]", "[output]\npicture = false"));
  const Ended ended = run_program(folder, "ensemble gas.toml --seeds 3 --out gases --quiet");
  REQUIRE_MESSAGE(ended.status == 0, ended.err);
  for (const char* heading : {"T with flow", "<q^2>", "largest", "dissipated", "collisions", "time (t0)"})
    CHECK_MESSAGE(contains(ended.out, heading), ended.out);
  const json found = json::parse(text_of(folder / "gases" / "ensemble.json"));
  const json& point = found["points"][0]["quantities"];
  for (const char* name :
       {"temperature", "mean_square_charge", "clusters", "largest_cluster", "dissipated_energy", "collisions"}) {
    double sum = 0;
    for (const int seed : {1, 2, 3}) {
      const ResultFile file((folder / fmt::format("gases/seed-{}.h5", seed)).string(), "read");
      sum += hdf5::get<double>(file.file(), std::string("summary/") + name).back();
    }
    CHECK(point[name]["value"].get<double>() == Approx(sum / 3).epsilon(1e-14).scale(0));
    CHECK(point[name]["half_width"].get<double>() > 0);
  }
}

// The estimate neglects accelerations and the higher temperature of charged gases, whose <q^2> in theory is one third
// too low: 10 % of the steps each. Without growing charges and the bound-pair frequency the estimate would have one
// third fewer steps than the run.
TEST_CASE("explain: predicted steps of a charging gas are right within 25 %") {
  const Folder folder;
  const std::string charges = replaced(gas_text(200, 12, 30, 30), "sum = \"minimum-image\"", "accuracy = 1e-2");
  folder.write("gas.toml",
               replaced(charges, "[effects.charge_exchange]", "[effects.charge_exchange]\ntransfer_prefactor = 0.12"));
  /// Returns the number after the given words and the number after the next comma; 0 if absent.
  const auto numbers_after = [](const std::string& out, const std::string& words) {
    const std::size_t at = out.find(words);
    REQUIRE_MESSAGE(at != std::string::npos, out);
    const std::string rest = out.substr(at + words.size(), out.find('\n', at + words.size()) - at - words.size());
    const std::size_t comma = rest.find(',');
    return std::pair(std::stod(rest), comma == std::string::npos ? 0 : std::stod(rest.substr(comma + 1)));
  };
  const std::string explained = run_program(folder, "explain gas.toml").out,
                    run = run_program(folder, "run gas.toml --set output.picture=false").out;
  const auto [steps, contact_steps] = numbers_after(explained, "\n  steps ");
  const auto [steps_made, contact_steps_made] = numbers_after(run, "\nsteps ");
  CHECK(steps_made == Approx(steps).epsilon(0.25));
  CHECK(contact_steps_made == Approx(contact_steps).epsilon(0.25));
  CHECK(numbers_after(run, "\ncharges' field computed ").first ==
        Approx(numbers_after(explained, " s of smooth forces, ").first).epsilon(0.25));
}

// Grains of half the radius have 1/8 of the mass. At the same temperature they are sqrt(8) times as fast and fly the
// allowed path per step in a shorter time.
TEST_CASE("explain: the shortest contact time follows size and speed of grains") {
  const Folder folder;
  folder.write("gas.toml", scene);
  const auto shortest = [&](const std::string& settings) {
    const std::string words = "the shortest lasts ", out = run_program(folder, "explain gas.toml" + settings).out;
    const std::size_t at = out.find(words);
    REQUIRE_MESSAGE(at != std::string::npos, out);
    return out.substr(at + words.size(), out.find(' ', at + words.size()) - at - words.size());
  };
  // At the same speed their contacts are half as long: Hertz's t_c ~ (m_eff / E*)^(2/5) R^(-1/5) ~ R.
  const auto number = [&](const std::string& settings) { return std::stod(shortest(settings)); };
  CHECK(number(" --set population.radius=0.25 --set population.temperature=0.125") ==
        Approx(0.5 * number("")).epsilon(0.01));
  CHECK_NE(shortest(" --set population.radius=0.25"), shortest(""));
}

TEST_CASE("explain: prints initial charges, steps and safe temperature of dipoles") {
  const Folder folder;
  folder.write("gas.toml",
               replaced(scene, "temperature = 1", "temperature = 1\ncharge = 2\ncharge_distribution = \"gaussian\"") +
                   "[effects.induced_dipoles]\npolarizability = 0.075\n");
  const Ended ended = run_program(folder, "explain gas.toml");
  REQUIRE_MESSAGE(ended.status == 0, ended.err);
  CHECK_MESSAGE(contains(ended.out, "charges              0 q0 in total, rms "), ended.out);
  CHECK_MESSAGE(contains(ended.out, "m0 v0 in total"), ended.out);
  CHECK_MESSAGE(contains(ended.out, "constant forces      for "), ended.out);
  // 60e6 bytes plus 1510 per grain.
  CHECK_MESSAGE(contains(ended.out, "memory               some 57 MiB\n"), ended.out);
  CHECK_MESSAGE(contains(ended.out, "multirate, steps chosen by the accuracy of forces\n"), ended.out);
  CHECK_MESSAGE(contains(ended.out, "the fastest grain flies 0.2 d0, an error equal to that of forces to 0.01\n"),
                ended.out);
  CHECK_MESSAGE(contains(ended.out, ": 16 steps, error of about 0.001 of a contact's energy, the minimum\n"),
                ended.out);
  const Ended given =
      run_program(folder, "explain gas.toml --set mechanics.step=0.001 --set mechanics.contact_substeps=40");
  CHECK_MESSAGE(
      contains(given.out, ": 40 steps, error of about 0.0002 of a contact's energy: mechanics.contact_substeps\n"),
      given.out);
  CHECK_MESSAGE(contains(given.out, "steps of at most 0.001 t0\n"), given.out);
  CHECK_MESSAGE(contains(given.out, " t0: mechanics.step\n"), given.out);
  // sqrt(4 * 0.4 * 278.6) 0.4687^(5/4) = 8.19; its square over 4 ln 60 is 4.1.
  CHECK_MESSAGE(contains(ended.out, "closer than 0.53 d0, which impacts at 8.19 v0"), ended.out);
  CHECK_MESSAGE(contains(ended.out, "safe below T = 4.1"), ended.out);
}

TEST_CASE("explain and run: report precision and poor parameters of Coulomb's sum") {
  const Folder folder;
  const auto said = [&](const std::string& command, const std::string& keys, const std::string& sentence) {
    folder.write("gas.toml",
                 replaced(replaced(scene, "sum = \"minimum-image\"", keys), "[output]", "[output]\npicture = false"));
    const Ended ended = run_program(folder, command + " gas.toml");
    CHECK_MESSAGE(ended.status == 0, ended.err);
    CHECK_MESSAGE(contains(ended.out + ended.err, sentence), ended.out << ended.err);
  };
  said("explain", "accuracy = 1e-7", "in double precision, as single is good for an accuracy of 6e-07 and more");
  said("explain", "accuracy = 1e-4", "in single precision");
  const std::string poor = "cutoff = 1.1\nalpha = 0.3\nmesh = 8\norder = 4";
  said("explain", poor, "with the given cutoff, mesh and order: at most 0.1 is allowed");
  said("run", poor, "lichtenberg: effects.coulomb: the estimated force error is ");
  // The error of a mesh follows from its spacing. More points would take gigabytes.
  said("explain", "cutoff = 2\nmesh = 256\norder = 4", "256 x 256 x 256 points");
}

TEST_CASE("gas of one grain, at rest or elastic: commands print no nan or inf") {
  const Folder folder;
  const std::string quiet = replaced(scene, "[output]", "[output]\npicture = false");
  const auto is_word = [](char c) { return std::isalnum(static_cast<unsigned char>(c)) || c == '_'; };
  const auto holds = [&](const std::string& text, const std::string& word) {
    for (std::size_t at = text.find(word); at != std::string::npos; at = text.find(word, at + 1))
      if ((at == 0 || !is_word(text[at - 1])) && !is_word(text[at + word.size()])) return true;
    return false;
  };
  const std::string elastic =
      replaced(quiet, "[effects.viscoelastic_contact]", "[effects.linear_contact]\nrestitution = 1");
  for (const std::string& gas :
       {replaced(quiet, "count = 60", "count = 1"), replaced(quiet, "temperature = 1", "temperature = 0"), elastic}) {
    folder.write("gas.toml", gas);
    for (const char* command :
         {"explain gas.toml", "run gas.toml --overwrite", "analyse gas.h5", "theory haff gas.h5"}) {
      const Ended ended = run_program(folder, command);
      CHECK(ended.status <= 2);
      CHECK_MESSAGE(!holds(ended.out + ended.err, "nan"), command << ended.out << ended.err);
      CHECK_MESSAGE(!holds(ended.out + ended.err, "inf"), command << ended.out << ended.err);
    }
  }
}

TEST_CASE("gas commands: impossible requests are refused with an error message") {
  const Folder folder;
  folder.write("gas.toml", replaced(scene, "[output]", "[output]\npicture = false"));
  REQUIRE(run_program(folder, "run gas.toml --quiet").status == 0);
  const auto refused = [&](const std::string& arguments, const std::string& sentence) {
    const Ended ended = run_program(folder, arguments);
    CHECK(ended.status == 2);
    CHECK_MESSAGE(contains(ended.err, sentence), ended.err);
  };
  refused("plot gas.h5 --frame 5", "frame 5 is not in gas.h5: it has frames 0 to 4");
  refused("analyse gas.h5 --frame -1", "--frame -1 is not in the result file gas.h5: it has frames 0 to 4");
  refused("network gas.h5", "has a periodic side");
  std::filesystem::create_directory(folder / "results");
  for (const char* command : {"analyse results", "theory haff results", "network results"})
    refused(command, "results is a folder: name a result file");
  refused("theory haff gas.h5 --plot --out haff.foo",
          "--out haff.foo: the picture's name must end in .png, .pdf or .svg");
  for (const char* series : {"time", "temperature"}) {
    std::filesystem::copy_file(folder / "gas.h5", folder / "damaged.h5",
                               std::filesystem::copy_options::overwrite_existing);
    damage(folder, "damaged.h5", std::string("gas/") + series);
    refused("theory haff damaged.h5", "damaged.h5 is damaged: ");
  }
  for (const auto& [lines, sentence] : std::vector<std::pair<std::string, std::string>>{
           {"f['network/contacts_of_all_frames'][0, 1] = -1", "touches the ground, which a gas does not have"},
           {"f['particles/conductors/velocity/value'][1, 5, 0] = 1e300", "velocity of frame 1 holds the number 1e+300"},
           {"f['particles/conductors/position/value'][1, 5, 0] = float('nan')",
            "position of frame 1 holds the number nan"}}) {
    std::filesystem::copy_file(folder / "gas.h5", folder / "damaged.h5",
                               std::filesystem::copy_options::overwrite_existing);
    damage_by(folder, "damaged.h5", lines);
    refused("analyse damaged.h5", sentence);
  }
  folder.write("one.toml", replaced(scene, "count = 60", "count = 1"));
  refused("work-precision one.toml", "one.toml: a single charge has no force");
  folder.write("poles.toml", scene + "[effects.induced_dipoles]\npolarizability = 0.05\ndegree = 2\n");
  refused("work-precision poles.toml", "effects.induced_dipoles.degree = 2 is not allowed in work-precision");
  refused("run one.toml --out ./one.toml --overwrite", "one.toml is an input file");
  refused("run gas.toml --from gas.h5 --out gas.h5 --overwrite", "gas.h5 is an input file");
  refused("work-precision one.toml --time --json=one.toml --overwrite", "one.toml is an input file");
  const Ended at_rest = run_program(folder, "work-precision one.toml --time --methods multirate");
  CHECK(at_rest.status == 0);
  CHECK_MESSAGE(!contains(at_rest.out, "nan"), at_rest.out);
  folder.write("large.toml", replaced(scene, "count = 60", "count = 1\nradius = 1.6"));
  refused("run large.toml",
          "large.toml:5: domain.size = 6 d0 along its shortest periodic side is not allowed with a grain of diameter "
          "3.2 d0");
  // With K q^2 = 4 a quarter of 2 pi sqrt(0.5 / (1.5 * 278.6^(2/3) 4^(1/3))) is 0.110.
  folder.write("held.toml", replaced(replaced(scene, "temperature = 1", "temperature = 1\ncharge = 2"), "[output]",
                                     "[mechanics]\nstep = 0.2\n[output]"));
  for (const std::string command : {"run", "explain"})
    refused(command + " held.toml", "mechanics.step = 0.2 is too long: forces that are constant over it would excite");
  CHECK(run_program(folder, "solve gas.toml").status == 0);
  const auto with_sum = [&](const std::string& keys) {
    folder.write("by-hand.toml", replaced(scene, "sum = \"minimum-image\"", keys));
  };
  with_sum("sum = \"minimum-image\"\norder = 6");
  refused("explain by-hand.toml",
          "effects.coulomb.order is not allowed with effects.coulomb.sum = \"minimum-image\": it is for \"mesh\"");
  with_sum("cutoff = 1.5\nmesh = 16\norder = 6\naccuracy = 1e-3");
  refused("explain by-hand.toml", "they leave nothing to choose");
  with_sum("cutoff = 1.5\nmesh = 14");
  refused("explain by-hand.toml",
          "[effects.coulomb] are not valid: no mesh of up to 1024 points along a side reaches an accuracy of 0.0001");
}

// 120 spheres in a cube of edge 5.2 have a volume fraction of 0.447, one third above the limit of random positions.
TEST_CASE("run --from: a gas too dense for random positions starts from a packing") {
  const Folder folder;
  const std::string body = "count = 120\nradius = 0.5\n";
  folder.write("packing.toml", "[domain]\nsize = [5.2, 5.2, 5.2]\n[[population]]\n" + body +
                                   "overlapping = true\n[effects.soft_repulsion]\n[output]\npicture = false\n");
  const auto write_gas = [&](const std::string& name, const std::string& edge, const std::string& population) {
    std::string sides;
    for (const char* side : {"left", "right", "bottom", "top", "front", "back"})
      sides += fmt::format("{} = \"periodic\"\n", side);
    folder.write(name, fmt::format("[units]\n[domain]\nsize = [{0}, {0}, {0}]\n{1}[[population]]\n{2}temperature = "
                                   "1\n[effects.linear_contact]\n[stop]\ntime = 0.1\n[output]\nevery = 0.1\npicture "
                                   "= false\n",
                                   edge, sides, population));
  };
  write_gas("gas.toml", "5.2", body);
  write_gas("narrow.toml", "4.3", body);
  write_gas("others.toml", "5.2", "count = 120\nradius = 0.4\n");
  const auto refused = [&](const std::string& command, const std::string& sentence) {
    const Ended ended = run_program(folder, command);
    CHECK(ended.status == 2);
    CHECK_MESSAGE(contains(ended.err, sentence), ended.err);
  };
  refused("run gas.toml", "population.count = 120 is impossible at this density");
  REQUIRE(run_program(folder, "run packing.toml").status == 0);
  const Ended ended = run_program(folder, "run gas.toml --from packing.h5 --out gas.h5");
  REQUIRE_MESSAGE(ended.status == 0, ended.err);
  const auto positions_in = [&](const std::string& file) {
    return hdf5::get<double>(hdf5::load(folder / file), "particles/conductors/position/value");
  };
  const std::vector<double> packed = positions_in("packing.h5"), gas = positions_in("gas.h5");
  CHECK(std::equal(packed.end() - 360, packed.end(), gas.begin()));
  for (const char* command : {"analyse gas.h5", "run gas.toml --from packing.h5 --out gas.h5 --resume",
                              "run gas.toml --from gas.h5 --out again.h5"}) {
    const Ended again = run_program(folder, command);
    CHECK_MESSAGE(again.status == 0, again.err);
  }
  refused("run gas.toml --from gas.h5 --out x.h5 --set units.length=1e-3 --set units.mass=1e3",
          "units.length is 0.00478 there and 0.001 here, units.mass is 0.000152 there and 1000 here");
  refused("run narrow.toml --from packing.h5 --out x.h5", "overlap by more than a radius in this domain");
  refused("run others.toml --from packing.h5 --out x.h5", "body 0 has a radius of 0.5");
}

// The scene's speed, 0.05 m/s or 0.06 m/s, is the unit of velocity.
TEST_CASE("scene in SI: resumes to the same result, starts only from the same units") {
  const Folder folder;
  const auto write = [&](const std::string& name, double speed) {
    folder.write(name,
                 fmt::format("[domain]\nsize = [1e-3, 1e-3, 1e-3]\nunbounded = true\n[material]\ndensity = 2500\n"
                             "[[population]]\ncount = 20\nradius = 50e-6\nvelocity_spread = {}\ncharge = \"1e4 e\"\n"
                             "[effects.viscoelastic_contact]\nyoung = 1e8\npoisson = 0.2\nviscosity = 1e-8\n"
                             "[effects.coulomb]\n[stop]\ntime = 4e-3\n[output]\nevery = 1e-3\npicture = false\n",
                             speed));
  };
  write("dust.toml", 0.05);
  write("fast.toml", 0.06);
  REQUIRE(run_program(folder, "run dust.toml --quiet").status == 0);
  CHECK(hdf5::get<double>(hdf5::load(folder / "dust.h5"), "reference/v0").front() == 0.05);
  REQUIRE(run_program(folder, "run dust.toml --quiet --out half.h5 --set stop.time=2e-3").status == 0);
  const Ended resumed = run_program(folder, "run dust.toml --quiet --out half.h5 --resume");
  REQUIRE_MESSAGE(resumed.status == 0, resumed.err);
  const auto positions = [&](const char* file) {
    return hdf5::get<double>(hdf5::load(folder / file), "particles/conductors/position/value");
  };
  CHECK(positions("dust.h5") == positions("half.h5"));
  CHECK(run_program(folder, "run dust.toml --quiet --out again.h5 --from dust.h5").status == 0);
  const Ended refused = run_program(folder, "run fast.toml --quiet --from dust.h5");
  CHECK(refused.status == 2);
  CHECK(contains(refused.err, "its reduced units are not those of"));
}

}  // namespace gas_commands_test
