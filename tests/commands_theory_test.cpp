// Tests of `lichtenberg theory smoluchowski` with a kernel of the user.
#include <doctest/doctest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <string>

#include "tests/commands.hpp"
#include "tests/source_folder.hpp"

namespace commands_theory_test {

using namespace lichtenberg;
using namespace lichtenberg::command_line_tests;

namespace {

/// Last finite value of a column of the answer.
double last(const nlohmann::json& answer, const std::string& column) {
  double value = NAN;
  for (const auto& each : answer["tables"][0]["columns"][column]["values"])
    if (each.is_number()) value = each;
  return value;
}

}  // namespace

// K = 1: S = 1 + t, number = 2/(2 + t), relative width sqrt(S number - 1) -> 1. The error of S is 1e-4.
TEST_CASE("theory smoluchowski --kernel: constant kernel, by name and table") {
  const Folder folder;
  folder.write("one.csv", "1, 10, 100\n1, 1, 1\n1, 1, 1\n\n1, 1, 1\n");
  for (const std::string kernel : {"power:0,0", "one.csv"}) {
    const Ended ended = run(folder, "theory smoluchowski --json --until 100 --kernel " + kernel);
    REQUIRE(ended.status == 0);
    const auto answer = nlohmann::json::parse(ended.out);
    CHECK(last(answer, "time") == near(100, 1e-12));
    CHECK(last(answer, "size") == near(101, 2e-4));
    CHECK(last(answer, "number") == near(2.0 / 102, 1e-6));
    CHECK(last(answer, "width") == near(std::sqrt(202.0 / 102 - 1), 2e-4));
  }
}

TEST_CASE("theory smoluchowski --repulsion: growth slows down, width falls") {
  const Folder folder;
  const auto answer = [&](const std::string& more) {
    return nlohmann::json::parse(run(folder, "theory smoluchowski --json --kernel brownian --until 1e4" + more).out);
  };
  const auto charged = answer(" --repulsion 0.05");
  CHECK(last(charged, "size") < 50);
  CHECK(last(charged, "width") < 0.3);
  CHECK(last(charged, "slope") < 0.1);
}

TEST_CASE("theory smoluchowski: wrong kernels and options are refused") {
  const Folder folder;
  folder.write("text.csv", "1, 2\n1, x\n1, 1\n");
  folder.write("short.csv", "1, 2\n1, 1\n");
  const std::string start = "theory smoluchowski --kernel ";
  check_refused(run(folder, start + "nowhere.csv"),
                "nowhere.csv cannot be read: --kernel names a kernel or a CSV file");
  check_refused(run(folder, start + "text.csv"), "text.csv, line 2: \"x\" is no number");
  check_refused(run(folder, start + "short.csv"), "short.csv: the kernel's table has 1 rows of values for 2 sizes");
  check_refused(run(folder, start + "power:1"), "it must have two exponents");
  check_refused(run(folder, start + "power:1,9"), "exponents must be from -3 to 3");
  check_refused(run(folder, start + "brownian --repulsion 0"), "--repulsion 0 is not allowed");
  check_refused(run(folder, start + "brownian --until 0"), "--until 0 is not allowed");
  check_refused(run(folder, "theory smoluchowski --until 5"), "--until needs --kernel");
  check_refused(run(folder, "theory haff --kernel brownian"), "option --kernel is for theory smoluchowski");
  check_refused(run(folder, start + "brownian --scene " + source_folder() + "/scenes/monopolar.toml"),
                "--kernel needs no gas");
}

}  // namespace commands_theory_test
