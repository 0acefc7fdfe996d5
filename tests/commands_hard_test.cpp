// Tests of error messages for hostile input: extreme numbers and names, files of other types, signals, endless scenes.
#include <doctest/doctest.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <string>
#include <utility>

#include "src/commands/reading.hpp"
#include "tests/program.hpp"

namespace commands_hard_test {

using namespace lichtenberg;

namespace {

/// Scene of a wire at 5954.5 V just above a side at -1653 V, onto which it falls.
const std::string falling_wire = R"(
[domain]
size = [0.032, 0.032]
bottom = { potential = -1653 }
[medium]
relative_permittivity = 2.5
viscosity = 0.7
[[conductor]]
position = [0.016, 0.001849]
radius = 1.324e-3
group = "wire"
[[group]]
name = "wire"
potential = 5954.5
[effects.floating_conductors]
[effects.stokes_drag]
[effects.hertz_contact]
[effects.wall_contact]
[effects.contact_discharge]
contact_distance = 1e-5
[effects.contact_resistance]
resistance = 6e7
[field]
cells = 128
[output]
every = 0.01
picture = false
[stop]
time = 1
)";

/// Scene of two neutral disks and one supply behind a resistor: at rest, and all at one potential.
const std::string lone_supply = R"(
[domain]
size = [0.032, 0.032]
[medium]
relative_permittivity = 2.5
viscosity = 0.7
[[electrode]]
shape = "disk"
centre = [0.016, 0.026]
radius = 2e-3
potential = 1000
series_resistance = 1e9
[[conductor]]
position = [0.016, 0.01]
radius = 1.3e-3
[[conductor]]
position = [0.011, 0.01]
radius = 1.3e-3
[effects.floating_conductors]
[effects.stokes_drag]
[effects.hertz_contact]
[effects.wall_contact]
[effects.contact_discharge]
contact_distance = 1e-4
[field]
cells = 64
[output]
every = 0.05
picture = false
[stop]
time = 0.2
)";

/// Scene of a disk, the only charge, in the middle of a ring of the given radius.
std::string in_ring(double radius) {
  return fmt::format(R"(
[domain]
size = [0.032, 0.032]
[medium]
relative_permittivity = 2.5
[[electrode]]
shape = "ring"
centre = [0.016, 0.016]
radius = {}
potential = 0
[[conductor]]
position = [0.016, 0.016]
radius = 1e-3
charge = 1e-9
[effects.floating_conductors]
[field]
cells = 128
)",
                     radius);
}

/// Runs a command that must end by itself; kills it after 10 minutes.
Ended run_within_minutes(const Folder& folder, const std::string& arguments) {
  return run_shell(folder, "timeout -s KILL 600 LICHTENBERG " + arguments);
}

/// Sends a signal `later` seconds after `file` exists and returns the run's status. The lock exists before the first
/// solve, the result after the first saved frame.
Ended run_with_signal(const Folder& folder, const std::string& signal, const std::string& file, double later) {
  // timeout forwards the signal once in the foreground and returns the status of its child.
  return run_shell(folder,
                   fmt::format("timeout --foreground -s KILL 600 LICHTENBERG run scene.toml --out x.h5 & run=$!; "
                               "while [ ! -e {} ] && kill -0 $run; do sleep 0.001; done; sleep {}; "
                               "kill -{} $run; wait $run",
                               file, later, signal));
}

void check_refused(const Ended& ended, int status, const std::string& part) {
  INFO(ended.err);
  CHECK(ended.status == status);
  CHECK(contains(ended.err, part));
  CHECK(ended.err.starts_with("lichtenberg: "));
}

}  // namespace

TEST_CASE("contact of two fixed potentials through a resistance: ends the run") {
  const Folder folder;
  folder.write("scene.toml", falling_wire);
  const Ended ended = run_within_minutes(folder, "run scene.toml --quiet");
  check_refused(ended, 1,
                "conductor 0 and the bottom side of the domain touch while their potentials are 7.61e+03 V apart");
  CHECK(contains(ended.err, "keep them apart"));
  CHECK_FALSE(contains(ended.err, "too soft"));
}

