// Tests of the program on one process and started by mpirun.
#include <doctest/doctest.h>

#include <nlohmann/json.hpp>

#include "tests/program.hpp"

namespace processes_test {

using namespace lichtenberg;

namespace {

using nlohmann::json;

const std::string scene = R"(
  [domain]
  size = [16e-3, 16e-3]
  bottom = { potential = 0.0 }
  [medium]
  permittivity = 4e-11
  viscosity = 1.0
  [[conductor]]
  position = [5e-3, 8e-3]
  radius = 1e-3
  charge = 1e-10
  [[conductor]]
  position = [10e-3, 9e-3]
  radius = 1e-3
  charge = 2e-10
  [effects.floating_conductors]
  [effects.stokes_drag]
  [stop]
  time = 2e-3
  [output]
  every = 1e-3
  picture = false
  [field]
  cells = 64
  tolerance = 1e-10
)";
const std::string assembled = "linear_solver = \"assembled\"\n";

/// Runs a shell command in a temporary folder with scene.toml.
Ended run(const std::string& command, const std::string& text, bool (*look)(const Folder&) = nullptr) {
  const Folder folder;
  folder.write("scene.toml", text);
  const Ended ended = run_shell(folder, command);
  if (look) CHECK(look(folder));
  return ended;
}

std::size_t count(const std::string& text, const std::string& part) {
  std::size_t n = 0;
  for (std::size_t at = 0; (at = text.find(part, at)) != std::string::npos; at += part.size()) ++n;
  return n;
}

}  // namespace

TEST_CASE("MPI processes: solve prints one answer, equal to one process's") {
  for (const auto& [processes, set] : {std::pair{"2", "field.linear_solver=assembled"},
                                       {"2", "field.cells=64"},      // a small grid, the same in both processes
                                       {"3", "field.cells=256"}}) {  // rows are divided
    CAPTURE(set);
    const std::string solve = std::string("LICHTENBERG solve scene.toml --json --set ") + set;
    const Ended alone = run(solve, scene);
    const Ended several = run(std::string("mpirun -n ") + processes + " " + solve + " --capacitance", scene);
    INFO(several.err);
    REQUIRE(alone.status == 0);
    REQUIRE(several.status == 0);
    const json a = json::parse(alone.out), b = json::parse(several.out);
    for (int k = 0; k < 2; ++k)
      CHECK(a["conductors"][k]["potential"].get<double>() ==
            doctest::Approx(b["conductors"][k]["potential"].get<double>()).epsilon(1e-8));
    CHECK(a["unknowns"] == b["unknowns"]);
  }
}

TEST_CASE("two MPI processes: a run writes one file and one summary") {
  const auto has_result = [](const Folder& folder) { return exists(folder / "scene.h5"); };
  const Ended result = run("mpirun -n 2 LICHTENBERG run scene.toml", scene + assembled, has_result);
  INFO(result.err);
  CHECK(result.status == 0);
  CHECK(count(result.out, "energy") == 1);
}

TEST_CASE("two MPI processes: a run on divided rows has a picture and continues") {
  const std::string program = "mpirun -n 2 LICHTENBERG run scene.toml --set field.cells=256 --set output.picture=true";
  const auto has_picture = [](const Folder& folder) { return exists(folder / "scene.png"); };
  const Ended result =
      run(program + " --set stop.time=1e-3 && " + program + " --resume --set stop.time=2e-3", scene, has_picture);
  INFO(result.err);
  CHECK(result.status == 0);
  CHECK(count(result.out, "energy") == 2);
}

TEST_CASE("two MPI processes: another field method is refused, no file is made") {
  const auto no_file = [](const Folder& folder) { return !exists(folder / "scene.h5"); };
  const Ended relaxation = run("mpirun -n 2 LICHTENBERG run scene.toml", scene + "method = \"relaxation\"\n", no_file);
  CHECK(relaxation.status == 2);
  CHECK(count(relaxation.err, "lichtenberg: ") == 1);
  CHECK(count(relaxation.err, "field.method = \"relaxation\" runs on one process") == 1);
}

TEST_CASE("two MPI processes: another Krylov method with the multigrid is refused") {
  const Ended result = run("mpirun -n 2 LICHTENBERG solve scene.toml --petsc -field_ksp_type cg", scene + "\n");
  CHECK(result.status == 2);
  CHECK(count(result.err, "leave -field_ksp_type and -field_pc_type out") == 1);
}

TEST_CASE("two MPI processes: an error of all processes is printed once") {
  const Ended result = run("mpirun -n 2 LICHTENBERG solve scene.toml --petsc -field_ksp_max_it 1", scene + assembled);
  CHECK(result.status == 1);
  CHECK(count(result.err, "lichtenberg") == 1);
  CHECK(count(result.err, "no convergence after 1 iterations") == 1);
}

// Without this the remaining process would wait endlessly; five minutes are ample.
TEST_CASE("two MPI processes: an error on one process ends both with status 1") {
  const std::string program = "LICHTENBERG solve scene.toml --petsc -field_mat_type ";
  const std::string two = "timeout -k 10 300 mpirun -n 1 " + program;
  const Ended first = run(two + "nonsense : -n 1 " + program + "aij", scene + assembled);
  const Ended second = run(two + "aij : -n 1 " + program + "nonsense", scene + assembled);
  CHECK(first.status == 1);
  CHECK(second.status == 1);
  CHECK(count(first.err, "lichtenberg: PETSc: ") == 1);
  CHECK(count(second.err, "lichtenberg, process 1: PETSc: ") == 1);
}

TEST_CASE("PETSc options: a misspelt one is refused, an unused one gives a warning") {
  const Ended misspelt = run("LICHTENBERG solve scene.toml --petsc -field_pc_tpye jacobi", scene + assembled);
  CHECK(misspelt.status == 2);
  CHECK(count(misspelt.err, "-field_pc_tpye") == 1);
  const Ended bare = run("LICHTENBERG solve scene.toml --petsc -pc_type jacobi", scene + assembled);
  CHECK(bare.status == 2);
  CHECK(count(bare.err, "-field_pc_type") == 1);
  const Ended other = run("LICHTENBERG solve scene.toml --petsc -nonsense 3", scene + assembled);
  CHECK(other.status == 0);
  CHECK(count(other.err, "-nonsense") == 1);
  const Ended good =
      run("LICHTENBERG solve scene.toml --petsc -field_pc_type jacobi -log_view :log", scene + assembled);
  CHECK(good.status == 0);
  CHECK(good.err.empty());
}

}  // namespace processes_test
