// Tests of drag near walls: Brenner's and O'Neill's factors, and the law of drag that depends on the position.
#include "src/effects/wall_drag.hpp"

#include <doctest/doctest.h>

#include <cmath>

#include "src/effects/effects.hpp"
#include "src/effects/stokes_drag.hpp"
#include "tests/near.hpp"
#include "tests/scene_texts.hpp"
#include "tests/spheres.hpp"

namespace effects_wall_drag_test {

using namespace lichtenberg;
using namespace lichtenberg::scene_texts;
using effects::drag_along_wall;
using effects::drag_towards_wall;
using effects::WallDrag;
using steel_spheres::cube_of;
using steel_spheres::drag;
using steel_spheres::radius;

namespace {

/// Brenner's sum with hyperbolic functions as powers of exp(alpha), and twice the terms that rounding needs.
double brenner(double gap) {
  const double x = gap + std::sqrt(gap * (2 + gap)) + 1;  // exp(alpha)
  const double sinh = (x - 1 / x) / 2;
  double sum = 0;
  for (double n = 1, p = x * x * x; n < 20 && p < 1e300; ++n, p *= x * x) {  // p = exp((2 n + 1) alpha)
    const double share = (p - 1 / p + (2 * n + 1) * (x * x - 1 / (x * x)) / 2) /
                         (p + 1 / p - 2 - (2 * n + 1) * (2 * n + 1) * sinh * sinh);
    sum += n * (n + 1) / ((2 * n - 1) * (2 * n + 3)) * (share - 1);
  }
  return 4.0 / 3 * sinh * sum;
}

/// Scene of a sphere of castor oil's drag near a corner of a cube of 6 cm.
Scene near_corner(double gap) {
  Scene scene = cube_of({{radius + gap, 0.03, 0.06 - radius - 2 * gap}}, 1e-3);
  scene.effects.add(effects::StokesDragOptions{.walls = true});
  return scene;
}

const std::string oil =
    "domain = { size = [0.06, 0.06, 0.06] }\nmedium = { viscosity = 0.7 }\n"
    "[[conductor]]\nposition = [0.03, 0.03, 0.03]\nradius = 1e-3\n[effects.stokes_drag]\n";

}  // namespace

TEST_CASE("drag near a wall: series, contact limits and far limits") {
  for (const double gap : {0.5, 1.0, 4.0, 30.0})  // where 20 terms suffice
    CHECK(drag_towards_wall(gap) == near(brenner(gap), 1e-13));
  // Cox & Brenner 1967, with an error of order gap ln gap; Chaoui & Feuillebois 2003, with an error of order gap. The
  // constant of Goldman, Cox & Brenner 1967 for motion along the wall, 0.9588, is 0.0045 too large.
  for (const double gap : {1e-3, 1e-4}) {
    const double digits = std::log(gap);
    CHECK(std::abs(drag_towards_wall(gap) - (1 / gap - 0.2 * digits + 0.971280)) < -0.5 * gap * digits);
    const double along = -8.0 / 15 * digits + 0.954294 - 64.0 / 375 * gap * digits;
    CHECK(std::abs(drag_along_wall(gap) - along) < 0.5 * gap);
  }
  // Faxen 1922, with terms of order x^6 in x = R/h missing; Lorentz 1907, with terms of order x^5.
  for (const double gap : {9.0, 29.0}) {
    const double x = 1 / (1 + gap),
                 along = 1 - 9.0 / 16 * x + x * x * x / 8 - 45.0 / 256 * std::pow(x, 4) - std::pow(x, 5) / 16;
    CHECK(std::abs(drag_along_wall(gap) - 1 / along) < std::pow(x, 6));
    CHECK(std::abs(drag_towards_wall(gap) - 1 / (1 - 9.0 / 8 * x + x * x * x / 2)) < std::pow(x, 4));
  }
}

TEST_CASE("WallDrag: interpolation to 1e-6, constant below the least gap") {
  const WallDrag table;
  for (double gap = 1.1e-4; gap < 5000; gap *= 1.37) {
    CAPTURE(gap);
    const auto [towards, along] = table.at(gap);
    CHECK(towards == near(drag_towards_wall(gap), 1e-6));
    CHECK(along == near(drag_along_wall(gap), 1e-6));
  }
  CHECK(table.at(1e-9).towards == table.at(WallDrag::least_gap).towards);
}

TEST_CASE("stokes_drag.walls: factors of each side, along each axis") {
  const double gap = 0.2 * radius;
  const Scene scene = near_corner(gap);
  const Bodies bodies = make_bodies(scene);
  const DragLaw law = effects::StokesDrag(scene).drag(bodies, 0);
  CHECK(law.linear == near(drag, 1e-14));
  const Vec3 more = law.by_position(position_in_space(bodies, 0));
  // Other sides are 3 cm or 5.7 cm away.
  const auto all = [&](int axis) {
    double sum = 0;
    for (int side = 0; side < 6; ++side) {
      const double c = scene.conductors[0].position[side / 2];
      const double g = ((side % 2 == 0 ? c : 0.06 - c) - radius) / radius;
      sum += (side / 2 == axis ? drag_towards_wall(g) : drag_along_wall(g)) - 1;
    }
    return drag * sum;
  };
  for (int axis = 0; axis < 3; ++axis) CHECK(more[axis] == near(all(axis), 1e-6));
  CHECK(more.x > drag * (drag_towards_wall(0.2) - 1));
  // Nearer than the roughness, by default 1e-3 of the radius, only the distance to the opposite side changes.
  const auto drag_at = [&](double x) { return law.by_position({x * radius, 0.03, 0.03}).x; };
  CHECK(drag_at(1.0001) == near(drag_at(1), 1e-7));
  CHECK(drag_at(1.0011) < 0.95 * drag_at(1));
}

TEST_CASE("stokes_drag.walls: force, Jacobian and power of one law") {
  Scene scene = near_corner(0.1 * radius);
  scene.conductors[0].velocity = {1e-3, -2e-3, 4e-3};
  Model model = effects::make_model_without_field(scene);
  CHECK(!model.drag.is_linear());
  CHECK(model.drag.linear()[0] == near(drag, 1e-14));
  const Vec3 position = scene.conductors[0].position, velocity = scene.conductors[0].velocity;
  const Vec3 more = effects::StokesDrag(scene).drag(model.bodies, 0).by_position(position);
  std::vector<double> force(3);
  model.forces(0, force);
  double power = 0;
  for (int k = 0; k < 3; ++k) {
    CHECK(force[k] == near(-(drag + more[k]) * velocity[k], 1e-12));
    power -= force[k] * velocity[k];
  }
  CHECK(model.drag.power(0, position, velocity) == near(power, 1e-12));
  ForceJacobian jacobian(3);
  model.jacobian(0, jacobian);
  double diagonal[3] = {};
  for (const auto& entry : jacobian.by_momentum)
    if (entry.row == entry.column) diagonal[entry.row] += entry.value;
  for (int k = 0; k < 3; ++k) CHECK(diagonal[k] == near(-(drag + more[k]) / model.bodies.mass[0], 1e-12));
}

TEST_CASE("stokes_drag.walls: keys without a wall or a meaning are refused") {
  CHECK(parse(oil).effects.find<effects::StokesDragOptions>()->walls == false);
  CHECK(parse(oil + "walls = true\nroughness = 1e-6\n").effects.find<effects::StokesDragOptions>()->roughness == 1e-6);
  check_refused(oil + "roughness = 1e-6\n", {"effects.stokes_drag.roughness needs effects.stokes_drag.walls = true"});
  check_refused(oil + "walls = true\nroughness = 1e-8\n",
                {"effects.stokes_drag.roughness = 1e-08 is not allowed", "1e-07 m"});
  const std::string sides = "left = \"periodic\"\nright = \"periodic\"\nbottom = \"periodic\"\ntop = \"periodic\"\n";
  check_refused("[domain]\nsize = [0.06, 0.06]\n" + sides +
                    "[medium]\nviscosity = 0.7\n[[conductor]]\nposition = [0.03, 0.03]\nradius = 1e-3\n"
                    "[effects.stokes_drag]\nwalls = true\n",
                {"effects.stokes_drag.walls = true needs a side of the domain that is not periodic"});
}

}  // namespace effects_wall_drag_test
