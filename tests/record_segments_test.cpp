// Tests of results with many frames: segments, merging, resuming.
#include <doctest/doctest.h>
#include <fmt/format.h>
#include <signal.h>
#include <sys/resource.h>

#include <fstream>
#include <vector>

#include "solvers/error.hpp"
#include "tests/many_frames.hpp"

namespace record_segments_test {

using namespace lichtenberg;
using namespace lichtenberg::many_frames;

TEST_CASE("result segments: contain the added frames, also when read by h5py") {
  const Folder folder;
  const std::string path = folder / "run.h5";
  run(path, 20, false);
  CHECK_GT(segments(path), 3);
  CHECK(numbers(path) == expected(20));
  CHECK(python(folder, R"(
import h5py
file = h5py.File("run.h5")
position, contacts = file["particles/conductors/position"], file["network/contacts_of_all_frames"]
assert position["value"].shape == (20, 20, 3) and position["value"].attrs["unit"] == "m"
assert (position["value"][:, 0, 1] == [2.0 * k for k in range(20)]).all()
assert list(position["step"]) == list(range(20)) and position["time"][19] == 9.5
assert list(file["observables/current"].attrs["terminals"]) == ["left", "right"]
assert contacts.shape == (sum(k % 4 for k in range(20)), 2) and contacts[-1, 1] == 2 + 19
assert len(file["network/contacts"]) == 3
)") == 0);
}

TEST_CASE("result segments: few frames stay in one file without a folder") {
  const Folder folder;
  run(folder / "run.h5", 20, false, 1 << 20);
  CHECK_FALSE(fs::exists(segments_folder(folder / "run.h5")));
  CHECK(numbers(folder / "run.h5") == expected(20));
}

TEST_CASE("result segments: a frame above the size limit becomes a segment at once") {
  const Folder folder;
  const std::string path = folder / "run.h5";
  Recorder recorder = start(path, 100);
  recorder.add(frame(0));
  CHECK_EQ(segments(path), 1);
  recorder.add(frame(1));
  recorder.save(milestone(2));
  CHECK_EQ(segments(path), 2);
  CHECK(numbers(path) == expected(2));
}

TEST_CASE("result segments: a completed run is one file, resuming copies nothing") {
  const Folder folder;
  const std::string path = folder / "run.h5";
  run(path, 20, true);
  CHECK_FALSE(fs::exists(segments_folder(path)));
  CHECK(numbers(path) == expected(20));
  CHECK(python(folder, "import h5py\nassert h5py.File('run.h5')['observables/energy/value'].is_virtual is False") == 0);
  const auto inode = identity_of(path).inode;
  {
    Recorder resumed = Recorder::resume(path, some_scene(), few);
    CHECK(!resumed.summary().empty());
    add_until(resumed, 23);
    resumed.save(milestone(23));
    CHECK(identity_of(segment_file(path, 0)).inode == inode);
    CHECK(numbers(path) == expected(23));
    add_until(resumed, 30);
    resumed.save(milestone(30, true));
  }
  CHECK(numbers(path) == expected(30));
  CHECK_FALSE(fs::exists(segments_folder(path)));
}

TEST_CASE("resume after 1 to 16 frames: the result has the numbers of a full run") {
  const Folder folder;
  for (const int stop : {1, 2, 7, 9, 16}) {
    const std::string path = folder / fmt::format("{}.h5", stop);
    run(path, stop, false);
    Recorder resumed = Recorder::resume(path, some_scene(), few);
    CHECK_EQ(resumed.frames(), stop);
    CHECK_EQ(resumed.checkpoint()->reals.at("mark")[0], stop);
    add_until(resumed, 20);
    resumed.save(milestone(20));
    CHECK(numbers(path) == expected(20));
    const auto history = hdf5::get<std::int64_t>(ResultFile(path, "read").file(), "relaxation/iteration");
    CHECK_EQ(history.front(), 1);
    CHECK_EQ(history.back(), 20);
  }
}

TEST_CASE("resume: removes unsaved segments and partial files") {
  const Folder folder;
  const std::string path = folder / "run.h5";
  run(path, 10, false);
  const auto before = segments(path);
  {
    Recorder resumed = Recorder::resume(path, some_scene(), few);
    for (int k = 10; k < 20; ++k) resumed.add(frame(k));
    CHECK_GT(segments(path), before);
  }
  folder.write("run.h5.partial-1", "x");
  CHECK(numbers(path) == expected(10));
  Recorder::resume(path, some_scene(), few);
  CHECK_EQ(segments(path), before);
  CHECK_FALSE(fs::exists(folder / "run.h5.partial-1"));
}

TEST_CASE("overwrite: segments of the old result stay until the first save") {
  const Folder folder;
  const std::string path = folder / "run.h5";
  run(path, 10, false);
  Recorder recorder = start(path, few, true);
  for (int k = 0; k < 7; ++k) recorder.add(frame(k));
  CHECK(numbers(path) == expected(10));
  recorder.save(milestone(7));
  CHECK(numbers(path) == expected(7));
  CHECK_EQ(segments(path), 1);
}

namespace {

/// Resumes a run that was interrupted after frames beyond its last checkpoint.
void resume_after(const std::vector<int>& checkpoints, const std::vector<int>& later) {
  for (const int checkpoint : checkpoints)
    for (const int more : later) {
      const int end = checkpoint + more;
      CAPTURE(checkpoint);
      CAPTURE(end);
      const Folder folder;
      const std::string path = folder / "run.h5";
      const auto check_frames = [&](int frames) {
        Numbers shown = expected(frames);
        shown["mark"] = {1.0 * checkpoint};
        CHECK(numbers(path) == shown);
        const std::vector<std::int32_t> last = hdf5::get<std::int32_t>(hdf5::load(path), "network/contacts");
        CHECK(last == std::get<std::vector<std::int32_t>>(frame(frames - 1).columns[5].values));
      };
      {
        Recorder recorder = start(path);
        for (int k = 0; k < checkpoint; ++k) recorder.add(frame(k));
        recorder.save(milestone(checkpoint));
        for (int k = checkpoint; k < end; ++k) recorder.add(frame(k));
        recorder.save_frames_alone();
      }
      check_frames(end);
      {
        Recorder resumed = Recorder::resume(path, some_scene(), few);
        CHECK_EQ(resumed.frames(), checkpoint);
        check_frames(end);  // Until the next save the frames remain.
        resumed.save(milestone(checkpoint));
      }
      check_frames(checkpoint);
      Recorder resumed = Recorder::resume(path, some_scene(), few);
      for (int k = checkpoint; k < end; ++k) resumed.add(frame(k));
      resumed.save_frames_alone();
      check_frames(end);
      for (int k = end; k < 20; ++k) resumed.add(frame(k));
      resumed.save(milestone(20, true));
      CHECK(numbers(path) == expected(20));
      CHECK_EQ(segments(path), 0);
    }
}

}  // namespace

// The last checkpoint of an interrupted run lies at the end of a segment, within one, or before any segment.
TEST_CASE("resume: frames after the last checkpoint are readable until replaced") {
  resume_after({1, 4, 5, 6}, {0, 1, 9});
}

TEST_CASE("resume: frames after any of nine checkpoints" * doctest::test_suite("long")) {
  resume_after({1, 2, 3, 4, 5, 6, 7, 8, 11}, {0, 1, 3, 9});
}

TEST_CASE("result segments: a missing or foreign segment is named in the error") {
  const Folder folder;
  const std::string path = folder / "run.h5";
  run(path, 10, false);
  run(folder / "other.h5", 20, false, 2000);
  fs::copy_file(segment_file(folder / "other.h5", 1), segment_file(path, 1), fs::copy_options::overwrite_existing);
  CHECK(contains(message_of([&] { numbers(path); }), "run.h5.frames/segment-000001.h5 is not the one"));
  fs::remove(segment_file(path, 1));
  CHECK(contains(message_of([&] { numbers(path); }), "run.h5.frames/segment-000001.h5, which holds frames"));
  CHECK_THROWS_AS(Recorder::resume(path, some_scene()), Failure);
}

// A limit on the file size simulates a full disk: segments fit, but the merged file does not.
TEST_CASE("full disk: segments that cannot be merged remain the result") {
  const Folder folder;
  const std::string path = folder / "run.h5";
  constexpr std::uint64_t tail = 30000;  // bytes
  run(path, 300, false, tail);
  const pid_t child = in_child([&] {
    Recorder recorder = Recorder::resume(path, some_scene(), tail);
    signal(SIGXFSZ, SIG_IGN);
    const rlimit at_most{150000, RLIM_INFINITY};  // The merged file has about 300000 bytes.
    setrlimit(RLIMIT_FSIZE, &at_most);
    const std::string warning = recorder.save(milestone(300, true));
    if (!contains(warning, "run.h5.frames belongs to")) throw Failure("no such warning: " + warning);
  });
  CHECK_EQ(status_of(child), 0);
  CHECK_GT(segments(path), 3);
  CHECK(numbers(path) == expected(300));
  Recorder later = Recorder::resume(path, some_scene(), tail);
  CHECK(!later.summary().empty());
  CHECK_FALSE(later.in_one_file());
  CHECK_EQ(later.save(milestone(300, true)), "");
  CHECK(later.in_one_file());
  CHECK_EQ(segments(path), 0);
}

TEST_CASE("result segments: more than the limit of open files can be merged") {
  const Folder folder;
  const std::string path = folder / "run.h5";
  run(path, 200, false);
  REQUIRE(segments(path) > 35);
  const pid_t child = in_child([&] {
    Recorder recorder = Recorder::resume(path, some_scene(), few);
    const rlimit at_most{30, 30};
    setrlimit(RLIMIT_NOFILE, &at_most);
    recorder.save(milestone(200, true));
  });
  CHECK_EQ(status_of(child), 0);
  CHECK_EQ(segments(path), 0);
  CHECK(numbers(path) == expected(200));
}

TEST_CASE("full disk: a failed segment gives a message, earlier data stay") {
  const Folder folder;
  const std::string path = folder / "run.h5";
  run(path, 10, false);
  const pid_t child = in_child([&] {
    Recorder recorder = Recorder::resume(path, some_scene(), few);
    signal(SIGXFSZ, SIG_IGN);
    const rlimit at_most{1000, RLIM_INFINITY};
    setrlimit(RLIMIT_FSIZE, &at_most);
    const std::string message = message_of([&] {
      for (int k = 10; k < 20; ++k) recorder.add(frame(k));
    });
    if (!contains(message, "cannot be written (File too large); the state saved up to t = 4.5 s is intact"))
      throw Failure(message);
  });
  CHECK_EQ(status_of(child), 0);
  CHECK(numbers(path) == expected(10));
}

TEST_CASE("write error message: states the saved time in the run's time unit") {
  const Folder folder;
  struct Case {
    std::string unit, told;
  };
  for (const auto& [unit, told] : {Case{"s", "t = 5 s"}, Case{"t0", "t = 5 t0"}, Case{"1", "iteration 5"}}) {
    const std::string path = folder / (unit + ".h5");
    const auto timed = [&, &unit = unit](int k) {
      Frame now = frame(k);
      now.time_unit = unit;
      return now;
    };
    Recorder recorder = start(path);
    for (int k = 0; k <= 10; ++k) recorder.add(timed(k));
    recorder.save(milestone(11));
    fs::remove_all(segments_folder(path));
    std::ofstream(segments_folder(path)) << "an obstacle";
    const std::string message = message_of([&] {
      for (int k = 11; k < 20; ++k) recorder.add(timed(k));
    });
    CHECK(contains(message, "the state saved up to " + told + " is intact"));
  }
}

TEST_CASE("stored analysis: leaves frames unchanged in segments and single files") {
  const Folder folder;
  const auto add = [](const hdf5::Handle& file) { hdf5::put(hdf5::open_group(file, "analysis"), "answer", 42.0, "1"); };
  struct Case {
    std::string name;
    bool over = false;
    std::uint64_t tail = few;
  };
  // In segments, merged, and in one compressed file from the start.
  for (const auto& [name, over, tail] : {Case{"now.h5"}, Case{"over.h5", true}, Case{"short.h5", false, 1 << 20}}) {
    CAPTURE(name);
    const std::string path = folder / name;
    run(path, 20, over, tail);
    store(ResultFile(path, "read"), add, 1000);
    CHECK(numbers(path) == expected(20));
    const ResultFile stored(path, "read");
    CHECK_EQ(hdf5::get<double>(stored.file(), "analysis/answer"), std::vector<double>{42});
    CHECK_EQ(hdf5::get<double>(stored.file(), "provenance/session-0/seconds/field"), std::vector<double>{0.5});
    const hdf5::Handle box(H5Gopen2(stored.file(), "particles/conductors/box", H5P_DEFAULT));
    CHECK_EQ(hdf5::text_attribute(box, "boundary"), std::vector<std::string>{"periodic", "none", "none"});
    CHECK_EQ(hdf5::integer_attribute(box, "dimension"), 3);
    Recorder resumed = Recorder::resume(path, some_scene(), few);
    CHECK(contains(message_of([&] { store(stored, add); }), "is being written"));
    add_until(resumed, 25);
    resumed.save(milestone(25));
    CHECK(numbers(path) == expected(25));
    CHECK_FALSE(hdf5::exists(ResultFile(path, "read").file(), "analysis"));
  }
}

TEST_CASE("Recorder::add: a column that cannot be recorded is named in the error") {
  const Folder folder;
  Recorder recorder = start(folder / "run.h5");
  const auto refused = [&](const std::function<void(Frame&)>& change) {
    Frame wrong = frame(1);
    change(wrong);
    CHECK_THROWS_AS(recorder.add(wrong), InputError);
    return message_of([&] { recorder.add(wrong); });
  };
  const auto check_both = [&] {
    CHECK(contains(refused([](auto& f) { std::get<0>(f.columns[0].values).pop_back(); }), "column `position`"));
    CHECK(contains(refused([](auto& f) { f.columns[1].unit = ""; }), "column `charge` of a frame cannot be recorded"));
    CHECK(contains(refused([](auto& f) { f.columns[2].name = "charge"; }), "column `charge`"));
    CHECK(contains(refused([](auto& f) { f.columns[2].name = "a/b"; }), "column `a/b`"));
    for (const std::string name : {"mass", "radius", "species", "box"}) {
      const std::string message = refused([&](auto& f) { f.columns[1].name = name; });
      CHECK(contains(message, "column `" + name + "` of a frame cannot be recorded: the name is that of"));
    }
    for (const std::string name : {"contacts_end", "ends_of_all_frames", "particle", "contact"}) {
      const std::string message = refused([&](auto& f) { f.columns[5].name = name; });
      CHECK(contains(message, "column `" + name + "` of a frame cannot be recorded: a list's name must not be"));
    }
    CHECK(contains(refused([](auto& f) { f.columns[3].labels.pop_back(); }), "column `current`"));
    CHECK(contains(refused([](auto& f) { f.columns[5].values = std::vector<std::int32_t>(3); }), "column `contacts`"));
  };
  check_both();
  recorder.add(frame(0));
  check_both();
  CHECK(contains(refused([](auto& f) { f.columns[1].unit = "V"; }), "column `charge`"));
  CHECK(contains(refused([](auto& f) { f.columns[1].name = "colour"; }), "column `colour`"));
  CHECK(contains(refused([](auto& f) { f.columns.erase(f.columns.begin() + 1); }), "column `charge`"));
  CHECK(contains(refused([](auto& f) { f.columns[4].values = std::vector<double>{1}; }), "column `solves`"));
  CHECK(contains(refused([](auto& f) { f.columns[3].labels = {"a", "b"}; }), "column `current`"));
  CHECK(contains(refused([](auto& f) { f.time_unit = "1"; }), "column `time`"));
  recorder.add(frame(1));
  recorder.save(milestone(2));
  CHECK(numbers(folder / "run.h5") == expected(2));
}

TEST_CASE("Recorder::add after a resume: a column with another unit is refused") {
  const Folder folder;
  run(folder / "run.h5", 10, false);
  Recorder resumed = Recorder::resume(folder / "run.h5", some_scene(), few);
  Frame other = frame(10);
  other.columns[1].unit = "V";
  CHECK(contains(message_of([&] { resumed.add(other); }), "column `charge`"));
}

TEST_CASE("frames in a result: compressed at the end of the run, not at each save") {
  const Folder folder;
  const std::string path = folder / "run.h5";
  const auto stored = [&] {
    const hdf5::Handle file = hdf5::load(path);
    const hdf5::Handle dataset(H5Dopen2(file, "particles/conductors/position/value", H5P_DEFAULT));
    return H5Dget_storage_size(dataset);
  };
  const hsize_t bytes = 100 * particles * 3 * sizeof(double);
  run(path, 100, false, 1 << 20);
  CHECK_EQ(stored(), bytes);
  Recorder::resume(path, some_scene(), 1 << 20).save(milestone(100, true));
  CHECK_LT(stored(), bytes / 2);  // The x, y and z arrays compress: one is always 0, and one is the same for all.
  CHECK(numbers(path) == expected(100));
}

}  // namespace record_segments_test
