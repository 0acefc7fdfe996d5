// Tests of the command run with contacts of conductors: a contact resistance and a short circuit.
#include <doctest/doctest.h>
#include <fmt/format.h>

#include <cmath>
#include <string>
#include <vector>

#include "src/record/hdf5.hpp"
#include "tests/folder.hpp"
#include "tests/run_child.hpp"

namespace run_contacts_test {

using namespace lichtenberg;
using namespace lichtenberg::run_child;

namespace {

/// Scene of a sphere that shuttles between two electrodes with the given contact resistance (ohm). It has 11 frames.
std::string shuttle_text(const std::string& contact_resistance) {
  return replaced(R"(
domain.size = [8e-3, 8e-3]
medium = { relative_permittivity = 4.7, viscosity = 0.7 }
[[electrode]]
name = "high"
shape = "bar"
from = [0.0, 0.0]
to = [0.0, 8e-3]
width = 2e-3
potential = 18e3
[[electrode]]
name = "low"
shape = "bar"
from = [8e-3, 0.0]
to = [8e-3, 8e-3]
width = 2e-3
potential = 0.0
[[conductor]]
position = [2.5e-3, 4e-3]
radius = 0.775e-3
[effects.floating_conductors]
[effects.stokes_drag]
[effects.hertz_contact]
[effects.wall_contact]
[effects.contact_discharge]
contact_distance = 2e-4
[effects.contact_resistance]
resistance = OHM
[field]
cells = 64
[output]
every = 0.01
checkpoint_every = 5
picture = false
[stop]
time = 0.1
)",
                  "OHM", contact_resistance);
}

}  // namespace

// With the sphere's capacitance of 0.3 pF, RC is 0.03 ms or 0.3 s; the sphere crosses the gap in 1 ms.
TEST_CASE("run with contact resistance: energy balances; a too slow contact ends it") {
  const Folder folder;
  folder.write("six.toml", shuttle_text("1e8"));
  Child sound(folder, "sound.h5");
  REQUIRE_EQ(sound.wait(), 0);
  CHECK_NE(sound.summary().find("\nbalance "), std::string::npos);
  CHECK_EQ(sound.messages().find("energy balance"), std::string::npos);
  const double imbalance = std::abs(number(folder / "sound.h5", "summary/relative_energy_imbalance"));
  CHECK_LT(imbalance, number(folder / "sound.h5", "summary/allowed_energy_imbalance"));
  CHECK_GT(imbalance, 0);

  folder.write("six.toml", shuttle_text("1e12"));
  Child slow(folder, "slow.h5", {"--quiet"});
  CHECK_EQ(slow.wait(), 1);
  CHECK_EQ(slow.summary(), "");
  CHECK_NE(slow.messages().find("conductor 0 and the electrode \"high\" touch while their potentials are "),
           std::string::npos);
  CHECK_NE(slow.messages().find("lower the resistance in [effects.contact_resistance] or widen "
                                "effects.contact_discharge.contact_distance"),
           std::string::npos);
}

TEST_CASE("run with contact resistance: resumed, it equals an uninterrupted run") {
  const Folder folder;
  folder.write("six.toml", shuttle_text("1e8"));
  REQUIRE_EQ(run(folder, "reference.h5"), 0);
  folder.write("six.toml", replaced(shuttle_text("1e8"), "time = 0.1", "time = 0.05"));
  REQUIRE_EQ(run(folder, "six.h5"), 0);
  folder.write("six.toml", shuttle_text("1e8"));
  REQUIRE_EQ(run(folder, "six.h5", {"--quiet", "--resume"}), 0);
  check_same_numbers(folder / "six.h5", folder / "reference.h5");
}

// A sphere between two plates 0.95 mm farther apart than its diameter. The contact with the lower plate opens at a gap
// of 0.525 mm. The upper plate attracts the sphere, and its contact closes at 0.5 mm, which is 0.45 mm from the lower
// plate.
TEST_CASE("run: a short circuit ends it with status 1 and keeps earlier frames") {
  const Folder folder;
  folder.write("six.toml", R"(
[domain]
size = [4e-3, 2.5e-3]
bottom = { potential = 0.0 }
top = { potential = 500.0 }
[medium]
relative_permittivity = 4.7
viscosity = 0.7
[[conductor]]
position = [2e-3, 0.875e-3]
radius = 0.775e-3
[effects.floating_conductors]
[effects.stokes_drag]
[effects.wall_contact]
[effects.contact_discharge]
contact_distance = 0.5e-3
[field]
cells = 64
[output]
every = 1e-3
checkpoint_every = 1000
picture = false
[stop]
time = 10.0
)");
  for (const bool resumed : {false, true}) {
    CAPTURE(resumed);
    Child child(folder, "six.h5", {"--quiet", resumed ? "--resume" : "--overwrite"});
    CHECK_EQ(child.wait(), 1);
    CAPTURE(child.messages());
    const std::vector<double> times = hdf5::get<double>(hdf5::load(folder / "six.h5"), "observables/energy/time");
    const std::string at = child.messages().substr(child.messages().find("at t = ") + 7);
    CHECK_GT(times.size(), 3);
    CHECK_LE(times.back(), std::stod(at));
    CHECK_GT(times.back() + 1e-3, std::stod(at));
    CHECK_NE(child.messages().find(fmt::format("six.h5 holds the run up to t = {:.6g} s, and --resume", times.back())),
             std::string::npos);
    // The position of the short circuit minus the path of a frame: about 5 mm/s times 1 ms.
    const std::vector<double> position =
        hdf5::get<double>(hdf5::load(folder / "six.h5"), "particles/conductors/position/value");
    CHECK_EQ(position[position.size() - 2], doctest::Approx(1.225e-3).epsilon(0.01));
  }
}

}  // namespace run_contacts_test
