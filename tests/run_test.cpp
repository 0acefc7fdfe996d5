// Tests of the command run in a process of its own, on a short scene of six conductors.
#include <doctest/doctest.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>

#include "src/analysis/network.hpp"
#include "src/commands/interruption.hpp"
#include "src/commands/start_from.hpp"
#include "src/effects/contact_discharge.hpp"
#include "src/effects/read_scene.hpp"
#include "src/record/hdf5.hpp"
#include "src/record/result_file.hpp"
#include "src/scene/scene.hpp"
#include "tests/folder.hpp"
#include "tests/run_child.hpp"

namespace run_test {

using namespace lichtenberg;
using namespace lichtenberg::run_child;
namespace fs = std::filesystem;

namespace {

int raise_when_handled = 0;

/// Signal to raise at the n-th reading of the clock; 0 raises none.
struct AtLook {
  int signal = 0, looks = 0;
} at_look;

}  // namespace

// Replaces the C library's function. A run handles SIGHUP last; the pending signal is raised as soon as it does.
extern "C" int sigaction(int signal, const struct sigaction* action, struct sigaction* before) noexcept {
  static const auto library = reinterpret_cast<decltype(&sigaction)>(dlsym(RTLD_NEXT, "sigaction"));
  const int status = library(signal, action, before);
  if (signal == SIGHUP && action != nullptr) raise(std::exchange(raise_when_handled, 0));
  return status;
}

extern "C" int clock_gettime(clockid_t clock, timespec* time) noexcept {
  static const auto library = reinterpret_cast<decltype(&clock_gettime)>(dlsym(RTLD_NEXT, "clock_gettime"));
  if (at_look.looks > 0 && --at_look.looks == 0) raise(std::exchange(at_look.signal, 0));
  return library(clock, time);
}

namespace {

/// Scene of six conductors charged by a current source, with one electrode. It has 41 frames and a checkpoint at every
/// fourth.
const std::string scene_text = R"(
title = "Six"
seed = 3
[domain]
size = [8e-3, 8e-3]
[medium]
relative_permittivity = 4.7
viscosity = 0.7
[[electrode]]
name = "ground"
shape = "half-disk"
side = "bottom"
at = 4e-3
radius = 1e-3
potential = 0.0
[[population]]
count = 6
radius = 0.775e-3
min_gap = 0.1e-3
[effects.floating_conductors]
[effects.current_injection]
current = 0.2e-9
[effects.stokes_drag]
[effects.hertz_contact]
[effects.wall_contact]
[effects.contact_discharge]
[field]
cells = 32
[output]
every = 0.01
checkpoint_every = 4
picture = false
[stop]
time = 0.4
stationary = false
)";

/// Folder that contains the scene.
struct SceneFolder : Folder {
  SceneFolder() { write("six.toml", scene_text); }
};

/// Copies the result of the scene, which is computed once for all tests.
void copy_result(const Folder& folder, const std::string& name) {
  static const SceneFolder made;
  if (!fs::exists(made / "six.h5")) REQUIRE_EQ(run(made, "six.h5"), 0);
  fs::copy_file(made / "six.h5", folder / name);
}

}  // namespace

TEST_CASE("run: its result has all frames, a balanced charge and a summary") {
  const SceneFolder folder;
  Child child(folder, "six.h5");
  REQUIRE_EQ(child.wait(), 0);
  const std::string path = folder / "six.h5";
  CHECK_EQ(frames(path), 41);
  const std::vector<double> time = hdf5::get<double>(hdf5::load(path), "observables/energy/time");
  for (size_t k = 0; k < time.size(); ++k) CHECK_EQ(time[k], doctest::Approx(0.01 * static_cast<double>(k)));
  // Six conductors receive 0.2 nA for 0.4 s: 4.8e-10 C, some of which must have moved.
  CHECK_EQ(hdf5::get<double>(hdf5::load(path), "observables/charge_fed/value").back(),
           doctest::Approx(4.8e-10).scale(0).epsilon(1e-12));  // 40 compensated sums.
  CHECK_LT(std::abs(number(path, "summary/relative_charge_imbalance")), 1e-12);
  for (const char* word : {"six.h5 holds the run up to t = 0.4 s", "connected", "endpoints", "branch points", "energy",
                           "charge", "field solves", "time"})
    CHECK_NE(child.summary().find(word), std::string::npos);
  CHECK_NE(child.messages().find("of 0.4 s"), std::string::npos);
}

