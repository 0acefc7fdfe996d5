// Tests of results of many frames that are killed during writes, read, written by several processes, or changed by
// others.
#include <doctest/doctest.h>
#include <fmt/format.h>
#include <signal.h>

#include <algorithm>
#include <fstream>
#include <optional>
#include <random>
#include <set>

#include "solvers/error.hpp"
#include "src/record/writer_lock.hpp"
#include "tests/disk_calls.hpp"
#include "tests/many_frames.hpp"

namespace record_disturbed_test {

using namespace lichtenberg;
using namespace lichtenberg::many_frames;

namespace {

/// Number of frames of an intact result.
int frames_of_whole(const std::string& path) {
  const Numbers found = numbers(path);
  const int frames = static_cast<int>(found.at("mark")[0]);
  CHECK(found == expected(frames));
  return frames;
}

/// A child saves, makes segments and merges them. It is killed before one of its changes of the disk, for every n-th
/// change and the last one, and resumed after every third kill.
void kill_before_every(long n) {
  const Folder folder;
  const std::string path = folder / "run.h5";
  disk_calls::done() = 0;
  REQUIRE_EQ(status_of(in_child([&] { run(path, 30, true); })), 0);
  const long calls = disk_calls::done();
  std::vector<int> left;  // Frames in the result after each kill.
  for (long call = 0; call < calls; call = call < calls - 1 ? std::min(call + n, calls - 1) : calls) {
    fs::remove_all(segments_folder(path));
    fs::remove(path);
    const pid_t child = in_child([&] {
      disk_calls::interrupt_before(call, SIGKILL);
      run(path, 30, true);
    });
    CHECK_EQ(status_of(child), 128 + SIGKILL);
    left.push_back(fs::exists(path) ? frames_of_whole(path) : 0);
    if (call / n % 3 != 0) continue;  // Resuming takes most of the time.
    Recorder recorder = fs::exists(path) ? Recorder::resume(path, some_scene(), few) : start(path);
    add_until(recorder, 30);
    recorder.save(milestone(30, true));
    CHECK(numbers(path) == expected(30));
    CHECK_FALSE(fs::exists(segments_folder(path)));
  }
  CHECK(std::ranges::is_sorted(left));  // Saved frames remain.
  CHECK_EQ(left.front(), 0);
  CHECK_EQ(left.back(), 30);
  CHECK_GT(std::set(left.begin(), left.end()).size(), 6);  // 12 values, of which ten are saves before the end.
}

}  // namespace

TEST_CASE("result file: killed before disk calls, it stays readable, resumable") { kill_before_every(13); }

TEST_CASE("result file: killed before every seventh disk call" * doctest::test_suite("long")) { kill_before_every(7); }

TEST_CASE("writer lock: a second writer is refused and the first one is named") {
  const Folder folder;
  const std::string path = folder / "run.h5";
  std::optional<Recorder> first = start(path);
  const auto refused = [&](bool overwrite) {
    CHECK_THROWS_AS(start(path, few, overwrite), InputError);
    return message_of([&] { start(path, few, overwrite); });
  };
  CHECK(contains(refused(false), fmt::format("run.h5 is being written by process {}", getpid())));
  first->add(frame(0));
  first->save(milestone(1));
  CHECK(contains(refused(true), "is being written by"));
  CHECK(contains(message_of([&] { Recorder::resume(path, some_scene()); }), "is being written by"));
  CHECK(fs::exists(folder / "run.h5.lock"));
  first.reset();
  CHECK_FALSE(fs::exists(folder / "run.h5.lock"));
  CHECK(message_of([&] { Recorder::resume(path, some_scene()); }) == "");
}

TEST_CASE("writer lock of a killed process: does not block a resume") {
  const Folder folder;
  const std::string path = folder / "run.h5";
  const pid_t child = in_child([&] {
    Recorder recorder = start(path);
    recorder.add(frame(0));
    recorder.save(milestone(1));
    pause();
  });
  while (!fs::exists(path)) usleep(1000);
  kill(child, SIGKILL);
  status_of(child);
  CHECK(fs::exists(folder / "run.h5.lock"));
  CHECK_EQ(Recorder::resume(path, some_scene()).frames(), 1);
}

// All processes compete repeatedly; no two may have the lock at the same time.
TEST_CASE("writer lock: at most one of four concurrent writers holds it") {
  const Folder folder;
  const std::string path = folder / "run.h5", inside = folder / "inside";
  std::vector<pid_t> children;
  for (int c = 0; c < 4; ++c)
    children.push_back(in_child([&] {
      for (int k = 0; k < 150; ++k) {
        const std::optional<WriterLock> lock = WriterLock::if_free(path);
        if (!lock) continue;
        if (!fs::create_directory(inside)) throw Failure("two have the lock");
        fs::remove(inside);
      }
    }));
  for (const pid_t child : children) CHECK_EQ(status_of(child), 0);
}

TEST_CASE("result file: a reader sees complete states during writes") {
  const Folder folder;
  const std::string path = folder / "run.h5";
  run(path, 3, false);
  const pid_t reader = in_child([&] {
    for (int last = 0; last < 60;) {
      const Numbers found = numbers(path);
      const int frames = static_cast<int>(found.at("mark")[0]);
      if (found != expected(frames) || frames < last) throw Failure(fmt::format("a wrong state of {} frames", frames));
      last = frames;
    }
  });
  Recorder recorder = Recorder::resume(path, some_scene(), few);
  add_until(recorder, 60);
  recorder.save(milestone(60, true));
  CHECK_EQ(status_of(reader), 0);
}

TEST_CASE("result file open and locked in h5py: a run can still save to it") {
  const Folder folder;
  const std::string path = folder / "run.h5";
  run(path, 10, false);
  const pid_t reader = in_child([&] {
    if (python(folder, R"(
import h5py, pathlib, time
file = h5py.File("run.h5")
before = file["observables/energy/value"][()]
pathlib.Path("open").touch()
while not pathlib.Path("saved").exists():
    time.sleep(0.01)
assert (file["observables/energy/value"][()] == before).all() and len(before) == 10
)") != 0)
      throw Failure("python failed");
  });
  while (!fs::exists(folder / "open")) usleep(1000);
  Recorder recorder = Recorder::resume(path, some_scene(), few);
  add_until(recorder, 20);
  recorder.save(milestone(20));
  folder.write("saved", "");
  CHECK_EQ(status_of(reader), 0);
  CHECK(numbers(path) == expected(20));
}

namespace {

/// Flips a random bit of each file of a result, a number of times. The file is then refused or has its original
/// numbers.
void flip_bits_of_files(int times) {
  const Folder folder;
  const std::string path = folder / "run.h5";
  std::mt19937 random(7);
  int refused = 0, harmless = 0, resumed = 0;
  const auto flip_bits = [&](const std::string& file, int frames) {
    const std::string whole = text_of(file);
    for (int trial = 0; trial < times; ++trial) {
      std::string flipped = whole;
      // 10 % of the bits are in the seal at the end.
      const std::size_t from = trial % 10 == 0 ? whole.size() - 24 : 0;
      flipped[std::uniform_int_distribution<std::size_t>(from, whole.size() - 1)(random)] ^= 1 << (random() % 8);
      std::ofstream(file, std::ios::binary) << flipped;
      bool same = false;
      const std::string sentence = message_of([&] { same = numbers(path) == expected(frames); });
      INFO(sentence);
      CHECK((same || contains(sentence, "checksum") || contains(sentence, "segment-") || contains(sentence, "HDF5")));
      ++(sentence.empty() ? harmless : refused);
      resumed += message_of([&] { Recorder::resume(path, some_scene(), few); }).empty();
    }
    std::ofstream(file, std::ios::binary) << whole;
  };
  run(path, 11, false);
  flip_bits(path, 11);
  flip_bits(segment_file(path, 1), 11);
  fs::remove_all(segments_folder(path));
  fs::remove(path);
  run(path, 11, true);
  flip_bits(path, 11);
  CHECK_EQ(resumed, 0);
  CHECK_GT(refused, 2.5 * times);
  MESSAGE(refused, " refused, ", harmless, " harmless");
}

}  // namespace

TEST_CASE("result file with a flipped bit: refused, or read with right numbers") { flip_bits_of_files(40); }

TEST_CASE("result file: 600 flipped bits" * doctest::test_suite("long")) { flip_bits_of_files(200); }

TEST_CASE("result changed by another program: readable but not resumable") {
  const Folder folder;
  const std::string path = folder / "run.h5";
  run(path, 3, false);
  REQUIRE(python(folder, "import h5py\nh5py.File('run.h5', 'r+').attrs['mine'] = 1") == 0);
  CHECK(numbers(path) == expected(3));
  CHECK(contains(message_of([&] { Recorder::resume(path, some_scene()); }), "was changed by another program"));
}

}  // namespace record_disturbed_test
