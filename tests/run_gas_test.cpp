// Tests of runs of gases whose frames are written concurrently with their steps.
#include <doctest/doctest.h>
#include <sched.h>
#include <sys/resource.h>

#include <cxxabi.h>
#include <dlfcn.h>
#include <atomic>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <thread>
#include <typeinfo>

#include "solvers/error.hpp"
#include "tests/gas_text.hpp"
#include "tests/run_child.hpp"

namespace run_gas_test {

using namespace lichtenberg;
using namespace lichtenberg::run_child;
namespace fs = std::filesystem;

namespace {

std::atomic<bool> failed = false;  ///< True after a Failure of the motion or the disk.

}  // namespace

}  // namespace run_gas_test

// Replaces the function of the C++ library.
extern "C" void __cxxabiv1::__cxa_throw(void* thrown, std::type_info* type, void (*destroy)(void*)) {
  static const auto library = reinterpret_cast<decltype(&__cxxabiv1::__cxa_throw)>(dlsym(RTLD_NEXT, "__cxa_throw"));
  if (*type == typeid(lichtenberg::Failure)) run_gas_test::failed = true;
  library(thrown, type, destroy);
  std::abort();  // This line is not reached.
}

namespace run_gas_test {

namespace {

/// Folder with a gas, whose frames another thread writes if there is a second core: 41 frames with a checkpoint each.
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

TEST_CASE("gas run: frames written concurrently equal frames written between steps") {
  const GasFolder folder;
  REQUIRE_EQ(run(folder, "beside.h5"), 0);
  REQUIRE_EQ(Child(folder, "between.h5", {"--quiet"}, stay_on_one_core).wait(), 0);
  CHECK_EQ(gas_frames(folder / "beside.h5"), 41);
  check_same_numbers(folder / "beside.h5", folder / "between.h5");
}

TEST_CASE("gas run killed or stopped during a write: resumes with identical bits") {
  const GasFolder folder;
  disk_calls::done() = 0;
  REQUIRE_EQ(run(folder, "reference.h5"), 0);
  const long calls = disk_calls::done();
  for (const int signal : {SIGKILL, SIGTERM})
    for (const long call : {1L, calls / 3, 2 * calls / 3}) {
      CAPTURE(call);
      fs::remove(folder / "six.h5");
      Child child(folder, "six.h5", {"--quiet"}, interrupted_before(call, signal));
      CHECK_EQ(child.wait(), 128 + signal);
      const bool saved = fs::exists(folder / "six.h5");
      CHECK_EQ(saved, signal == SIGTERM || call > 1);  // A stopped run completes the write that it has begun.
      if (saved) CHECK_LT(gas_frames(folder / "six.h5"), 41);
      if (signal == SIGTERM) CHECK_NE(child.messages().find("--resume continues from there"), std::string::npos);
      REQUIRE_EQ(run(folder, "six.h5", {"--quiet", saved ? "--resume" : "--overwrite"}), 0);
      check_same_numbers(folder / "six.h5", folder / "reference.h5");
    }
}

// The first step fails while the first frame waits to be written; with one core, frames are written before it.
TEST_CASE("gas run: simultaneous failures of motion and disk are both reported" *
          doctest::skip(std::thread::hardware_concurrency() < 2)) {
  const Folder folder;
  folder.write("six.toml", replaced(gas_text(60, 8, 1, 0.025), "contact]\n", "contact]\nelastic = 1e60\n") +
                               "picture = false\n[mechanics]\nthreads = 1\n");
  Child child(folder, "six.h5", {"--quiet"}, [] {
    signal(SIGXFSZ, SIG_IGN);
    const rlimit at_most{1000, 1000};
    setrlimit(RLIMIT_FSIZE, &at_most);
    // Frames are written after the motion has failed.
    disk_calls::before = [motion = std::this_thread::get_id()](long) {
      for (int ms = 0; ms < 60'000 && !failed && std::this_thread::get_id() != motion; ++ms)
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    };
  });
  CHECK_EQ(child.wait(), 1);
  CAPTURE(child.messages());
  CHECK(contains(child.messages(), "six.h5 cannot be written (File too large); nothing was saved"));
  CHECK(contains(child.messages(), "softer contacts (stiffness), or a far shorter mechanics.step, is needed; and "));
}

TEST_CASE("gas run on a full disk: status 1, the last checkpoint is kept") {
  const GasFolder folder;
  REQUIRE_EQ(run(folder, "reference.h5"), 0);
  const std::string said = run_on_full_disk(folder, fs::file_size(folder / "reference.h5") / 2);
  CHECK_EQ(said.find('\n') + 1, said.size());
  CHECK_LT(gas_frames(folder / "six.h5"), 41);
  REQUIRE_EQ(run(folder, "six.h5", {"--quiet", "--resume"}), 0);
  check_same_numbers(folder / "six.h5", folder / "reference.h5");
}

}  // namespace run_gas_test