TEST_CASE("run: a frame that rounding puts just before stop.time is the last") {
  const SceneFolder folder;
  const std::string every = replaced(scene_text, "every = 0.01", "every = 0.03");  // 11 * 0.03 < 0.33
  folder.write("six.toml", replaced(every, "time = 0.4", "time = 0.33"));
  REQUIRE_EQ(run(folder, "six.h5"), 0);
  CHECK_EQ(frames(folder / "six.h5"), 12);
}

TEST_CASE("run: --quiet prints nothing") {
  const SceneFolder folder;
  Child child(folder, "six.h5", {"--quiet"});
  CHECK_EQ(child.wait(), 0);
  CHECK_EQ(child.summary() + child.messages(), "");
}

// Contacts are all pairs closer than the contact gap and some of those closer than the release gap.
TEST_CASE("run: a gap below contact_distance is a contact, one above release is not") {
  const SceneFolder folder;
  copy_result(folder, "six.h5");
  const Scene scene = read_scene(folder / "six.toml");
  const hdf5::Handle file = hdf5::load(folder / "six.h5");
  const std::vector<double> all = hdf5::get<double>(file, "particles/conductors/position/value");
  std::vector<Vec2> position;
  for (size_t k = all.size() - 3 * scene.conductors.size(); k < all.size(); k += 3)
    position.push_back({all[k], all[k + 1]});
  const std::vector<double> radius = hdf5::get<double>(file, "particles/conductors/radius");
  const effects::ContactDischargeOptions& discharge = *scene.effects.find<effects::ContactDischargeOptions>();
  const analysis::Ground ground = analysis::ground_of(scene);
  const auto inner = analysis::contacts(position, radius, discharge.contact_distance, ground);
  const auto outer =
      analysis::contacts(position, radius, 1.001 * discharge.contact_distance * (1 + discharge.hysteresis), ground);
  const std::vector<std::int32_t> pairs = hdf5::get<std::int32_t>(file, "network/contacts");
  std::vector<analysis::Edge> recorded;
  for (size_t k = 0; k < pairs.size(); k += 2) recorded.emplace_back(pairs[k], pairs[k + 1]);
  std::sort(recorded.begin(), recorded.end());
  CHECK_GT(recorded.size(), 0);
  CHECK(std::includes(recorded.begin(), recorded.end(), inner.begin(), inner.end()));
  CHECK(std::includes(outer.begin(), outer.end(), recorded.begin(), recorded.end()));
}

namespace {

/// A run that stops at a frame with a checkpoint equals an uninterrupted run up to there.
void resume_from(const std::vector<int>& checkpoints) {
  const SceneFolder folder;
  copy_result(folder, "reference.h5");
  for (const int checkpoint : checkpoints) {
    CAPTURE(checkpoint);
    folder.write("six.toml", replaced(scene_text, "time = 0.4", fmt::format("time = {:.2f}", 0.01 * checkpoint)));
    REQUIRE_EQ(run(folder, "six.h5", {"--quiet", "--overwrite"}), 0);
    folder.write("six.toml", scene_text);
    REQUIRE_EQ(run(folder, "six.h5", {"--quiet", "--resume"}), 0);
    check_same_numbers(folder / "six.h5", folder / "reference.h5");
  }
}

}  // namespace

TEST_CASE("run: resumed from some checkpoints, its result has identical bits") { resume_from({4, 20, 36}); }

TEST_CASE("run: resumed from any checkpoint, same bits" * doctest::test_suite("long")) {
  resume_from({8, 12, 16, 24, 28, 32});
}

TEST_CASE("run: killed at a disk call and resumed, its result has identical bits") {
  const SceneFolder folder;
  disk_calls::done() = 0;
  REQUIRE_EQ(run(folder, "reference.h5"), 0);
  const long calls = disk_calls::done();
  std::vector<size_t> left;  // Frames after each kill.
  for (const long call : {0L, calls / 5, calls / 2, 4 * calls / 5, calls - 1}) {
    fs::remove(folder / "six.h5");
    Child child(folder, "six.h5", {"--quiet"}, interrupted_before(call, SIGKILL));
    CHECK_EQ(child.wait(), 128 + SIGKILL);
    const bool saved = fs::exists(folder / "six.h5");
    left.push_back(saved ? frames(folder / "six.h5") : 0);
    REQUIRE_EQ(run(folder, "six.h5", {"--quiet", saved ? "--resume" : "--overwrite"}), 0);
    check_same_numbers(folder / "six.h5", folder / "reference.h5");
  }
  CHECK(std::ranges::is_sorted(left));
  CHECK_EQ(left.front(), 0);
  CHECK_GT(left[1], 1);
  CHECK_LT(left[3], 41);
  CHECK_EQ(left.back(), 41);  // Only the folder's list of names was not on the disk yet.
}

