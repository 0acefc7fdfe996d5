// Runs of gases, whose frames are written beside their steps.
#include <doctest/doctest.h>
#include <sched.h>
#include <sys/resource.h>

#include <filesystem>
#include <thread>

#include "tests/gas_text.hpp"
#include "tests/run_child.hpp"

using namespace lichtenberg;
using namespace lichtenberg::run_child;
namespace fs = std::filesystem;

namespace {

/// A folder with a gas in it, whose frames are written by another thread where there is a second core. 41 frames, with
/// a checkpoint each.
struct GasFolder : Folder {
  GasFolder() { write("six.toml", gas_text(60, 8, 1, 0.025, "[mechanics]\nthreads = 1\n") + "picture = false\n"); }
};

void stay_on_one_core() {
  cpu_set_t all, one;
  CPU_ZERO(&one);
  sched_getaffinity(0, sizeof all, &all);
  for (int core = 0; core < CPU_SETSIZE && CPU_COUNT(&one) == 0; ++core)
    if (CPU_ISSET(core, &all)) CPU_SET(core, &one);
  sched_setaffinity(0, sizeof one, &one);
}

size_t gas_frames(const std::string& path) {
  return hdf5::shape(hdf5::load(path), "observables/kinetic_energy/value")[0];
}

}  // namespace

TEST_CASE("a gas whose frames are written beside its steps leaves what one leaves that writes them in between") {
  const GasFolder folder;
  REQUIRE_EQ(run(folder, "beside.h5"), 0);
  REQUIRE_EQ(Child(folder, "between.h5", {"--quiet"}, stay_on_one_core).wait(), 0);
  CHECK_EQ(gas_frames(folder / "beside.h5"), 41);
  check_same_numbers(folder / "beside.h5", folder / "between.h5");
}

TEST_CASE("a gas that is killed or stopped while a frame is written goes on bit for bit") {
  const GasFolder folder;
  const Interruptions interruptions(folder, "reference.h5");
  for (int trial = 0; trial < 6; ++trial) {
    const int signal = trial % 2 ? SIGTERM : SIGKILL;
    fs::remove(folder / "six.h5");
    Child child(folder, "six.h5", {"--quiet"});
    interruptions.send(signal, child, "six.h5", trial, trial < 2);
    const int status = child.wait();
    const bool saved = fs::exists(folder / "six.h5");
    if (status == 128 + SIGTERM && saved)
      CHECK_NE(child.messages().find("--resume goes on from there"), std::string::npos);
    REQUIRE_EQ(run(folder, "six.h5", {"--quiet", saved ? "--resume" : "--overwrite"}), 0);
    check_same_numbers(folder / "six.h5", folder / "reference.h5");
  }
}

// The first step fails while the first frame waits to be written; with one core frames are written before it.
TEST_CASE("a motion and a disk that fail at once are both said" *
          doctest::skip(std::thread::hardware_concurrency() < 2)) {
  const Folder folder;
  folder.write("six.toml", replaced(gas_text(60, 8, 1, 0.025), "contact]\n", "contact]\nelastic = 1e60\n") +
                               "picture = false\n[mechanics]\nthreads = 1\n");
  int both = 0;
  for (int trial = 0; trial < 50 && both == 0; ++trial) {
    Child child(folder, "six.h5", {"--quiet"}, [] {
      signal(SIGXFSZ, SIG_IGN);
      const rlimit at_most{1000, 1000};
      setrlimit(RLIMIT_FSIZE, &at_most);
    });
    CHECK_EQ(child.wait(), 1);
    const auto says = [&](const std::string& part) { return child.messages().find(part) != std::string::npos; };
    CAPTURE(child.messages());
    CHECK(says("six.h5 cannot be written (File too large); nothing was saved"));
    both += says("softer contacts (elastic), or a far shorter mechanics.step, is needed; and ");
  }
  CHECK_GT(both, 0);
}

TEST_CASE("a full disk ends a gas too with status 1 and the sentence, and leaves the last checkpoint") {
  const GasFolder folder;
  REQUIRE_EQ(run(folder, "reference.h5"), 0);
  const std::string said = run_on_full_disk(folder, fs::file_size(folder / "reference.h5") / 2);
  CHECK_EQ(said.find('\n') + 1, said.size());
  CHECK_LT(gas_frames(folder / "six.h5"), 41);
  REQUIRE_EQ(run(folder, "six.h5", {"--quiet", "--resume"}), 0);
  check_same_numbers(folder / "six.h5", folder / "reference.h5");
}