TEST_CASE("SIGTERM or SIGHUP: run stops between two steps and names --resume") {
  const Folder folder;
  // The only frame in 1000 simulated seconds takes hours.
  std::string endless = replaced(lone_supply, "every = 0.05", "every = 1000");
  endless = replaced(endless, "time = 0.2", "time = 1000\nstationary = false\n[mechanics]\nlargest_step = 1e-4");
  folder.write("scene.toml", endless);
  for (const auto& [signal, status] : {std::pair{"TERM", 143}, std::pair{"HUP", 129}})
    for (const auto& [file, later] : {std::pair{"x.h5", 0.1}, std::pair{"x.h5.lock", 0.0}}) {
      CAPTURE(file);
      std::filesystem::remove(folder / "x.h5");
      const Ended ended = run_with_signal(folder, signal, file, later);
      CHECK_MESSAGE(ended.status == status, ended.err);
      CHECK_MESSAGE(contains(ended.err, "stopped at t = 0 s; the same command with --resume continues from there"),
                    ended.err);
      CHECK_FALSE(std::filesystem::exists(folder / "x.h5.lock"));
    }
}

// A charge of 10^30 C within 0.1 ms gives forces of 10^60 N. CVODE's step would become 0 and its call endless.
TEST_CASE("current of 2e35 A: overflowing forces end the run with an error message") {
  const Folder folder;
  folder.write("scene.toml", R"(seed = 1
[domain]
size = [0.02844, 0.02844]
bottom = { potential = 0.0 }
[medium]
relative_permittivity = 4.7
viscosity = 0.7
[[population]]
count = 12
radius = 0.000775
min_gap = 0.0001
[effects.floating_conductors]
[effects.current_injection]
current = 2e+35
[effects.stokes_drag]
[effects.hertz_contact]
[effects.wall_contact]
[effects.contact_discharge]
[field]
cells = 48
[stop]
time = 0.0001
[output]
every = 5e-5
)");
  check_refused(run_within_minutes(folder, "run scene.toml --quiet"), 1, "is pressed into a side of the domain");
}

TEST_CASE("file size limit (ulimit -f): run reports a write error") {
  const Folder folder;
  folder.write("scene.toml", lone_supply);
  const Ended ended = run_shell(folder, "ulimit -f 16; LICHTENBERG run scene.toml --quiet");
  check_refused(ended, 1, "File too large");
}

TEST_CASE("integers beyond 2^53 in a scene: read as numbers, refused by range") {
  const Folder folder;
  folder.write("large.toml", replaced(falling_wire, "1.324e-3", "9007199254740993"));
  check_refused(run_program(folder, "explain large.toml"), 2, "by 9.01e+15 m");
  folder.write("negative.toml", "material = { density = -9223372036854775808 }\n" + falling_wire);
  check_refused(run_program(folder, "explain negative.toml"), 2,
                "material.density = -9223372036854775808 is not allowed");
}

TEST_CASE("electrode less than half a cell diagonal inside the domain: refused") {
  const Folder folder;
  // The corners are 0.022627 m from the centre; half the diagonal of a cell is 1.77e-4 m.
  for (const auto& [radius, depth] :
       {std::pair{0.03, "by 0 m, which is not at all"}, std::pair{0.0225, "by 0.000127 m"}}) {
    folder.write("ring.toml", in_ring(radius));
    check_refused(run_program(folder, "solve ring.toml"), 2, std::string("the ring reaches into the domain ") + depth);
  }
  folder.write("ring.toml", in_ring(0.0224));
  CHECK(run_program(folder, "solve ring.toml").status == 0);
  folder.write("disk.toml",
               replaced(replaced(replaced(in_ring(1e-3), "ring", "disk"), "radius = 0.001", "radius = 4.1e-3"),
                        "centre = [0.016, 0.016]", "centre = [-4e-3, 0.016]"));
  check_refused(run_program(folder, "solve disk.toml"), 2, "the disk reaches into the domain by 0.0001 m");
}

TEST_CASE("source behind a resistor, neutral conductors: the run completes") {
  const Folder folder;
  folder.write("scene.toml", lone_supply);
  const Ended ended = run_within_minutes(folder, "run scene.toml");
  CHECK_MESSAGE(ended.status == 0, ended.err);
  CHECK_FALSE(contains(ended.out, "nan"));
}

// No device is tested, because as root a failure would replace it.
TEST_CASE("run: its result file does not replace a pipe or a symbolic link") {
  const Folder folder;
  folder.write("scene.toml", lone_supply);
  REQUIRE(run_shell(folder, "mkfifo pipe; ln -s elsewhere link").status == 0);
  for (const std::string file : {"pipe", "link"})
    for (const std::string how : {"", " --overwrite"})
      check_refused(run_program(folder, "run scene.toml --out " + file + how), 2, file + " is no plain file");
  CHECK(std::filesystem::is_fifo(folder / "pipe"));
  CHECK(std::filesystem::is_symlink(folder / "link"));
}

