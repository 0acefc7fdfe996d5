// Tests of the requested accuracy with closed curves: the error is below the estimate also at corners and tips.
#include <doctest/doctest.h>

#include <cmath>

#include "solvers/laplace/accuracy/accuracy.hpp"
#include "solvers/laplace/accuracy/gaps.hpp"
#include "tests/curve_references.hpp"

namespace accuracy_curves_test {

using namespace lichtenberg;
using namespace lichtenberg::laplace;
using namespace lichtenberg::curve_references;

TEST_CASE("field.accuracy with closed curves: error below the request") {
  const Vec2 centre{0.5031, 0.4977};
  const auto check = [](const Pair& pair, double accuracy) {
    AccuracyRequest request;
    request.accuracy = accuracy;
    request.most_cells = 1024;
    const AccurateSolution found = solve_to_accuracy(between(pair), request);
    const double error = std::abs(found.solution.body_charge[0] / pair.capacitance - 1);
    CAPTURE(found.choice.cells);
    CAPTURE(error);
    CHECK(found.choice.estimate <= accuracy);
    CHECK(error < accuracy);
  };
  for (const double accuracy : {3e-2, 1e-2, 3e-3}) {
    check(confocal_ellipses(centre, 0.25, 0.12, 0.4), 0.1 * accuracy);
    check(confocal_ellipses(centre, 0.25, 0.05, 0.4), accuracy);
    for (const double angle : {0.0, 0.3, pi / 4}) check(concentric_rhombi(centre, pi / 4, angle), accuracy);
    check(concentric_rhombi(centre, pi / 6, 0.2), accuracy);
  }
}

TEST_CASE("narrowest gap of closed curves: to sides and to each other") {
  const ClosedCurve one = make_ellipse({0.3, 0.5}, {0.1, 0.1}, 0, false),
                    other = make_ellipse({0.55, 0.5}, {0.1, 0.1}, 0, false);
  LaplaceProblem problem{.size = {1, 1}, .permittivity = 1};
  problem.bodies = {{Freeform{&one}, 0}, {Freeform{&other}, 1}};
  problem.groups = {{false, 0, 1}, {true, 0, 0}};
  CHECK(narrowest(problem).gap == doctest::Approx(0.05).epsilon(0.01));
  CHECK(narrowest(problem).radius == doctest::Approx(0.1).epsilon(1e-3));
  problem.groups[1] = {false, 0, 1};
  CHECK(narrowest(problem).gap == doctest::Approx(0.2).epsilon(1e-3));
}

}  // namespace accuracy_curves_test
