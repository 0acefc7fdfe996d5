// Results of many frames: written in segments, read while they are written, killed, flipped and put together.
#include <doctest/doctest.h>
#include <fmt/format.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <optional>
#include <random>

#include "solvers/error.hpp"
#include "src/record/recorder.hpp"
#include "src/record/result_file.hpp"
#include "tests/folder.hpp"
#include "tests/message.hpp"

using namespace lichtenberg;
namespace fs = std::filesystem;
using Of = Column::Of;

namespace {

constexpr int particles = 20;
constexpr std::uint64_t few = 3000;  // bytes: three frames and a segment is full

Scene some_scene() {
  Scene scene;
  scene.path = "many.toml";
  scene.text = "title = \"many\"\n[stop]\ntime = 1.0\n";
  scene.domain.size = {1, 1};
  for (int i = 0; i < particles; ++i) scene.conductors.push_back({.position = {0.01 * i, 0.5}, .radius = 0.001});
  return scene;
}

/// Numbers that depend on the frame, and lists of a length that does.
Frame frame(int k) {
  std::vector<double> position, charge;
  std::vector<std::int32_t> pairs;
  for (int i = 0; i < particles; ++i) {
    position.insert(position.end(), {i + 1e-3 * k, 2.0 * k, 0});
    charge.push_back(1e-9 * i * k);
  }
  for (int c = 0; c < k % 4; ++c) pairs.insert(pairs.end(), {c, c + k});
  return {.time = 0.5 * k,
          .columns = {{"position", "m", Of::particles, 3, position},
                      {"charge", "C", Of::particles, 0, charge},
                      {"energy", "J", Of::system, 0, std::vector<double>{1.0 + k}},
                      {"current", "A", Of::system, 2, std::vector<double>{1.0 * k, -1.0 * k}, {"left", "right"}},
                      {"solves", "1", Of::system, 0, std::vector<std::int64_t>{7 * k}},
                      {"contacts", "1", Of::list, 2, pairs}}};
}

Milestone milestone(int frames, bool over = false) {
  Milestone m;
  m.checkpoint.reals["mark"] = {1.0 * frames};
  m.seconds["field"] = 0.5;
  m.history = ColumnGroup{"relaxation", {{"iteration", "1", Of::list, 0, std::vector<std::int64_t>{frames}}}};
  if (over) m.summary = {{"energy", 2.5, "J"}};
  return m;
}

Recorder start(const std::string& path, std::uint64_t tail = few, bool overwrite = false) {
  return Recorder::start(path, some_scene(), std::vector<double>(particles, 1e-3), overwrite, tail);
}

/// Adds frames up to `end`, with a save after each third of all.
void add_until(Recorder& recorder, int end) {
  for (int k = static_cast<int>(recorder.frames()); k < end; ++k) {
    recorder.add(frame(k));
    if (k % 3 == 0) recorder.save(milestone(k + 1));
  }
}

void run(const std::string& path, int frames, bool to_the_end, std::uint64_t tail = few) {
  Recorder recorder = start(path, tail);
  add_until(recorder, frames);
  recorder.save(milestone(frames, to_the_end));
}

std::int64_t segments(const std::string& path) {
  std::error_code none;
  return std::distance(fs::directory_iterator(segments_folder(path), none), {});
}

using Numbers = std::map<std::string, std::vector<double>>;

/// All numbers of all frames, as a reader finds them.
Numbers numbers(const std::string& path) {
  const ResultFile file(path, "read");
  Numbers found;
  for (const std::string name : {"particles/conductors/position/value", "particles/conductors/charge/value",
                                 "observables/energy/value", "observables/current/value", "observables/solves/value",
                                 "observables/energy/step", "observables/energy/time", "network/contacts_end"})
    found[name] = file.rows<double>(name);
  const auto ends = file.rows<std::int64_t>("network/contacts_end");
  for (std::int64_t k = 0; k < file.frames(); ++k)
    for (const std::int32_t end : file.list<std::int32_t>("contacts", ends, k)) found["contacts"].push_back(end);
  found["mark"] = hdf5::get<double>(file.file(), "checkpoint/reals/mark");
  return found;
}

/// What a reader must find in a result of so many frames.
Numbers expected(int frames) {
  Numbers all;
  const auto append = [](std::vector<double>& to, const Column& column) {
    std::visit([&](const auto& values) { to.insert(to.end(), values.begin(), values.end()); }, column.values);
  };
  double contacts = 0;
  for (int k = 0; k < frames; ++k) {
    const Frame now = frame(k);
    append(all["particles/conductors/position/value"], now.columns[0]);
    append(all["particles/conductors/charge/value"], now.columns[1]);
    append(all["observables/energy/value"], now.columns[2]);
    append(all["observables/current/value"], now.columns[3]);
    append(all["observables/solves/value"], now.columns[4]);
    if (now.columns[5].size() > 0) append(all["contacts"], now.columns[5]);
    all["observables/energy/step"].push_back(k);
    all["observables/energy/time"].push_back(now.time);
    all["network/contacts_end"].push_back(contacts += static_cast<double>(now.columns[5].rows()));
  }
  all["mark"] = {1.0 * frames};
  return all;
}

pid_t in_child(const std::function<void()>& action) {
  const pid_t child = fork();
  if (child != 0) return child;
  const std::string message = message_of(action);
  if (!message.empty()) std::fprintf(stderr, "%s\n", message.c_str());
  _exit(message.empty() ? 0 : 1);
}

int status_of(pid_t child) {
  int status = 0;
  waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

/// Runs a script by Debian's python, which has h5py, and returns its exit status.
int python(const Folder& folder, const std::string& script) {
  folder.write("script.py", script);
  return std::system(fmt::format("cd '{}' && /usr/bin/python3 script.py", folder.path.string()).c_str());
}

}  // namespace

TEST_CASE("frames in segments are the frames that were added, also to h5py") {
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

TEST_CASE("few frames stay in one file, of which no folder speaks") {
  const Folder folder;
  run(folder / "run.h5", 20, false, 1 << 20);
  CHECK_FALSE(fs::exists(segments_folder(folder / "run.h5")));
  CHECK(numbers(folder / "run.h5") == expected(20));
}

TEST_CASE("a frame above the limit is a segment at once") {
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

TEST_CASE("a run that is over is one file again, and one that goes on from it copies nothing") {
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

TEST_CASE("a run resumed at any frame ends with the numbers and the history of one that never stopped") {
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

TEST_CASE("segments that no save has made part of the result go when it is resumed, and a killed run's partial file") {
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

TEST_CASE("the segments of a run that is overwritten stay until the first save") {
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

// A child saves, makes segments and puts them together, again and again, and is killed anywhere in it.
TEST_CASE("killed at any moment the result so far is readable, and the resumed run ends with the same numbers") {
  const Folder folder;
  const std::string path = folder / "run.h5";
  const auto start_of_one = std::chrono::steady_clock::now();
  REQUIRE_EQ(status_of(in_child([&] { run(path, 30, true); })), 0);
  const auto whole =
      std::chrono::duration_cast<std::chrono::microseconds>(std::chrono::steady_clock::now() - start_of_one);
  std::mt19937 random(5);
  int killed = 0, none = 0, over = 0;
  for (int trial = 0; trial < 30; ++trial) {
    fs::remove_all(segments_folder(path));
    fs::remove(path);
    const pid_t child = in_child([&] { run(path, 30, true); });
    usleep(std::uniform_int_distribution<useconds_t>(0, static_cast<useconds_t>(whole.count()))(random));
    kill(child, SIGKILL);
    killed += status_of(child) == 128 + SIGKILL;
    none += !fs::exists(path);
    if (fs::exists(path)) {
      const Numbers found = numbers(path);
      const int frames = static_cast<int>(found.at("mark")[0]);
      over += frames == 30;
      CHECK(found == expected(frames));
    }
    Recorder recorder = fs::exists(path) ? Recorder::resume(path, some_scene(), few) : start(path);
    add_until(recorder, 30);
    recorder.save(milestone(30, true));
    CHECK(numbers(path) == expected(30));
    CHECK_FALSE(fs::exists(segments_folder(path)));
  }
  CHECK_GT(killed, 10);
  MESSAGE("killed ", killed, ", before the first save ", none, ", after the last frame ", over);
}

TEST_CASE("a second writer is refused at once and told who the first is") {
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

TEST_CASE("a process that is killed locks nobody out") {
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

// All of them at once, over and over: of those that got the lock none may have met another.
TEST_CASE("of many that want to write at the same time, one at a time does") {
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

TEST_CASE("who reads while a run writes sees a complete state and disturbs nothing") {
  const Folder folder;
  const std::string path = folder / "run.h5";
  run(path, 3, false);
  const pid_t reader = in_child([&] {
    for (int last = 0; last < 200;) {
      const Numbers found = numbers(path);
      const int frames = static_cast<int>(found.at("mark")[0]);
      if (found != expected(frames) || frames < last) throw Failure(fmt::format("a wrong state of {} frames", frames));
      last = frames;
    }
  });
  Recorder recorder = Recorder::resume(path, some_scene(), few);
  add_until(recorder, 200);
  recorder.save(milestone(200, true));
  CHECK_EQ(status_of(reader), 0);
}

TEST_CASE("h5py may hold a result open, with HDF5's lock on it, while its run goes on") {
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

// Of every file of a result a bit is flipped, anywhere: what is read then is either refused or what was written.
TEST_CASE("a flipped bit is refused in a sentence or changes nothing") {
  const Folder folder;
  const std::string path = folder / "run.h5";
  std::mt19937 random(7);
  int refused = 0, harmless = 0, resumed = 0;
  const auto flip_bits = [&](const std::string& file, int frames, int times) {
    const std::string whole = text_of(file);
    for (int trial = 0; trial < times; ++trial) {
      std::string flipped = whole;
      // one in ten of the bits in the seal at the end
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
  flip_bits(path, 11, 200);
  flip_bits(segment_file(path, 1), 11, 200);
  fs::remove_all(segments_folder(path));
  fs::remove(path);
  run(path, 11, true);
  flip_bits(path, 11, 200);
  CHECK_EQ(resumed, 0);
  CHECK_GT(refused, 500);
  MESSAGE(refused, " refused, ", harmless, " harmless");
}

TEST_CASE("a result that another program has changed can be read, and not resumed") {
  const Folder folder;
  const std::string path = folder / "run.h5";
  run(path, 3, false);
  REQUIRE(python(folder, "import h5py\nh5py.File('run.h5', 'r+').attrs['mine'] = 1") == 0);
  CHECK(numbers(path) == expected(3));
  CHECK(contains(message_of([&] { Recorder::resume(path, some_scene()); }), "was changed by another program"));
}

TEST_CASE("a result of an earlier format can be read, and is refused by its version when it is resumed") {
  const Folder folder;
  const std::string path = folder / "run.h5";
  run(path, 3, false);
  {
    const hdf5::Handle file = hdf5::load(path);
    hdf5::put_attribute(file, "lichtenberg_result", 1);
    write_atomically(path, hdf5::image(file));
  }
  CHECK(numbers(path) == expected(3));
  CHECK(contains(message_of([&] { Recorder::resume(path, some_scene()); }), "has result format 1"));
}

TEST_CASE("a segment that is missing or another run's is told by its name") {
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

// A limit on the size of files stands for a disk without room: segments fit, all of them together do not.
TEST_CASE("where there is no room to put segments together they stay, and are the result") {
  const Folder folder;
  const std::string path = folder / "run.h5";
  constexpr std::uint64_t tail = 30000;  // bytes
  run(path, 600, false, tail);
  const pid_t child = in_child([&] {
    Recorder recorder = Recorder::resume(path, some_scene(), tail);
    signal(SIGXFSZ, SIG_IGN);
    const rlimit at_most{200000, RLIM_INFINITY};  // of some 600000
    setrlimit(RLIMIT_FSIZE, &at_most);
    const std::string warning = recorder.save(milestone(600, true));
    if (!contains(warning, "run.h5.frames stays beside")) throw Failure("no such warning: " + warning);
  });
  CHECK_EQ(status_of(child), 0);
  CHECK_GT(segments(path), 3);
  CHECK(numbers(path) == expected(600));
  CHECK(!Recorder::resume(path, some_scene()).summary().empty());
}

TEST_CASE("more segments than a process may open files are put together") {
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

TEST_CASE("a disk that is full while a segment is written costs a sentence and nothing that was there") {
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
    if (!contains(message, "cannot be written (File too large); what was saved up to t = 4.5 s stands"))
      throw Failure(message);
  });
  CHECK_EQ(status_of(child), 0);
  CHECK(numbers(path) == expected(10));
}

TEST_CASE("what stands is told in the run's own time") {
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
    std::ofstream(segments_folder(path)) << "in the way";
    const std::string message = message_of([&] {
      for (int k = 11; k < 20; ++k) recorder.add(timed(k));
    });
    CHECK(contains(message, "what was saved up to " + told + " stands"));
  }
}

TEST_CASE("what is stored beside the frames leaves them alone, however the result is stored") {
  const Folder folder;
  const auto add = [](const hdf5::Handle& file) { hdf5::put(hdf5::open_group(file, "analysis"), "answer", 42.0, "1"); };
  struct Case {
    std::string name;
    bool over = false;
    std::uint64_t tail = few;
  };
  // In segments, put together, and in one file from the start: compressed.
  for (const auto& [name, over, tail] : {Case{"now.h5"}, Case{"over.h5", true}, Case{"short.h5", false, 1 << 20}}) {
    CAPTURE(name);
    const std::string path = folder / name;
    run(path, 20, over, tail);
    store(ResultFile(path, "read"), add, 1000);
    CHECK(numbers(path) == expected(20));
    const ResultFile stored(path, "read");
    CHECK_EQ(hdf5::get<double>(stored.file(), "analysis/answer"), std::vector<double>{42});
    CHECK_EQ(hdf5::get<double>(stored.file(), "provenance/session-0/seconds/field"), std::vector<double>{0.5});
    Recorder resumed = Recorder::resume(path, some_scene(), few);
    CHECK(contains(message_of([&] { store(stored, add); }), "is being written"));
    add_until(resumed, 25);
    resumed.save(milestone(25));
    CHECK(numbers(path) == expected(25));
    CHECK_FALSE(hdf5::exists(ResultFile(path, "read").file(), "analysis"));
  }
}

TEST_CASE("a column that cannot be recorded is named") {
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

TEST_CASE("a resumed run's columns are those of the frames before") {
  const Folder folder;
  run(folder / "run.h5", 10, false);
  Recorder resumed = Recorder::resume(folder / "run.h5", some_scene(), few);
  Frame other = frame(10);
  other.columns[1].unit = "V";
  CHECK(contains(message_of([&] { resumed.add(other); }), "column `charge`"));
}
