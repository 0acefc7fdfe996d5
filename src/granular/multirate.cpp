#include "src/granular/integrator.hpp"

namespace lichtenberg::granular {
namespace {

/// Forces of charges act as impulses at both ends of a step (Tuckerman, Berne and Martyna 1992), between which contacts
/// alone move the grains. Charges move from grain to grain between the impulses of two steps, each with its own
/// charges.
class Multirate final : public Integrator {
 public:
  double longest_step(const Gas& gas) const override {
    const double speed = gas.fastest(), most = gas.scene().mechanics.step;
    return speed * most > path ? path / speed : most;
  }

  void step(Gas& gas, double end) override {
    const double begin = gas.time(), half = 0.5 * (end - begin);
    gas.kick(half);
    gas.drive(begin, half);
    gas.follow_contacts(end);
    gas.drive(begin + half, half);
    gas.kick(half);
    gas.settle_contacts();
  }

 private:
  /// No grain flies farther in a step, in diameters: forces change over a diameter.
  static constexpr double path = 0.2;
};

}  // namespace

std::unique_ptr<Integrator> make_multirate() { return std::make_unique<Multirate>(); }

}  // namespace lichtenberg::granular
