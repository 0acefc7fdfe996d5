#include <fmt/format.h>

#include <array>
#include <cmath>
#include <functional>

#include "validation/fuzz/grammar.hpp"

namespace lichtenberg::fuzz {
namespace {

/// Key of a table. A fixed value is always written; of the others a random selection is.
struct GasKey {
  std::string name;
  std::function<std::string(Dice& dice)> sensible;
  bool fixed = false;
};
using GasKeys = std::vector<GasKey>;

const std::vector<std::string> extremes{"0",     "-1",  "1e-300", "1e-30",   "1e-6", "1e6",    "1e30",
                                        "1e300", "nan", "inf",    "\"all\"", "true", "[1, 2]", "1"};

std::string decades(Dice& dice, double low, double high) {
  return fmt::format("{:.4g}", std::pow(10.0, dice.between(low, high)));
}
std::string value(Dice& dice, std::string sensible, double wild) {
  return dice.chance(wild) ? dice.of(extremes) : sensible;
}

GasKey between(std::string name, double low, double high) {
  return {std::move(name), [=](Dice& dice) { return decades(dice, low, high); }};
}
GasKey one_of(std::string name, std::vector<std::string> values) {
  return {std::move(name), [values = std::move(values)](Dice& dice) { return dice.of(values); }};
}
GasKey flag(std::string name) { return one_of(std::move(name), {"true", "false"}); }
GasKey whole(std::string name, std::size_t low, std::size_t high) {
  return {std::move(name), [=](Dice& dice) { return std::to_string(low + dice.below(high - low + 1)); }};
}
GasKey fixed(std::string name, std::string text) {
  return {std::move(name), [text = std::move(text)](Dice&) { return text; }, true};
}

GasKeys with(GasKeys keys, const GasKeys& more) {
  keys.insert(keys.end(), more.begin(), more.end());
  return keys;
}

struct GasEffect {
  std::string name;
  double probability;
  std::vector<GasKeys> alternatives;
};

std::vector<GasEffect> gas_effects() {
  const GasKeys coulomb{between("coupling_constant", -5, 1)},
      exchange{between("transfer_prefactor", -4, 0), between("capacity", 1, 2)};
  return {{"viscoelastic_contact", 0.02, {{between("stiffness", 1.5, 4), between("damping", 0, 2)}}},
          {"linear_contact", 0.02, {{between("stiffness", 1.5, 4), between("restitution", -1, 0)}}},
          {"coulomb",
           0.6,
           {with(coulomb, {between("accuracy", -7, -1)}),
            with(coulomb, {between("accuracy", -4, -1), whole("order", 4, 8)}),
            with(coulomb,
                 {between("cutoff", 0, 0.5), whole("mesh", 8, 40), whole("order", 4, 8), between("alpha", -1, 0.3)}),
            with(coulomb, {fixed("sum", "\"ewald\""), between("accuracy", -9, -1)}),
            with(coulomb, {fixed("sum", "\"minimum-image\"")}),
            with(coulomb, {fixed("sum", "\"shifted-force\""), between("cutoff", 0, 0.5), between("damping", -2, 0)})}},
          {"charge_exchange",
           0.5,
           {with(exchange, {fixed("model", "\"impact\""), between("exponent", -1, 0.5), flag("each_step")}),
            with(exchange, {fixed("model", "\"random-walk\""), between("rate", -1, 2)}),
            with(exchange, {fixed("model", "\"contact-area\""), between("rate", -1, 2)}),
            {fixed("model", "\"none\"")}}},
          {"induced_dipoles",
           0.1,
           {{between("polarizability", -3, -1.3), between("tolerance", -6, -2),
             one_of("sum", {"\"ewald\"", "\"mixed-consistent\"", "\"minimum-image\"", "\"source\""})}}},
          {"gas_drag", 0.1, {{between("stokes", -2, 1), between("speed", -1, 1), between("correlation_time", -2, 0)}}},
          {"uniform_force", 0.1, {{fixed("acceleration", "[0, 0, 1e-3]")}}}};
}

std::vector<GasKeys> populations() {
  const GasKeys any{between("temperature", -6, 1), between("min_gap", -3, -1),
                    one_of("radius", {"0.5", "0.4", "[0.3, 0.6]"})};
  return {any, with(any, {between("charge", -2, 1)}),
          with(any, {fixed("charge", "1"), fixed("charge_distribution", "\"gaussian\"")}),
          with(any, {fixed("charge", "2"), fixed("charge_distribution", "\"exponential-power\""),
                     fixed("charge_exponent", "0.8")})};
}

const std::vector<GasKeys> stages{{flag("elastic"), between("stiffness", 0, 2), between("temperature", -3, 1)}};
const std::vector<GasKeys> motions{
    {one_of("integrator", {"\"multirate\"", "\"verlet\"", "\"gear\"", "\"gear-printed\"", "\"cvode\""}),
     between("step", -3.5, -2.5), whole("threads", 1, 3)},
    {between("step", -3, 0.5), whole("contact_substeps", 10, 60), whole("threads", 1, 3)}};

/// Returns a table with one of the alternative lists of keys.
std::string table(Dice& dice, double wild, const std::string& header, const std::vector<GasKeys>& alternatives) {
  std::string text = header + "\n";
  for (const GasKey& key : dice.of(alternatives))
    if (key.fixed || dice.chance(0.6))
      text +=
          fmt::format("{} = {}\n", key.name, key.fixed ? key.sensible(dice) : value(dice, key.sensible(dice), wild));
  return text;
}

std::string box(Dice& dice, double wild) {
  static const std::array<const char*, 6> sides{"left", "right", "bottom", "top", "front", "back"};
  const std::size_t dimension = dice.chance(0.03) ? 2 : 3;
  std::string edges, text;
  for (std::size_t k = 0; k < dimension; ++k)
    edges += (k > 0 ? ", " : "") + value(dice, fmt::format("{:.3f}", dice.between(2.5, 12)), wild / 3);
  for (std::size_t k = 0; k < 2 * dimension; ++k)
    if (!dice.chance(wild / 6)) text += fmt::format("{} = \"periodic\"\n", sides[k]);
  return fmt::format("[domain]\nsize = [{}]\n{}", edges, text);
}

}  // namespace

std::string random_gas(Dice& dice) {
  static const std::vector<GasEffect> effects = gas_effects();
  static const std::vector<GasKeys> kinds = populations();
  const double wild = dice.of(std::array{0.0, 0.0, 0.03, 0.15});
  std::string text = "[units]\n" + box(dice, wild);
  for (std::size_t k = dice.of(std::array{0, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 2, 2}); k > 0; --k)
    text += table(dice, wild, fmt::format("[[population]]\ncount = {}", 1 + dice.below(40)), kinds);
  const std::string contact = dice.chance(2.0 / 3) ? "viscoelastic_contact" : "linear_contact";
  for (const GasEffect& effect : effects)
    if (effect.name == contact || dice.chance(effect.probability))
      text += table(dice, wild, fmt::format("[effects.{}]", effect.name), effect.alternatives);
  for (std::size_t k = dice.of(std::array{0, 0, 1, 2}); k > 0; --k)
    text += table(dice, wild, "[[equilibration]]\nduration = " + value(dice, decades(dice, -2, -1), wild), stages);
  if (dice.chance(0.5)) text += table(dice, wild, "[mechanics]", motions);
  return text + fmt::format("[stop]\ntime = {}\n[output]\npicture = false\nevery = {}\n",
                            value(dice, decades(dice, -2, -0.5), wild), value(dice, decades(dice, -2, 0), wild / 3));
}

}  // namespace lichtenberg::fuzz