namespace {

/// Terminates this process as soon as its signal handlers are installed.
void terminate_once_handled() { raise_when_handled = SIGTERM; }

}  // namespace

TEST_CASE("run: SIGTERM during the choice of a field method leaves no file") {
  const SceneFolder folder;
  folder.write("six.toml", replaced(scene_text, "cells = 32", "accuracy = 1e-4"));
  Child child(folder, "six.h5", {}, terminate_once_handled);
  CHECK_EQ(child.wait(), 128 + SIGTERM);
  CHECK_NE(child.messages().find("stopped before the run began: nothing was written"), std::string::npos);
  CHECK_FALSE(fs::exists(folder / "six.h5"));
}

TEST_CASE("run: SIGTERM during the placement of conductors stops it at once") {
  const SceneFolder folder;
  // The count is too large for random positions and too small for the early check. Without the signal the run ends with
  // status 2.
  folder.write("six.toml", replaced(replaced(scene_text, "count = 6\n", "count = 9000\n"), "0.775e-3", "0.04e-3"));
  Child child(folder, "six.h5", {}, terminate_once_handled);
  CHECK_EQ(child.wait(), 128 + SIGTERM);
  CHECK_NE(child.messages().find("stopped before the run began: nothing was written"), std::string::npos);
  CHECK_EQ(child.messages().find("after this step"), std::string::npos);  // There is no step yet.
}

namespace {

/// Run that draws a picture at its end. Its plot script writes its process number when it imports h5py and then waits.
class Drawing {
 public:
  explicit Drawing(const Folder& folder)
      : begun_(folder / "drawing"), child_(folder, "six.h5", {"--quiet"}, [&] {
          folder.write("h5py.py", fmt::format("import os, pathlib, time\n"
                                              "pathlib.Path('{0}.new').write_text(str(os.getpid()))\n"
                                              "os.rename('{0}.new', '{0}')\n"
                                              "time.sleep(300)\n",
                                              begun_.string()));
          setenv("PYTHONPATH", folder.path.c_str(), 1);
        }) {
    child_.wait_for(begun_);
    script_ = std::stoi(text_of(begun_));
  }
  Child& run() { return child_; }
  pid_t script() const { return script_; }

 private:
  fs::path begun_;
  Child child_;
  pid_t script_ = 0;
};

}  // namespace

TEST_CASE("Interruption: a second signal of any kind ends the process at once") {
  for (const int first : {SIGINT, SIGTERM, SIGHUP})
    for (const int second : {SIGINT, SIGTERM, SIGHUP}) {
      const pid_t process = fork();
      if (process == 0) {
        close(STDERR_FILENO);
        signal(SIGHUP, SIG_DFL);
        const Interruption interruption;
        raise(first);
        raise(second);
        _exit(0);
      }
      int status = 0;
      REQUIRE_EQ(waitpid(process, &status, 0), process);
      CHECK(WIFSIGNALED(status));
      CHECK_EQ(WTERMSIG(status), second);
    }
}

TEST_CASE("start_from: a stop request while placing a result's scene is obeyed") {
  const SceneFolder folder;
  copy_result(folder, "six.h5");
  Scene scene = read_scene(folder / "six.toml");
  CHECK_THROWS_AS(start_from(folder / "six.h5", {}, scene, [] { return true; }), Stopped);
}

TEST_CASE("run: SIGTERM during the last picture leaves a complete, unlocked result") {
  const SceneFolder folder;
  folder.write("six.toml", replaced(scene_text, "picture = false", "picture = true"));
  Drawing drawing(folder);
  drawing.run().send(SIGTERM);
  CHECK_EQ(drawing.run().wait(), 128 + SIGTERM);
  CHECK_EQ(frames(folder / "six.h5"), 41);
  CHECK_FALSE(fs::exists(folder / "six.h5.lock"));
}

TEST_CASE("run: SIGKILL during a picture also ends the plot script") {
  const SceneFolder folder;
  folder.write("six.toml", replaced(scene_text, "picture = false", "picture = true"));
  prctl(PR_SET_CHILD_SUBREAPER, 1);  // This process receives the status of the orphaned script.
  Drawing drawing(folder);
  drawing.run().send(SIGKILL);
  CHECK_EQ(drawing.run().wait(), 128 + SIGKILL);
  int status = 0;
  CHECK_EQ(waitpid(drawing.script(), &status, 0), drawing.script());  // The script would wait for minutes.
  prctl(PR_SET_CHILD_SUBREAPER, 0);
  CHECK_EQ(WTERMSIG(status), SIGTERM);
  CHECK_FALSE(fs::exists(folder / "six.png"));
}

