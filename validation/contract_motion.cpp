// Accuracy contract of resistor networks and of the motion of conductors: random networks, and random charged
// conductors in oil.
//
//   contract_motion              a few cases: seconds
//   contract_motion long         500 cases of each guarantee
//   contract_motion FROM TO      the cases of these seeds

#include <Eigen/Core>

#include "solvers/network/conduction.hpp"
#include "src/mechanics/simulation.hpp"
#include "tests/conductance_matrix.hpp"
#include "tests/dense_algebra.hpp"
#include "tests/line_charges.hpp"
#include "tests/spheres.hpp"
#include "validation/contract.hpp"
#include "validation/program.hpp"

namespace contract_motion_validation {

using namespace lichtenberg;
using namespace lichtenberg::validation;
using network::Network;

namespace {

// Networks.

/// Returns a connected network of links to near nodes, with resistances over up to three decades.
Network random_network(CaseRandom& random, int nodes) {
  Network result{.nodes = nodes};
  const double most = random.pick({1, 10, 1e3}), links = random.uniform(1.2, 3);
  for (int b = 1; b < nodes; ++b)
    result.links.push_back({random.whole(std::max(0, b - 30), b - 1), b, random.logarithmic(1, most)});
  while (static_cast<double>(result.links.size()) < links * nodes) {
    const int a = random.whole(0, nodes - 1), b = random.whole(std::max(0, a - 30), std::min(nodes - 1, a + 30));
    if (a != b) result.links.push_back({a, b, random.logarithmic(1, most)});
  }
  return result;
}

void check_network(Contract& contract, CaseRandom& random) {
  static const Guarantee exact_solver{"network: resistance by elimination", "dense pseudo-inverse"},
      iterative{"network: resistance by multigrid", "elimination"};
  const int nodes = random.whole(5, 250), low = random.whole(0, nodes / 2 - 1),
            high = random.whole(nodes / 2, nodes - 1);
  const Network small = random_network(random, nodes);
  const Eigen::MatrixXd inverse = symmetric_pseudo_inverse(Eigen::MatrixXd(network::conductance_matrix(small)));
  const double resistance = inverse(low, low) + inverse(high, high) - 2 * inverse(low, high);
  // conduct() checks the balance of power to 1e-10.
  contract.add(exact_solver, 1e-10, std::abs(network::conduct(small, low, high).resistance / resistance - 1));
  const Network large = random_network(random, 20 * nodes);
  const double tolerance = random.pick({1e-4, 1e-6, 1e-8, 1e-10});
  const double found =
      network::conduct(large, low, 20 * high, {.method = network::Method::multigrid, .tolerance = tolerance})
          .resistance;
  contract.add(iterative, tolerance, std::abs(found / network::conduct(large, low, 20 * high).resistance - 1));
}

// Motion.

/// Returns two to eight charged conductors that do not meet, in oil.
Scene random_conductors(CaseRandom& random) {
  using steel_spheres::radius;
  std::vector<Vec2> positions;
  const int count = random.whole(2, 8);
  while (static_cast<int>(positions.size()) < count) {
    const Vec2 p{random.uniform(0.03, 0.07), random.uniform(0.03, 0.07)};
    if (std::ranges::all_of(positions, [&](Vec2 other) { return norm(p - other) > 6 * radius; }))
      positions.push_back(p);
  }
  Scene scene = steel_spheres::scene_of(positions);
  scene.effects.add<effects::FloatingConductorsOptions>();
  scene.effects.add<effects::StokesDragOptions>();
  for (Conductor& conductor : scene.conductors) {
    conductor.charge = random.uniform(1e-12, 1e-11);  // repel each other
    conductor.velocity = {random.uniform(-0.05, 0.05), random.uniform(-0.05, 0.05), 0};
  }
  scene.mechanics.position_tolerance = radius * random.pick({1e-2, 1e-3, 1e-4, 1e-5});
  scene.mechanics.relative_tolerance = 1e-3 * scene.mechanics.position_tolerance / radius;
  return scene;
}

/// Tests the positions after half a second, over the tolerance of each coupling step times the number of steps. Errors
/// do not grow, because the conductors are overdamped and repel each other.
void check_motion(Contract& contract, CaseRandom& random) {
  static const Guarantee positions{"position_tolerance: positions, all steps", "monolithic coupling at 1e-11"};
  Scene scene = random_conductors(random);
  constexpr double end = 0.5;
  scene.mechanics.largest_step = end;
  Simulation split(scene, std::make_unique<LineCharges>());
  split.advance_to(end);
  Scene reference = scene;
  reference.mechanics.coupling = FieldCoupling::monolithic;
  reference.mechanics.relative_tolerance = 1e-11;
  Simulation monolithic(reference, std::make_unique<LineCharges>());
  monolithic.advance_to(end);
  const ConductorFrame found = split.now(), exact = monolithic.now();
  double error = 0;
  for (std::size_t i = 0; i < exact.position.size(); ++i)
    error = larger(error, norm(found.position[i] - exact.position[i]));
  contract.add(positions, scene.mechanics.position_tolerance * static_cast<double>(split.counters().steps), error);
}

void check(Contract& contract, std::uint64_t seed) {
  CaseRandom networks(seed, 1), motion(seed, 2);
  check_network(contract, networks);
  check_motion(contract, motion);
}

}  // namespace

int validate(int argc, char** argv) { return Contract().run("networks and motion", argc, argv, 5, 500, check); }

const lichtenberg::validation::Program program("contract_motion", validate);

}  // namespace contract_motion_validation
