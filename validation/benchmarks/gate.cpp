// Fixed pieces of work on one thread, of which validation/gate.py counts the instructions.
//
//   benchmark_gate NAME | --list | --time
//
// Runs one piece, of which valgrind counts the part `measured`, or prints the names. With --time, prints the least time
// of each whole piece, with its preparation, as a ratio to the time of a Fourier transform of 64^3 numbers.

#include <fftw3.h>
#include <fmt/format.h>
#include <valgrind/callgrind.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <random>

#include "solvers/laplace/cutcell/solver.hpp"
#include "solvers/laplace/multipole/solver.hpp"
#include "solvers/laplace/spheres/spheres.hpp"
#include "solvers/neighbours/list.hpp"
#include "solvers/network/build.hpp"
#include "solvers/network/conduction.hpp"
#include "solvers/network/resistor.hpp"
#include "solvers/parallel/petsc.hpp"
#include "src/effects/effects.hpp"
#include "src/effects/read_scene.hpp"
#include "src/granular/granular_motion.hpp"
#include "src/record/recorder.hpp"
#include "src/statics/minimization.hpp"
#include "validation/benchmarks/scene.hpp"

namespace {

using namespace lichtenberg;
using namespace lichtenberg::laplace;

/// Runs `work`, and lets valgrind count its instructions.
void measured(const std::function<void()>& work) {
  CALLGRIND_START_INSTRUMENTATION;
  work();
  CALLGRIND_STOP_INSTRUMENTATION;
}

/// Makes the field problem of `count` disks after `steps` small displacements.
LaplaceProblem disks(int count, int steps = 0) {
  LaplaceProblem problem = benchmarks::disks_round_ground(count, 1);
  for (std::size_t body = 1; body < problem.bodies.size(); ++body) {
    const double angle = 2.4 * static_cast<double>(body);
    std::get<Disk>(problem.bodies[body].shape).centre += 0.1 * steps * Vec2{std::cos(angle), std::sin(angle)};
  }
  return problem;
}

void cold_field() {
  CutCellSolver solver({.cells = 256});
  measured([&] { solver.solve(disks(100)); });
}

void moving_field() {
  CutCellSolver solver({.cells = 256});
  solver.set_tolerance(1e-5);
  for (int step = 0; step < 4; ++step) solver.solve(disks(100, step));
  measured([&] {
    for (int step = 4; step < 8; ++step) solver.solve(disks(100, step));
  });
}

void multipoles() {
  MultipoleSolver solver({.tolerance = 1e-8});
  measured([&] { solver.solve(disks(40)); });
}

/// Solves for charged spheres of radius 1 in free space, with gaps of at least a tenth, on a jittered lattice.
void spheres(int along, double accuracy) {
  SphereProblem problem{.free_space = true, .permittivity = 1};
  std::mt19937_64 random(1);
  const auto uniform = [&] { return static_cast<double>(random() >> 11) * 0x1p-53 - 0.5; };
  for (int k = 0; k < along * along * along; ++k) {
    const Vec3 site{1.0 * (k % along), 1.0 * (k / along % along), 1.0 * (k / along / along)};
    problem.spheres.push_back({3 * site + 0.9 * Vec3{uniform(), uniform(), uniform()}, 1, k});
    problem.groups.push_back({.charge = uniform()});
  }
  SphereSolver solver({.accuracy = accuracy});
  measured([&] { solver.solve(problem); });
}

void near_spheres() { spheres(3, 1e-6); }
void many_spheres() { spheres(5, 1e-3); }

void neighbours() {
  constexpr int count = 20000;
  std::mt19937 random(1);
  std::uniform_real_distribution<double> coordinate(0, 50);
  std::vector<double> position(3 * count), radius(count, 0.5);
  for (double& x : position) x = coordinate(random);
  Box<3> box{{50, 50, 50}};
  box.sides.fill(Boundary::periodic);
  NeighbourList list(0, 1.0);
  measured([&] { list.search(Spheres<3>{position, radius, box}, parallel::Team::single()); });
}

/// Makes a scene of a gas with 0.15 grains in a unit volume; `effects`: text of its other effects.
Scene gas(int grains, const std::string& effects) {
  const double side = std::cbrt(grains / 0.15);
  std::string text = fmt::format("[units]\n[domain]\nsize = [{0}, {0}, {0}]\n", side);
  for (const auto name : side_names) text += fmt::format("{} = \"periodic\"\n", name);
  for (const int charge : {1, -1})
    text += fmt::format("[[population]]\ncount = {}\ncharge = {}\ntemperature = 1\n", grains / 2, charge);
  return parse_scene(text + "[effects.viscoelastic_contact]\nstiffness = 278.6\ndamping = 27.7\n" + effects +
                         "[mechanics]\nthreads = 1\n[stop]\ntime = 1e6\n[output]\nevery = 1e6\npicture = false\n",
                     "gas.toml");
}

void steps_of(const Scene& scene, double time) {
  GranularMotion motion(scene);
  motion.advance_to(0.1 * time, {});
  measured([&] { motion.advance_to(time, {}); });
}

void contacts() { steps_of(gas(6000, ""), 1); }
void charged_gas() { steps_of(gas(2000, "[effects.coulomb]\ncoupling_constant = 1\naccuracy = 1e-3\n"), 0.1); }
void polarized_gas() {
  steps_of(gas(400,
               "[effects.coulomb]\ncoupling_constant = 1\naccuracy = 1e-3\n"
               "[effects.induced_dipoles]\npolarizability = 0.075\n"),
           0.05);
}

void network_resistance() {
  using namespace lichtenberg::network;
  constexpr int across = 150;
  const double row = std::sqrt(0.75);
  ParticlePacking packing{
      .walls = {{"bottom", {0, -0.45, 0}, {0, 1, 0}}, {"top", {0, (across - 1) * row + 0.45, 0}, {0, -1, 0}}}};
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> fraction(-1, 1);
  for (int k = 0; k < across * across; ++k) {
    const int x = k % across, y = k / across;
    packing.position.push_back({x + 0.5 * (y % 2) + 0.03 * fraction(random), y * row + 0.03 * fraction(random), 0});
    packing.radius.push_back(0.518 * (1 + 0.04 * fraction(random)));
  }
  parallel::Team& team = parallel::Team::single();
  measured([&] {
    const PackingNetwork net = particle_network(packing, find_contacts(packing, team), resistor_model("length"),
                                                {.resistance_per_length = 1}, {{true, 0}, {true, 1}}, team);
    conductance_between(net.network, net.electrode[0], net.electrode[1], team);
  });
}

void packing() {
  const Scene scene = parse_scene(
      "[domain]\nsize = [24, 24]\n[effects.soft_repulsion]\n[minimize]\nforce_tolerance = 1e-8\nthreads = 1\n"
      "[[population]]\ncount = 600\nradius = [0.4, 0.66]\noverlapping = true\n",
      "packing.toml");
  Minimization minimization(scene);
  measured([&] {
    while (!minimization.at_rest() && minimization.iterate()) {
    }
  });
}

void scenes() {
  std::vector<std::filesystem::path> files;
  for (const auto& file : std::filesystem::directory_iterator(LICHTENBERG_SOURCE_DIR "/scenes"))
    if (file.path().extension() == ".toml" && file.file_size() < 4000) files.push_back(file.path());
  std::ranges::sort(files);
  measured([&] {
    for (const auto& file : files) read_scene(file.string());
  });
}

void record() {
  const std::string path = (std::filesystem::temp_directory_path() / fmt::format("gate-{}.h5", getpid())).string();
  std::vector<double> position(3 * 20000);
  std::ranges::generate(position,
                        [random = std::mt19937_64(1)]() mutable { return 0x1p-64 * static_cast<double>(random()); });
  Scene scene;
  scene.domain.size = {1, 1};
  measured([&] {
    Recorder recorder = Recorder::start(path, scene, std::vector<double>(20000, 1.0), true);
    for (int frame = 0; frame < 10; ++frame)
      recorder.add({.time = 1.0 * frame, .columns = {{"position", "m", Column::Of::particles, 3, position}}});
    recorder.save({});
  });
  std::filesystem::remove(path);
}

const std::vector<std::pair<std::string, void (*)()>> pieces = {{"cold-field", cold_field},
                                                                {"moving-field", moving_field},
                                                                {"multipoles", multipoles},
                                                                {"near-spheres", near_spheres},
                                                                {"many-spheres", many_spheres},
                                                                {"neighbours", neighbours},
                                                                {"contacts", contacts},
                                                                {"charged-gas", charged_gas},
                                                                {"polarized-gas", polarized_gas},
                                                                {"network", network_resistance},
                                                                {"packing", packing},
                                                                {"scenes", scenes},
                                                                {"record", record}};

double least_seconds(const std::function<void()>& work) {
  double least = INFINITY;
  for (int repeat = 0; repeat < 5; ++repeat) {
    const auto start = std::chrono::steady_clock::now();
    work();
    least = std::min(least, std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
  }
  return least;
}

double seconds_of_transform() {
  fftw_complex* values = fftw_alloc_complex(64 * 64 * 64);
  fftw_plan plan = fftw_plan_dft_3d(64, 64, 64, values, values, FFTW_FORWARD, FFTW_ESTIMATE);
  std::fill_n(&values[0][0], 2 * 64 * 64 * 64, 0.0);
  const double seconds = least_seconds([&] { fftw_execute(plan); });
  fftw_destroy_plan(plan);
  fftw_free(values);
  return seconds;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Fixed pieces of work for validation/gate.py");
  std::vector<std::string> names;
  for (const auto& piece : pieces) names.push_back(piece.first);
  std::string name;
  bool list = false, time = false;
  app.add_option("name", name, "piece to run")->check(CLI::IsMember(names));
  app.add_flag("--list", list, "print the names");
  app.add_flag("--time", time, "print times over that of a transform");
  app.require_option(1);
  CLI11_PARSE(app, argc, argv);
  parallel::start_petsc();
  for (const auto& [piece, work] : pieces) {
    if (list) fmt::print("{}\n", piece);
    if (time) fmt::print("{} {:.3f}\n", piece, least_seconds(work) / seconds_of_transform());
    if (piece == name) work();
  }
  parallel::finish_petsc();
}
