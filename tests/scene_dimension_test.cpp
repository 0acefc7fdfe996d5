// Tests of dimensions and periodic sides of a scene, and of refusals by parts without support for them.
#include <doctest/doctest.h>
#include <fmt/format.h>

#include <string>

#include "src/model/bodies.hpp"
#include "src/scene/effect_kind.hpp"
#include "src/scene/scene.hpp"
#include "tests/scene_texts.hpp"

namespace scene_dimension_test {

using namespace lichtenberg;
using namespace lichtenberg::scene_texts;

namespace {

const std::string cube = "domain = { size = [1.0, 2.0, 3.0] }\n";
const std::string around = "domain = { size = [1.0, 2.0], left = \"periodic\", right = \"periodic\" }\n";
const std::string periodic_cube =
    "domain = { size = [1.0, 1.0, 1.0], left = \"periodic\", right = \"periodic\", bottom = \"periodic\", "
    "top = \"periodic\", front = \"periodic\", back = \"periodic\" }\n";
const std::string elastic = "effects.hertz_contact = {}\n";

std::string ball(const std::string& position, const std::string& more = "") {
  return "[[conductor]]\nposition = " + position + "\nradius = 0.1\n" + more;
}

/// Smallest surface-to-surface distance (m) of nearest images across periodic sides.
double smallest_gap(const Scene& scene) {
  const Box<3> box = scene.domain.box();
  double least = INFINITY;
  for (std::size_t i = 0; i < scene.conductors.size(); ++i)
    for (std::size_t j = 0; j < i; ++j) {
      const Conductor &a = scene.conductors[i], &b = scene.conductors[j];
      const Vec3 separation = box.difference(a.position, b.position);
      least = std::min(least, norm(separation) - a.radius - b.radius);
    }
  return least;
}

}  // namespace

TEST_CASE("periodic sides of a scene: make the axes of the box periodic") {
  const Scene plane = parse(around + ball("[0.5, 0.5]"));
  CHECK(plane.domain.box().periodic(0));
  CHECK_FALSE(plane.domain.box().periodic(1));
  const Scene space = parse(periodic_cube + ball("[0.5, 0.5, 0.5]"));
  CHECK(space.domain.box().lengths == Vec3{1, 1, 1});
  for (const DomainSide& side : space.domain.sides) CHECK(side.periodic);
  CHECK_FALSE(parse(cube + ball("[0.5, 0.5, 0.5]")).domain.box().any_periodic());
}

TEST_CASE("periodic axis: both of its sides or none must be periodic") {
  check_refused("domain = { size = [1.0, 1.0], left = \"periodic\" }\n" + ball("[0.5, 0.5]"),
                {"test.toml:1:", "domain.left = \"periodic\"", "domain.right = \"insulating\"", "both its sides"});
  check_refused("domain = { size = [1.0, 1.0], bottom = { potential = 5.0 }, top = \"periodic\" }\n",
                {"domain.top = \"periodic\"", "domain.bottom = { potential = 5 }"});
  check_refused("domain = { size = [1.0, 1.0], left = \"round\" }\n",
                {"domain.left = \"round\"", "\"periodic\", \"insulating\", { potential = a number in V"});
}

TEST_CASE("domain.front, back: refused in 2D, and in 3D if they have a potential") {
  check_refused("domain = { size = [1.0, 1.0], front = \"periodic\", back = \"periodic\" }\n",
                {"domain.front is not allowed in two dimensions"});
  check_refused("domain = { size = [1.0, 1.0, 1.0], back = { potential = 5.0 } }\n",
                {"domain.back = { potential = 5 }", "in three dimensions", "\"periodic\""});
}

TEST_CASE("position and velocity: must have the domain's number of components") {
  const Conductor c = parse(cube + ball("[0.5, 0.5, 2.5]", "velocity = [1.0, 2.0, 3.0]\n")).conductors[0];
  CHECK(c.position == Vec3{0.5, 0.5, 2.5});
  CHECK(c.velocity == Vec3{1, 2, 3});
  CHECK(parse(cube + ball("[0.5, 0.5, 2.5]")).conductors[0].velocity == Vec3{});
  check_refused(cube + ball("[0.5, 0.5]"), {"conductor.position has 2 numbers", "the domain has 3"});
  check_refused(cube + ball("[0.5, 0.5, 0.5]", "velocity = [1.0, 2.0]\n"),
                {"conductor.velocity has 2 numbers", "the domain has 3"});
  check_refused("domain.size = [1.0, 1.0]\n" + ball("[0.5, 0.5]", "velocity = [1.0, 2.0, 3.0]\n"),
                {"conductor.velocity has 3 numbers", "the domain has 2"});
}

TEST_CASE("effect that does not support periodic sides: the scene is refused") {
  const std::string fluid = "medium = { relative_permittivity = 2.0, viscosity = 1.0 }\n";
  const auto table = [](const std::string& effect) { return "effects." + effect + " = {}\n"; };
  check_refused(around + fluid + table("floating_conductors") + ball("[0.5, 0.5]"),
                {"effects.floating_conductors is not allowed with a periodic side"});
  CHECK(refusal(around + table("soft_repulsion") + ball("[0.5, 0.5]")) == "");
  for (const std::string effect : {"hertz_contact", "stokes_drag", "wall_contact", "gravity"}) {
    CHECK(refusal(periodic_cube + fluid + table(effect) + ball("[0.5, 0.5, 0.5]")) == "");
    CHECK(refusal(around + fluid + table(effect) + ball("[0.5, 0.5]")) == "");
  }
}

TEST_CASE("keys of electric fields: refused in 3D or periodic scenes without field") {
  for (const std::string more :
       {"[[group]]\nname = \"wire\"\n", "[field]\ncells = 64\n", "charge = 1.0\n",
        "[[electrode]]\nshape = \"disk\"\ncentre = [0.2, 0.2]\nradius = 0.1\npotential = 0\n"}) {
    check_refused(cube + ball("[0.5, 0.5, 0.5]") + more, {"is not allowed in three dimensions", "leave it out"});
    check_refused(around + ball("[0.5, 0.5]") + more, {"is not allowed with a periodic side", "leave it out"});
  }
}

TEST_CASE("[network]: refused with a periodic side; front and back only in 3D") {
  const std::string between = "[network]\nterminals = \"front,back\"\n";
  CHECK(refusal(cube + ball("[0.5, 0.5, 0.5]") + between) == "");
  check_refused(periodic_cube + ball("[0.5, 0.5, 0.5]") + between, {"[network] is not allowed with a periodic side"});
  check_refused("domain.size = [1.0, 1.0]\n" + ball("[0.5, 0.5]") + between, {"network.terminals", "\"front\""});
}

TEST_CASE("conductor at a periodic side: may cross it, its centre must be inside") {
  CHECK(refusal(around + ball("[0.0, 0.5]")) == "");
  check_refused(around + ball("[-0.01, 0.5]"), {"reaches out of the domain by 0.01 m", "its centre"});
  check_refused(around + ball("[0.5, 0.05]"), {"reaches out of the domain by 0.05 m"});
  check_refused(cube + ball("[0.5, 0.5, 2.95]"), {"conductor.position = [0.5, 0.5, 2.95] m", "the whole sphere"});
  check_refused("domain = { size = [0.15, 1.0], left = \"periodic\", right = \"periodic\" }\n" + ball("[0.1, 0.5]"),
                {"overlaps its own image"});
}

TEST_CASE("overlap of conductors across a periodic side or along z: refused") {
  check_refused(around + ball("[0.95, 0.5]") + ball("[0.1, 0.5]"), {"overlaps the one at [0.95, 0.5] m", "0.05 m"});
  CHECK(refusal("domain.size = [1.0, 2.0]\n" + ball("[0.9, 0.5]") + ball("[0.1, 0.5]")) == "");
  check_refused(cube + ball("[0.5, 0.5, 1.0]") + ball("[0.5, 0.5, 1.15]"), {"overlaps the one at [0.5, 0.5, 1] m"});
  CHECK(refusal(cube + ball("[0.5, 0.5, 1.0]") + ball("[0.5, 0.5, 1.3]")) == "");
}

TEST_CASE("population in space or across periodic sides: has no overlaps") {
  const std::string many = "[[population]]\ncount = 30\nradius = [0.06, 0.1]\n";
  for (const std::string& start : {cube, periodic_cube, around}) {
    CAPTURE(start);
    const Scene s = parse(start + elastic + many + "min_gap = 0.001\n");
    CHECK(smallest_gap(s) >= 0.001);
    bool through = false;  // A conductor crosses a side.
    for (const Conductor& c : s.conductors) through |= c.position.x < c.radius || c.position.x > 1 - c.radius;
    CHECK(through == s.domain.box().periodic(0));
  }
  const Scene packing = parse(cube + "effects.soft_repulsion = {}\n" + many);
  CHECK(smallest_gap(packing) >= 0);
}

TEST_CASE("population.region: a box in space, or a rectangle over the whole depth") {
  const auto with_region = [](const std::string& domain, const std::string& region) {
    return domain + elastic + "[[population]]\ncount = 30\nradius = 0.02\nregion = " + region + "\n";
  };
  const auto within = [](const Scene& scene, Vec3 lower, Vec3 upper) {
    return std::ranges::all_of(scene.conductors, [&](const Conductor& c) {
      for (int k = 0; k < 3; ++k)
        if (c.position[k] < lower[k] + c.radius || c.position[k] > upper[k] - c.radius) return false;
      return true;
    });
  };
  const std::string box = "[[0.1, 0.2, 1.0], [0.5, 0.6, 1.5]]", rectangle = "[[0.1, 0.2], [0.5, 0.6]]";
  CHECK(within(parse(with_region(cube, box)), {0.1, 0.2, 1}, {0.5, 0.6, 1.5}));
  CHECK(within(parse(with_region(periodic_cube, "[[0.1, 0.2, 0.3], [0.5, 0.6, 0.7]]")), {0.1, 0.2, 0.3},
               {0.5, 0.6, 0.7}));
  const Scene through = parse(with_region(cube, rectangle));
  CHECK(within(through, {0.1, 0.2, 0}, {0.5, 0.6, 3}));
  CHECK_FALSE(within(through, {0.1, 0.2, 1}, {0.5, 0.6, 1.5}));
  check_refused(with_region(cube, "[[0.1, 0.2, 1.0], [0.5, 0.6, 3.5]]"),
                {"population.region from [0.1, 0.2, 1] to [0.5, 0.6, 3.5]",
                 "[[left, bottom, front], [right, top, back]]", "from [0, 0, 0] to [1, 2, 3] m"});
  check_refused(with_region(cube, "[[0.1, 0.2, 1.0], [0.5, 0.6, 1.0]]"), {"population.region", "is not allowed"});
  check_refused(with_region(cube, "[[0.1, 0.2, 1.0], [0.5, 0.6]]"), {"population.region", "wrong unit or type"});
  check_refused(with_region("domain.size = [1.0, 1.0]\n", box),
                {"population.region has corners of 3 numbers", "the domain has 2"});
}

TEST_CASE("make_bodies: bodies get the scene's box and are wrapped into it") {
  const Bodies bodies = make_bodies(parse(periodic_cube + ball("[0.5, 0.5, 1.0]", "velocity = [0.0, 0.0, 2.0]\n")));
  CHECK(bodies.box.any_periodic());
  CHECK(bodies.position == std::vector<double>{0.5, 0.5, 0});
  CHECK(bodies.image == std::vector<int>{0, 0, 1});
  CHECK(velocity<3>(bodies, 0) == Vec3{0, 0, 2});
}

}  // namespace scene_dimension_test
