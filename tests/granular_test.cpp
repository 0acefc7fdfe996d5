#include <doctest/doctest.h>
#include <fmt/format.h>
#include "src/effects/linear_contact.hpp"
#include "src/theory/restitution.hpp"
#include "tests/grains.hpp"
using namespace lichtenberg;
using namespace lichtenberg::grains;

TEST_CASE("x") {
  for (auto which : {Integrator::multirate, Integrator::verlet, Integrator::gear, Integrator::gear_printed, Integrator::cvode})
    for (double v : {.01, .1, 1., 5., 10.})
      for (double dt : {.02, .01, .005, .002, .001}) {
        Scene scene = cube(20, which);
        scene.effects.add(effects::ViscoelasticContactOptions{278.6, 27.7});
        scene.mechanics.step = dt;
        double eps = theory::collision({278.6, 27.7}, v).restitution;
        double worst = 0;
        try { for (int k = 0; k < 20; ++k) worst = std::max(worst, std::abs(restitution(scene, v, 1 + (k + .5) / 20) - eps)); }
        catch (std::exception& e) { fmt::print("{}\n", e.what()); continue; }
        fmt::print("{} v {} dt {} worst {:.2e}\n", name_of(which), v, dt, worst);
        if (which == Integrator::cvode) break;
      }
}
