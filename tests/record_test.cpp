// Result files: what stands in them, and that neither a kill, a full disk nor a damaged file costs more than one
// sentence.
#include <doctest/doctest.h>
#include <petscsys.h>  // the MPI that PETSc stands on
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <limits>
#include <random>

#include "solvers/error.hpp"
#include "src/analysis/packing.hpp"
#include "src/effects/contact_discharge.hpp"
#include "src/record/atomic_file.hpp"
#include "src/record/layout.hpp"
#include "src/record/provenance.hpp"
#include "src/record/recorder.hpp"
#include "src/record/scene_change.hpp"
#include "src/record/vtkhdf.hpp"
#include "tests/folder.hpp"
#include "tests/frames.hpp"
#include "tests/message.hpp"

using namespace lichtenberg;
namespace fs = std::filesystem;

namespace {

Scene two_conductors() {
  Scene scene;
  scene.path = "pair.toml";
  scene.title = "a pair";
  scene.text = "title = \"a pair\"\n[stop]\ntime = 1.0\n";
  scene.seed = 18446744073709551615u;  // the largest there is
  scene.domain.size = {0.05, 0.04};
  scene.domain.sides[2] = {true, -3.0};
  scene.medium = {4e-11, 0.7, 1.5e-3};
  scene.electrodes.push_back({"needle", Disk{{0.02, 0}, 0.001}, 5});
  scene.electrodes.push_back({"rod", Bar{{0, 0}, {0.01, 0}, 0.002}, 6});
  scene.electrodes.push_back({"dish", Ring{{0.025, 0.02}, 0.02}, 7});
  scene.conductors.push_back({.position = {0.01, 0.02}, .radius = 0.001});
  scene.conductors.push_back({.position = {0.03, 0.02}, .radius = 0.0005});
  scene.effects.add(effects::ContactDischargeOptions{0.00075, 0.01});
  return scene;
}

const std::vector<double> masses{3e-5, 4e-6};

ConductorFrame frame(double time) {
  ConductorFrame f;
  f.time = time;
  f.position = {{0.01 + time, 0.02}, {0.03, 0.02 - time}};
  f.velocity = {{1, 2}, {3, 4}};
  f.force = {{5e-6, 0}, {0, 6e-6}};
  f.charge = {1e-10, 2e-10};
  f.potential = {10 + time, 20};
  f.group = {0, 1};
  f.energy = 1e-6 * time;
  f.charge_held = 3e-10;
  f.charge_fed = 4e-10;
  f.charge_drained = 1e-10;
  f.field_solves = 7;
  f.iterations = 70;
  return f;
}

analysis::ContactNetwork network_of_two() {
  analysis::ContactNetwork net;
  net.contacts = {{0, analysis::to_ground}, {0, 1}};
  net.successor = {analysis::to_ground, 0};
  net.degrees.connected = 2;
  net.degrees.number = {0, 1, 1};
  return net;
}

Frame columns(const ConductorFrame& f) { return columns_of(f, network_of_two()); }

Milestone milestone(double mark) {
  Milestone m;
  m.checkpoint.reals["mark"] = {mark};
  m.seconds["field"] = 0.5;
  return m;
}

/// A run of frames 0, 1, ..., n - 1 (s), saved once.
Recorder saved_run(const std::string& path, int n) {
  Recorder recorder = Recorder::start(path, two_conductors(), masses, false);
  for (int k = 0; k < n; ++k) recorder.add(columns(frame(k)));
  recorder.save(milestone(n - 1));
  return recorder;
}

std::vector<char> bytes_of(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

void write_bytes(const std::string& path, const std::vector<char>& bytes) {
  std::ofstream(path, std::ios::binary).write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
}

/// Exit status of a child process that runs the action: 99 if it throws, 128 and the signal's number if it crashes.
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

std::string unit_of(const hdf5::Handle& file, const std::string& path) {
  const hdf5::Handle attribute(H5Aopen_by_name(file, path.c_str(), "unit", H5P_DEFAULT, H5P_DEFAULT));
  const hdf5::Handle type(H5Aget_type(attribute));
  char* text = nullptr;
  hdf5::check(H5Aread(attribute, type, &text));
  const std::string unit = text;
  H5free_memory(text);
  return unit;
}

bool is_group(hid_t parent, const std::string& name) {
  const hdf5::Handle object(H5Oopen(parent, name.c_str(), H5P_DEFAULT));
  return H5Iget_type(object) == H5I_GROUP;
}

bool is_number(hid_t parent, const std::string& name) {
  const hdf5::Handle dataset(H5Dopen2(parent, name.c_str(), H5P_DEFAULT)), type(H5Dget_type(dataset));
  return H5Tget_class(type) != H5T_STRING;
}

void for_each_dataset(hid_t group, const std::string& path, const std::function<void(const std::string&)>& visit) {
  for (const std::string& name : hdf5::names(group)) {
    if (is_group(group, name))
      for_each_dataset(hdf5::Handle(H5Gopen2(group, name.c_str(), H5P_DEFAULT)), path + "/" + name, visit);
    else if (is_number(group, name))
      visit(path + "/" + name);
  }
}

}  // namespace

TEST_CASE("frames are elements of H5MD that share one step and one time") {
  const Folder folder;
  saved_run(folder / "run.h5", 3);
  const hdf5::Handle file = hdf5::load(folder / "run.h5");
  CHECK_EQ(hdf5::get<std::int64_t>(file, "particles/conductors/position/step"), std::vector<std::int64_t>{0, 1, 2});
  CHECK_EQ(hdf5::get<double>(file, "observables/energy/time"), std::vector<double>{0, 1, 2});
  H5O_info_t a, b;
  hdf5::check(H5Oget_info_by_name(file, "particles/conductors/position/time", &a, H5P_DEFAULT));
  hdf5::check(H5Oget_info_by_name(file, "observables/endpoints/time", &b, H5P_DEFAULT));
  CHECK_EQ(a.addr, b.addr);
}

TEST_CASE("what drained to each terminal stands in the file under its name, and nothing does without terminals") {
  const Folder folder;
  Recorder recorder = Recorder::start(folder / "run.h5", two_conductors(), masses, false);
  for (int k = 0; k < 2; ++k) {
    ConductorFrame f = frame(k);
    f.terminals = {{.name = "left", .potential = 5, .drained = 1e-10 * k}, {.name = "right", .drained = 3e-10}};
    f.energy_balance.emplace();
    recorder.add(columns_of(f, {}));
  }
  recorder.save(milestone(1));
  const hdf5::Handle file = hdf5::load(folder / "run.h5");
  const hdf5::Handle element = hdf5::open_group(file, "observables/charge_drained_by_terminal");
  CHECK_EQ(hdf5::get<double>(element, "value"), std::vector<double>{0, 3e-10, 1e-10, 3e-10});
  CHECK_EQ(hdf5::shape(element, "value"), hdf5::Shape{2, 2});
  for (const std::string name : {"charge_drained_by_terminal", "charge_delivered", "terminal_potential", "current"})
    CHECK_EQ(hdf5::text_attribute(hdf5::open_group(file, "observables/" + name), "terminals"),
             std::vector<std::string>{"left", "right"});
  saved_run(folder / "without.h5", 2);
  CHECK_FALSE(hdf5::exists(hdf5::load(folder / "without.h5"), "observables/charge_drained_by_terminal"));
}

TEST_CASE("vectors are in space, with z = 0, and carry their units") {
  const Folder folder;
  saved_run(folder / "run.h5", 2);
  const hdf5::Handle file = hdf5::load(folder / "run.h5");
  CHECK_EQ(hdf5::shape(file, "particles/conductors/position/value"), hdf5::Shape{2, 2, 3});
  CHECK_EQ(hdf5::get<double>(file, "particles/conductors/position/value"),
           std::vector<double>{0.01, 0.02, 0, 0.03, 0.02, 0, 0.01 + 1, 0.02, 0, 0.03, 0.02 - 1, 0});
  const hdf5::Handle box(H5Gopen2(file, "particles/conductors/box", H5P_DEFAULT));
  CHECK_EQ(hdf5::integer_attribute(box, "dimension"), 3);
  CHECK_EQ(unit_of(file, "particles/conductors/position/value"), "m");
  CHECK_EQ(unit_of(file, "particles/conductors/velocity/value"), "m s-1");
  CHECK_EQ(unit_of(file, "particles/conductors/force/value"), "N");
  CHECK_EQ(unit_of(file, "particles/conductors/potential/value"), "V");
  CHECK_EQ(unit_of(file, "particles/conductors/position/time"), "s");
}

TEST_CASE("a periodic box has its edges, as H5MD asks for") {
  const Folder folder;
  const std::string path = folder / "box.h5";
  Scene scene = two_conductors();
  scene.domain.size.z = 0.03;
  for (const int side : {0, 1, 4, 5}) scene.domain.sides[side].periodic = true;
  Recorder::start(path, scene, masses, false).save(milestone(0));
  const hdf5::Handle file = hdf5::load(path);
  const hdf5::Handle box(H5Gopen2(file, "particles/conductors/box", H5P_DEFAULT));
  CHECK_EQ(hdf5::text_attribute(box, "boundary"), std::vector<std::string>{"periodic", "none", "periodic"});
  CHECK_EQ(hdf5::get<double>(box, "edges"), std::vector<double>{0.05, 0.04, 0.03});
  CHECK_EQ(hdf5::text_attribute(hdf5::open_group(file, "scene/domain"), "sides").back(), "back");
}

TEST_CASE("a file says that its units are SI, and of grains that they are not") {
  const Folder folder;
  Scene grains = two_conductors();
  grains.reference = Reference{};
  const auto system = [&](const std::string& path, const Scene& scene) {
    Recorder::start(path, scene, masses, false).save(milestone(0));
    const hdf5::Handle file = hdf5::load(path);
    return hdf5::text_attribute(hdf5::open_group(file, "h5md/modules/units"), "system");
  };
  CHECK_EQ(system(folder / "conductors.h5", two_conductors()), std::vector<std::string>{"SI"});
  CHECK_EQ(system(folder / "grains.h5", grains), std::vector<std::string>{"reduced"});
}

TEST_CASE("every number but steps and the checkpoint's arrays has a unit") {
  const Folder folder;
  Recorder recorder = Recorder::start(folder / "run.h5", two_conductors(), masses, false);
  recorder.add(columns(frame(0)));
  Milestone all = milestone(0);
  all.field = laplace::Field{2, 1, 0.01, {1, 2}, {-1, 0}};
  all.summary = {{"energy", 1, "J"}};
  recorder.save(all);
  const hdf5::Handle file = hdf5::load(folder / "run.h5");
  int datasets = 0;
  for_each_dataset(file, "", [&](const std::string& path) {
    ++datasets;
    if (path.ends_with("/step") || path.starts_with("/checkpoint/")) return;
    CAPTURE(path);
    CHECK(H5Aexists_by_name(file, path.c_str(), "unit", H5P_DEFAULT) > 0);
  });
  CHECK_GT(datasets, 60);
}

TEST_CASE("the scene stands in the file, with the geometry that a picture needs") {
  const Folder folder;
  saved_run(folder / "run.h5", 1);
  const hdf5::Handle file = hdf5::load(folder / "run.h5");
  CHECK_EQ(hdf5::get_text(file, "scene/text"), two_conductors().text);
  CHECK_EQ(hdf5::get<std::uint64_t>(file, "scene/seed")[0], 18446744073709551615u);
  CHECK_EQ(hdf5::get<double>(file, "scene/domain/size"), std::vector<double>{0.05, 0.04});
  CHECK_EQ(hdf5::get<std::int32_t>(file, "scene/domain/side_is_electrode"), std::vector<std::int32_t>{0, 0, 1, 0});
  CHECK_EQ(hdf5::get<double>(file, "scene/domain/side_potential"), std::vector<double>{0, 0, -3, 0});
  CHECK_EQ(hdf5::get<double>(file, "scene/electrodes/0/radius"), std::vector<double>{0.001});
  CHECK_EQ(hdf5::get<double>(file, "scene/electrodes/1/to"), std::vector<double>{0.01, 0});
  CHECK_EQ(hdf5::get<double>(file, "scene/electrodes/2/potential"), std::vector<double>{7});
  CHECK_EQ(hdf5::get<double>(file, "scene/contact_gap"), std::vector<double>{0.00075});
  CHECK_EQ(hdf5::get<double>(file, "particles/conductors/radius"), std::vector<double>{0.001, 0.0005});
  CHECK_EQ(hdf5::get<double>(file, "particles/conductors/mass"), masses);
  // One species a radius, in ascending order.
  CHECK_EQ(hdf5::get<std::int32_t>(file, "particles/conductors/species"), std::vector<std::int32_t>{1, 0});
  CHECK_EQ(hdf5::get<double>(file, "parameters/vmd_structure/radius"), std::vector<double>{0.0005, 0.001});
}

TEST_CASE("the network stands in the file frame by frame, its contacts for the last") {
  const Folder folder;
  Recorder recorder = saved_run(folder / "run.h5", 2);
  const analysis::ContactNetwork loose{{{1, analysis::to_ground}}, {analysis::unconnected, analysis::to_ground}, {}};
  recorder.add(columns_of(frame(2), loose));
  recorder.save(milestone(2));
  const hdf5::Handle file = hdf5::load(folder / "run.h5");
  CHECK_EQ(hdf5::get<std::int32_t>(file, "particles/conductors/successor/value"),
           std::vector<std::int32_t>{-1, 0, -1, 0, -2, -1});
  CHECK_EQ(hdf5::get<std::int64_t>(file, "observables/endpoints/value"), std::vector<std::int64_t>{1, 1, 0});
  CHECK_EQ(hdf5::get<std::int32_t>(file, "network/contacts"), std::vector<std::int32_t>{1, -1});
}

TEST_CASE("a neutral scene without contacts has neither charges nor a network") {
  const Folder folder;
  Recorder recorder = Recorder::start(folder / "run.h5", two_conductors(), masses, false);
  ConductorFrame neutral = frame(0);
  neutral.charge.clear();
  neutral.potential.clear();
  recorder.add(columns_of(neutral, {}));
  recorder.save(milestone(0));
  const hdf5::Handle file = hdf5::load(folder / "run.h5");
  CHECK(hdf5::exists(file, "particles/conductors/position"));
  CHECK_FALSE(hdf5::exists(file, "particles/conductors/charge"));
  CHECK_FALSE(hdf5::exists(file, "particles/conductors/successor"));
}

TEST_CASE("frames reach the disk with the checkpoint, not before") {
  const Folder folder;
  Recorder recorder = saved_run(folder / "run.h5", 2);
  CHECK_EQ(recorder.saved_time(), 1);
  recorder.add(columns(frame(2)));
  CHECK_EQ(recorder.frames(), 3);
  CHECK_EQ(hdf5::shape(hdf5::load(folder / "run.h5"), "observables/energy/value"), hdf5::Shape{2});
  recorder.save(milestone(2));
  const hdf5::Handle file = hdf5::load(folder / "run.h5");
  CHECK_EQ(hdf5::get<double>(file, "particles/conductors/potential/value"),
           std::vector<double>{10, 20, 11, 20, 12, 20});
  CHECK_EQ(hdf5::get<double>(file, "checkpoint/reals/mark"), std::vector<double>{2});
}

TEST_CASE("a checkpoint comes back bit for bit") {
  const Folder folder;
  std::optional<Recorder> recorder = Recorder::start(folder / "run.h5", two_conductors(), masses, false);
  recorder->add(columns_of(frame(0), {}));
  Milestone m;
  m.checkpoint.reals["odd"] = {0.1, -0.0, std::numeric_limits<double>::denorm_min(),
                               -std::numeric_limits<double>::infinity()};
  m.checkpoint.reals["none"] = {};
  m.checkpoint.reals["old"] = {1, 2, 3};
  m.checkpoint.integers["large"] = {std::numeric_limits<std::int64_t>::min(), -1};
  recorder->save(m);
  m.checkpoint.reals.erase("old");  // and of another shape
  m.checkpoint.reals["odd"].push_back(4);
  recorder->save(m);
  recorder.reset();
  const Recorder resumed = Recorder::resume(folder / "run.h5", two_conductors());
  REQUIRE(resumed.checkpoint());
  CHECK_EQ(resumed.checkpoint()->reals, m.checkpoint.reals);
  CHECK(std::signbit(resumed.checkpoint()->reals.at("odd")[1]));
  CHECK_EQ(resumed.checkpoint()->integers, m.checkpoint.integers);
}

TEST_CASE("a resumed run goes on where the file ends and adds its own provenance") {
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

TEST_CASE("a resumed run's file holds what an uninterrupted one's does, what grains' units are among it") {
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

TEST_CASE("contacts of a packing that was at rest do not stand beside the frames of one that goes on") {
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

TEST_CASE("saving the same again does not let the file grow") {
  const Folder folder;
  Recorder recorder = saved_run(folder / "run.h5", 2);
  Milestone m = milestone(1);
  m.field = laplace::Field{8, 8, 0.01, std::vector<double>(64, 1), std::vector<int>(64, -1)};
  recorder.save(m);
  const auto size = fs::file_size(folder / "run.h5");
  for (int k = 0; k < 20; ++k) recorder.save(m);
  CHECK_EQ(fs::file_size(folder / "run.h5"), size);
}

TEST_CASE("an existing file is refused, and overwritten only by the first save") {
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

TEST_CASE("a place that cannot be written is refused before any work starts") {
  const Folder folder;
  CHECK_THROWS_AS(Recorder::start(folder / "missing/run.h5", two_conductors(), masses, false), InputError);
  fs::create_directory(folder / "run.h5");
  CHECK_THROWS_AS(Recorder::start(folder / "run.h5", two_conductors(), masses, true), InputError);
}

// A file-size limit fails a write just as a full disk does, only with another error number. The limit is set so low
// that nothing fits, that half of the new version fits, and that all but its last byte fits.
TEST_CASE("a full disk costs one sentence and leaves the last good version") {
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
      return message.find("run.h5 cannot be written (File too large); what was saved up to t = 1 s stands") !=
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
    CHECK(std::distance(fs::directory_iterator(fs::path(path).parent_path()), {}) == 1);  // no partial file
  }
}

TEST_CASE("two writers of one file do not mix") {
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

// Each version's checkpoint says how many frames it was written with: a mixture of two versions would not agree.
TEST_CASE("a kill at any moment leaves a whole version") {
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
    CHECK(WIFSIGNALED(status));  // it was still saving
    const Recorder resumed = Recorder::resume(path, two_conductors());
    CHECK_EQ(resumed.checkpoint()->reals.at("mark")[0], *resumed.saved_time());
  }
}

TEST_CASE("a truncated file is damaged, wherever it was cut") {
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

TEST_CASE("what is no result file of this format cannot be resumed") {
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
  CHECK_EQ(resume("old.h5").find("can be resumed"), std::string::npos);  // no list of those that are only read
}

TEST_CASE("a run is resumed with the scene it was started with") {
  const Folder folder;
  saved_run(folder / "run.h5", 1);
  Scene other = two_conductors();
  other.text = "title = \"another pair\"\n";
  CHECK_THROWS_AS(Recorder::resume(folder / "run.h5", other), InputError);
  CHECK_NE(message_of([&] { Recorder::resume(folder / "run.h5", other); }).find("pair.toml: key `title` is not what"),
           std::string::npos);
  other.text = "title = \"a pair\"\n[stop]\ntime = 2.0\n";
  CHECK_EQ(Recorder::resume(folder / "run.h5", other).saved_time(), 0);
}

TEST_CASE("the first change of a scene is named; comments, order, [stop], [output] and [network] do not count") {
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

TEST_CASE("a minimization may go on with more iterations, another tolerance and other threads, and with nothing else") {
  const std::string now = "[minimize]\nmax_iterations = 9\nforce_tolerance = 1e-9\nthreads = 2\n";
  CHECK_EQ(first_change("", now), "");
  CHECK_EQ(first_change("[minimize]\nmax_iterations = 5\n", now), "");
  CHECK_EQ(first_change(now, now + "method = \"fire\"\n"), "minimize");
  CHECK_EQ(first_change("[minimize]\nmethod = \"lbfgs\"\n", now + "method = \"fire\"\n"), "minimize.method");
  CHECK_EQ(first_change("[minimize]\nmethod = \"fire\"\n", now + "method = \"fire\"\nstep = 1e-3\n"), "minimize.step");
}

TEST_CASE("a field becomes VTKHDF image data, once") {
  const Folder folder;
  const std::string path = folder / "field.vtkhdf";
  write_field_vtkhdf(path, laplace::Field{3, 2, 0.5, {1, 2, 3, 4, 5, 6}, {-1, -1, 0, 0, 1, 1}});
  const hdf5::Handle file = hdf5::load(path);
  CHECK_EQ(hdf5::shape(file, "VTKHDF/PointData/potential"), hdf5::Shape{2, 2, 3});  // two layers, rows, columns
  CHECK_EQ(hdf5::get<double>(file, "VTKHDF/PointData/potential"),
           std::vector<double>{1, 2, 3, 4, 5, 6, 1, 2, 3, 4, 5, 6});
  CHECK_EQ(hdf5::get<std::int32_t>(file, "VTKHDF/PointData/body"),
           std::vector<std::int32_t>{-1, -1, 0, 0, 1, 1, -1, -1, 0, 0, 1, 1});
  const hdf5::Handle image(H5Gopen2(file, "VTKHDF", H5P_DEFAULT));
  const hdf5::Handle extent(H5Aopen(image, "WholeExtent", H5P_DEFAULT));
  std::array<int, 6> points{};  // indices of the first and the last, along x, y and z
  hdf5::check(H5Aread(extent, H5T_NATIVE_INT, points.data()));
  CHECK_EQ(points, std::array<int, 6>{0, 2, 0, 1, 0, 1});
  const auto before = bytes_of(path);
  CHECK_THROWS_AS(write_field_vtkhdf(path, laplace::Field{1, 1, 1, {0}, {-1}}), InputError);
  CHECK_EQ(bytes_of(path), before);
}

TEST_CASE("HDF5 leaves MPI alone") {
  const Folder folder;
  saved_run(folder / "run.h5", 1);
  int initialized = 1;
  MPI_Initialized(&initialized);
  CHECK_EQ(initialized, 0);
}

TEST_CASE("the environment's options for PETSc are part of where a run came from") {
  setenv("PETSC_OPTIONS", "-field_ksp_max_it 77", 1);
  CHECK(provenance().petsc_options == "-field_ksp_max_it 77");
  unsetenv("PETSC_OPTIONS");
  CHECK(provenance().petsc_options.empty());
}
