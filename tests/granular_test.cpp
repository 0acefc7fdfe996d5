#include <doctest/doctest.h>
#include <fmt/format.h>
#include "src/effects/linear_contact.hpp"
#include "src/theory/restitution.hpp"
#include "tests/grains.hpp"
using namespace lichtenberg;
using namespace lichtenberg::grains;

TEST_CASE("x") {
  for (auto which : {Integrator::cvode})
    for (double v : {.01, .1, 1., 5., 10.})
      for (double dt : {.05}) {
        Scene scene = cube(20, which);
        scene.effects.add(effects::ViscoelasticContactOptions{278.6, 27.7});
        scene.mechanics.step = dt;
        double eps = theory::collision({278.6, 27.7}, v).restitution;
        double worst = 0;
        for (int k = 0; k < 3; ++k) worst = std::max(worst, std::abs(restitution(scene, v, 1 + (k + .5) / 20) - eps)); 
        fmt::print("{} v {} dt {} worst {:.2e}\n", name_of(which), v, dt, worst);
      }
}
