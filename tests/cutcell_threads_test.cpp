// Tests of threads, and of results that must not depend on them or on the order of bodies.
#include <doctest/doctest.h>
#include <pthread.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <string>
#include <vector>

#include "solvers/error.hpp"
#include "solvers/laplace/cutcell/solver.hpp"
#include "solvers/parallel/team.hpp"
#include "tests/cutcell_problems.hpp"

namespace cutcell_threads_test {

using namespace lichtenberg;
using namespace lichtenberg::laplace;
using namespace lichtenberg::cutcell_problems;

TEST_CASE("cut-cell solver: any number of threads gives identical bits") {
  // 324 disks on 512 cells: every thread has several bands of rows of the grids, and parts of the set-up.
  LaplaceProblem problem = random_disks(324, 512, 8, 0.05);
  problem.bodies.push_back({Ring{{256, 256}, 300}, 0});
  bool in_groups = false;
  SUBCASE("each disk alone") {}
  SUBCASE("in twenty groups, subgrid conductors of coarse grids") { in_groups = true; }
  if (in_groups) {
    problem.groups.resize(21);
    for (int k = 1; k <= 324; ++k) problem.bodies[k].group = 1 + k % 20;
  }
  const auto solve = [&](int threads) {
    CutCellSolver solver({.cells = 512, .threads = threads});
    std::vector<double> bits;
    LaplaceProblem moving = problem;
    for (int step = 0; step < 3; ++step) {
      const LaplaceSolution solution = solver.solve(moving);
      bits.insert(bits.end(), solution.group_potential.begin(), solution.group_potential.end());
      bits.insert(bits.end(), solution.body_charge.begin(), solution.body_charge.end());
      for (const Vec2 f : solution.body_force) bits.insert(bits.end(), {f.x, f.y});
      bits.push_back(solution.work);
      for (std::size_t k = 1; k < moving.bodies.size() - 1; ++k)
        std::get<Disk>(moving.bodies[k].shape).centre += Vec2{0.01, 0.02};
    }
    const Field field = solver.field();
    bits.insert(bits.end(), field.value.begin(), field.value.end());
    return bits;
  };
  const std::vector<double> one = solve(1);
  for (const int threads : {2, 3, 7}) CHECK((solve(threads) == one));
}

TEST_CASE("cut-cell solver: the order of bodies changes results within tolerance") {
  LaplaceProblem problem = random_disks(60, 256, 8, 0.5), turned = problem;
  std::reverse(turned.bodies.begin(), turned.bodies.end());
  const std::size_t bodies = problem.bodies.size();
  CutCellSolver coarse(options(64, 1e-4)), solver(options(256, 1e-9)), coarse_turned(options(64, 1e-4)),
      solver_turned(options(256, 1e-9));
  bool follows = false;
  SUBCASE("from history") {}
  SUBCASE("following a coarser grid") { follows = true; }
  if (follows) {
    solver.follow(coarse);
    solver_turned.follow(coarse_turned);
  }
  for (int step = 0; step < 4; ++step) {
    for (std::size_t k = 1; k < bodies; ++k) {  // Some bodies move into another row.
      const Vec2 shift = 0.3 * Vec2{std::cos(2.4 * static_cast<double>(k)), std::sin(2.4 * static_cast<double>(k))};
      std::get<Disk>(problem.bodies[k].shape).centre += shift;
      std::get<Disk>(turned.bodies[bodies - 1 - k].shape).centre += shift;
    }
    const std::array<int, 2> coarse_iterations{coarse.solve(problem).iterations,
                                               coarse_turned.solve(turned).iterations};
    CHECK(std::abs(coarse_iterations[0] - coarse_iterations[1]) <= 1);  // A norm may be close to its tolerance.
    const LaplaceSolution a = solver.solve(problem), b = solver_turned.solve(turned);
    CHECK(std::abs(a.iterations - b.iterations) <= 1);
    double largest = 0;
    for (const Vec2 force : a.body_force) largest = std::max(largest, norm(force));
    for (std::size_t k = 0; k < bodies; ++k) {
      // Each is a solution to 1e-9 in the energy norm.
      CHECK(norm(a.body_force[k] - b.body_force[bodies - 1 - k]) < 1e-8 * largest);
      CHECK(a.body_charge[k] == doctest::Approx(b.body_charge[bodies - 1 - k]).epsilon(1e-8));
    }
  }
  const Field field = solver.field(), field_turned = solver_turned.field();
  for (std::size_t k = 0; k < field.body.size(); ++k) {
    const int body = field_turned.body[k];
    CHECK(field.body[k] == (body < 0 ? -1 : static_cast<int>(bodies) - 1 - body));
  }
}

TEST_CASE("parallel::Team: does every task once, rethrows a background exception") {
  parallel::Team team(4);
  for (int round = 0; round < 2000; ++round) {
    const int count = 1 + round % 37;
    std::vector<int> done(count, 0);
    bool aside = false;
    if (round % 3 == 0) team.start([&] { aside = true; });
    team.for_each(count, [&](int k) { ++done[k]; });
    if (round % 3 == 0) team.finish();
    CHECK(aside == (round % 3 == 0));
    CHECK(std::all_of(done.begin(), done.end(), [](int times) { return times == 1; }));
  }
  team.start([] { throw Failure("aside"); });
  CHECK_THROWS_AS(team.finish(), Failure);
}

/// Address space (bytes) for 100 more threads with the default stack size.
rlim_t room_for_a_hundred_threads() {
  pthread_attr_t usual;
  REQUIRE(pthread_getattr_default_np(&usual) == 0);
  std::size_t stack = 0;
  pthread_attr_getstacksize(&usual, &stack);
  pthread_attr_destroy(&usual);
  rlim_t pages = 0;  // Pages in use.
  std::ifstream("/proc/self/statm") >> pages;
  return pages * static_cast<rlim_t>(sysconf(_SC_PAGESIZE)) + 100 * stack;
}

TEST_CASE("parallel::Team: more threads than available are refused") {
  rlimit before{};
  REQUIRE(getrlimit(RLIMIT_AS, &before) == 0);
  rlimit little = before;
  little.rlim_cur = std::min(before.rlim_max, room_for_a_hundred_threads());
  REQUIRE(setrlimit(RLIMIT_AS, &little) == 0);
  std::string sentence;
  try {
    parallel::Team team(1000);
  } catch (const Failure& failure) {
    sentence = failure.what();
  }
  setrlimit(RLIMIT_AS, &before);
  CHECK(sentence.starts_with("thread "));
  CHECK(sentence.ends_with("use fewer threads"));
}

[[gnu::noinline]] const void* call_site() { return __builtin_return_address(0); }

TEST_CASE("parallel::Team: a task is compiled once for one and for several threads") {
  // The call address of the task distinguishes its compilations at any optimization that inlines it.
  std::vector<const void*> site(8);
  const auto run = [&](parallel::Team& team, int count) {
    team.for_each(count, [&](int k) { site[k] = call_site(); });
    return site[0];
  };
  parallel::Team one(1), four(4);
  const void* alone = run(one, 8);
  CHECK(run(four, 8) == alone);
  CHECK(run(four, 1) == alone);
}

}  // namespace cutcell_threads_test
