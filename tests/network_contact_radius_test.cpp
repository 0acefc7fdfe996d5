// Tests of resistors whose contact radius follows from force or overlap, and of contacts across periodic sides.
#include <doctest/doctest.h>

#include <cmath>
#include <numbers>

#include "solvers/error.hpp"
#include "solvers/network/build.hpp"
#include "solvers/network/conduction.hpp"
#include "solvers/network/resistor.hpp"
#include "tests/message.hpp"

namespace network_contact_radius_test {

using namespace lichtenberg;
using namespace lichtenberg::network;
using doctest::Approx;

namespace {

constexpr double pi = std::numbers::pi, radius = 2e-3, overlap = 1e-6;
const std::vector<PackingElectrode> ends = {{true, 0}, {true, 1}};

/// Chain of three spheres between two walls. All contacts have the force `force` and the same overlap.
ParticlePacking chain(double force) {
  ParticlePacking packing{.radius = {radius, radius, radius}};
  for (int k = 0; k < 3; ++k) packing.position.push_back({0, 0, radius - overlap + k * (2 * radius - overlap)});
  packing.walls = {{"front", {}, {0, 0, 1}}, {"back", {0, 0, 6 * radius - 4 * overlap}, {0, 0, -1}}};
  packing.force = [force](double, double) { return force; };
  return packing;
}

/// particle_network as an object, with its default arguments.
constexpr auto by_particles = [](const auto&... given) { return particle_network(given...); };

/// Returns the resistances of the particle-centred and the contact-centred network.
std::pair<double, double> resistances(const ParticlePacking& packing, const char* model, const Parameters& p,
                                      const std::vector<PackingElectrode>& electrodes = ends) {
  const Contacts contacts = find_contacts(packing);
  const auto measured = [&](auto build) {
    const PackingNetwork net = build(packing, contacts, resistor_model(model), p, electrodes);
    return conduct(net.network, net.electrode[0], net.electrode[1]).resistance;
  };
  return {measured(by_particles), measured(contact_network)};
}

}  // namespace

TEST_CASE("hertz resistors: a chain has Holm's resistance of Hertz's contact radius") {
  const Parameters p{.resistivity = 7e-7, .elastic_modulus = 1.1e11};
  for (const double force : {1.0, 8.0}) {
    const double pair = std::cbrt(0.75 * force * 0.5 * radius / 1.1e11),
                 wall = std::cbrt(0.75 * force * radius / 1.1e11);
    const auto [particle, contact] = resistances(chain(force), "hertz", p);
    CHECK(particle == Approx(2 * 7e-7 / (2 * pair) + 2 * 7e-7 / (4 * wall)).epsilon(1e-13));
    CHECK(contact == Approx(particle).epsilon(1e-13));
  }
  // R ~ F^(-1/3): eight times the force halves the resistance
  CHECK(resistances(chain(1), "hertz", p).first == Approx(2 * resistances(chain(8), "hertz", p).first).epsilon(1e-13));
}

TEST_CASE("overlap resistors: equal hertz resistors of the force of that overlap") {
  // F = 4/3 E* R^(1/2) delta^(3/2) has b^2 = R delta; walls have twice the effective radius
  constexpr double modulus = 1.1e11;
  ParticlePacking packing = chain(0);
  packing.force = [](double distance, double reach) {
    const double effective = reach > 1.5 * radius ? 0.5 * radius : radius;
    return 4.0 / 3 * modulus * std::sqrt(effective) * std::pow(reach - distance, 1.5);
  };
  const double hertz = resistances(packing, "hertz", {.resistivity = 1e-6, .elastic_modulus = modulus}).first;
  const auto [particle, contact] = resistances(packing, "overlap", {.resistivity = 1e-6});
  CHECK(particle == Approx(hertz).epsilon(1e-9));  // rounding of positions over the overlap
  CHECK(contact == Approx(particle).epsilon(1e-12));
}

TEST_CASE("film resistance: a film adds its resistance over the contact's area") {
  const Parameters bare{.resistivity = 7e-7, .elastic_modulus = 1.1e11};
  Parameters film = bare;
  film.film_resistance = 3e-12;
  const double pair = std::cbrt(0.75 * 2 * 0.5 * radius / 1.1e11), wall = std::cbrt(0.75 * 2 * radius / 1.1e11);
  const double added = 2 * 3e-12 / (pi * pair * pair) + 2 * 3e-12 / (pi * wall * wall);
  const auto [particle, contact] = resistances(chain(2), "hertz", film);
  CHECK(particle == Approx(resistances(chain(2), "hertz", bare).first + added).epsilon(1e-13));
  CHECK(contact == Approx(particle).epsilon(1e-13));
  const Parameters fixed{.resistivity = 7e-7, .contact_radius = 1e-5, .film_resistance = 3e-12};
  const auto [by_particle, by_contact] = resistances(chain(2), "constriction", fixed);
  CHECK(by_particle == Approx(6 * 7e-7 / 4e-5 + 4 * 3e-12 / (pi * 1e-10)).epsilon(1e-13));
  CHECK(by_contact == Approx(by_particle).epsilon(1e-13));
}

TEST_CASE("greenwood resistors: rough contacts have R ~ 1/F below, F^(-1/3) above") {
  Parameters p{.resistivity = 7e-7, .elastic_modulus = 1.1e11, .hardness = 5e9, .spot_radius = 1e-9};
  const double force = 2, pair = std::cbrt(0.75 * force * 0.5 * radius / 1.1e11),
               wall = std::cbrt(0.75 * force * radius / 1.1e11), asperities = force / (pi * 5e9 * 1e-18);
  const auto [particle, contact] = resistances(chain(force), "greenwood", p);
  CHECK(particle == Approx(7e-7 / 2 * (2 * (1 / (asperities * 1e-9) + 1 / pair) + 1 / (asperities * 1e-9) + 1 / wall))
                        .epsilon(1e-13));
  CHECK(contact == Approx(particle).epsilon(1e-13));
  p.spot_radius = 1e-3;  // few large spots, whose number counts
  p.hardness = 5e12;
  const double low = resistances(chain(1e-6), "greenwood", p).first;
  CHECK(low == Approx(2 * resistances(chain(2e-6), "greenwood", p).first).epsilon(1e-2));
}

TEST_CASE("contact radius from a load: impossible materials are refused") {
  const Parameters p{.resistivity = 1, .elastic_modulus = 1e11};
  ParticlePacking unknown = chain(1);
  unknown.force = {};
  CHECK(message_of<InputError>([&] { resistances(unknown, "hertz", p); }).find("needs the forces of contacts") !=
        std::string::npos);
  CHECK(message_of<InputError>([&] {
          resistances(chain(1), "hertz", {.resistivity = 1, .elastic_modulus = 1});
        }).find("elastic_modulus = 1 Pa is too small") != std::string::npos);
  CHECK(message_of<InputError>([&] {
          resistances(chain(1), "greenwood",
                      {.resistivity = 1, .elastic_modulus = 1e11, .hardness = 1e3, .spot_radius = 1e-9});
        }).find("hardness = 1000 Pa is too small") != std::string::npos);
  CHECK(message_of<InputError>(
            [&] { check(resistor_model("hertz"), {.resistivity = 1, .elastic_modulus = 1, .hardness = 1}); })
            .find("does not use hardness: leave it out; allowed is resistivity and elastic_modulus, and optional "
                  "film_resistance") != std::string::npos);
}

TEST_CASE("periodic ring of spheres: the network closes across the side") {
  // Eight spheres of radius 0.55 on the axis of a box of length 8: k (n - k) / n between spheres apart by k
  ParticlePacking packing{.radius = std::vector<double>(8, 0.55)};
  for (int k = 0; k < 8; ++k) packing.position.push_back({k + 0.3, 1, 1});
  packing.box = {.lengths = {8, 2, 2}};
  packing.box.sides[0] = packing.box.sides[1] = Boundary::periodic;
  CHECK(find_contacts(packing).pairs.size() == 8);
  const std::vector<PackingElectrode> far{{false, 1}, {false, 4}}, near{{false, 7}, {false, 2}};
  const auto [particle, contact] = resistances(packing, "length", {.resistance_per_length = 1}, far);
  CHECK(particle == Approx(3.0 * 5 / 8));
  CHECK(contact == Approx(2.0 * 4 / 6));  // the electrodes themselves have no resistance: paths of 2 and 4 spheres
  CHECK(resistances(packing, "length", {.resistance_per_length = 1}, near).first == Approx(3.0 * 5 / 8));
}

}  // namespace network_contact_radius_test