TEST_CASE("file names and scene keys that are too long: refused with status 2") {
  const Folder folder;
  folder.write("scene.toml", lone_supply);
  const std::string name(300, 'x');
  check_refused(run_program(folder, "run scene.toml --out " + name + ".h5"), 2, "File name too long");
  check_refused(run_program(folder, "explain " + name + ".toml"), 2, "File name too long");
  check_refused(run_program(folder, "run scene.toml --resume --out " + name + ".h5"), 2, "File name too long");
  check_refused(run_program(folder, "ensemble scene.toml --vary title=\\\"" + name + "\\\""), 2, "306 characters");
  std::string keys = "a";
  for (int k = 0; k < 50000; ++k) keys += ".a";
  folder.write("deep.toml", "title = \"1.2\" # ...\n" + keys + " = 1\n");
  check_refused(run_program(folder, "explain deep.toml"), 2,
                "deep.toml:2: a key with more than 1000 parts is not allowed");
  folder.write("deep.toml", "[" + keys + "]\n");
  check_refused(run_program(folder, "explain deep.toml"), 2, "deep.toml:1: a key with more than 1000 parts");
}

TEST_CASE("scene file: a pipe, a device or more than 100 MB is refused") {
  const Folder folder;
  REQUIRE(run_shell(folder, "mkfifo pipe.toml; truncate -s 100000001 large.toml").status == 0);
  const auto refused = [&](const std::string& command, const std::string& part) {
    check_refused(run_shell(folder, "timeout -s KILL 60 LICHTENBERG " + command), 2, part);
  };
  refused("run /dev/zero", "/dev/zero is not a regular file");
  refused("run large.toml", "large.toml has 100000001 bytes: at most 100000000 are allowed");
  for (const std::string command : {"run", "explain", "solve", "ensemble"})
    refused(command + " pipe.toml", "pipe.toml is not a regular file");
}

TEST_CASE("limit below 64 open files (ulimit -n): commands end with a message") {
  const Folder folder;
  folder.write("scene.toml", lone_supply);
  for (const std::string command : {"solve scene.toml", "run scene.toml", "--version"})
    check_refused(run_shell(folder, "ulimit -n 12; LICHTENBERG " + command), 1,
                  "only 12 files may be open at once (ulimit -n), and at least 64 are needed");
  CHECK(run_shell(folder, "ulimit -n 64; LICHTENBERG solve scene.toml").status == 0);
  // The program may raise the soft limit.
  CHECK(run_shell(folder, "ulimit -S -n 12; LICHTENBERG solve scene.toml").status == 0);
}

TEST_CASE("scene text with control characters: refused, and they are not printed") {
  const Folder folder;
  const auto silent = [](const Ended& ended) {
    return !contains(ended.out + ended.err, "\x1b") && !contains(ended.out + ended.err, "\x07");
  };
  for (const std::string& text :
       {"title = \"\\u001b]0;owned\\u0007\"\n" + lone_supply, "title = \"\\u009b31m\"\n" + lone_supply,
        replaced(lone_supply, "shape = \"disk\"", "shape = \"disk\"\nname = \"\\u001b[31m\"")}) {
    folder.write("scene.toml", text);
    for (const std::string command : {"explain", "solve", "run"}) {
      const Ended ended = run_program(folder, command + " scene.toml");
      check_refused(ended, 2, "without control characters");
      CHECK(silent(ended));
    }
  }
  folder.write("scene.toml", "\"\\u001b[31m\" = 1\n" + lone_supply);
  const Ended unknown = run_program(folder, "explain scene.toml");
  check_refused(unknown, 2, "unknown key \\x1b[31m");
  CHECK(silent(unknown));
  CHECK(silent(run_program(folder, "explain \"$(printf '\\033[31m').toml\"")));
  folder.write("scene.toml", "picture = fals\n[output]\n");
  const Ended two_lines = run_program(folder, "explain scene.toml");
  check_refused(two_lines, 2, "saw 'fals\\x0a'");
  CHECK(std::ranges::count(two_lines.err, '\n') == 1);
}

TEST_CASE("energy imbalance within the noise of field solves: reported as noise") {
  // Almost nothing moves: the stored energy is 1e-14 J, and solves to 1e-4 change it by more than the supplied energy.
  const Folder folder;
  folder.write("scene.toml", R"(
[domain]
size = [0.032, 0.024]
left = { potential = 0.6272755018183267 }
right = { potential = 0.0 }
[medium]
relative_permittivity = 4.7
viscosity = 0.01
[[conductor]]
position = [0.026048015083479842, 0.012086521266721257]
radius = 0.0009709687077031326
[effects.floating_conductors]
[effects.stokes_drag]
[effects.hertz_contact]
[effects.wall_contact]
[effects.contact_discharge]
[field]
cells = 128
[output]
every = 0.01
picture = false
[stop]
time = 0.05
stationary = false
)");
  const Ended ended = run_program(folder, "run scene.toml");
  CHECK(ended.status == 0);
  CHECK(contains(ended.out, "the noise of field solves; "));
  CHECK_FALSE(contains(ended.out, "(relative "));
  CHECK_FALSE(contains(ended.err, "WARNING"));
}

