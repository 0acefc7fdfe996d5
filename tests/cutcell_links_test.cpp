// Tests of links of the cut-cell grid: conductances from fluid cells to conductors, their gradients and channels.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "solvers/laplace/cutcell/level_builder.hpp"
#include "solvers/laplace/cutcell/link.hpp"
#include "solvers/laplace/cutcell/link_batch.hpp"
#include "solvers/laplace/cutcell/medium.hpp"
#include "tests/cutcell_problems.hpp"

namespace cutcell_links_test {

using namespace lichtenberg;
using namespace lichtenberg::laplace;
using namespace lichtenberg::cutcell_problems;

TEST_CASE("log-fitted link (cell to disk): exact flux of a logarithmic potential") {
  const Vec2 centre{0.3, -0.2}, p{2.5, 0.5}, a{2.0, 1.0}, b{2.0, 0.0};
  const double R = 1.7, q = 2.4;
  const double seen = std::atan2(a.y - centre.y, a.x - centre.x) - std::atan2(b.y - centre.y, b.x - centre.x);
  const double difference = q / (2 * pi) * std::log(norm(p - centre) / R);
  // Rounding of a few operations on numbers of order one.
  CHECK(log_fitted_link(p, a, b, centre, R).value * difference == doctest::Approx(q * seen / (2 * pi)).epsilon(1e-14));
}

TEST_CASE("log-fitted link (cell to disk): tends to 1 / distance for large circles") {
  const double R = 1e6, cut = 0.3;
  const Conductance c = log_fitted_link({0, 0}, {0.5, 0.5}, {0.5, -0.5}, {R + cut, 0}, R);
  // c = dtheta / ln(1 + cut/R), dtheta = 1/(R + cut - 1/2): the relative difference is of order 1/R.
  CHECK(c.value == doctest::Approx(1 / cut).epsilon(2.0 / R));
}

TEST_CASE("log_fitted_links: batches equal single links to rounding") {
  for (const double R : {least_batched_radius, 1.0, 7.75, 1000.0})
    for (int k = 0; k < 1000; ++k) {
      // Centres at any position in a cell, and a cell at the rim in any direction.
      const Vec2 centre{std::fmod(0.618 * k, 1), std::fmod(0.414 * k, 1)};
      const Vec2 rim = centre + R * Vec2{std::cos(0.1 * k), std::sin(0.1 * k)};
      const Outline disk{Outline::Kind::disk, centre, {}, R};
      const int i = static_cast<int>(std::floor(rim.x)), j = static_cast<int>(std::floor(rim.y));
      for (int side = 0; side < 4; ++side) {
        const Vec2 p = cell_centre(i, j), e = direction(side);
        if (norm(p - centre) <= R || norm(p + e - centre) > R) continue;
        const Conductance alone = fluid_link(disk, p, e, LinkFormula::log_fitted);
        LinkBatch batch;
        batch.x.fill(p.x - centre.x), batch.y.fill(p.y - centre.y), batch.ex.fill(e.x), batch.ey.fill(e.y);
        batch.radius.fill(R), batch.radius2.fill(R * R);
        const BatchConductances together = log_fitted_links(batch);
        // Both have r^2 - R^2 with the rounding of R^2, divided by some cells times R, or by 1e-4 for a short cut.
        const double cut = std::max(norm(p - centre) - R, smallest_cut), rounding = 1e-15 * (1 + R / cut);
        CHECK(together.value[k % LinkBatch::width] == doctest::Approx(alone.value).epsilon(rounding));
        const Vec2 gradient{together.gradient_x[k % LinkBatch::width], together.gradient_y[k % LinkBatch::width]};
        CHECK(norm(gradient - alone.gradient) < 2 * rounding * norm(alone.gradient));
      }
    }
}

TEST_CASE("links in gaps below a cell: LevelBuilder equals functions of link.hpp") {
  for (const bool one_group : {false, true}) {
    LaplaceProblem problem{.size = {32, 32}, .permittivity = 1};
    problem.sides[bottom].kind = Side::Kind::electrode;
    problem.groups = {{.floating = true}, {.floating = true}};
    // The gap is 0.66 cells.
    problem.bodies = {{Disk{{9.8, 15.9}, 5}, 0}, {Disk{{20.45, 16.3}, 5}, one_group ? 0 : 1}};
    Level level(problem, 32, 32);
    LevelBuilder().build(problem, LinkFormula::log_fitted, level);
    std::size_t link = 0, squeezed = 0;
    for (int body = 0; body < 2; ++body) {
      const Outline own = outline_in_cells(problem.bodies[body].shape, 1),
                    other = outline_in_cells(problem.bodies[1 - body].shape, 1);
      for (int j = 0; j < 32; ++j)
        for (int i = 0; i < 32; ++i)
          for (int side = 0; side < 4 && covers(own, i, j); ++side) {
            const Vec2 p = cell_centre(i, j), e = direction(side);
            const auto covered_at = [&](const Outline& outline, int cells) {
              return covers(outline, i + cells * static_cast<int>(e.x), j + cells * static_cast<int>(e.y));
            };
            if (covered_at(own, 1) || covered_at(other, 1)) continue;
            Conductance c = fluid_link(own, p + e, -e, LinkFormula::log_fitted);
            OpposedSurfaceCorrection narrow;
            if (!one_group && covered_at(other, 2)) narrow = correct_for_opposed_surface(own, p, e, other, c);
            REQUIRE(link < level.links.size());
            const FluidLink& found = level.links[link];
            // As for batches: the rounding of R^2 divided by the cut and R.
            const double cut = std::max(norm(p + e - own.centre) - own.size, smallest_cut),
                         rounding = 1e-15 * (1 + 5 / cut);
            CHECK(found.conductance == doctest::Approx(c.value).epsilon(10 * rounding));
            CHECK(norm(found.gradient - c.gradient) < 10 * rounding * norm(c.gradient));
            if (narrow.close) {
              REQUIRE(squeezed < level.cross_gradients.size());
              const CrossGradient& cross = level.cross_gradients[squeezed++];
              CHECK(cross.link == static_cast<int>(link));
              CHECK(cross.body == 1 - body);
              CHECK(norm(cross.gradient - narrow.partner_gradient) < 10 * rounding * norm(narrow.partner_gradient));
            }
            ++link;
          }
    }
    CHECK(link == level.links.size());
    CHECK(squeezed == level.cross_gradients.size());
    CHECK((squeezed > 0) == !one_group);
  }
}

TEST_CASE("link conductances: gradients equal central differences") {
  // Central differences with step s: truncation s^2 f'''/6 and rounding 1e-16 |f| / s are equal near s = 1e-5.
  const double s = 1e-5, accuracy = 1e-7;
  SUBCASE("log-fitted, outside and inside") {
    for (const bool inside : {false, true}) {
      const Vec2 centre{0.1, 0.2}, p = inside ? Vec2{3.3, 1.1} : Vec2{4.3, 1.1};
      const Vec2 a{inside ? 3.8 : 3.8, 1.6}, b{3.8, 0.6};
      const auto value = [&](Vec2 x) { return log_fitted_link(p, a, b, x, 3.9, inside).value; };
      const Vec2 gradient = log_fitted_link(p, a, b, centre, 3.9, inside).gradient;
      CHECK(gradient.x ==
            doctest::Approx((value(centre + Vec2{s, 0}) - value(centre - Vec2{s, 0})) / (2 * s)).epsilon(accuracy));
      CHECK(gradient.y ==
            doctest::Approx((value(centre + Vec2{0, s}) - value(centre - Vec2{0, s})) / (2 * s)).epsilon(accuracy));
    }
  }
  SUBCASE("channel between two circles") {
    for (const double gap : {0.7, 0.05, 1e-3}) {
      const Vec2 p{0.1, 0.2}, e{1, 0}, a{-7.6, 0.9}, b{a.x + 16 + gap, 0.6};
      const double tiny = 1e-3 * gap;  // The integrand varies over the gap.
      const auto value = [&](Vec2 x, Vec2 y) { return gap_conductance(p, e, 1, {x, 8}, {y, 8}).value; };
      const PairConductance c = gap_conductance(p, e, 1, {a, 8}, {b, 8});
      const Vec2 dx{tiny, 0}, dy{0, tiny};
      // The truncation error is (tiny/gap)^2 = 1e-6.
      CHECK(c.gradient_a.x == doctest::Approx((value(a + dx, b) - value(a - dx, b)) / (2 * tiny)).epsilon(1e-5));
      CHECK(c.gradient_b.x == doctest::Approx((value(a, b + dx) - value(a, b - dx)) / (2 * tiny)).epsilon(1e-5));
      CHECK(c.gradient_a.y == doctest::Approx((value(a + dy, b) - value(a - dy, b)) / (2 * tiny)).epsilon(1e-3));
      const auto to_rim = [&](Vec2 x, Vec2 y) { return gap_conductance(p, e, 1, {x, 8}, {y, -24}).value; };
      const Vec2 rim{b.x - 32, 0.6};
      const PairConductance r = gap_conductance(p, e, 1, {a, 8}, {rim, -24});
      CHECK(r.gradient_a.x == doctest::Approx((to_rim(a + dx, rim) - to_rim(a - dx, rim)) / (2 * tiny)).epsilon(1e-5));
      CHECK(r.gradient_b.x == doctest::Approx((to_rim(a, rim + dx) - to_rim(a, rim - dx)) / (2 * tiny)).epsilon(1e-5));
      CHECK(r.gradient_b.y == doctest::Approx((to_rim(a, rim + dy) - to_rim(a, rim - dy)) / (2 * tiny)).epsilon(1e-3));
    }
  }
}

TEST_CASE("gap_conductance between circles: equals the integral of ds / gap") {
  // Parabolic channel: gap(s) = g + s^2 (1/R_a + 1/R_b) / 2 up to terms s^4/(4 R^3) = 3e-5 for s = 1/2, R = 8.
  for (const double g : {1e-5, 1e-3, 0.1}) {
    const double k = 0.125, exact = 2 / std::sqrt(g * k) * std::atan(0.5 * std::sqrt(k / g));
    CHECK(gap_conductance({0, 0}, {1, 0}, 1, {{-7.7, 0}, 8}, {{8.3 + g, 0}, 8}).value ==
          doctest::Approx(exact).epsilon(1e-3));
  }
  // Channel at the rim of a dish of radius 24, with curvature 1/8 - 1/24.
  for (const double g : {1e-5, 1e-3, 0.1}) {
    const double k = 0.5 * (1.0 / 8 - 1.0 / 24), exact = 2 / std::sqrt(g * k) * std::atan(0.5 * std::sqrt(k / g));
    CHECK(gap_conductance({0, 0}, {1, 0}, 1, {{-7.7, 0}, 8}, {{0.3 + g - 24, 0}, -24}).value ==
          doctest::Approx(exact).epsilon(1e-3));
  }
}

TEST_CASE("links to a disk centred on a cell corner: faces see 3/4 or 1/4 pi") {
  // The disk covers the cell above and to the right of the corner. Two faces subtend pi/4 each; those that end in the
  // corner share the rest.
  const double ln = std::log(std::sqrt(2.5) / 0.1), near_ln = std::log(std::sqrt(0.5) / 0.1);
  const Conductance left = log_fitted_link({-0.5, 0.5}, {0, 1}, {0, 0}, {0, 0}, 0.1);
  const Conductance below = log_fitted_link({0.5, -0.5}, {0, 0}, {1, 0}, {0, 0}, 0.1);
  const Conductance right = log_fitted_link({1.5, 0.5}, {1, 0}, {1, 1}, {0, 0}, 0.1);
  CHECK(left.value == doctest::Approx(0.75 * pi / near_ln).epsilon(1e-8));  // The centre is shifted by 1e-9.
  CHECK(below.value == doctest::Approx(0.75 * pi / near_ln).epsilon(1e-8));
  CHECK(right.value == doctest::Approx(0.25 * pi / ln).epsilon(1e-12));
  CHECK(std::isfinite(left.gradient.x));
  CHECK(std::isfinite(below.gradient.y));
}

TEST_CASE("link to a disk centred on a cell face: the cell sees an angle of pi") {
  for (const Vec2 p : {Vec2{0.5, -0.5}, Vec2{0.5, 0.5}}) {
    const double ln = std::log(std::hypot(0.41, 0.5) / 0.5);
    const Conductance c = log_fitted_link(p, {0, 0}, {1, 0}, {0.91, 0}, 0.5);
    // The centre is shifted by 1e-9 from one at a distance of 0.09.
    CHECK(c.value == doctest::Approx(pi / ln).epsilon(1e-7));
    CHECK(std::isfinite(norm(c.gradient)));
  }
}

TEST_CASE("disks of radius 0.545 cells on cell faces: links positive, CG converges") {
  // The centres lie on faces, as in two-disks.toml with 36 cells. With a negative conductance CG would not converge.
  LaplaceProblem problem{.permittivity = 1};
  problem.size = {36, 36};
  problem.bodies = {{Disk{{16.91, 18}, 0.545}, 0}, {Disk{{19.09, 18}, 0.545}, 1}};
  problem.groups = {{false, 0, 0}, {true, 1, 0}};
  Level level(problem, 36, 36);
  LevelBuilder().build(problem, LinkFormula::log_fitted, level);
  for (const FluidLink& link : level.links) CHECK(link.conductance > 0);
  CutCellSolver solver(options(36));
  const LaplaceSolution solution = solver.solve(problem);
  CHECK(solution.iterations < 20);
  // In the infinite plane the potential is arccosh(2) / pi; the box and the coarse cells change it by several percent.
  CHECK(solution.group_potential[0] == doctest::Approx(0.0));
  CHECK(solution.group_potential[1] == doctest::Approx(std::acosh(2.0) / pi).epsilon(0.2));
}

}  // namespace cutcell_links_test
