// Tests of the content of result files.
#include <doctest/doctest.h>
#include <petscsys.h>  // The MPI library that PETSc uses.

#include <array>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <limits>
#include <optional>

#include "solvers/error.hpp"
#include "src/record/provenance.hpp"
#include "src/record/result.hpp"
#include "src/record/vtkhdf.hpp"
#include "tests/recorded_pair.hpp"

namespace record_test {

using namespace lichtenberg;
using namespace lichtenberg::recorded_pair;

namespace {

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

TEST_CASE("result frames: H5MD elements share one step and one time array") {
  const Folder folder;
  saved_run(folder / "run.h5", 3);
  const hdf5::Handle file = hdf5::load(folder / "run.h5");
  CHECK_EQ(hdf5::get<std::int64_t>(file, "particles/conductors/position/step"), std::vector<std::int64_t>{0, 1, 2});
  CHECK_EQ(hdf5::get<double>(file, "observables/energy/time"), std::vector<double>{0, 1, 2});
  hobj_ref_t a = 0, b = 1;  // addresses in the file
  hdf5::check(H5Rcreate(&a, file, "particles/conductors/position/time", H5R_OBJECT, -1));
  hdf5::check(H5Rcreate(&b, file, "observables/endpoints/time", H5R_OBJECT, -1));
  CHECK_EQ(a, b);
}

TEST_CASE("result terminals: collected charges by name, absent without terminals") {
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

TEST_CASE("result vectors: three components, z = 0 in the plane, with units") {
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

TEST_CASE("result box: a periodic axis gives a matrix of edges for each frame") {
  const Folder folder;
  const std::string path = folder / "box.h5";
  Scene scene = two_conductors();
  scene.electrodes.clear();  // Electrodes have no third dimension.
  scene.domain.size.z = 0.03;
  for (const int side : {0, 1, 4, 5}) scene.domain.sides[side].periodic = true;
  Recorder recorder = Recorder::start(path, scene, masses, false);
  for (const int k : {0, 1}) recorder.add(columns(frame(k)));
  recorder.save(milestone(1));
  const hdf5::Handle file = hdf5::load(path);
  const hdf5::Handle box(H5Gopen2(file, "particles/conductors/box", H5P_DEFAULT));
  CHECK_EQ(hdf5::text_attribute(box, "boundary"), std::vector<std::string>{"periodic", "none", "periodic"});
  // H5MD 1.1: rows are the vectors of the box; step and time are those of the positions.
  CHECK_EQ(hdf5::shape(box, "edges/value"), hdf5::Shape{2, 3, 3});
  CHECK_EQ(hdf5::get<double>(box, "edges/value"), std::vector<double>{0.05, 0, 0, 0, 0.04, 0, 0, 0, 0.03,  //
                                                                      0.05, 0, 0, 0, 0.04, 0, 0, 0, 0.03});
  CHECK_EQ(unit_of(file, "particles/conductors/box/edges/value"), "m");
  CHECK_EQ(hdf5::get<double>(box, "edges/time"), std::vector<double>{0, 1});
  CHECK_EQ(hdf5::get<std::int64_t>(box, "edges/step"), std::vector<std::int64_t>{0, 1});
  CHECK_EQ(hdf5::text_attribute(hdf5::open_group(file, "scene/domain"), "sides").back(), "back");
}

TEST_CASE("result box: without a periodic axis there are no edges") {
  const Folder folder;
  saved_run(folder / "run.h5", 1);
  CHECK_FALSE(hdf5::exists(hdf5::load(folder / "run.h5"), "particles/conductors/box/edges"));
}

TEST_CASE("result time: counts of iterations have no unit") {
  const Folder folder;
  Recorder recorder = Recorder::start(folder / "run.h5", two_conductors(), masses, false);
  Frame first = columns(frame(0));
  first.time_unit = "1";
  recorder.add(first);
  recorder.save(milestone(0));
  const hdf5::Handle file = hdf5::load(folder / "run.h5");
  CHECK_EQ(H5Aexists_by_name(file, "particles/conductors/position/time", "unit", H5P_DEFAULT), 0);
}

TEST_CASE("result units: SI for conductors, reduced units for grains") {
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

TEST_CASE("result units: all numbers have one except steps and checkpoint arrays") {
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

TEST_CASE("result scene: its text and the geometry for pictures are stored") {
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
  // One species per radius, in ascending order.
  CHECK_EQ(hdf5::get<std::int32_t>(file, "particles/conductors/species"), std::vector<std::int32_t>{1, 0});
  CHECK_EQ(hdf5::get<double>(file, "parameters/vmd_structure/radius"), std::vector<double>{0.0005, 0.001});
}

TEST_CASE("result network: successors for each frame, contacts for the last one") {
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

TEST_CASE("result without charges and contacts: no charge or network columns") {
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

TEST_CASE("result frames: written with the checkpoint and not earlier") {
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

TEST_CASE("result checkpoint: reading it back gives identical bits") {
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
  m.checkpoint.reals.erase("old");  // The array has another shape.
  m.checkpoint.reals["odd"].push_back(4);
  recorder->save(m);
  recorder.reset();
  const Recorder resumed = Recorder::resume(folder / "run.h5", two_conductors());
  REQUIRE(resumed.checkpoint());
  CHECK_EQ(resumed.checkpoint()->reals, m.checkpoint.reals);
  CHECK(std::signbit(resumed.checkpoint()->reals.at("odd")[1]));
  CHECK_EQ(resumed.checkpoint()->integers, m.checkpoint.integers);
}

TEST_CASE("write_field_vtkhdf: cells fill the box once, no file is replaced") {
  const Folder folder;
  const std::string path = folder / "field.vtkhdf";
  write_field_vtkhdf(path, laplace::Field{3, 2, 0.5, {1, 2, 3, 4, 5, 6}, {-1, -1, 0, 0, 1, 1}});
  const hdf5::Handle file = hdf5::load(path);
  CHECK_EQ(hdf5::get<double>(file, "VTKHDF/CellData/potential"), std::vector<double>{1, 2, 3, 4, 5, 6});
  CHECK_EQ(hdf5::get<std::int32_t>(file, "VTKHDF/CellData/body"), std::vector<std::int32_t>{-1, -1, 0, 0, 1, 1});
  CHECK_EQ(hdf5::get<std::int64_t>(file, "VTKHDF/cells"), std::vector<std::int64_t>{3, 2});
  CHECK_EQ(hdf5::get<double>(file, "VTKHDF/cell_edge"), std::vector<double>{.5});
  const std::vector<double> corners = hdf5::get<double>(file, "VTKHDF/Points");
  const std::vector<std::int64_t> ends = hdf5::get<std::int64_t>(file, "VTKHDF/Connectivity");
  CHECK_EQ(corners.size(), 3 * 4 * 3);
  // The last cell, the upper right one: its lower left corner, and its upper right corner, which is the box's.
  const auto corner = [&](int k) { return Vec2{corners[3 * ends[20 + k]], corners[3 * ends[20 + k] + 1]}; };
  CHECK_EQ(corner(0).x, 1);
  CHECK_EQ(corner(0).y, .5);
  CHECK_EQ(corner(3).x, 1.5);
  CHECK_EQ(corner(3).y, 1);
  const auto before = bytes_of(path);
  CHECK_THROWS_AS(write_field_vtkhdf(path, laplace::Field{1, 1, 1, {0}, {-1}}), InputError);
  CHECK_EQ(bytes_of(path), before);
}

TEST_CASE("stored field: single precision if requested, compressed if smooth") {
  const Folder folder;
  laplace::Field field{256, 256, 1, {}, {}};
  for (int k = 0; k < 256 * 256; ++k) field.value.push_back(1 + k / 256), field.body.push_back(-1);
  field.value[7] = 1.0 / 3;
  const auto bytes = [&](StoredField stored) {
    const hdf5::Handle file = hdf5::create_in_memory();
    put_vtkhdf(file, field, stored);
    const std::vector<double> values = hdf5::get<double>(file, "VTKHDF/CellData/potential");
    CHECK(values[7] == (stored == StoredField::single_precision ? double{1.0f / 3} : 1.0 / 3));
    CHECK(values[300] == 2);
    return hdf5::image(file).size();
  };
  const std::size_t raw = 2 * 256 * 256 * sizeof(double);
  CHECK(bytes(StoredField::single_precision) < raw / 10);
  CHECK(bytes(StoredField::double_precision) < raw / 10);
}

TEST_CASE("Result object: reads its data also after it was moved") {
  const Folder folder;
  saved_run(folder / "run.h5", 2);
  std::vector<Result> results;
  for (int k = 0; k < 5; ++k) results.emplace_back(folder / "run.h5");  // The vector moves the earlier results.
  for (const Result& result : results) CHECK_EQ(result.conductor_frame(1).charge, std::vector<double>{1e-10, 2e-10});
}

TEST_CASE("HDF5 calls: do not initialize MPI") {
  const Folder folder;
  saved_run(folder / "run.h5", 1);
  int initialized = 1;
  MPI_Initialized(&initialized);
  CHECK_EQ(initialized, 0);
}

TEST_CASE("provenance: contains PETSC_OPTIONS of the environment") {
  setenv("PETSC_OPTIONS", "-field_ksp_max_it 77", 1);
  CHECK(provenance().petsc_options == "-field_ksp_max_it 77");
  unsetenv("PETSC_OPTIONS");
  CHECK(provenance().petsc_options.empty());
}

}  // namespace record_test
