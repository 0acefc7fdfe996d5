#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "src/effects/charge_exchange_law.hpp"
#include "src/model/effect.hpp"
#include "src/model/grain_contact.hpp"
#include "src/scene/effect_kind.hpp"

namespace lichtenberg::effects {

/// Model of the charge that two grains in contact transfer (Singh 2019, table 3.1). `impact`: by the impact energy,
/// once in a collision unless `each_step` is set. `random_walk`: white noise during contact. `contact_area`: white
/// noise times the contact area. `none`: no transfer. The others are DirectedExchange. `size`: drive by the radii.
/// `material`: drive by the affinities of the grains. `polarization`: drive by the direction of the contact in a
/// uniform field (Paehtz, Herrmann and Shinbrot 2010). `patches`: PatchExchange.
enum class ExchangeModel { impact, random_walk, contact_area, size, material, polarization, patches, none };

}  // namespace lichtenberg::effects

namespace lichtenberg {
template <>
inline constexpr Named<effects::ExchangeModel> values_named<effects::ExchangeModel>[] = {
    {effects::ExchangeModel::impact, "impact"},
    {effects::ExchangeModel::random_walk, "random-walk"},
    {effects::ExchangeModel::contact_area, "contact-area"},
    {effects::ExchangeModel::size, "size"},
    {effects::ExchangeModel::material, "material"},
    {effects::ExchangeModel::polarization, "polarization"},
    {effects::ExchangeModel::patches, "patches"},
    {effects::ExchangeModel::none, "none"}};
template <>
inline constexpr Named<effects::OverCapacity> values_named<effects::OverCapacity>[] = {
    {effects::OverCapacity::refuse, "refuse"}, {effects::OverCapacity::reset, "reset"}};
}  // namespace lichtenberg

namespace lichtenberg::effects {

/// Parameters of the charge exchange between grains in contact: model, prefactor and exponent of the transferred
/// charge, and largest charge of a grain. Reduced units.
struct ChargeExchangeOptions {
  ExchangeModel model = ExchangeModel::impact;
  double strength = 4.5e-3;            ///< Q, prefactor of the transferred charge (q0)
  double exponent = 0.83;              ///< eta, for impact and the models with a sign
  double rate = 1;                     ///< lambda, 1/t0, for random_walk and contact_area
  double feedback = 0;                 ///< 1/q0, for the models with a sign
  std::optional<double> memory;        ///< number of collisions, for the models with a sign; empty: no limit
  std::vector<double> affinities{};    ///< of each [[conductor]] and then of each [[population]], for material
  std::vector<double> affinity{};      ///< of each grain, from `affinities`, or from `donors` for patches
  std::optional<Coordinates> field{};  ///< electric field that polarizes contacts, for polarization
  double patches = 10;                 ///< pairs of patches in a contact of unit energy, for patches
  std::vector<double> donors{};        ///< probabilities, of the same tables as `affinities`, for patches; empty: 1/2
  /// True: the model `impact` transfers charge in each step of a contact instead of once in a collision
  bool each_step = false;
  std::optional<double> capacity;  ///< largest charge of a grain (q0); empty: no limit
  OverCapacity over_capacity = OverCapacity::refuse;

  static const EffectKind& kind();
};

/// Effect of charge transfer between two grains in contact. One grain gains the charge that the other loses.
/// Transfers are multiples of a power of two (charge_quantum()), which avoids rounding errors of the total charge.
/// OverCapacity::reset discards charge.
class ChargeExchange : public Effect {
 public:
  ChargeExchange(const ChargeExchangeOptions& options, std::uint64_t seed);

  const EffectKind& kind() const override { return ChargeExchangeOptions::kind(); }
  Needs needs() const override { return {.charges = true}; }
  void exchange_charges(const ContactRecord& contacts, const Bodies& bodies, std::span<double> charge) override;
  void save(Checkpoint& checkpoint) const override;
  void restore(const Checkpoint& checkpoint) override;
  void summarize(const State& state, Summary& summary) const override;

 private:
  bool is_once_a_collision() const;
  /// Returns the charge (q0) that the second grain of the contact gives to the first in a time dt (t0). `difference`:
  /// charge of the first minus that of the second (q0).
  double transfer(const GrainContact& contact, double dt, const Bodies& bodies, double difference,
                  Random& random) const;
  /// Returns the collision that a contact has begun with. `difference`: charge of the first grain minus that of the
  /// second (q0).
  Collision collision_of(const GrainContact& contact, const Bodies& bodies, double difference) const;
  /// Transfers charge between the two grains of a contact. `count` numbers the transfers of a pair, to select its
  /// random numbers.
  void move(const GrainContact& contact, double dt, std::uint64_t count, const Bodies& bodies,
            std::span<double> charge);

  ChargeExchangeOptions options_;
  std::uint64_t seed_;
  /// Number of collisions of each grain, which selects its random numbers.
  std::vector<std::int64_t> collisions_;
  std::int64_t steps_ = 0, transfers_ = 0, refused_ = 0;
  double lost_ = 0;  ///< charge, q0
};

}  // namespace lichtenberg::effects
