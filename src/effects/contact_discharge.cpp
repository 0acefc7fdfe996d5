#include "src/effects/contact_discharge.hpp"

#include <algorithm>
#include <cmath>

namespace lichtenberg::effects {
namespace {

/// Whether contacts that are asked for in ascending order are among some that are in ascending order.
class Among {
 public:
  explicit Among(std::span<const Contact> sorted) : next_(sorted.begin()), end_(sorted.end()) {}
  bool has(Contact contact) {
    while (next_ != end_ && *next_ < contact) ++next_;
    return next_ != end_ && *next_ == contact;
  }

 private:
  std::span<const Contact>::iterator next_, end_;
};

}  // namespace

const EffectKind& ContactDischargeOptions::kind() {
  static const EffectKind kind = {
      .name = "contact_discharge",
      .description = "conductors that come close become one electrically",
      .help =
          "Conductors close to each other, or to an electrode, become one electrically (D 6.40). "
          "Needs floating_conductors.",
      .options = ContactDischargeOptions{},
      .keys = {{.name = "gap",
                .place = place<&ContactDischargeOptions::gap>,
                .unit = "m",
                .range = ranges::positive,
                .computed_default = "the smallest radius",
                .help = "contact is made when two surfaces come closer than this"},
               {.name = "hysteresis",
                .place = place<&ContactDischargeOptions::hysteresis>,
                .range = {.low = 0, .high = 1},
                .help = "contact is lost beyond gap * (1 + hysteresis): conductors at rest there must not chatter"}},
      .needs = {{"floating_conductors"}},
      .dimensions = {2, 3},
      .periodic = true,
      .complete =
          [](const Draft& draft, Scene& scene) {
            if (draft.line("effects.contact_discharge.gap") == 0)
              scene.effects.find<ContactDischargeOptions>()->gap =
                  std::ranges::min(scene.conductors, {}, &Conductor::radius).radius;
          },
      .make = [](const Scene& scene) -> std::unique_ptr<Effect> { return std::make_unique<ContactDischarge>(scene); },
      .contact_gap = [](const Scene& scene) { return scene.effects.find<ContactDischargeOptions>()->gap; }};
  return kind;
}

ContactDischarge::ContactDischarge(const Scene& scene)
    : tolerance_(scene.mechanics.position_tolerance),
      make_gap_(scene.effects.find<ContactDischargeOptions>()->gap),
      release_gap_(make_gap_ +
                   std::max(scene.effects.find<ContactDischargeOptions>()->hysteresis * make_gap_, tolerance_)),
      together_(std::min(tolerance_, 0.25 * (release_gap_ - make_gap_))),
      terminals_(terminals_of(scene)) {}

double ContactDischarge::gap(const Bodies& bodies, Contact contact) const {
  const int i = contact.conductor, j = contact.partner, n = bodies.size();
  if (j >= n) return view(terminals_[j - n].surface, position_in_space(bodies, i)).distance - bodies.radius[i];
  return norm(bodies.box.difference(position_in_space(bodies, i), position_in_space(bodies, j))) - bodies.radius[i] -
         bodies.radius[j];
}

double ContactDischarge::gap_rate(const Bodies& bodies, Contact contact) const {
  const int i = contact.conductor, j = contact.partner, n = bodies.size();
  if (j >= n)
    return dot(velocity_in_space(bodies, i), view(terminals_[j - n].surface, position_in_space(bodies, i)).normal);
  const Vec3 r = bodies.box.difference(position_in_space(bodies, i), position_in_space(bodies, j));
  return dot(velocity_in_space(bodies, i) - velocity_in_space(bodies, j), r) / norm(r);
}

std::vector<Contact> ContactDischarge::near(const Bodies& bodies, double range, std::span<const double> travel) const {
  std::vector<Contact> found;
  for (const Pair pair : pairs_within_reach(near_, bodies, range, travel)) found.push_back({pair.i, pair.j});
  const auto conductors = static_cast<std::ptrdiff_t>(found.size());
  look_at_terminals(bodies);
  const int n = bodies.size(), terminals = static_cast<int>(terminals_.size());
  for (int i = 0; i < n; ++i)
    for (int t = 0; t < terminals; ++t)
      if (terminal_gap_[i * terminals + t] - near_.moved()[i] < range + travel[i] &&
          gap(bodies, {i, n + t}) < range + travel[i])
        found.push_back({i, n + t});
  std::inplace_merge(found.begin(), found.begin() + conductors, found.end());
  return found;
}

/// The gaps where the bodies were at the last search, which is now if they are not known.
void ContactDischarge::look_at_terminals(const Bodies& bodies) const {
  if (searches_ == near_.searches()) return;
  searches_ = near_.searches();
  terminal_gap_.clear();
  const int n = bodies.size();
  for (int i = 0; i < n; ++i)
    for (int t = 0; t < static_cast<int>(terminals_.size()); ++t) terminal_gap_.push_back(gap(bodies, {i, n + t}));
}

ContactDischarge::Changes ContactDischarge::update(const Bodies& bodies, std::vector<Contact>& contacts) const {
  const auto made_now = [&](Contact contact) {
    const double g = gap(bodies, contact);
    return g <= make_gap_ || (g <= make_gap_ + together_ && gap_rate(bodies, contact) < 0);
  };
  const auto lost_now = [&](Contact contact) {
    const double g = gap(bodies, contact);
    return g >= release_gap_ || (g >= release_gap_ - together_ && gap_rate(bodies, contact) > 0);
  };
  Changes changes;
  std::vector<Contact> now;
  now.reserve(contacts.size());
  Among before(contacts);
  // What is not even near the release gap is lost whether it is looked at or not.
  const std::vector<double> here(bodies.size());
  for (const Contact contact : near(bodies, release_gap_ + together_, here)) {
    const bool was = before.has(contact);
    const bool is = was ? !lost_now(contact) : made_now(contact);
    if (is) now.push_back(contact);
    changes.made += is && !was;
  }
  changes.lost = static_cast<int>(contacts.size()) + changes.made - static_cast<int>(now.size());
  contacts = std::move(now);
  return changes;
}

std::vector<ContactDischarge::Watch> ContactDischarge::watch(const Bodies& bodies, std::span<const Contact> contacts,
                                                             const ElectricalGroups& groups,
                                                             std::span<const double> travel) const {
  const int n = bodies.size();
  const auto one_already = [&](Contact c) {
    return c.partner < n ? groups.id[c.conductor] == groups.id[c.partner]
                         : is_one(groups, c.conductor, terminals_[c.partner - n]);
  };
  std::vector<Watch> watched;
  Among made(contacts);
  for (const Contact contact : near(bodies, make_gap_, travel))
    if (!one_already(contact) && !made.has(contact)) watched.push_back({contact, false});
  for (const Contact contact : contacts) {
    const double approach = travel[contact.conductor] + (contact.partner < n ? travel[contact.partner] : 0);
    if (release_gap_ - gap(bodies, contact) <= approach) watched.push_back({contact, true});
  }
  return watched;
}

double ContactDischarge::blind_way(const Bodies& bodies, const Watch& watch) const {
  const int i = watch.contact.conductor, j = watch.contact.partner;
  // Where the gap is at its threshold, centres lie on a circle round each other, or on a curve round the electrode that
  // is nowhere bent more sharply than at its corner. The chord of a circle that rises by s over it is sqrt(8 r s).
  const double arm =
      bodies.radius[i] + (watch.made ? release_gap_ : make_gap_) + (j < bodies.size() ? bodies.radius[j] : 0);
  return std::max(std::abs(excess(bodies, watch)), std::sqrt(8 * arm * tolerance_));
}

}  // namespace lichtenberg::effects