// 41 frames with checkpoints at the first, the 21st and the last. The signal arrives between the first two checkpoints,
// where a run reads the clock several times per frame.
TEST_CASE("run: SIGINT stops at a checkpoint, SIGTERM at once, and both can resume") {
  const SceneFolder folder;
  folder.write("six.toml", replaced(scene_text, "checkpoint_every = 4", "checkpoint_every = 20"));
  REQUIRE_EQ(run(folder, "reference.h5"), 0);
  for (const int signal : {SIGINT, SIGTERM}) {
    Child child(folder, "six.h5", {"--overwrite"}, [&] {
      at_look.signal = signal;
      // Counting starts at the last disk call of a save.
      disk_calls::before = [](long) { at_look.looks = at_look.signal == 0 ? 0 : 30; };
    });
    REQUIRE_EQ(child.wait(), 128 + signal);
    CHECK_NE(child.messages().find("--resume continues from "), std::string::npos);
    const size_t left = frames(folder / "six.h5");
    if (signal == SIGINT) CHECK_EQ(left, 21);
    if (signal == SIGTERM) CHECK((left > 1 && left < 21));
    REQUIRE_EQ(run(folder, "six.h5", {"--quiet", "--resume"}), 0);
    check_same_numbers(folder / "six.h5", folder / "reference.h5");
  }
}

TEST_CASE("run: resuming a completed run changes nothing") {
  const SceneFolder folder;
  copy_result(folder, "six.h5");
  const std::string before = text_of(folder / "six.h5");
  CHECK_EQ(run(folder, "six.h5", {"--resume"}), 0);
  CHECK_EQ(text_of(folder / "six.h5"), before);
}

TEST_CASE("run: an existing result is refused, replaced only with --overwrite") {
  const SceneFolder folder;
  folder.write("six.h5", "precious");
  Child child(folder, "six.h5");
  CHECK_EQ(child.wait(), 2);
  CHECK_NE(child.messages().find("six.h5 exists: go on from it with --resume, replace it with --overwrite"),
           std::string::npos);
  CHECK_EQ(text_of(folder / "six.h5"), "precious");
  CHECK_EQ(run(folder, "six.h5", {"--quiet", "--resume", "--overwrite"}), 2);
  CHECK_EQ(text_of(folder / "six.h5"), "precious");
  CHECK_EQ(run(folder, "six.h5", {"--quiet", "--overwrite"}), 0);
  CHECK_EQ(frames(folder / "six.h5"), 41);
}

TEST_CASE("run --resume: missing file, cut file or changed scene are refused") {
  const SceneFolder folder;
  CHECK_EQ(run(folder, "six.h5", {"--quiet", "--resume"}), 2);
  copy_result(folder, "six.h5");
  const std::string whole = text_of(folder / "six.h5");

  folder.write("cut.h5", whole.substr(0, whole.size() / 2));
  Child cut(folder, "cut.h5", {"--resume"});
  CHECK_EQ(cut.wait(), 1);
  CHECK_NE(cut.messages().find("cut.h5 is damaged and cannot be resumed"), std::string::npos);

  folder.write("six.toml", replaced(scene_text, "viscosity = 0.7", "viscosity = 0.8"));
  Child other(folder, "six.h5", {"--resume"});
  CHECK_EQ(other.wait(), 2);
  CHECK_NE(other.messages().find("key `medium.viscosity` has changed"), std::string::npos);
  CHECK_EQ(text_of(folder / "six.h5"), whole);
}

// The disk can store the first versions of the file but not the last.
TEST_CASE("run: a full disk ends it with status 1 and keeps the last checkpoint") {
  const SceneFolder folder;
  copy_result(folder, "reference.h5");
  folder.write("six.toml", replaced(scene_text, "time = 0.4", "time = 0.01"));
  REQUIRE_EQ(run(folder, "start.h5"), 0);
  folder.write("six.toml", scene_text);
  run_on_full_disk(folder, (fs::file_size(folder / "start.h5") + fs::file_size(folder / "reference.h5")) / 2);
  CHECK_LT(frames(folder / "six.h5"), 41);
  REQUIRE_EQ(run(folder, "six.h5", {"--quiet", "--resume"}), 0);
  check_same_numbers(folder / "six.h5", folder / "reference.h5");
}

TEST_CASE("run: output.picture = true writes a picture") {
  const SceneFolder folder;
  folder.write("six.toml",
               replaced(replaced(scene_text, "picture = false", "picture = true"), "time = 0.4", "time = 0.02"));
  CHECK_EQ(run(folder, "six.h5"), 0);
  CHECK_EQ(text_of(folder / "six.png").substr(1, 3), "PNG");
}

}  // namespace run_test
