#include "src/effects/charge_exchange.hpp"

#include <fmt/format.h>

#include <cmath>

#include "solvers/error.hpp"
#include "src/effects/device_forces.hpp"
#include "src/effects/uniform_field.hpp"
#include "src/effects/vector_key.hpp"
#include "src/model/checkpoint.hpp"
#include "src/model/motion.hpp"
#include "src/model/neighbours.hpp"
#include "src/scene/si.hpp"

namespace lichtenberg::effects {
namespace {

bool has_sign(ExchangeModel model) {
  return model == ExchangeModel::size || model == ExchangeModel::material || model == ExchangeModel::polarization;
}

/// Returns true for models that transfer charge in each step of a contact, at a rate.
bool is_by_time(ExchangeModel model) {
  return model == ExchangeModel::random_walk || model == ExchangeModel::contact_area;
}

double effective_mass(const Bodies& bodies, Pair pair) {
  return bodies.mass[pair.i] * bodies.mass[pair.j] / (bodies.mass[pair.i] + bodies.mass[pair.j]);
}

/// Returns the vector (d0) from the centre of the second grain to that of the first.
Vec3 separation(const Bodies& bodies, Pair pair) {
  return visit_spheres(bodies, [&](const auto& s) {
    const auto r = s.box.difference(s.centre(pair.i), s.centre(pair.j));
    Vec3 result{};
    for (int k = 0; k < bodies.dimension; ++k) result[k] = r[k];
    return result;
  });
}

/// Returns the law of a model with one transfer in a collision.
CollisionExchange collision_exchange(const ChargeExchangeOptions& options) {
  CollisionExchange law;
  switch (options.model) {
    case ExchangeModel::size:
      law.drive = ExchangeDrive::size;
      break;
    case ExchangeModel::material:
      law.drive = ExchangeDrive::material;
      break;
    case ExchangeModel::polarization:
      law.drive = ExchangeDrive::field;
      break;
    case ExchangeModel::patches:
      law.drive = ExchangeDrive::patches;
      break;
    default:
      break;
  }
  law.patch = {options.strength, options.patches, options.exponent};
  law.impact = {options.strength, options.exponent};
  law.directed = {options.strength, options.exponent, options.feedback, options.memory.value_or(INFINITY)};
  if (options.field) law.field = options.field->value;
  law.capacity = options.capacity.value_or(INFINITY);
  return law;
}

/// Throws InputError for affinities or a field that the model requires and the file lacks, or of a wrong length.
void check_drive(const Draft& draft, const ChargeExchangeOptions& options) {
  const auto refuse_it = [&](const std::string& key, const std::string& message) {
    const int line = draft.line("effects.charge_exchange." + key);
    refuse(draft.scene.path, line > 0 ? line : draft.line("effects.charge_exchange.model"),
           "effects.charge_exchange." + key + " " + message);
  };
  const std::size_t tables = draft.conductors.size() + draft.populations.size();
  const auto check_count = [&](const std::string& key, const std::vector<double>& table_values) {
    if (table_values.size() != tables)
      refuse_it(key, fmt::format(
                         "{} model = \"{}\" needs one for each [[conductor]] and then for each [[population]], {} "
                         "in all",
                         table_values.empty() ? "is missing:" : fmt::format("has {} numbers, and", table_values.size()),
                         name_of(options.model), tables));
  };
  if (options.model == ExchangeModel::material) check_count("affinities", options.affinities);
  if (!options.donors.empty()) check_count("donors", options.donors);
  if (options.model != ExchangeModel::polarization) return;
  require_in_si(draft, "effects.charge_exchange.field");
  if (!options.field && draft.scene.effects.has("uniform_field")) return;
  if (!options.field) refuse_it("field", "is missing: model = \"polarization\" needs it or effects.uniform_field");
  check_components(draft, "effects.charge_exchange.field", *options.field);
}

/// Throws InputError for positive feedback without a capacity, or with one at which sums of charges are not exact.
void check_growth(const Draft& draft, const ChargeExchangeOptions& options) {
  constexpr double exact = 1 << 22;  // of the prefactor (charge_quantum())
  const double most = exact * options.strength;
  if (options.feedback > 0 && options.capacity.value_or(INFINITY) > most)
    refuse(draft.scene.path, draft.line("effects.charge_exchange.feedback"),
           fmt::format("effects.charge_exchange.feedback = {:g} is not allowed: charges that grow without limit need "
                       "effects.charge_exchange.capacity, at most {:g}",
                       options.feedback, most));
}

void check_charge_exchange(const Draft& draft) {
  const auto& options = *draft.scene.effects.find<ChargeExchangeOptions>();
  const bool impact = options.model == ExchangeModel::impact, none = options.model == ExchangeModel::none;
  const auto only_with = [&](const std::string& key, bool allowed, const std::string& models) {
    if (!allowed)
      refuse_if_given(draft, "effects.charge_exchange." + key,
                      fmt::format("is not allowed with effects.charge_exchange.model = \"{}\": it is for {}",
                                  name_of(options.model), models));
  };
  const bool sign = has_sign(options.model), patches = options.model == ExchangeModel::patches;
  if (!none) require_in_si(draft, "effects.charge_exchange.transfer_prefactor");
  if (is_by_time(options.model)) require_in_si(draft, "effects.charge_exchange.rate");
  const std::string with_sign = "\"size\", \"material\" and \"polarization\"";
  only_with("exponent", impact || sign || patches, "\"impact\", \"patches\", " + with_sign);
  only_with("each_step", impact, "\"impact\"");
  only_with("rate", is_by_time(options.model), "\"random-walk\" and \"contact-area\"");
  for (const char* key : {"patches", "donors"}) only_with(key, patches, "\"patches\"");
  for (const char* key : {"feedback", "memory"}) only_with(key, sign, with_sign);
  only_with("affinities", options.model == ExchangeModel::material, "\"material\"");
  only_with("field", options.model == ExchangeModel::polarization, "\"polarization\"");
  check_drive(draft, options);
  check_growth(draft, options);
  for (const char* key : {"transfer_prefactor", "capacity", "over_capacity"}) only_with(key, !none, "the other models");
  if (!options.capacity)
    refuse_if_given(draft, "effects.charge_exchange.over_capacity",
                    "needs effects.charge_exchange.capacity: add it, or leave the key out");
}

/// Returns the number of each grain from those of [[conductor]] and [[population]]; empty if these are.
std::vector<double> grain_values(const Draft& draft, const std::vector<double>& table_values) {
  std::vector<double> all;
  if (table_values.empty()) return all;
  auto number = table_values.begin();
  for (std::size_t k = 0; k < draft.conductors.size(); ++k) all.push_back(*number++);
  for (const PopulationDraft& population : draft.populations) all.insert(all.end(), population.count, *number++);
  return all;
}

/// Sets the affinity or the donors of each grain from those of the tables, and the field from that of
/// effects.uniform_field.
void complete_charge_exchange(const Draft& draft, Scene& scene) {
  auto& options = *scene.effects.find<ChargeExchangeOptions>();
  if (const auto* external = scene.effects.find<UniformFieldOptions>();
      external && options.model == ExchangeModel::polarization && !options.field)
    options.field = external->field;
  options.affinity = grain_values(draft, options.affinities);
  if (options.model == ExchangeModel::patches) {
    if (draft.line("effects.charge_exchange.exponent") == 0)
      options.exponent = 0.4;  // area of Hertz's contact at the largest overlap
    options.affinity = grain_values(draft, options.donors);
    if (options.donors.empty()) options.affinity.assign(scene.conductors.size(), 0.5);
  }
  if (!options.capacity) return;
  for (const Conductor& grain : scene.conductors)
    if (std::abs(grain.charge) > *options.capacity)
      refuse(scene.path, draft.line("effects.charge_exchange.capacity"),
             fmt::format("effects.charge_exchange.capacity = {:g} is not allowed: a grain has the charge {:g} at the "
                         "start, and at least its magnitude is needed",
                         *options.capacity, grain.charge));
}

/// Returns the course of the charge difference of two grains that collide again and again (DirectedExchange), or the
/// rms charge of a collision (PatchExchange).
std::vector<ExplanationLine> explain_charge_exchange(const Scene& scene) {
  const auto& options = *scene.effects.find<ChargeExchangeOptions>();
  if (options.model == ExchangeModel::patches)
    return {{"transferred charge",
             fmt::format("{:g} pairs of patches of {:g} q0 at an energy of 1 m0 v0^2: rms {:.4g} q0 of equal grains",
                         options.patches, options.strength, options.strength * std::sqrt(0.5 * options.patches))}};
  if (!has_sign(options.model)) return {};
  const double growth = 2 * options.strength * options.feedback;
  std::string text = fmt::format("{:g} q0 times the drive per collision of energy 1 m0 v0^2, by {}", options.strength,
                                 name_of(options.model));
  if (growth < 0)
    text += fmt::format("; two grains saturate at a difference of {:.4g} q0 times the drive", -1 / options.feedback);
  if (growth > 0)
    text += fmt::format("; differences grow by {:.4g} per collision, up to charges of {:g} q0", 1 + growth,
                        *options.capacity);
  if (options.memory) text += fmt::format("; 1/e of it after {:g} collisions", *options.memory);
  return {{"transferred charge", text}};
}

void charge_exchange_on_device(const Scene& scene, DeviceForces& forces) {
  const auto& options = *scene.effects.find<ChargeExchangeOptions>();
  forces.charged = true;
  if (options.model == ExchangeModel::none) return;
  if (is_by_time(options.model))
    refuse_on_device(scene, fmt::format("effects.charge_exchange.model = \"{}\"", name_of(options.model)));
  if (options.each_step) refuse_on_device(scene, "effects.charge_exchange.each_step");
  if (options.capacity && options.over_capacity == OverCapacity::reset)
    refuse_on_device(scene, "effects.charge_exchange.over_capacity = \"reset\", which does not conserve charge");
  forces.exchange = collision_exchange(options);
  forces.affinity = options.affinity;
  forces.exchanges = true;
}

}  // namespace

const EffectKind& ChargeExchangeOptions::kind() {
  static const EffectKind kind = {
      .name = "charge_exchange",
      .description = "grains in contact exchange charge",
      .help =
          "Grains in contact transfer equal and opposite charges: of random sign (Singh 2019, equations 3.45 to 3.51 "
          "and 4.3), or with a sign by size, material or polarization. The energy balance includes the resulting "
          "change of the Coulomb energy (effects.coulomb).",
      .options = ChargeExchangeOptions{},
      .keys =
          {{.name = "model",
            .target = target<&ChargeExchangeOptions::model>,
            .help = "model of the charge transfer between grains in contact. impact: once per collision (but see "
                    "each_step), of size Q (m_eff v^2)^eta with random factors, for the effective mass m_eff and the "
                    "impact speed v; random-walk: white noise of variance Q^2 rate dt in each "
                    "step of the contact; contact-area: that noise times the contact area; none: no transfer. With a "
                    "sign, once "
                    "per collision, of size Q (m_eff v^2)^eta times a drive: size: (R_i - R_j)/(R_i + R_j), so that "
                    "larger grains become positive; material: difference of affinities; polarization: component of "
                    "field along the contact. patches: once per collision, Q for each donor that faces an acceptor "
                    "(Apodaca et al. 2010)"},
           {.name = "transfer_prefactor",
            .target = target<&ChargeExchangeOptions::strength>,
            .unit = "q0",
            // Fourth powers of charges must not overflow.
            .range = {.low = 0, .high = 1e50, .low_itself = false},
            .help = "prefactor Q of the transferred charge, in reduced units (q0; q0/d0^2 in the model contact-area). "
                    "Without [units] it is in C, for an energy m_eff v^2 of m0 v0^2 or an area of d0^2, whose values "
                    "explain prints",
            .old_name = "strength"},
           {.name = "exponent",
            .target = target<&ChargeExchangeOptions::exponent>,
            // Exponent of energies, bounded to avoid overflow.
            .range = {.low = 0, .high = 10},
            .help = "exponent eta of the models with one transfer per collision, whose transferred charge is "
                    "proportional to (impact energy)^eta; of patches it is 0.4 by default, as the area of Hertz's "
                    "contact"},
           {.name = "rate",
            .target = target<&ChargeExchangeOptions::rate>,
            .unit = "1/t0",
            .range = ranges::positive,
            .help =
                "rate lambda of the models random-walk and contact-area, in reduced units (1/t0). Per unit of "
                "time the variance of the transferred charge grows by Q^2 lambda in the model random-walk, with Q = "
                "transfer_prefactor. In the model contact-area it grows by Q^2 lambda area^2, where area is the "
                "contact area"},
           {.name = "affinities",
            .target = target<&ChargeExchangeOptions::affinities>,
            .computed_default = "none; needed for the model material",
            .help = "affinities of the grains for positive charge, pure numbers: one for each [[conductor]] and then "
                    "for each [[population]], for the model material"},
           {.name = "field",
            .target = target<&ChargeExchangeOptions::field>,
            .computed_default = "effects.uniform_field.field; without that effect it is needed for the model "
                                "polarization",
            .help = "uniform electric field that polarizes contacts in the model polarization, in any unit: the drive "
                    "is its component along the line from one centre to the other at the end of the step. It exerts "
                    "no force"},
           {.name = "patches",
            .target = target<&ChargeExchangeOptions::patches>,
            .range = {.low = 0, .high = 1e6, .low_itself = false},
            .help = "number n of pairs of facing patches in a contact of impact energy m_eff v^2 = 1 m0 v0^2, for the "
                    "model patches. Other contacts have n (m_eff v^2)^exponent pairs"},
           {.name = "donors",
            .target = target<&ChargeExchangeOptions::donors>,
            .range = {.low = 0, .high = 1},
            .computed_default = "0.5 of all grains",
            .help = "probability that a patch of a grain is a donor, and not an acceptor, for the model patches: one "
                    "number for each [[conductor]] and then for each [[population]]. Donors become positive"},
           {.name = "feedback",
            .target = target<&ChargeExchangeOptions::feedback>,
            .unit = "1/q0",
            .range = {.low = -1e50, .high = 1e50},
            .help = "number that is added to the drive of models with a sign per charge difference of the two grains. "
                    "Negative: transfers end at the difference -drive/feedback; positive: differences grow "
                    "exponentially, up to the capacity"},
           {.name = "memory",
            .target = target<&ChargeExchangeOptions::memory>,
            .range = ranges::positive,
            .computed_default = "none",
            .help = "number of collisions of a grain after which its transfers are 1/e of the first one, for models "
                    "with a sign"},
           {.name = "each_step",
            .target = target<&ChargeExchangeOptions::each_step>,
            .help = "true: the model impact transfers charge in each step of a contact, as in Singh 2019, table 3.1, "
                    "so that the result depends on the step; false: once per collision"},
           {.name = "capacity",
            .target = target<&ChargeExchangeOptions::capacity>,
            .unit = "q0",
            .range = ranges::positive,
            .computed_default = "none",
            .help = "capacity C of a grain, its largest charge of either sign, in reduced units (q0; Singh 2019, eq. "
                    "3.47)"},
           {.name = "over_capacity",
            .target = target<&ChargeExchangeOptions::over_capacity>,
            .help = "treatment of a transfer that would charge a grain beyond its capacity. refuse: it does not take "
                    "place; reset: the grain loses its whole charge, as printed in Singh 2019, so that charge is not "
                    "conserved"}},
      .dimensions = {2, 3},
      .periodic = true,
      .grains = true,
      .check = check_charge_exchange,
      .complete = complete_charge_exchange,
      .make =
          [](const Scene& scene) {
            return std::make_unique<ChargeExchange>(*scene.effects.find<ChargeExchangeOptions>(), scene.seed);
          },
      .explain = explain_charge_exchange,
      .cost = {.evaluations_a_step =
                   [](const Scene& scene) {
                     return scene.effects.find<ChargeExchangeOptions>()->model == ExchangeModel::none ? 1.0 : 2.0;
                   }},
      .device = charge_exchange_on_device};
  return kind;
}

ChargeExchange::ChargeExchange(const ChargeExchangeOptions& options, std::uint64_t seed)
    : options_(options), seed_(seed) {}

bool ChargeExchange::is_once_a_collision() const { return !is_by_time(options_.model) && !options_.each_step; }

/// Transfers charge in new contacts, or in all contacts for models with a transfer in each step. Random numbers are
/// selected by the pair and by the number of earlier collisions of its first grain (or of earlier steps). Each
/// collision thus has its own numbers, independent of threads and of rebuilds of the neighbour list.
void ChargeExchange::exchange_charges(const ContactRecord& contacts, const Bodies& bodies, std::span<double> charge) {
  if (options_.model == ExchangeModel::none) return;
  collisions_.resize(bodies.size());
  if (is_once_a_collision()) {
    for (const GrainContact& contact : contacts.begun) {
      move(contact, contacts.dt, collisions_[contact.pair.i], bodies, charge);
      ++collisions_[contact.pair.i], ++collisions_[contact.pair.j];
    }
    return;
  }
  for (const GrainContact& contact : contacts.open) move(contact, contacts.dt, steps_, bodies, charge);
  ++steps_;
}

Collision ChargeExchange::collision_of(const GrainContact& contact, const Bodies& bodies, double difference) const {
  const auto [i, j] = contact.pair;
  Collision collision{.effective_mass = effective_mass(bodies, contact.pair),
                      .speed = contact.impact_speed,
                      .radius_i = bodies.radius[i],
                      .radius_j = bodies.radius[j],
                      .difference = difference,
                      .collisions_i = static_cast<double>(collisions_[i]),
                      .collisions_j = static_cast<double>(collisions_[j])};
  if (options_.model == ExchangeModel::material || options_.model == ExchangeModel::patches)
    collision.affinity_i = options_.affinity[i], collision.affinity_j = options_.affinity[j];
  if (options_.model == ExchangeModel::polarization) collision.separation = separation(bodies, contact.pair);
  return collision;
}

double ChargeExchange::transfer(const GrainContact& contact, double dt, const Bodies& bodies, double difference,
                                Random& random) const {
  const auto [i, j] = contact.pair;
  if (!is_by_time(options_.model))
    return collision_exchange(options_)(collision_of(contact, bodies, difference), random);
  if (options_.model == ExchangeModel::random_walk)
    return RandomWalkExchange{options_.strength, options_.rate}(dt, random);
  const double distance =
      visit_spheres(bodies, [&](const auto& s) { return norm(s.box.difference(s.centre(i), s.centre(j))); });
  const double overlap = std::max(bodies.radius[i] + bodies.radius[j] - distance, 0.0);
  return ContactAreaExchange{options_.strength, options_.rate}(
      contact_area(bodies.radius[i], bodies.radius[j], overlap), dt, random);
}

void ChargeExchange::move(const GrainContact& contact, double dt, std::uint64_t count, const Bodies& bodies,
                          std::span<double> charge) {
  const auto [i, j] = contact.pair;
  Random random({seed_, RandomPurpose::exchange, static_cast<std::uint64_t>(i), static_cast<std::uint64_t>(j), count});
  const double dq =
      whole_quanta(transfer(contact, dt, bodies, charge[i] - charge[j], random), charge_quantum(options_.strength));
  const ExchangedCharges after =
      effects::exchange_charges(charge[i], charge[j], dq, options_.capacity.value_or(INFINITY), options_.over_capacity);
  refused_ += dq != 0 && after.i == charge[i] && after.j == charge[j];
  ++transfers_;
  lost_ += after.lost;
  charge[i] = after.i, charge[j] = after.j;
}

void ChargeExchange::save(Checkpoint& checkpoint) const {
  checkpoint.integers["collisions"] = collisions_;
  checkpoint.integers["counters"] = {steps_, transfers_, refused_};
  checkpoint.reals["lost"] = {lost_};
}

void ChargeExchange::restore(const Checkpoint& checkpoint) {
  collisions_ = integers(checkpoint, "collisions");
  const std::vector<std::int64_t>& counters = integers(checkpoint, "counters");
  if (counters.size() != 3)
    throw Failure(
        "the checkpoint's counters of effects.charge_exchange do not fit this program: another version wrote them");
  steps_ = counters[0], transfers_ = counters[1], refused_ = counters[2];
  lost_ = reals(checkpoint, "lost", 1).front();
}

void ChargeExchange::summarize(const State&, Summary& summary) const {
  if (options_.model == ExchangeModel::none) return;
  std::string text = fmt::format("{} transfers", transfers_);
  if (options_.capacity) text += fmt::format(", {} refused by the capacity", refused_);
  if (lost_ != 0) text += fmt::format(", a charge of {:.4g} lost beyond it", lost_);
  summary.lines.push_back({"exchange", text});
  summary.quantities.push_back({"transfers", static_cast<double>(transfers_), "1"});
  summary.quantities.push_back({"lost_charge", lost_, "q0"});
}

}  // namespace lichtenberg::effects
