#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "solvers/error.hpp"
#include "src/granular/integrator.hpp"
#include "src/granular/pace.hpp"
#include "src/scene/effect_kind.hpp"

namespace lichtenberg::granular {
namespace {

/// Forces of charges are held over a step, within which contacts are followed by steps of their own, and then put
/// right: velocity Verlet for the charges. Where nothing touches it is the same as impulses at both ends of a step
/// (Tuckerman, Berne and Martyna 1992); but impulses shake contacts that hold a bound pair, which dissipate what they
/// gain by it, step after step. Charges move from grain to grain between two steps, each with its own charges.
class Multirate final : public GasIntegrator {
 public:
  double longest_step(Gas& gas) const override {
    const double speed = gas.fastest(), asked = gas.scene().mechanics.step, hold = longest_hold(gas);
    if (std::isinf(asked)) return std::min(hold, by_accuracy(gas, speed));
    if (asked > hold && gas.steps == 0)  // later, when charges have grown, steps become shorter by themselves
      throw InputError(
          fmt::format("{}: mechanics.step = {:g} is too long: forces that are held so long would drive the swinging of "
                      "grains that their charges hold together; {:.2g} is the longest",
                      gas.scene().path, asked, 0.99 * hold));
    const double most = std::min(asked, hold);
    return speed * most > longest_way ? longest_way / speed : most;
  }

  void step(Gas& gas, double end) override {
    const double begin = gas.time(), half = 0.5 * (end - begin);
    gas.drive(begin, half);
    gas.follow_contacts(end);
    gas.drive(begin + half, half);
    gas.settle_contacts();
  }

 private:
  static double by_accuracy(Gas& gas, double speed) {
    const double accuracy = number_in(gas.scene(), &EffectKind::force_accuracy).value();
    const double acceleration = gas.largest_smooth_acceleration();
    const std::vector<double>& radius = gas.bodies().radius;
    const double way = way_for(accuracy, radius.size(), 2 * *std::ranges::min_element(radius));
    const double step = time_for(way, speed, acceleration);
    // Shorter than a step of contacts gains nothing.
    const double impact = gas.fastest_impact() + 2 * acceleration * step;
    return std::max(step, shortest_contact(gas.law(), impact) / gas.scene().mechanics.contact_steps);
  }
};

}  // namespace

std::unique_ptr<GasIntegrator> make_multirate() { return std::make_unique<Multirate>(); }

}  // namespace lichtenberg::granular
