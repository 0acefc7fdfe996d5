// Tests of translations of multipoles in space.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "solvers/laplace/spheres/harmonics.hpp"
#include "solvers/laplace/spheres/translation.hpp"

namespace spheres_translation_test {

using namespace lichtenberg;
using namespace lichtenberg::laplace::spheres;

TEST_CASE("translation of multipoles: the shifted expansion gives an equal field") {
  constexpr int source_degree = 6, target_degree = 60;
  const Translation translation(target_degree);
  const Vec3 shift{1.1, -1.7, 0.6}, offset{0.1, 0.2, -0.25};
  const double d = norm(shift), source_radius = 0.5, target_radius = 0.4;
  std::vector<Lanes> value(harmonics(target_degree)), scratch(value.size());
  std::vector<double> near(value.size()), there(value.size());
  regular_harmonics(offset, target_degree, near.data());
  regular_harmonics(shift + offset, source_degree, there.data());
  PairDirections directions;
  for (int lane = 0; lane < lanes; ++lane) directions.set(lane, shift);
  double exact = 0;
  for (int l = 0; l <= source_degree; ++l)
    for (int m = -l; m <= l; ++m) {
      const double a = std::sin(1.0 + 7 * l + 3 * m);
      value[at(l, m)] = Lanes{} + a * std::pow(2 * source_radius / d, l) * source_radius / d;
      exact += a * there[at(l, m)] * std::pow(source_radius, l + 1) / std::pow(norm(shift + offset), 2 * l + 1);
    }
  translation.apply(directions, source_degree, target_degree, value.data(), scratch.data());
  double moved = 0;
  for (int l = 0; l <= target_degree; ++l)
    for (int m = -l; m <= l; ++m)
      moved += value[at(l, m)][3] * std::pow(2 * target_radius / d, l) * near[at(l, m)] / std::pow(target_radius, l);
  // The ratio of the two distances, 0.16, to the power 60 is negligible. The bound is rounding in sums of some thousand
  // terms.
  CHECK(moved == doctest::Approx(exact).epsilon(1e-13));
}

TEST_CASE("translation up to degree 8: unrolled loops equal general ones") {
  // A target degree of 9 takes the general loops; its coefficients up to lower degrees are those of a lower target.
  constexpr int above = 9;
  const Translation translation(above);
  PairDirections directions;
  for (int lane = 0; lane < lanes; ++lane) directions.set(lane, {0.3, lane - 3.0, lane % 3 - 1.0});
  for (int source = 0; source < above; ++source)
    for (int target = 0; target < above; ++target) {
      CAPTURE(source);
      CAPTURE(target);
      std::vector<Lanes> value(harmonics(above)), scratch(value.size());
      for (int h = 0; h < harmonics(source); ++h)
        for (int lane = 0; lane < lanes; ++lane) value[h][lane] = std::sin(1 + 3 * h + lane);
      std::vector<Lanes> general = value;
      translation.apply(directions, source, target, value.data(), scratch.data());
      translation.apply(directions, source, above, general.data(), scratch.data());
      double error = 0;
      for (int h = 0; h < harmonics(target); ++h)
        for (int lane = 0; lane < lanes; ++lane) error = std::max(error, std::abs(value[h][lane] - general[h][lane]));
      // Rounding in five sums of at most 9 products with values of at most about 9.
      CHECK(error < 1e-13);
    }
}

}  // namespace spheres_translation_test
