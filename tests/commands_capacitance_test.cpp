// Tests of `solve --capacitance`, and of spheres between two plates.
#include <doctest/doctest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/commands.hpp"

namespace commands_capacitance_test {

using namespace lichtenberg;
using namespace lichtenberg::command_line_tests;
using nlohmann::json;

namespace {

const std::string plates_in_space = R"(
  [domain]
  size = [8e-3, 10e-3, 12e-3]
  left = { potential = 100.0 }
  right = { potential = -50.0 }
  [medium]
  permittivity = 4e-11
  [[conductor]]
  position = [3e-3, 5e-3, 6e-3]
  radius = 1e-3
  charge = 1e-11
  [effects.floating_conductors]
  [field]
  accuracy = 1e-8
)";

}  // namespace

TEST_CASE("solve --capacitance: matrix times potentials gives the groups' charges") {
  const Folder folder;
  // Conductors 0 and 1 form one group. In space two electrodes at one potential form one as well.
  const std::string wired = "[[conductor]]\nradius = 1e-3\ngroup = \"pair\"\n";
  const std::string last = "[[conductor]]\nradius = 1e-3\ncharge = -3e-11\n";
  const std::string medium = "[medium]\npermittivity = 4e-11\n[[group]]\nname = \"pair\"\ncharge = 1e-10\n";
  const auto electrode = [](const std::string& name, const std::string& shape, const std::string& geometry) {
    return "[[electrode]]\nname = \"" + name + "\"\nshape = \"" + shape + "\"\n" + geometry +
           "\nradius = 1e-3\npotential = 7.0\n";
  };
  folder.write("plane.toml", "[domain]\nsize = [16e-3, 16e-3]\nbottom = { potential = 10.0 }\n" + medium + wired +
                                 "position = [4e-3, 6e-3]\n" + wired + "position = [7e-3, 6e-3]\n" + last +
                                 "position = [12e-3, 7e-3]\n" + electrode("a", "disk", "centre = [5e-3, 13e-3]") +
                                 electrode("b", "disk", "centre = [11e-3, 13e-3]") +
                                 "[effects.floating_conductors]\n[field]\nmethod = \"multipole\"\n");
  folder.write("space.toml", "[domain]\nsize = [16e-3, 16e-3, 16e-3]\nbottom = { potential = 10.0 }\n" + medium +
                                 wired + "position = [4e-3, 6e-3, 8e-3]\n" + wired + "position = [7e-3, 6e-3, 8e-3]\n" +
                                 last + "position = [12e-3, 7e-3, 8e-3]\n" +
                                 electrode("a", "sphere", "position = [5e-3, 13e-3, 8e-3]") +
                                 electrode("b", "sphere", "position = [11e-3, 13e-3, 8e-3]") +
                                 "[effects.floating_conductors]\n[field]\naccuracy = 1e-8\n");
  for (const std::string scene : {"plane.toml", "space.toml"}) {
    CAPTURE(scene);
    const Ended ended = run(folder, "solve " + scene + " --capacitance --json");
    REQUIRE_MESSAGE(ended.status == 0, ended.err);
    const json answer = json::parse(ended.out);
    const json& matrix = answer["capacitance"]["matrix"];
    std::vector<double> potential(matrix.size()), charge(matrix.size());
    for (const char* list : {"conductors", "electrodes"})
      for (const json& one : answer[list]) {
        potential[one["group"].get<int>()] = one["potential"].get<double>();
        charge[one["group"].get<int>()] += one["charge"].get<double>();
      }
    for (std::size_t i = 0; i < matrix.size(); ++i) {
      double made = 0;
      for (std::size_t j = 0; j < matrix.size(); ++j) made += matrix[i][j].get<double>() * potential[j];
      CHECK(std::abs(made - charge[i]) < 1e-6 * 1e-10);
    }
    if (scene == "space.toml") CHECK(answer["capacitance"]["groups"][2] == "a, b");
    CHECK(answer["conductors"][2]["group"] == 1);
  }
}

TEST_CASE("solve --capacitance: plates are included; symmetric, zero row sums") {
  const Folder folder;
  folder.write("plates.toml", plates_in_space);
  const json answer = json::parse(run(folder, "solve plates.toml --capacitance --json").out);
  const json& matrix = answer["capacitance"]["matrix"];
  CHECK(answer["capacitance"]["groups"] ==
        json({"conductor 0", "the left side of the domain", "the right side of the domain"}));
  const double potential[] = {answer["conductors"][0]["potential"].get<double>(), 100, -50};
  const double charge[] = {1e-11, answer["electrodes"][0]["charge"].get<double>(),
                           answer["electrodes"][1]["charge"].get<double>()};
  for (int i = 0; i < 3; ++i) {
    double sum = 0, made = 0;
    for (int j = 0; j < 3; ++j) {
      const double c = matrix[i][j].get<double>();
      sum += c, made += c * potential[j];
      CHECK(c == near(matrix[j][i].get<double>(), 1e-6));
    }
    // All other sides are insulators: equal potentials give no field.
    CHECK(std::abs(sum) < 1e-7 * matrix[i][i].get<double>());
    CHECK(made == near(charge[i], 1e-6));
  }
  // Adjacent sides have one charge.
  const std::string right = "right = { potential = -50.0 }";
  std::string edge = plates_in_space;
  edge.replace(edge.find(right), right.size(), "right = { potential = 100.0 }\n top = { potential = 100.0 }");
  folder.write("edge.toml", edge);
  const json joined = json::parse(run(folder, "solve edge.toml --capacitance --json").out);
  CHECK(joined["capacitance"]["groups"] == json({"conductor 0", "the left, right, top sides of the domain"}));
  CHECK(joined["electrodes"].back()["charge"].get<double>() == near(-1e-11, 1e-9));
  CHECK(joined["electrodes"][0]["charge"].is_null());
  CHECK(joined["capacitance"]["matrix"][0][1].get<double>() ==
        near(-joined["capacitance"]["matrix"][0][0].get<double>(), 1e-7));
}

TEST_CASE("explain and work-precision: state unknowns, degree and error of spheres") {
  const Folder folder;
  folder.write("plates.toml", plates_in_space);
  const std::string explained = run(folder, "explain plates.toml").out;
  const json solved = json::parse(run(folder, "solve plates.toml --json").out);
  CHECK(contains(explained, fmt::format("{} unknowns of a single solve", solved["unknowns"].get<long>())));
  CHECK(contains(explained, "degree "));
  CHECK(contains(explained, "cost: an estimate"));
  const Ended swept =
      run(folder, "work-precision plates.toml --methods spheres,spheres-degree --json sweep.json --output sweep.png");
  CHECK(contains(swept.out, "field of 1 spheres in 1 groups"));
  const json sweep = json::parse(text_of(folder / "sweep.json"));
  double dipoles = 0, best = 1;
  for (const json& point : sweep["points"]) {
    const double error = point["errors"]["forces"].get<double>();
    if (point["method"] == "spheres") {
      CHECK(error < point["settings"]["accuracy"].get<double>());
      best = std::min(best, error);
    } else if (point["settings"]["degree"] == 1) {
      dipoles = error;
    }
  }
  CHECK(best < 1e-9);
  CHECK(dipoles > 1e3 * best);  // The images contribute more than a dipole for a sphere between plates.
  check_refused(run(folder, "work-precision plates.toml --sizes 64"), "--sizes is for methods with a grid");
}

}  // namespace commands_capacitance_test
