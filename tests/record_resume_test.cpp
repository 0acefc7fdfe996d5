// Tests of resumed result files after kills, full disks and damage.
#include <doctest/doctest.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <functional>
#include <optional>
#include <random>

#include "solvers/error.hpp"
#include "src/analysis/packing.hpp"
#include "src/record/atomic_file.hpp"
#include "src/record/scene_change.hpp"
#include "src/record/seal.hpp"
#include "src/record/vtkhdf.hpp"
#include "src/version.hpp"
#include "tests/recorded_pair.hpp"

namespace record_resume_test {

using namespace lichtenberg;
using namespace lichtenberg::recorded_pair;

namespace {

/// Exit status of a child process that runs the action: 99 if it throws, 128 plus the signal's number if it crashes.
int in_child(const std::function<int()>& action) {
  const pid_t child = fork();
  if (child == 0) {
    int result = 99;
    if (const std::string message = message_of([&] { result = action(); }); !message.empty())
      std::fprintf(stderr, "%s\n", message.c_str());
    _exit(result);
  }
  int status = 0;
  waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

}  // namespace

TEST_CASE("Recorder::resume: continues at the end of the file, adds provenance") {
  const Folder folder;
  saved_run(folder / "run.h5", 2);
  Recorder resumed = Recorder::resume(folder / "run.h5", two_conductors());
  CHECK_EQ(resumed.saved_time(), 1);
  CHECK_EQ(resumed.frames(), 2);
  resumed.add(columns(frame(2)));
  Milestone last = milestone(2);
  last.summary = {{"energy", 2.5, "J"}};
  resumed.save(last);
  const hdf5::Handle file = hdf5::load(folder / "run.h5");
  CHECK_EQ(hdf5::get<std::int64_t>(file, "observables/connected/step"), std::vector<std::int64_t>{0, 1, 2});
  CHECK_EQ(hdf5::get<double>(file, "provenance/session-1/seconds/field"), std::vector<double>{0.5});
  CHECK_FALSE(hdf5::exists(file, "provenance/session-2"));
  CHECK_EQ(hdf5::get<double>(file, "summary/energy"), std::vector<double>{2.5});
}

TEST_CASE("Recorder::resume: columns that the file lacks are left out, one warning") {
  const Folder folder;
  saved_run(folder / "run.h5", 2);
  Recorder resumed = Recorder::resume(folder / "run.h5", two_conductors());
  Frame more = columns(frame(2));
  more.add_particles("gap", "m", std::vector<double>{1, 2});
  more.add_list("ends", "1", std::vector<int>{1, 2, 3});
  resumed.add(std::move(more));
  CHECK_NE(resumed.warning_of_columns().find("run.h5 was begun without ends, gap"), std::string::npos);
  resumed.save(milestone(2));
  const hdf5::Handle file = hdf5::load(folder / "run.h5");
  CHECK_EQ(hdf5::get<std::int64_t>(file, "observables/connected/step"), std::vector<std::int64_t>{0, 1, 2});
  CHECK_FALSE(hdf5::exists(file, "particles/conductors/gap"));
  CHECK_FALSE(hdf5::exists(file, "network/ends_end"));
}

TEST_CASE("Recorder::resume: another build of the program gives one warning") {
  const Folder folder;
  const std::string path = folder / "run.h5";
  saved_run(path, 2);
  CHECK_EQ(Recorder::resume(path, two_conductors()).warning(), "");
  const auto pages = std::make_shared<hdf5::Pages>(hdf5::pages_of(OpenFile(path)));
  {
    const hdf5::Handle session = hdf5::open_group(hdf5::open_in_memory(pages), "provenance/session-0");
    hdf5::check(H5Adelete(session, "commit"));
    hdf5::put_attribute(session, "commit", "0123456789ab");
  }
  write_sealed(path, *pages);
  {
    Recorder resumed = Recorder::resume(path, two_conductors());
    const std::string number = lichtenberg_version().number;
    CHECK_NE(resumed.warning().find("run.h5 was last continued by lichtenberg " + number + " (0123456789ab), not " +
                                    number + " ("),
             std::string::npos);
    resumed.save(milestone(2));
  }
  CHECK_EQ(Recorder::resume(path, two_conductors()).warning(), "");
}

TEST_CASE("Recorder::resume: frames after the last checkpoint are replaced") {
  const Folder folder;
  Recorder recorder = saved_run(folder / "run.h5", 2);
  analysis::ContactNetwork fewer = network_of_two();
  fewer.contacts.pop_back();
  recorder.add(columns_of(frame(2), fewer));
  recorder.add(columns(frame(3)));
  recorder.save_frames_alone();
  const auto steps = [&] {
    return hdf5::get<std::int64_t>(hdf5::load(folder / "run.h5"), "observables/connected/step");
  };
  CHECK_EQ(steps(), std::vector<std::int64_t>{0, 1, 2, 3});
  { const Recorder done = std::move(recorder); }
  Recorder resumed = Recorder::resume(folder / "run.h5", two_conductors());
  CHECK_EQ(resumed.saved_time(), 1);
  CHECK_EQ(resumed.frames(), 2);
  CHECK_EQ(resumed.checkpoint()->reals, milestone(1).checkpoint.reals);
  resumed.add(columns(frame(2)));
  resumed.save(milestone(2));
  CHECK_EQ(steps(), std::vector<std::int64_t>{0, 1, 2});
  saved_run(folder / "whole.h5", 3);
  const hdf5::Handle cut = hdf5::load(folder / "run.h5"), whole = hdf5::load(folder / "whole.h5");
  for (const std::string list : {"network/contacts", "network/contacts_end", "network/contacts_of_all_frames"})
    CHECK_EQ(hdf5::get<std::int64_t>(cut, list), hdf5::get<std::int64_t>(whole, list));
}

TEST_CASE("resumed result of grains: has the groups of a full run and its units") {
  const Folder folder;
  Scene grains = two_conductors();
  grains.reference = Reference{};
  const auto run = [&](const std::string& path, bool resumed) {
    std::optional<Recorder> recorder = Recorder::start(path, grains, masses, false);
    for (const int k : {0, 1}) {
      if (resumed && k == 1) {
        recorder.reset();
        recorder.emplace(Recorder::resume(path, grains));
      }
      recorder->add(columns(frame(k)));
      recorder->save(milestone(k));
    }
    return hdf5::load(path);
  };
  const hdf5::Handle whole = run(folder / "whole.h5", false), cut = run(folder / "cut.h5", true);
  CHECK_EQ(hdf5::names(cut), hdf5::names(whole));
  REQUIRE(hdf5::exists(cut, "reference"));
  CHECK_EQ(hdf5::get<double>(cut, "reference/d0"), std::vector<double>{Reference{}.length});
}

TEST_CASE("Recorder::resume: older files with constant box edges keep them") {
  const Folder folder;
  const std::string path = folder / "run.h5", edges = "particles/conductors/box/edges";
  Scene scene = two_conductors();
  for (const int side : {0, 1}) scene.domain.sides[side].periodic = true;
  {
    Recorder recorder = Recorder::start(path, scene, masses, false);
    recorder.add(columns(frame(0)));
    recorder.save(milestone(0));
  }
  const auto pages = std::make_shared<hdf5::Pages>(hdf5::pages_of(OpenFile(path)));
  {
    const hdf5::Handle file = hdf5::open_in_memory(pages);
    hdf5::check(H5Ldelete(file, edges.c_str(), H5P_DEFAULT));
    hdf5::put<double>(file, edges, std::array{0.05, 0.04, 1.5e-3}, {3}, "m");
  }
  write_sealed(path, *pages);
  Recorder resumed = Recorder::resume(path, scene);
  resumed.add(columns(frame(1)));
  resumed.save(milestone(1));
  const hdf5::Handle file = hdf5::load(path);
  CHECK_EQ(hdf5::get<double>(file, edges), std::vector<double>{0.05, 0.04, 1.5e-3});
  CHECK_EQ(hdf5::get<double>(file, "observables/energy/time"), std::vector<double>{0, 1});
}

TEST_CASE("Recorder::resume: accepts iteration times with unit 1 or without unit") {
  const Folder folder;
  const std::string path = folder / "run.h5";
  const auto iteration = [](double number) {
    Frame made = columns(frame(number));
    made.time_unit = "1";
    return made;
  };
  for (const bool written : {false, true}) {
    CAPTURE(written);
    {
      Recorder recorder = Recorder::start(path, two_conductors(), masses, true);
      recorder.add(iteration(0));
      recorder.save(milestone(0));
    }
    if (written) {
      const auto pages = std::make_shared<hdf5::Pages>(hdf5::pages_of(OpenFile(path)));
      {
        const hdf5::Handle file = hdf5::open_in_memory(pages);
        hdf5::put_attribute(hdf5::Handle(H5Dopen2(file, "observables/energy/time", H5P_DEFAULT)), "unit",
                            std::string("1"));
      }
      write_sealed(path, *pages);
    }
    Recorder resumed = Recorder::resume(path, two_conductors());
    resumed.add(iteration(1));
    resumed.save(milestone(1));
    CHECK_EQ(hdf5::get<double>(hdf5::load(path), "observables/energy/time"), std::vector<double>{0, 1});
  }
}

TEST_CASE("Recorder::resume: later frames delete the stored contacts of a packing") {
  const Folder folder;
  Milestone last = milestone(1);
  last.findings = {
      analysis::columns_of(analysis::Packing{.contacts = {{.particle = 0, .partner = 1}}, .rattler = {false, false}})};
  saved_run(folder / "run.h5", 2).save(last);
  CHECK(hdf5::exists(hdf5::load(folder / "run.h5"), "packing/contacts"));
  Recorder resumed = Recorder::resume(folder / "run.h5", two_conductors());
  resumed.add(columns(frame(2)));
  resumed.save(milestone(2));
  CHECK_FALSE(hdf5::exists(hdf5::load(folder / "run.h5"), "packing"));
}

TEST_CASE("Recorder::save: repeated saves do not enlarge the file") {
  const Folder folder;
  Recorder recorder = saved_run(folder / "run.h5", 2);
  Milestone m = milestone(1);
  m.field = laplace::Field{8, 8, 0.01, std::vector<double>(64, 1), std::vector<int>(64, -1)};
  recorder.save(m);
  const auto size = fs::file_size(folder / "run.h5");
  for (int k = 0; k < 20; ++k) recorder.save(m);
  CHECK_EQ(fs::file_size(folder / "run.h5"), size);
}

TEST_CASE("Recorder::start: existing file refused, or replaced at the first save") {
  const Folder folder;
  const std::string path = folder / "run.h5";
  write_bytes(path, {'o', 'l', 'd'});
  CHECK_THROWS_AS(Recorder::start(path, two_conductors(), masses, false), InputError);
  Recorder recorder = Recorder::start(path, two_conductors(), masses, true);
  recorder.add(columns_of(frame(0), {}));
  CHECK_EQ(bytes_of(path), std::vector<char>{'o', 'l', 'd'});
  recorder.save(milestone(0));
  CHECK_EQ(hdf5::shape(hdf5::load(path), "observables/energy/value"), hdf5::Shape{1});
}

TEST_CASE("Recorder::start: a path that cannot be written is refused at once") {
  const Folder folder;
  CHECK_THROWS_AS(Recorder::start(folder / "missing/run.h5", two_conductors(), masses, false), InputError);
  fs::create_directory(folder / "run.h5");
  CHECK_THROWS_AS(Recorder::start(folder / "run.h5", two_conductors(), masses, true), InputError);
}

// A file-size limit fails a write as a full disk does, with another error number. The limit admits nothing, half of the
// new version, or all except its last byte.
TEST_CASE("Recorder::save on a full disk: one message, the last version is kept") {
  const Folder folder;
  const std::string path = folder / "run.h5";
  saved_run(path, 2);
  const std::vector<char> before = bytes_of(path);
  const auto save_more = [&](rlim_t limit) {
    return in_child([&] {
      Recorder recorder = Recorder::resume(path, two_conductors());
      for (int k = 2; k < 40; ++k) recorder.add(columns(frame(k)));
      signal(SIGXFSZ, SIG_IGN);
      const rlimit at_most{limit, limit};
      setrlimit(RLIMIT_FSIZE, &at_most);
      const std::string message = message_of([&] { recorder.save(milestone(39)); });
      if (message.empty()) return 0;
      return message.find("run.h5 cannot be written (File too large); the state saved up to t = 1 s is intact") !=
                     std::string::npos
                 ? 3
                 : 4;
    });
  };
  REQUIRE_EQ(save_more(RLIM_INFINITY), 0);
  const auto size = fs::file_size(path);
  write_bytes(path, before);
  for (const rlim_t limit : {rlim_t{0}, size / 2, size - 1}) {
    CHECK_EQ(save_more(limit), 3);
    CHECK_EQ(bytes_of(path), before);
    CHECK(std::distance(fs::directory_iterator(fs::path(path).parent_path()), {}) == 1);  // There is no partial file.
  }
}

TEST_CASE("write_atomically: two writers of one file do not mix their data") {
  const Folder folder;
  const std::string path = folder / "shared";
  constexpr std::size_t size = 1 << 16;
  const auto write_often = [&](std::byte letter) {
    const pid_t child = fork();
    if (child != 0) return child;
    const std::vector<std::byte> bytes(size, letter);
    const bool failed = !message_of([&] {
                           for (int k = 0; k < 40; ++k) write_atomically(path, bytes);
                         }).empty();
    _exit(failed ? 1 : 0);
  };
  for (const pid_t child : {write_often(std::byte{'a'}), write_often(std::byte{'b'})}) {
    int status = 0;
    waitpid(child, &status, 0);
    CHECK(WIFEXITED(status));
    CHECK(WEXITSTATUS(status) == 0);
    const std::vector<char> found = bytes_of(path);
    CHECK(found.size() == size);
    CHECK(std::ranges::count(found, found.front()) == size);
  }
  CHECK(std::distance(fs::directory_iterator(fs::path(path).parent_path()), {}) == 1);
}

// Each version's checkpoint contains its number of frames; a mixture of two versions would disagree.
TEST_CASE("Recorder::save: a kill at any moment leaves a complete version") {
  const Folder folder;
  const std::string path = folder / "run.h5";
  std::mt19937 random(11);
  for (int trial = 0; trial < 20; ++trial) {
    fs::remove(path);
    saved_run(path, 1);
    const pid_t child = fork();
    if (child == 0) {
      message_of([&] {
        Recorder recorder = Recorder::resume(path, two_conductors());
        for (int k = 1;; ++k) {
          recorder.add(columns(frame(k)));
          recorder.save(milestone(k));
        }
      });
      _exit(99);
    }
    usleep(std::uniform_int_distribution<useconds_t>(0, 40000)(random));
    kill(child, SIGKILL);
    int status = 0;
    waitpid(child, &status, 0);
    CHECK(WIFSIGNALED(status));  // The process was still saving.
    const Recorder resumed = Recorder::resume(path, two_conductors());
    CHECK_EQ(resumed.checkpoint()->reals.at("mark")[0], *resumed.saved_time());
  }
}

TEST_CASE("Recorder::resume: a file cut at any length is refused as damaged") {
  const Folder folder;
  saved_run(folder / "run.h5", 3);
  const std::vector<char> whole = bytes_of(folder / "run.h5");
  for (size_t length = 100; length < whole.size(); length += 997) {
    write_bytes(folder / "cut.h5", {whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(length)});
    CHECK_THROWS_AS(Recorder::resume(folder / "cut.h5", two_conductors()), Failure);
  }
  CHECK_NE(message_of([&] { Recorder::resume(folder / "cut.h5", two_conductors()); }).find("cut.h5 is damaged"),
           std::string::npos);
}

TEST_CASE("Recorder::resume: a file of another kind or format is refused") {
  const Folder folder;
  const auto resume = [&](const std::string& name) {
    const std::string path = folder / name;
    CHECK_THROWS_AS(Recorder::resume(path, two_conductors()), InputError);
    return message_of([&] { Recorder::resume(path, two_conductors()); });
  };
  CHECK_NE(resume("missing.h5").find("does not exist"), std::string::npos);
  write_bytes(folder / "text.h5", {'t', 'e', 'x', 't'});
  CHECK_NE(resume("text.h5").find("is no HDF5 file"), std::string::npos);
  write_field_vtkhdf(folder / "field.h5", laplace::Field{1, 1, 1, {0}, {-1}});
  CHECK_NE(resume("field.h5").find("was not written by"), std::string::npos);
  const hdf5::Handle old = hdf5::create_in_memory();
  hdf5::put_attribute(old, "lichtenberg_result", 0);
  write_atomically(folder / "old.h5", hdf5::image(old));
  CHECK_NE(resume("old.h5").find("has result format 0"), std::string::npos);
  // There is no list of formats that can only be read.
  CHECK_EQ(resume("old.h5").find("can be resumed"), std::string::npos);
}

TEST_CASE("Recorder::resume: a changed title is refused, a changed [stop] accepted") {
  const Folder folder;
  saved_run(folder / "run.h5", 1);
  Scene other = two_conductors();
  other.text = "title = \"another pair\"\n";
  CHECK_THROWS_AS(Recorder::resume(folder / "run.h5", other), InputError);
  CHECK_NE(message_of([&] { Recorder::resume(folder / "run.h5", other); }).find("pair.toml: key `title` has changed"),
           std::string::npos);
  other.text = "title = \"a pair\"\n[stop]\ntime = 2.0\n";
  CHECK_EQ(Recorder::resume(folder / "run.h5", other).saved_time(), 0);
}

TEST_CASE("first_change of two scenes: first different key outside [output], [stop]") {
  const std::string scene = "a = 1\n[medium]\nviscosity = 0.7\n[[conductor]]\nx = 1\n[stop]\ntime = 1\n";
  CHECK_EQ(first_change(scene, scene), "");
  CHECK_EQ(first_change(scene,
                        "# new\n[output]\nevery = 3\n[medium]\nviscosity = 0.7 # same\n[[conductor]]\nx = 1\n"
                        "[stop]\ntime = 2\n"),
           "a");
  CHECK_EQ(first_change(scene, "a = 1\n[output]\nevery = 3\n[[conductor]]\nx = 1\n[medium]\nviscosity = 0.7 # same\n"),
           "");
  CHECK_EQ(first_change(scene, "a = 1\n[medium]\nviscosity = 0.8\n[[conductor]]\nx = 1\n"), "medium.viscosity");
  CHECK_EQ(first_change(scene, "a = 1\n[medium]\nviscosity = 0.7\n[[conductor]]\nx = 1\n[[conductor]]\nx = 2\n"),
           "conductor");
  CHECK_EQ(first_change(scene, "a = 1\n[medium]\nviscosity = 0.7\ndepth = 2\n[[conductor]]\nx = 1\n"), "medium.depth");
}

TEST_CASE("first_change of two scenes: former names of keys count as equal") {
  const std::string before = "[reference]\nlength = 1e-3\n[effects.coulomb]\nstrength = 2.0\n";
  CHECK_EQ(first_change(before, "[units]\nlength = 1e-3\n[effects.coulomb]\ncoupling_constant = 2.0\n"), "");
  CHECK_EQ(first_change(before, "[units]\nlength = 1e-3\n[effects.coulomb]\ncoupling_constant = 3.0\n"),
           "effects.coulomb.coupling_constant");
}

TEST_CASE("first_change: iterations, tolerance, threads of [minimize] may change") {
  const std::string now = "[minimize]\nmax_iterations = 9\nforce_tolerance = 1e-9\nthreads = 2\n";
  CHECK_EQ(first_change("", now), "");
  CHECK_EQ(first_change("[minimize]\nmax_iterations = 5\n", now), "");
  CHECK_EQ(first_change(now, now + "method = \"fire\"\n"), "minimize");
  CHECK_EQ(first_change("[minimize]\nmethod = \"lbfgs\"\n", now + "method = \"fire\"\n"), "minimize.method");
  CHECK_EQ(first_change("[minimize]\nmethod = \"fire\"\n", now + "method = \"fire\"\nstep = 1e-3\n"), "minimize.step");
}

}  // namespace record_resume_test
