#include "validation/theory/two_grains.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <boost/math/tools/toms748_solve.hpp>
#include <cmath>
#include <span>
#include <vector>

#include "solvers/error.hpp"
#include "solvers/ode/ode.hpp"

namespace lichtenberg::theory {
namespace {

using State = std::span<const double>;  // overlap xi, its rate xi', dissipated energy

constexpr double nearly = 1e-10;  ///< fraction of the impact energy that a pair at rest may have

double spring(const TwoGrains& pair, double overlap) { return pair.elastic * std::pow(overlap, pair.exponent); }
double stored(const TwoGrains& pair, double overlap) { return spring(pair, overlap) * overlap / (pair.exponent + 1); }

/// Returns a value with the sign of the contact force before the non-attractive cut-off.
double pressure(const TwoGrains& pair, State y) { return pair.elastic * y[0] + pair.dissipative * y[1]; }

/// Returns the energy of an attracting pair above that of rest, from differences without cancellation.
double above_rest(const TwoGrains& pair, double rest, State y) {
  const double coulomb = pair.coulomb * (y[0] - rest) / ((1 - y[0]) * (1 - rest));
  return pair.effective_mass * y[1] * y[1] / 2 + stored(pair, std::max(y[0], 0.0)) - stored(pair, rest) + coulomb;
}

/// State of a contact during its integration.
struct Motion {
  Motion(const TwoGrains& p, double impact);
  void rates(bool pressing, State y, std::span<double> rate) const;
  int follow(bool pressing, const std::vector<Ode::Value>& falls);
  Ode::Value comes_to_rest() const;

  TwoGrains pair;
  double rest = 0;  ///< static overlap
  double time = 0, natural_time = 0, enough = 0;
  std::vector<double> y, absolute;
};

Motion::Motion(const TwoGrains& p, double impact) : pair(p), rest(static_overlap(p)), y{0, impact, 0} {
  const double twice_kinetic = pair.effective_mass * impact * impact;
  const double depth = std::pow(twice_kinetic / pair.elastic, 1 / (pair.exponent + 1));
  natural_time = depth / impact;
  absolute = {1e-16 * depth, 1e-16 * impact, 1e-16 * twice_kinetic};
  enough = nearly * above_rest(pair, rest, y);
}

void Motion::rates(bool pressing, State now, std::span<double> rate) const {
  const double overlap = std::max(now[0], 0.0), distance = 1 - now[0];
  const double force = pressing ? std::pow(overlap, pair.exponent - 1) * pressure(pair, now) : 0;
  rate[0] = now[1];
  rate[1] = -(force + pair.coulomb / (distance * distance)) / pair.effective_mass;
  rate[2] = (force - spring(pair, overlap)) * now[1];
}

/// Integrates to the first of the events and returns its index. From onset the variable is sigma, with time = sigma^2.
int Motion::follow(bool pressing, const std::vector<Ode::Value>& falls) {
  const bool touch = time == 0;
  const auto by_sigma = [&](double sigma, State now, std::span<double> rate) {
    rates(pressing, now, rate);
    for (double& r : rate) r *= touch ? 2 * sigma : 1;
  };
  Ode ode{.rates = by_sigma, .absolute = absolute, .falls = falls};
  constexpr double centres_meet = 1e-6;
  ode.falls.push_back([](double, State now) { return 1 - now[0] - centres_meet; });
  OdeEnd end{.time = time};
  while (end.event < 0) {
    const double start = end.time;
    end = integrate(ode, start, start + 100 * (touch ? std::sqrt(natural_time) : natural_time), y);
  }
  time = touch ? end.time * end.time : end.time;
  if (end.event + 1u == ode.falls.size())
    throw Failure("theory: the centres of two grains meet; their contact is too soft for this speed and charge");
  return end.event;
}

/// Returns an event function that is positive until an attracting pair is at rest.
Ode::Value Motion::comes_to_rest() const {
  return [this](double, State now) { return pair.coulomb < 0 ? above_rest(pair, rest, now) - enough : 1; };
}

}  // namespace

PairContact contact(const TwoGrains& pair, double impact) {
  Motion motion(pair, impact);
  const Ode::Value rests = motion.comes_to_rest();
  const Ode::Value turns = [](double, State y) { return y[1]; }, parts = [](double, State y) { return y[0]; };
  const Ode::Value gives_way = [&](double, State y) { return pressure(pair, y); };
  const Ode::Value presses = [&](double, State y) { return -pressure(pair, y); };

  PairContact found;
  bool at_rest = motion.follow(true, {turns, rests}) == 1;
  found.deepest = motion.y[0];
  while (!at_rest && !found.opens) {
    at_rest = motion.follow(true, {gives_way, rests}) == 1;
    if (at_rest) break;
    found.force_ends = motion.time;
    found.opens = pair.dissipative == 0 || motion.follow(false, {parts, presses}) == 0;
  }
  if (at_rest) found.force_ends = 0;
  found.release = found.opens ? -motion.y[1] : 0;
  found.duration = motion.time;
  found.dissipated = motion.y[2];
  return found;
}

PairOutcome outcome(const TwoGrains& pair, double impact) {
  const double escape = escape_speed(pair);
  PairOutcome found;
  for (double speed = impact; found.contacts == 0 || (found.captured && found.last > 0); speed = found.last) {
    const PairContact now = contact(pair, speed);
    ++found.contacts;
    found.dissipated += now.dissipated;
    found.captured = now.release < escape;
    if (now.opens) found.last = now.release;
    if (!now.opens || pair.dissipative == 0) break;
  }
  return found;
}

double escape_speed(const TwoGrains& pair) { return std::sqrt(std::max(0.0, -2 * pair.coulomb / pair.effective_mass)); }

double static_overlap(const TwoGrains& pair) {
  if (pair.coulomb >= 0) return 0;
  const auto excess = [&](double x) { return spring(pair, x) * (1 - x) * (1 - x) + pair.coulomb; };
  const double strongest = pair.exponent / (pair.exponent + 2);  // overlap at which the left side is largest
  if (excess(strongest) < 0)
    throw InputError(fmt::format("a contact of E = {} cannot hold two grains that attract each other with {} at touch",
                                 pair.elastic, -pair.coulomb));
  std::uintmax_t iterations = 200;
  const auto [low, high] = boost::math::tools::toms748_solve(excess, 0.0, strongest,
                                                             boost::math::tools::eps_tolerance<double>(52), iterations);
  return (low + high) / 2;
}

double static_energy(const TwoGrains& pair) {
  const double overlap = static_overlap(pair);
  return stored(pair, overlap) + pair.coulomb / (1 - overlap);
}

double capture_speed(const TwoGrains& pair) {
  const double escape = escape_speed(pair);
  if (escape == 0 || pair.dissipative == 0) return escape;
  const auto excess = [&](double impact) { return contact(pair, impact).release - escape; };
  double high = 2 * escape;
  while (excess(high) < 0) high *= 2;
  std::uintmax_t iterations = 100;
  const auto [below, above] = boost::math::tools::toms748_solve(
      excess, escape, high, boost::math::tools::eps_tolerance<double>(36), iterations);
  return (below + above) / 2;
}

}  // namespace lichtenberg::theory
