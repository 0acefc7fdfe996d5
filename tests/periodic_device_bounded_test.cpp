// Tests of the device's sums in boxes with open and grounded sides, executed by the CPU item by item, against the
// CPU's.

#include <doctest/doctest.h>

#include <cmath>
#include <numeric>

#include "solvers/error.hpp"
#include "solvers/periodic/bounded.hpp"
#include "solvers/periodic/device/device.hpp"
#include "tests/periodic_sources.hpp"

namespace periodic_device_bounded_test {

using namespace lichtenberg;
using namespace lichtenberg::periodic;

namespace {

constexpr Side p = Side::periodic, o = Side::open, g = Side::grounded;

const Enclosure enclosures[] = {
    {{9, 11, 7}, {p, p, p, p, o, o}}, {{9, 11, 7}, {o, o, p, p, o, o}}, {{9, 11, 7}, {o, o, o, o, o, o}},
    {{9, 11, 7}, {p, p, p, p, g, o}}, {{9, 11, 7}, {p, p, p, p, o, g}}, {{9, 11, 7}, {p, p, p, p, g, g}},
    {{9, 11, 7}, {g, g, p, p, o, g}}, {{9, 11, 7}, {o, g, g, g, g, o}},
};

SourceSet charges_in(const Enclosure& enclosure) {
  SourceSet sources = random_sources(150, enclosure.lengths, 0.9, false, 4);
  for (int i = 0; i < sources.size(); ++i)
    for (int k = 0; k < 3; ++k)  // at least 0.45 from the sides
      sources.position[3 * i + k] = 0.45 + (1 - 0.9 / enclosure.lengths[k]) * sources.position[3 * i + k];
  return sources;
}

Response on_device(const MeshChoice& choice, const Enclosure& enclosure, const SourceSet& sources) {
  const auto device = device::make_host_mesh(choice.mesh, choice.cloud(), enclosure);
  Response response;
  device->evaluate({choice.mesh.lengths, sources.position, sources.charge}, {}, parallel::Team::single(), response);
  return response;
}

Response on_cpu(const MeshRequest& request, const MeshChoice& choice, const Enclosure& enclosure,
                const SourceSet& sources) {
  BoundedSum sum(request, enclosure, choice);
  Response response;
  sum.evaluate(sources, {}, parallel::Team::single(), response);
  return response;
}

}  // namespace

// The numbers of the same mesh in single and double precision, as in periodic_device_test.cpp. Without periodic images
// along an axis the mesh covers more than twice its length, and the potentials of neighbouring charges cancel less.
TEST_CASE("device mesh sum, open and grounded sides: forces equal the CPU's") {
  for (const Enclosure& enclosure : enclosures)
    for (const double accuracy : {1e-2, 1e-4}) {
      CAPTURE(accuracy);
      CAPTURE(&enclosure - enclosures);
      const SourceSet sources = charges_in(enclosure);
      const MeshRequest request{.accuracy = accuracy, .charges = sources.size(), .contact = 0.9, .only_double = true};
      const MeshChoice choice = choose_quick_mesh(enclosure.request(request));
      const Response expected = on_cpu(request, choice, enclosure, sources),
                     found = on_device(choice, enclosure, sources);
      CHECK(relative_difference(found.field, expected.field) < 2e-6);
      CHECK(relative_difference(found.potential, expected.potential) < 2e-6);
      CHECK(relative_difference(found.force, expected.force) < 2e-6);
      double energies = 0;
      for (int i = 0; i < sources.size(); ++i) energies += std::abs(0.5 * sources.charge[i] * expected.potential[i]);
      CHECK(std::abs(found.energy - expected.energy) < 2e-6 * energies);
    }
}

TEST_CASE("device mesh sum, open and grounded sides: the device's mesh is accurate") {
  for (const Enclosure& enclosure : enclosures) {
    CAPTURE(&enclosure - enclosures);
    const SourceSet sources = charges_in(enclosure);
    const MeshRequest fine{.accuracy = 1e-6, .charges = sources.size(), .contact = 0.9, .only_double = true};
    const Response exact = on_cpu(fine, choose_quick_mesh(enclosure.request(fine)), enclosure, sources);
    const MeshRequest request{.accuracy = 1e-3, .charges = sources.size(), .contact = 0.9, .on_device = true};
    const MeshChoice choice = choose_quick_mesh(enclosure.request(request));
    REQUIRE(choice.mesh.window == Window::prolate);
    // As for periodic sides; the charges are unequal.
    CHECK(relative_difference(on_device(choice, enclosure, sources).force, exact.force) < 1.5 * request.accuracy);
  }
}

TEST_CASE("device mesh sum, grounded sides: order and scale of charges") {
  const Enclosure& enclosure = enclosures[6];
  const SourceSet sources = charges_in(enclosure);
  const int n = sources.size();
  const MeshChoice choice = choose_quick_mesh(enclosure.request({.accuracy = 1e-3, .charges = n, .on_device = true}));
  const Response expected = on_device(choice, enclosure, sources);
  SourceSet turned = sources;
  for (int i = 0; i < n; ++i) {
    turned.charge[i] = 64 * sources.charge[n - 1 - i];
    for (int k = 0; k < 3; ++k) turned.position[3 * i + k] = sources.position[3 * (n - 1 - i) + k];
  }
  const Response found = on_device(choice, enclosure, turned);
  CHECK(found.energy == 4096 * expected.energy);
  for (int i = 0; i < n; ++i)
    for (int k = 0; k < 3; ++k) REQUIRE(found.force[3 * i + k] == 4096 * expected.force[3 * (n - 1 - i) + k]);
}

TEST_CASE("device mesh sum, grounded sides: dipoles are refused") {
  const Enclosure& enclosure = enclosures[3];
  SourceSet sources = random_sources(50, enclosure.lengths, 0.9, true, 4);
  const MeshChoice choice =
      choose_quick_mesh(enclosure.request({.accuracy = 1e-2, .charges = 50, .polarizability = 0.02}));
  const auto device = device::make_host_mesh(choice.mesh, choice.cloud(), enclosure);
  Response response;
  CHECK_THROWS_AS(device->evaluate({choice.mesh.lengths, sources.position, sources.charge, sources.dipole}, {},
                                   parallel::Team::single(), response),
                  InputError);
}

}  // namespace periodic_device_bounded_test
