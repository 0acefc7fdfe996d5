// Command added from outside through headers alone.
#include <doctest/doctest.h>

#include <memory>

#include "solvers/error.hpp"
#include "src/commands/command_line.hpp"
#include "src/effects/read_scene.hpp"
#include "src/record/atomic_file.hpp"
#include "src/record/hdf5.hpp"
#include "tests/folder.hpp"
#include "tests/scene_texts.hpp"
#include "tests/source_folder.hpp"

namespace extend_command {

using namespace lichtenberg;

namespace {

struct CountArguments {
  std::string scene;
  int least = 0, found = 0;
};

/// `lichtenberg count SCENE [--least N]`: the number of bodies of a scene.
Command count_command(const std::shared_ptr<CountArguments>& request) {
  return {"count",
          "Counts the bodies of a scene",
          {{"SCENE", &request->scene, "scene file (.toml)", {.required = true}},
           {"--least", &request->least, "fewer bodies than this are refused"}},
          [request] {
            request->found = static_cast<int>(read_scene(request->scene).conductors.size());
            if (request->found < request->least) throw InputError(request->scene + ": too few bodies");
          }};
}

}  // namespace

TEST_CASE("user-defined command: runs, checks its arguments and has help") {
  const auto request = std::make_shared<CountArguments>();
  std::vector<Command> commands = all_commands();
  commands.push_back(count_command(request));
  const std::string scene = source_folder() + "/scenes/two-disks.toml";
  CHECK(run_command_line({"count", scene}, commands) == 0);
  CHECK(request->found == 2);
  CHECK(run_command_line({"count", scene, "--least", "3"}, commands) == 2);
  CHECK(run_command_line({"count"}, commands) == 2);
  CHECK(run_command_line({"help", "count"}, commands) == 0);
  CHECK(run_command_line({"explain", scene}, commands) == 0);  // All other commands still exist.
}

TEST_CASE("user-defined command: an error of its HDF5 calls gives status 2") {
  const Folder folder;
  folder.write("no.h5", "nothing");
  std::string file;
  const Command command{
      "rows", "Counts the radii of a result", {{"FILE", &file, "result file of a run (.h5)", {.required = true}}}, [&] {
        const auto opened = hdf5::open(std::make_shared<const OpenFile>(file));
        hdf5::get<double>(opened, "particles/conductors/radius");
      }};
  CHECK(run_command_line({"rows", (folder / "no.h5").string()}, {command}) == 2);
}

}  // namespace extend_command
