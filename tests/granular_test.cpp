#include <doctest/doctest.h>

#include <cmath>
#include <random>

#include "src/granular/contact_motion.hpp"
#include "src/model/neighbours.hpp"

using namespace lichtenberg;
using namespace lichtenberg::granular;

namespace {

Bodies grains(int n) {
  Bodies bodies{.dimension = 3};
  bodies.position.assign(3 * n, 0);
  bodies.momentum.assign(3 * n, 0);
  bodies.mass.assign(n, 1);
  bodies.radius.assign(n, 0.5);
  bodies.box.lengths = {20, 20, 20};
  bodies.box.sides.fill(Boundary::periodic);
  return bodies;
}

double kinetic(const Bodies& b) {
  double e = 0;
  for (std::size_t k = 0; k < b.momentum.size(); ++k) e += b.momentum[k] * b.momentum[k] / (2 * b.mass[k / 3]);
  return e;
}

/// A ball of n grains flying to its centre.
Bodies imploding(int n, double speed) {
  Bodies b = grains(n);
  std::mt19937 random(3);
  std::uniform_real_distribution<double> u(-2.2, 2.2);
  for (int i = 0; i < n; ++i) {
    for (bool placed = false; !placed;) {
      for (int k = 0; k < 3; ++k) b.position[3 * i + k] = u(random);
      placed = true;
      for (int j = 0; j < i; ++j) placed &= norm(position<3>(b, i) - position<3>(b, j)) > 1.05;
    }
    for (int k = 0; k < 3; ++k) b.momentum[3 * i + k] = -speed * b.position[3 * i + k];
  }
  return b;
}

struct End {
  Bodies bodies;
  double left_over, dissipated;
};

End run(Bodies b, const ContactLaw& law, double dt, double until, parallel::Team& team = parallel::Team::single()) {
  const auto motion = make_contact_motion(law, 3);
  const double before = kinetic(b);
  ContactRecord record;
  for (double t = 0; t < until - 1e-9; t += dt)
    motion->advance(b, pairs_closer_than(b, 0.6), t, dt, 1, team, record);
  return {b, kinetic(b) + motion->stored_energy(b) + record.dissipated - before, record.dissipated};
}

}  // namespace

TEST_CASE("x") {
  for (double D : {0.0, 27.7}) {
    const ContactLaw law = effects::ViscoelasticLaw{278.6, D};
    End ref = run(imploding(13, 0.5), law, 0.0003125, 1.6);
    for (double dt : {0.02, 0.01, 0.005, 0.0025, 0.00125}) {
      End e = run(imploding(13, 0.5), law, dt, 1.6);
      double worst = 0;
      for (int k = 0; k < 39; ++k) worst = std::max(worst, std::abs(e.bodies.momentum[k] - ref.bodies.momentum[k]));
      double p = 0;
      for (int k = 0; k < 39; k += 3) p += e.bodies.momentum[k];
      MESSAGE(D << " " << dt << " " << worst << " left " << e.left_over << " of " << e.dissipated << " p " << p);
    }
  }
}
