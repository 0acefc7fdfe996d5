// Test of every line of the tutorial in its order.
#include <doctest/doctest.h>

#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>

#include "src/record/hdf5.hpp"
#include "tests/program.hpp"
#include "tests/source_folder.hpp"

namespace tutorial_test {

using namespace lichtenberg;

namespace {

const std::string program = "    ./lichtenberg ";

/// Executes the tutorial: follow() runs its commands and writes the files that it shows. `ended` has the result of each
/// command by its arguments.
struct Reader {
  Folder folder;
  int commands = 0;
  std::map<std::string, Ended> ended;

  void follow(const std::string& text) {
    std::istringstream lines(text);
    for (std::string line; std::getline(lines, line);) {
      if (line == "```toml") write_file(lines);
      if (line.starts_with(program)) run(line.substr(program.size()));
    }
  }

  void write_file(std::istringstream& lines) {
    std::string name, text;
    std::getline(lines, name);
    REQUIRE(name.starts_with("# "));
    for (std::string line; std::getline(lines, line) && line != "```";) text += line + "\n";
    folder.write(name.substr(2), text);
  }

  void run(const std::string& arguments) {
    ended[arguments] = run_program(folder, arguments);
    ++commands;
  }
};

}  // namespace

TEST_CASE("tutorial first-scene.md: each command has the described result") {
  Reader reader;
  std::filesystem::create_directory_symlink(source_folder() + "/scenes", reader.folder / "scenes");
  reader.follow(text_of(source_folder() + "/docs/tutorials/first-scene.md"));
  CHECK(reader.commands == 14);
  for (const auto& [arguments, ended] : reader.ended) {
    const bool refused = arguments == "solve scenes/two-disks.toml --set field.accuracy=1e-3";
    CHECK_MESSAGE(ended.status == (refused ? 2 : 0), arguments << ": " << ended.err);
    if (refused) CHECK(contains(ended.err, "is chosen for field.accuracy"));
  }
  const auto printed = [&](const std::string& arguments) { return reader.ended.at(arguments).out; };
  CHECK(contains(printed("solve scenes/two-disks.toml --capacitance"), "652.1"));
  CHECK(contains(printed("solve plates.toml --capacitance"), "2.49688"));
  CHECK(nlohmann::json::parse(printed("solve scenes/two-disks.toml --set field.cells=128 --json"))["units"]["charge"] ==
        "C");
  for (const std::string picture : {"own.png", "own-3.png"})
    CHECK(text_of(reader.folder / picture).starts_with("\x89PNG"));
  const auto frames = [&](const std::string& result) {
    return hdf5::get<double>(hdf5::load(reader.folder / result), "particles/conductors/position/time").size();
  };
  CHECK(frames("own.h5") == 16);
  CHECK(frames("thicker.h5") == 11);
  CHECK(nlohmann::json::parse(text_of(reader.folder / "own-ensemble/ensemble.json"))["members"].size() == 4);
}

}  // namespace tutorial_test
