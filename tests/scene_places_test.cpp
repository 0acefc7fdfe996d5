// Tests of positions in a scene: electrodes, conductors, groups, populations, packings.
#include <doctest/doctest.h>

#include <algorithm>
#include <string>

#include "src/effects/contact_resistance.hpp"
#include "src/effects/effects.hpp"
#include "src/effects/hertz_contact.hpp"
#include "src/effects/leakage.hpp"
#include "src/effects/wall_contact.hpp"
#include "src/scene/placing.hpp"
#include "src/scene/scene.hpp"
#include "src/scene/stopping.hpp"
#include "tests/folder.hpp"
#include "tests/scene_texts.hpp"

namespace scene_places_test {

using namespace lichtenberg;
using namespace lichtenberg::scene_texts;

TEST_CASE("young and poisson: own values of conductors, populations, in scene order") {
  const std::string two = disk("[0.01, 0.01]", "young = 1e6\n") + disk("[0.02, 0.01]", "poisson = 0.1\n") +
                          disk("[0.03, 0.01]") +
                          "[[population]]\ncount = 2\nradius = 0.0005\nyoung = 2e6\npoisson = 0.4\n";
  const auto check_bodies = [](const std::vector<effects::Elasticity>& found, double young, double poisson) {
    const std::vector<effects::Elasticity> expected{
        {1e6, poisson}, {young, 0.1}, {young, poisson}, {2e6, 0.4}, {2e6, 0.4}};
    REQUIRE(found.size() == expected.size());
    for (std::size_t i = 0; i < found.size(); ++i) {
      CHECK(found[i].young == expected[i].young);
      CHECK(found[i].poisson == expected[i].poisson);
    }
  };
  const std::string walls = "effects.wall_contact = { young = 5e6, poisson = 0.25 }\n";
  const std::string spheres = "effects.hertz_contact = { young = 3e6, poisson = 0.3 }\n";
  const Scene both = parse(box + walls + spheres + two);
  check_bodies(both.effects.find<effects::HertzContactOptions>()->bodies, 3e6, 0.3);
  check_bodies(both.effects.find<effects::WallContactOptions>()->bodies, 3e6, 0.3);
  check_bodies(parse(box + walls + two).effects.find<effects::WallContactOptions>()->bodies, 5e6, 0.25);
  CHECK(parse(box + spheres + disk("[0.01, 0.01]")).effects.find<effects::HertzContactOptions>()->bodies.empty());
}

TEST_CASE("young and poisson without an elastic contact: refused") {
  const std::string needed = " needs the table [effects.hertz_contact] or [effects.wall_contact]";
  for (const std::string key : {"young = 1e6", "poisson = 0.1"}) {
    const std::string name = key.substr(0, key.find(' '));
    check_refused(box + electrostatics + disk("[0.01, 0.01]", key + "\n"), {"test.toml:8: conductor." + name + needed});
    check_refused(box + electrostatics + "[[population]]\ncount = 2\nradius = 0.0005\n" + key + "\n",
                  {"population." + name + needed});
  }
  const std::string spheres = "effects.hertz_contact = {}\n";
  check_refused(box + spheres + disk("[0.01, 0.01]", "young = 0\n"), {"conductor.young = 0", "greater than 0"});
  check_refused(box + spheres + disk("[0.01, 0.01]", "poisson = 0.51\n"), {"conductor.poisson = 0.51", "at most 0.5"});
}

TEST_CASE("electrode: each shape is read with its geometry, wrong keys are refused") {
  const Scene s = parse(box + electrostatics + disk("[0.01, 0.01]") + R"(
[[electrode]]
shape = "half-disk"
side = "right"
at = 0.005
radius = 0.002
potential = 1.0
[[electrode]]
shape = "bar"
from = [0.0, 0.019]
to = [0.04, 0.019]
width = 0.001
potential = 1.0
[[electrode]]
name = "rim"
shape = "ring"
centre = [0.02, 0.01]
radius = 0.02
potential = 1.0
)");
  REQUIRE(s.electrodes.size() == 3);
  CHECK(std::get<Disk>(s.electrodes[0].shape).centre == Vec2{0.04, 0.005});
  CHECK(s.electrodes[0].name == "half-disk 1");
  CHECK(std::get<Bar>(s.electrodes[1].shape).to == Vec2{0.04, 0.019});
  CHECK(std::get<Ring>(s.electrodes[2].shape).radius == 0.02);
  CHECK(s.electrodes[2].name == "rim");
  CHECK(s.electrodes[2].potential == 1);

  const std::string half_disk = "[[electrode]]\nshape = \"half-disk\"\npotential = 1\n";
  check_refused(box + half_disk + "side = \"left\"\nat = 0.01\n", {"electrode.radius is missing", "half-disk"});
  check_refused(box + half_disk + "side = \"left\"\nat = 0.01\nradius = 0.001\nwidth = 1\n",
                {"electrode.width does not belong", "half-disk", "only to bar"});
  check_refused(box + half_disk + "side = \"left\"\nat = 0.03\nradius = 0.001\n",
                {"electrode.at = 0.03 m lies outside", "left", "0.02 m"});
  check_refused(box + "[[electrode]]\nshape = \"disk\"\ncentre = [0.05, 0.01]\nradius = 0.001\npotential = 1\n",
                {"lies outside the domain", "[0.04, 0.02]"});
  check_refused(
      box + "[[electrode]]\nshape = \"bar\"\nfrom = [0.01, 0.01]\nto = [0.01, 0.01]\nwidth = 0.001\npotential = 1\n",
      {"electrode.from and electrode.to", "length"});
  check_refused(box + "[[electrode]]\nshape = \"square\"\npotential = 1\n",
                {"electrode.shape = \"square\"", "\"disk\", \"half-disk\", \"bar\", \"ring\""});
  check_refused(box + "[[electrode]]\nshape = \"disk\"\ncentre = [0.01, 0.01]\nradius = 0.001\n",
                {"electrode.potential is missing", "a number in V"});
  const std::string named = "[[electrode]]\nname = \"a\"\nshape = \"disk\"\nradius = 0.001\npotential = 1\n";
  check_refused(box + named + "centre = [0.01, 0.01]\n" + named + "centre = [0.02, 0.01]\n",
                {"electrode.name = \"a\" is taken"});
}

TEST_CASE("resistors and leakage: read; missing tables, bad values are refused") {
  const std::string scene = box + electrostatics + disk("[0.005, 0.015]") + grounded;
  const auto supplied = [](const std::string& keys) {
    return "[[electrode]]\nshape = \"disk\"\ncentre = [0.035, 0.01]\nradius = 0.002\npotential = 5.0\n" + keys + "\n";
  };
  const Scene good =
      parse(scene + supplied("series_resistance = 1e9") +
            "[effects.leakage]\nconductivity = 1e-11\n[effects.contact_discharge]\n"
            "[effects.contact_resistance]\nresistance = 5.0\nresistivity = 1e-3\ncontact_radius = 1e-5\n");
  CHECK(good.electrodes[0].series_resistance == 0);
  CHECK(good.electrodes[1].series_resistance == 1e9);
  CHECK(good.effects.find<effects::LeakageOptions>()->conductivity == 1e-11);
  CHECK(good.effects.find<effects::ContactResistanceOptions>()->ohms() == 55);  // 5 + 1e-3 / 2e-5
  CHECK(good.medium.temperature == 295.15);
  check_refused(scene + supplied("series_resistance = -1"), {"electrode.series_resistance", "-1", "greater than 0"});
  check_refused(scene + "[effects.contact_resistance]\nresistance = 5.0\n",
                {"effects.contact_resistance needs the table [effects.contact_discharge]"});
  const std::string contacts = scene + "[effects.contact_discharge]\n[effects.contact_resistance]\n";
  check_refused(contacts, {"contact_resistance needs a resistance in ohm"});
  check_refused(contacts + "resistivity = 1.0\n", {"contact_resistance needs a contact_radius"});
  check_refused(contacts + "resistance = 5.0\ncontact_radius = 1e-5\n",
                {"contact_resistance.contact_radius needs", "resistivity"});
  check_refused(contacts + "resistance = -1.0\n", {"effects.contact_resistance.resistance = -1", "at least 0"});
  check_refused(scene + "[effects.leakage]\nconductivity = -1.0\n", {"effects.leakage.conductivity", "greater than 0"});
  check_refused(contacts + "resistance = 1.0\n[mechanics]\ncoupling = \"monolithic\"\n",
                {"mechanics.coupling = \"monolithic\" is not allowed with the table [effects.contact_resistance]"});
  check_refused(box + "effects.floating_conductors = {}\nfield = { cells = 64, method = \"multipole\" }\n" +
                    disk("[0.005, 0.015]") + grounded + supplied("series_resistance = 1.0"),
                {"field.method = \"multipole\" is not allowed with electrode.series_resistance"});
  check_refused(box + "field = { cells = 64 }\n" + disk("[0.005, 0.015]") + supplied("series_resistance = 1.0"),
                {"electrode.series_resistance needs the table [effects.floating_conductors]"});
  check_refused(
      box + "field = { cells = 64 }\n" + disk("[0.005, 0.015]") + supplied("series_resistance = 1.0") + grounded,
      {"test.toml:7: electrode.series_resistance"});  // The line of the electrode with the resistor.
  // In an insulated box a resistor can collect the injected charge, but it cannot balance an initial charge.
  const std::string behind = supplied("series_resistance = 1.0");
  CHECK(refusal(box + electrostatics + "effects.current_injection.current = 1e-9\n" + disk("[0.005, 0.015]") +
                behind) == "");
  check_refused(box + electrostatics + disk("[0.005, 0.015]", "charge = 3e-10\n") + behind,
                {"3e-10 C", "potential without a resistor, or the charges must cancel"});
  check_refused(scene +
                    "[[electrode]]\nshape = \"disk\"\ncentre = [0.023, 0.01]\nradius = 0.002\npotential = 0.0\n"
                    "series_resistance = 1.0\n",
                {"touches the electrode \"disk 1\"", "behind a resistor"});
}

TEST_CASE("electrodes of different potentials: must not touch") {
  const auto refused = [](const std::string& first, const std::string& second) {
    const auto with = [](const std::string& keys, int potential) {
      return "[[electrode]]\n" + keys + "\npotential = " + std::to_string(potential) + "\n";
    };
    const auto sentence = [&](int potential) {
      return refusal(box + "field.cells = 64\n" + disk("[0.005, 0.015]") + with(first, 0) + with(second, potential));
    };
    CHECK(sentence(0) == "");  // Equal potentials: two electrodes form one shape.
    return has(sentence(1), "electrodes that touch must have the same potential");
  };
  const std::string disk_at = "shape = \"disk\"\nradius = 0.002\ncentre = ";
  const std::string bar = "shape = \"bar\"\nwidth = 0.002\n";
  const std::string ring = "shape = \"ring\"\ncentre = [0.02, 0.01]\nradius = 0.021\n";
  CHECK(refused(disk_at + "[0.02, 0.01]", disk_at + "[0.0239, 0.01]"));
  CHECK_FALSE(refused(disk_at + "[0.02, 0.01]", disk_at + "[0.0241, 0.01]"));
  CHECK(refused(disk_at + "[0.02, 0.01]", bar + "from = [0.0219, 0.01]\nto = [0.03, 0.01]"));
  CHECK_FALSE(refused(disk_at + "[0.02, 0.01]", bar + "from = [0.0221, 0.01]\nto = [0.03, 0.01]"));
  CHECK(refused(ring, ring));
  CHECK(refused(ring, disk_at + "[0.0391, 0.01]"));
  CHECK_FALSE(refused(ring, disk_at + "[0.0389, 0.01]"));
  CHECK(refused(ring, bar + "from = [0.03, 0.01]\nto = [0.0411, 0.01]"));
  CHECK_FALSE(refused(ring, bar + "from = [0.03, 0.01]\nto = [0.0408, 0.01]"));
  // One bar lies along x with a corner at (0.03, 0.011). The other lies along the diagonal; its flat end is 0.1 mm *
  // sqrt(2) beyond the corner or overlaps it. Their extents along x and y overlap in both cases.
  const std::string along_x = bar + "from = [0.02, 0.01]\nto = [0.03, 0.01]";
  CHECK(refused(along_x, bar + "from = [0.0299, 0.0109]\nto = [0.035, 0.016]"));
  CHECK_FALSE(refused(along_x, bar + "from = [0.0301, 0.0111]\nto = [0.035, 0.016]"));
  // A ring that leaves the whole domain to the fluid (half the domain's diagonal is 0.02236 m) covers no cell. A ring
  // that covers only the corners may cover none (half a cell's diagonal is 0.00044 m).
  const auto with_ring = [](const std::string& radius) {
    return "domain = { size = [0.04, 0.02], top = { potential = 5 } }\nfield.cells = 64\n" + disk("[0.01, 0.01]") +
           "[[electrode]]\nshape = \"ring\"\ncentre = [0.02, 0.01]\npotential = 0\nradius = " + radius + "\n";
  };
  check_refused(with_ring("0.0224"), {"the ring reaches into the domain by 0 m, which is not at all"});
  check_refused(with_ring("0.0223"), {"the ring reaches into the domain by 6.07e-05 m"});
  check_refused(with_ring("0.0218"), {"\"ring 1\" at 0 V", "top side of the domain at 5 V"});
  check_refused(
      "domain = { size = [0.04, 0.02], bottom = { potential = 5 } }\nmedium.permittivity = 1e-11\n"
      "[[electrode]]\nname = \"sink\"\nshape = \"half-disk\"\nside = \"bottom\"\nat = 0.01\nradius = 0.001\n"
      "potential = 0\n",
      {"\"sink\" at 0 V", "bottom side of the domain at 5 V"});
}

TEST_CASE("electrode sides that meet in a corner: must have one potential") {
  const auto with_sides = [](const std::string& sides) {
    return "field.cells = 64\nmedium.permittivity = 1e-11\n" + disk("[0.01, 0.01]") +
           "[domain]\nsize = [0.04, 0.02]\n" + sides;
  };
  CHECK(refusal(with_sides("left = { potential = 5 }\nright = { potential = 0 }\n")) == "");
  CHECK(refusal(with_sides("left = { potential = 5 }\ntop = { potential = 5 }\n")) == "");
  check_refused(with_sides("left = { potential = 5 }\ntop = { potential = 0 }\n"),
                {"left side of the domain at 5 V", "top side at 0 V", "same potential"});
  check_refused(with_sides("right = { potential = 5 }\nbottom = { potential = 0 }\n"),
                {"right side of the domain at 5 V", "bottom side at 0 V"});
}

TEST_CASE("conductor that overlaps another or lies outside the domain: refused") {
  const std::string start = box + electrostatics + grounded;
  // The centres are 1.8 mm apart and the radii are 1 mm: an overlap of 0.2 mm.
  check_refused(
      start + disk("[0.01, 0.01]") + disk("[0.0118, 0.01]"),
      {"test.toml:13:", "conductor.position = [0.0118, 0.01]", "[0.01, 0.01] m (line 10)", "overlaps", "0.0002 m"});
  check_refused(start + disk("[0.0005, 0.01]"), {"[0.0005, 0.01]", "reaches out of the domain by 0.0005 m"});
  check_refused(start + disk("[0.01, 0.03]"), {"reaches out of the domain by 0.011 m"});
  check_refused(start + disk("[0.0225, 0.01]"), {"overlaps the electrode \"disk 1\" by 0.0005 m"});
  // Inside the electrode.
  check_refused(start + disk("[0.02, 0.01]"), {"overlaps the electrode \"disk 1\" by 0.003 m"});
  // Contact with each other, the electrode (0.02 + 0.002 + 0.001) and the side is allowed, within decimal rounding.
  CHECK(refusal(box + electrostatics + "effects.contact_discharge = {}\n" + grounded + disk("[0.023, 0.01]") +
                disk("[0.025, 0.01]") + disk("[0.039, 0.01]") + disk("[0.01, 0.019]")) == "");
}

TEST_CASE("[[group]]: a wrong charge, potential or member is refused") {
  const std::string start = box + electrostatics;
  const std::string group = "[[group]]\nname = \"wire\"\n";
  const std::string member = disk("[0.01, 0.01]", "group = \"wire\"\n");
  check_refused(start + group + "charge = 1e-10\npotential = 5\n" + member,
                {"the group \"wire\" has both a charge and a potential", "only one"});
  check_refused(start + group + member, {"the group \"wire\" has neither", "C", "V"});
  check_refused(start + group + "potential = 5\n" + disk("[0.01, 0.01]", "group = \"wire\"\ncharge = 1e-10\n"),
                {"conductor.charge = 1e-10 C is not allowed", "\"wire\""});
  check_refused(start + group + "potential = 5\n" + member + disk("[0.03, 0.01]", "group = \"wier\"\n"),
                {"conductor.group = \"wier\" is unknown", "\"wire\""});
  check_refused(start + group + "potential = 5\n" + disk("[0.03, 0.01]", "group = \"wier\"\n"),
                {"conductor.group = \"wier\" is unknown", "\"wire\""});
  check_refused(start + member, {"conductor.group = \"wire\" is unknown", "no [[group]]"});
  check_refused(start + group + "potential = 5\n" + disk("[0.01, 0.01]"), {"\"wire\" has no conductors"});
  check_refused(start + group + "potential = 5\n" + group + "potential = 5\n" + member, {"\"wire\" is defined twice"});

  const Scene two =
      parse(start + group + "charge = 1e-10\n[[group]]\nname = \"sink\"\npotential = 0\n" +
            disk("[0.03, 0.01]", "group = \"sink\"\n") + member + disk("[0.015, 0.01]", "group = \"wire\"\n"));
  REQUIRE(two.groups.size() == 2);
  CHECK(two.groups[0].charge == 1e-10);
  CHECK_FALSE(two.groups[0].potential);
  CHECK(two.groups[1].potential == 0.0);
  CHECK(two.conductors[0].group == 1);
  CHECK(two.conductors[1].group == 0);
  CHECK(two.conductors[2].group == 0);
}

TEST_CASE("net charge in an insulated box: refused without a ground") {
  const std::string start = box + electrostatics;
  const std::string plus = disk("[0.01, 0.01]", "charge = 3e-10\n");
  const auto needs_ground = {std::string("without any ground"), std::string("[[electrode]]")};
  check_refused(start + plus, {"3e-10 C", "without any ground", "must cancel"});
  check_refused(start + "effects.current_injection.current = 1e-9\n" + disk("[0.01, 0.01]"), needs_ground);
  check_refused(start + disk("[0.01, 0.01]", "group = \"g\"\n") + "[[group]]\nname = \"g\"\ncharge = 1e-10\n",
                needs_ground);
  check_refused(start + "[[population]]\ncount = 3\nradius = 0.001\ncharge = 1e-10\n", needs_ground);

  CHECK(refusal(start + plus + grounded) == "");
  // 0.1 + 0.2 differs from 0.3 in binary: the charges cancel to rounding.
  CHECK(refusal(start + plus + disk("[0.02, 0.01]", "charge = -1e-10\n") + disk("[0.03, 0.01]", "charge = -2e-10\n")) ==
        "");
  CHECK(refusal(start + plus + disk("[0.02, 0.01]", "group = \"g\"\n") + "[[group]]\nname = \"g\"\npotential = 0\n") ==
        "");
  CHECK(refusal("domain = { size = [0.04, 0.02], top = { potential = 0 } }\nmedium.permittivity = 1e-11\n" +
                electrostatics + plus) == "");
}

TEST_CASE("charge whose square overflows: refused with its key") {
  const std::string start = box + electrostatics + grounded;
  check_refused(start + disk("[0.01, 0.01]", "charge = -1e308\n"),
                {"test.toml:13: conductor.charge = -1e+308", "must be 0 or from 1e-50 to 1e+50"});
  check_refused(start + "[[population]]\ncount = 1\nradius = 0.001\ncharge = 1e200\n", {"population.charge = 1e+200"});
  check_refused(start + "[[group]]\nname = \"g\"\ncharge = 1e200\n" + disk("[0.01, 0.01]", "group = \"g\"\n"),
                {"group.charge = 1e+200"});
  CHECK(refusal(start + disk("[0.01, 0.01]", "charge = -1e50\n")) == "");
}

TEST_CASE("bodies in contact: must have one potential or [contact_discharge]") {
  const std::string wire = "[[group]]\nname = \"a\"\ncharge = 0.0\n";
  const std::string two = disk("[0.01, 0.01]") + disk("[0.012, 0.01]");
  const std::string at_bottom = disk("[0.01, 0.001]"), below_electrode = disk("[0.02, 0.013]");
  check_refused(box + electrostatics + grounded + two,
                {"test.toml:10:", "[0.01, 0.01]", "[0.012, 0.01]", "line 13", "[effects.contact_discharge]"});
  check_refused(box + electrostatics + grounded + below_electrode, {"touches the electrode \"disk 1\""});
  check_refused(
      "medium = { relative_permittivity = 2.0 }\ndomain = { size = [0.04, 0.02], bottom = { potential = 1 } }\n" +
          electrostatics + at_bottom,
      {"touches the bottom side"});
  CHECK(refusal(box + electrostatics + grounded + at_bottom) == "");  // An insulating side has no potential.
  CHECK(refusal(box + electrostatics + grounded + disk("[0.01, 0.01]") + disk("[0.01201, 0.01]")) == "");
  CHECK(refusal(box + "field.cells = 64\n" + two) == "");  // There is no field.
  CHECK(refusal(box + electrostatics + "effects.contact_discharge = {}\n" + grounded + two) == "");
  CHECK(refusal(box + electrostatics + wire + grounded + disk("[0.01, 0.01]", "group = \"a\"\n") +
                disk("[0.012, 0.01]", "group = \"a\"\n")) == "");
  const std::string held = "[[group]]\nname = \"a\"\npotential = 0.0\n";
  CHECK(refusal(box + electrostatics + held + grounded + disk("[0.02, 0.013]", "group = \"a\"\n")) == "");
  // Behind a resistor the electrode's potential differs from its supply's.
  check_refused(
      box + electrostatics + held + grounded + "series_resistance = 1e9\n" + disk("[0.02, 0.013]", "group = \"a\"\n"),
      {"touches the electrode \"disk 1\""});
}

TEST_CASE("packing scene: reads walls, radii, networks; impossible keys are refused") {
  const std::string start = "[domain]\nsize = [4.0, 2.0]\n", contact = "[effects.soft_repulsion]\n";
  const std::string some = "[[population]]\ncount = 6\nradius = [0.2, 0.4]\noverlapping = true\n";
  SUBCASE("the domain's sides are the first walls") {
    const Scene s = parse(start + contact + some + "[[wall]]\npoint = [1.0, 0.0]\nnormal = [3.0, 4.0]\n");
    REQUIRE(s.walls.size() == 5);
    CHECK(s.walls[1].name == "right");
    CHECK(s.walls[3].name == "top");
    CHECK(s.walls[4].name == "wall 1");
    CHECK(s.walls[4].normal[0] == doctest::Approx(0.6));
    for (const Conductor& c : s.conductors)
      for (const Wall& wall : s.walls) CHECK(distance(wall, c) >= c.radius * (1 - 1e-9));
  }
  SUBCASE("three dimensions") {
    const Scene s = parse("[domain]\nsize = [4.0, 2.0, 3.0]\n" + contact + some +
                          "[[conductor]]\nposition = [1.0, 1.0, 2.5]\nradius = 0.3\n");
    CHECK(s.dimension() == 3);
    CHECK(s.walls.size() == 6);
    CHECK(s.walls[3].name == "top");  // Along y, as in two dimensions.
    CHECK(s.walls[5].name == "back");
    CHECK(s.conductors[0].position.z == 2.5);
    check_refused(start + contact + "[[conductor]]\nposition = [1.0, 1.0, 2.5]\nradius = 0.3\n",
                  {"conductor.position has 3 numbers", "the domain has 2"});
  }
  SUBCASE("radii stay in their interval and a list is repeated") {
    for (const std::string distribution : {"normal", "lognormal"}) {
      const Scene s = parse("[domain]\nsize = [40.0, 40.0]\n" + contact +
                            "[[population]]\ncount = 2000\nradius = [0.2, 0.4]\noverlapping = true\ndistribution = \"" +
                            distribution + "\"\ndeviation = 0.1\n");
      double sum = 0;
      for (const Conductor& c : s.conductors) {
        CHECK((c.radius >= 0.2 && c.radius <= 0.4));
        sum += c.radius;
      }
      // The mean is 0.3 by symmetry, or 0.3 exp(0.1^2 / 2) = 0.3015. The mean of 2000 has a standard deviation of 0.03
      // / sqrt(2000) = 0.0007.
      CHECK(sum / 2000 == doctest::Approx(distribution == "normal" ? 0.3 : 0.3015).epsilon(4 * 0.0007 / 0.3));
    }
    const Scene s = parse(start + contact + "[[population]]\ncount = 5\nradii = [0.1, 0.3]\noverlapping = true\n");
    CHECK((s.conductors[0].radius == 0.1 && s.conductors[1].radius == 0.3 && s.conductors[4].radius == 0.1));
    check_refused(start + contact + "[[population]]\ncount = 5\noverlapping = true\n",
                  {"population.radius is missing"});
    check_refused(start + contact + some + "radii = [0.1]\n", {"population.radius and population.radii"});
    check_refused(start + contact + some + "distribution = \"normal\"\n", {"population.deviation is missing"});
    check_refused(start + contact + some + "distribution = \"normal\"\nmean = 9.0\ndeviation = 0.01\n",
                  {"less than a radius in 100000"});
    check_refused(start + contact + some + "deviation = 0.1\n", {"population.deviation", "not allowed"});
  }
  SUBCASE("an impossible packing is refused") {
    for (const std::string radius : {"0.0", "-0.1"})
      check_refused(start + contact + "[[population]]\ncount = 6\nradius = " + radius + "\noverlapping = true\n",
                    {"population.radius = " + std::string(radius == "0.0" ? "0" : "-0.1"), "greater than 0"});
    check_refused(start + "[effects.soft_repulsion]\nbox = false\n" + some, {"no walls", "[[wall]]"});
    check_refused(start + contact + "[[population]]\ncount = 60\nradius = 0.4\noverlapping = true\n",
                  {"cannot fit", "3.77 times"});  // 60 pi 0.16 / 8
    check_refused(start + contact + "[[population]]\ncount = 1\nradius = 1.1\noverlapping = true\n",
                  {"no space for even one of radius 1.1 m"});
    check_refused("[domain]\nsize = [40.0, 1.0]\n" + contact + "[[conductor]]\nposition = [9.0, 0.5]\nradius = 1.2\n",
                  {"radius 1.2 m cannot fit between walls that are 1 m apart"});
    check_refused(start + contact + "[[conductor]]\nposition = [9.0, 0.5]\nradius = 0.1\n",
                  {"not inside the wall \"right\""});
    const std::string one = "[[conductor]]\nposition = [1.0, 0.5]\nradius = 0.1\n";
    check_refused(start + contact + one + one, {"two particles are at [1, 0.5] m"});
    check_refused(start + contact + some + "[[wall]]\npoint = [1.0, 0.0]\nnormal = [0.0, 0.0]\n", {"wall.normal = 0"});
    check_refused(start + contact + some + "[[wall]]\nname = \"top\"\npoint = [1.0, 0.0]\nnormal = [0.0, 1.0]\n",
                  {"wall.name = \"top\" is taken"});
    check_refused(start + contact + some + "[minimize]\nmethod = \"newton\"\n",
                  {"minimize.method = \"newton\"", "one of \"lbfgs-newton\""});
    check_refused(start + contact + some + "[effects.hertz_contact]\n", {"effects.hertz_contact", "leave one out"});
    check_refused(start + some, {"population.overlapping", "[effects.soft_repulsion]"});
  }
  SUBCASE("a network that could not be measured is refused before the run") {
    const auto check_network = [&](const std::string& table, std::initializer_list<std::string> parts) {
      CAPTURE(table);
      check_refused(start + contact + some + "[network]\n" + table, parts);
    };
    check_network("terminals = \"bottom,lid\"\n",
                  {"test.toml:9: network.terminals", "no wall \"lid\"; allowed are left, right, bottom, top"});
    check_network("terminals = \"top,top\"\n", {"network.terminals", "same electrode twice"});
    check_network("terminals = \"0,6\"\n", {"network.terminals", "no particle 6; allowed are 0 to 5"});
    check_network("model = \"particle\"\nresistor = \"disk\"\nsheet_resistance = 1.0\ncontact_radius = 0.01\n",
                  {"test.toml:9: network.model = \"particle\"", "\"contact\""});
    check_network("contact_radius = 0.01\n",
                  {"network.contact_radius", "\"constant\" does not use it", "needs resistance"});
    check_network("resistor = \"length\"\nresistance_per_length = 1.0\nresistivity = 0.01\n",
                  {"test.toml:11: network.resistivity", "\"length\" does not use it"});
    check_network("resistor = \"constriction\"\nresistivity = 1.0\ncontact_radius = 0.5\n",
                  {"test.toml:11: network.contact_radius", "too large"});
    check_refused("[domain]\nsize = [4.0, 2.0, 3.0]\n" + contact + some +
                      "[network]\nresistor = \"disk\"\nsheet_resistance = 1.0\ncontact_radius = 0.01\n",
                  {"test.toml:9: network.resistor", "disks in the plane"});
    const std::string lid = "[[wall]]\npoint = [0.0, 1.9]\nnormal = [0.0, -1.0]\nname = ";
    for (const std::string name : {"7", "-1", "a,b", " lid"})
      check_refused(start + contact + some + lid + "\"" + name + "\"\n",
                    {"wall.name = \"" + name + "\" is not allowed", "a number"});
    parse(start + contact + some + lid + "\"lid 2\"\n[network]\nterminals = \"0, lid 2\"\nresistance = 2.0\n");
    // Without a packing the sides are available as well.
    parse(box + "field.cells = 64\n" + disk("[0.01, 0.01]") + "[network]\nterminals = \"left,0\"\n");
  }
  SUBCASE("keys that a packing ignores are refused with a replacement") {
    const auto check_idle = [&](const std::string& key, const std::string& text, const std::string& remedy) {
      CAPTURE(key);
      check_refused(text, {key + " is not allowed with effects.soft_repulsion", remedy});
    };
    for (const std::string side : {"left", "right", "bottom", "top"})
      check_idle("domain." + side, start + side + " = { potential = 0.0 }\n" + contact + some,
                 "soft_repulsion.box = false");
    check_idle("[medium]", start + contact + some + "[medium]\nviscosity = 0.7\n", "no fluid");
    check_idle("[material]", start + contact + some + "[material]\ndensity = 9.0\n", "mass");
    check_idle("[field]", start + contact + some + "[field]\ncells = 64\n", "nothing is charged");
    check_idle("[mechanics]", start + contact + some + "[mechanics]\n", "[minimize]");
    check_idle("[stop]", start + contact + some + "[stop]\ntime = 3.0\n", "minimize.max_iterations");
    check_idle("output.every", start + contact + some + "[output]\nevery = 3.0\n", "minimize.record_every");
    check_idle("population.charge", start + contact + some + "charge = 1e-9\n", "nothing is charged");
    const std::string one = start + contact + "[[conductor]]\nposition = [1.0, 0.5]\nradius = 0.1\n";
    check_idle("conductor.charge", one + "charge = 0.0\n", "nothing is charged");
    check_idle("conductor.velocity", one + "velocity = [1.0, 0.0]\n", "nothing happens in time");
    check_refused(start + contact + some + "[minimize]\nstep = 1e-3\n",
                  {"minimize.step is not allowed", "\"lbfgs-newton\"", "\"gradient-descent\""});
    parse(start + contact + some + "[minimize]\nmethod = \"gradient-descent\"\nstep = 1e-3\n");
    for (const std::string effect : {"leakage]\nconductivity = 1e-12\n", "contact_resistance]\nresistance = 1.0\n"})
      check_refused(start + contact + some + "[effects." + effect,
                    {"which permits no other effect than gravity: leave one out"});
    check_refused(one + "group = \"a\"\n", {"conductor.group = \"a\" is unknown"});
    parse(start + contact + some + "[output]\nfile = \"p.h5\"\ncheckpoint_every = 3\npicture = false\n");
  }
}

}  // namespace scene_places_test