namespace {

/// Exit status and standard error of a command that crashes in a child process while it reads a file.
std::pair<int, std::string> end_of_crash(const Folder& folder, const std::string& file) {
  const std::string messages = folder / "messages";
  const pid_t command = fork();
  if (command == 0) {
    const int target = open(messages.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0666);
    dup2(target, STDERR_FILENO);
    signal(SIGABRT, SIG_DFL);
    read_in_child({file});
    abort();
  }
  int status = 0;
  waitpid(command, &status, 0);
  return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, text_of(messages)};
}

}  // namespace

TEST_CASE("read_in_child: a crash on a readable file is not reported as damage") {
  const Folder folder;
  folder.write("scene.toml", lone_supply);
  REQUIRE(run_program(folder, "run scene.toml --quiet").status == 0);
  const auto [status, message] = end_of_crash(folder, folder / "scene.h5");
  CHECK(status == 1);
  CHECK(contains(message, "lichtenberg: the program crashed (signal 6"));
  CHECK(contains(message, "this is an error of the program"));
  CHECK_FALSE(contains(message, "is damaged"));
}

TEST_CASE("file names with control characters: accepted, not printed raw" * doctest::test_suite("long")) {
  const Folder folder;
  const std::string name =
      "a\x1b[31m\x07"
      "b";
  folder.write(name + ".toml", lone_supply);
  const std::string shown = "\"$(printf 'a\\033[31m\\007b').", scene = shown + "toml\"", result = shown + "h5\"";
  REQUIRE(run_program(folder, "run --quiet " + scene).status == 0);
  for (const std::string& command :
       {"explain " + scene, "solve " + scene + " --field " + shown + "hdf\"", "run --overwrite " + scene,
        "analyse " + result, "export " + result + " --to csv", "export " + result + " --to xyz", "view " + result,
        "ensemble " + scene + " --quiet", "plot " + result, "network " + result, "theory " + result}) {
    CAPTURE(command);
    const Ended ended = run_program(folder, command);
    CHECK_FALSE(contains(ended.out + ended.err, "\x1b"));
    CHECK_FALSE(contains(ended.out + ended.err, "\x07"));
    CHECK((ended.out + ended.err).size() > 0);
    CHECK(ended.status == (command.starts_with("theory") ? 2 : 0));
  }
}

TEST_CASE("disk smaller than a grid cell: solve and run print a warning") {
  const Folder folder;
  folder.write("scene.toml", replaced(replaced(falling_wire, "1.324e-3", "1e-4"), "time = 1\n", "time = 1e-9\n"));
  for (const std::string command : {"solve", "run"}) {  // A cell is 2.5e-4 m wide.
    const Ended ended = run_program(folder, command + " scene.toml");
    CHECK(ended.status == 0);
    CHECK_MESSAGE(contains(ended.out + ended.err, "disks below a cell: 1 of them"), ended.err);
  }
  folder.write("scene.toml", replaced(falling_wire, "time = 1\n", "time = 1e-9\n"));
  CHECK_FALSE(contains(run_program(folder, "run scene.toml --overwrite").err, "below a cell"));
}

TEST_CASE("run: ends with a message on lost data if its result folder is removed") {
  const Folder folder;
  // Only the removal ends this run.
  const std::string often = replaced(lone_supply, "every = 0.05", "every = 1e-3");
  folder.write("scene.toml", replaced(often, "time = 0.2", "time = 1e6\nstationary = false"));
  const Ended ended =
      run_shell(folder,
                "mkdir inner; timeout -s KILL 600 LICHTENBERG run scene.toml --out inner/x.h5 --quiet & run=$!; "
                "while [ ! -e inner/x.h5 ] && kill -0 $run; do sleep 0.001; done; "
                "until rm -rf inner 2>&-; do :; done; wait $run");
  check_refused(ended, 1, "inner/x.h5 cannot be written");
  CHECK(contains(ended.err, "is lost, because the file was removed during the run"));
  CHECK_FALSE(contains(ended.err, "intact"));
}

}  // namespace commands_hard_test
