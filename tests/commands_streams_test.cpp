// Tests of standard streams that are closed, full or broken pipes: work is stored, and no file gets the output.
#include <doctest/doctest.h>

#include <filesystem>
#include <initializer_list>
#include <string>

#include "tests/commands.hpp"
#include "tests/file_numbers.hpp"

namespace commands_streams_test {

using namespace lichtenberg;
using namespace lichtenberg::command_line_tests;

namespace {

/// Folder with a scene of two conductors and five frames, which takes milliseconds.
struct Moving : Folder {
  Moving() {
    write("moving.toml", replaced(small_scene, "4e-11", "4e-11\nviscosity = 0.7") +
                             "[effects.stokes_drag]\n[output]\nevery = 1e-3\ncheckpoint_every = 1\npicture = "
                             "false\n[stop]\ntime = 4e-3\n");
  }
  /// All numbers of a result except timings.
  std::map<std::string, std::vector<std::byte>> numbers(const std::string& file) const {
    auto bytes = numbers_in((path / file).string());
    std::erase_if(bytes, [](const auto& entry) { return entry.first.starts_with("/provenance"); });
    return bytes;
  }
};

}  // namespace

TEST_CASE("run: closed or full output streams change neither result nor status") {
  const Moving folder;
  REQUIRE(run(folder, "run moving.toml --out reference.h5 --quiet").status == 0);
  const auto reference = folder.numbers("reference.h5");
  for (const std::string streams :
       {">/dev/null 2>/dev/full", ">/dev/full", ">&-", "2>&-", ">&- 2>&-", "<&- >&- 2>&-", ">/dev/full 2>&-"}) {
    CAPTURE(streams);
    CHECK(run_shell(folder, "LICHTENBERG run moving.toml --out shown.h5 --overwrite " + streams).status == 0);
    REQUIRE(std::filesystem::exists(folder / "shown.h5"));
    CHECK((folder.numbers("shown.h5") == reference));
    std::filesystem::remove(folder / "shown.h5");
  }
}

TEST_CASE("run: a pipe closed by its reader changes neither result nor status") {
  const Moving folder;
  REQUIRE(run(folder, "run moving.toml --out reference.h5 --quiet").status == 0);
  run_shell(folder, "(LICHTENBERG run moving.toml --out shown.h5 2>&1; echo $? >status) | true");
  CHECK(text_of(folder / "status") == "0\n");
  CHECK((folder.numbers("shown.h5") == folder.numbers("reference.h5")));
}

TEST_CASE("run: a full standard output gives a message and status 0") {
  const Moving folder;
  const Ended ended = run_shell(folder, "LICHTENBERG run moving.toml >/dev/full");
  CHECK(ended.status == 0);
  CHECK(contains(ended.err, "the output could not be written (No space left on device)"));
}

TEST_CASE("errors: exit status stays 2 even if no message can be written") {
  const Moving folder;
  for (const std::string streams : {"2>/dev/full", "2>&-", ">&- 2>&-"}) {
    CAPTURE(streams);
    CHECK(run_shell(folder, "LICHTENBERG run nowhere.toml " + streams).status == 2);
    CHECK(run_shell(folder, "LICHTENBERG nonsense " + streams).status == 2);
  }
}

TEST_CASE("help: a closed pipe ends it by SIGPIPE, a closed stdout with status 1") {
  const Folder folder;
  run_shell(folder, "(sleep 0.2; LICHTENBERG help scene; echo $? >status) | true");
  CHECK(text_of(folder / "status") == "141\n");  // 128 plus the number of SIGPIPE.
  CHECK(text_of(folder / "err").empty());
  CHECK(run_shell(folder, "LICHTENBERG help scene >&-").status == 1);
}

TEST_CASE("analyse: its results are stored even if they cannot be printed") {
  const Moving folder;
  folder.write("contacts.toml",
               text_of(folder / "moving.toml") + "[effects.contact_discharge]\ncontact_distance = 1e-5\n");
  for (const std::string streams : {">/dev/full", ">&-"}) {
    CAPTURE(streams);
    REQUIRE(run(folder, "run contacts.toml --quiet --overwrite").status == 0);
    CHECK(run_shell(folder, "LICHTENBERG analyse contacts.h5 " + streams).status == 1);
    CHECK(numbers_in(folder / "contacts.h5").contains("/analysis/connected"));
  }
}

TEST_CASE("ensemble: runs and tabulates members with stdout closed, stderr full") {
  const Moving folder;
  const Ended ended =
      run_shell(folder, "LICHTENBERG ensemble moving.toml --vary conductor[0].charge=1e-10,2e-10 >&- 2>/dev/full");
  CHECK(ended.status == 0);
  CHECK(std::filesystem::exists(folder / "moving-ensemble" / "ensemble.json"));
}

TEST_CASE("plot, view and export: write with closed or full streams" * doctest::test_suite("long")) {
  const Moving folder;
  REQUIRE(run(folder, "run moving.toml --quiet").status == 0);
  for (const std::string streams : {">/dev/full", ">&-", ">&- 2>&-", ">/dev/full 2>/dev/full"}) {
    CAPTURE(streams);
    for (const auto& [command, file] :
         {std::pair{"view moving.h5", "moving.html"}, std::pair{"export moving.h5 --to xyz", "moving.xyz"}}) {
      CAPTURE(command);
      const Ended ended = run_shell(folder, fmt::format("LICHTENBERG {} {}", command, streams));
      CHECK(ended.status == 0);
      CHECK_FALSE(contains(ended.err, "Traceback"));
      CHECK_FALSE(contains(ended.err, "Exception ignored"));
      CHECK(std::filesystem::file_size(folder / file) > 0);
      std::filesystem::remove(folder / file);
    }
  }
  const Ended plotted = run_shell(folder, "LICHTENBERG plot moving.h5 --out picture.png >/dev/full");
  CHECK(plotted.status == 0);
  CHECK(contains(plotted.err, "the output could not be written (No space left on device)"));
  CHECK(std::filesystem::exists(folder / "picture.png"));
}

}  // namespace commands_streams_test
