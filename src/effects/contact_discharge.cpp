#include "src/effects/contact_discharge.hpp"

#include <algorithm>
#include <cmath>

namespace lichtenberg::effects {
namespace {

/// Tests if contacts are in a sorted list. The contacts must be tested in ascending order.
class SortedLookup {
 public:
  explicit SortedLookup(std::span<const Contact> sorted) : next_(sorted.begin()), end_(sorted.end()) {}
  bool has(Contact contact) {
    while (next_ != end_ && *next_ < contact) ++next_;
    return next_ != end_ && *next_ == contact;
  }

 private:
  std::span<const Contact>::iterator next_, end_;
};

/// Returns the largest change (m) of a contact's gap if each body i moves by at most travel[i] (m); `bodies`: number of
/// conductors.
double approach(Contact contact, int bodies, std::span<const double> travel) {
  return travel[contact.conductor] + (contact.partner < bodies ? travel[contact.partner] : 0);
}

/// Compares gaps between two conductors with distances, without square roots. It serves loops over many pairs, most of
/// which are not close. Contacts with terminals always need the exact test.
class PairScreen {
 public:
  explicit PairScreen(const Bodies& bodies) : bodies_(bodies), nearest_(bodies.box) {}

  /// Returns false only if the gap is certainly not less than `gap` (m).
  bool may_be_below(Contact contact, double gap) const {
    if (contact.partner >= bodies_.size()) return true;
    const double separation = distance_at_gap(contact, gap);
    return separation <= 0 || distance2(contact) <= (1 + margin) * separation * separation;
  }
  /// Returns false only if the gap is certainly less than `gap` (m).
  bool may_reach(Contact contact, double gap) const {
    if (contact.partner >= bodies_.size()) return true;
    const double separation = distance_at_gap(contact, gap);
    return separation <= 0 || distance2(contact) >= (1 - margin) * separation * separation;
  }

 private:
  // Far above the rounding of a gap, and small enough that few pairs need the exact test
  static constexpr double margin = 1e-9;

  /// Returns the centre distance (m) with this gap.
  double distance_at_gap(Contact contact, double gap) const {
    return bodies_.radius[contact.conductor] + bodies_.radius[contact.partner] + gap;
  }
  double distance2(Contact contact) const {
    const std::size_t d = bodies_.dimension;
    const double *a = &bodies_.position[contact.conductor * d], *b = &bodies_.position[contact.partner * d];
    double sum = 0;
    for (std::size_t k = 0; k < d; ++k) {
      const double separation = nearest_(a[k] - b[k], static_cast<int>(k));
      sum += separation * separation;
    }
    return sum;
  }

  const Bodies& bodies_;
  NearestImage<3> nearest_;
};

}  // namespace

const EffectKind& ContactDischargeOptions::kind() {
  static const EffectKind kind = {
      .name = "contact_discharge",
      .description = "conductors closer than a gap are electrically connected",
      .help =
          "Conductors closer than contact_distance to each other or to an electrode are in electrical contact "
          "(Stephenson 2018, eq. 6.40). They then have one potential, unless contact_resistance or another effect "
          "gives the contact a conductance. Needs floating_conductors.",
      .options = ContactDischargeOptions{},
      .keys = {{.name = "contact_distance",
                .target = target<&ContactDischargeOptions::contact_distance>,
                .unit = "m",
                .range = ranges::positive,
                .computed_default = "the smallest radius",
                .help = "gap between two surfaces below which they are in electrical contact, in m",
                .old_name = "gap"},
               {.name = "hysteresis",
                .target = target<&ContactDischargeOptions::hysteresis>,
                .range = {.low = 0, .high = 1},
                .help = "relative hysteresis of a contact, which opens above contact_distance * (1 + hysteresis), but "
                        "at least mechanics.position_tolerance above contact_distance. Contacts of conductors at rest "
                        "thus do not alternate between open and closed"}},
      .needs = {{"floating_conductors"}},
      .dimensions = {2, 3},
      .periodic = true,
      .complete =
          [](const Draft& draft, Scene& scene) {
            if (draft.line("effects.contact_discharge.contact_distance") == 0)
              scene.effects.find<ContactDischargeOptions>()->contact_distance = scene.smallest_radius();
          },
      .make = [](const Scene& scene) { return std::make_unique<ContactDischarge>(scene); },
      .contact_gap =
          [](const Scene& scene) { return scene.effects.find<ContactDischargeOptions>()->contact_distance; }};
  return kind;
}

ContactDischarge::ContactDischarge(const Scene& scene)
    : tolerance_(scene.mechanics.position_tolerance),
      make_gap_(scene.effects.find<ContactDischargeOptions>()->contact_distance),
      release_gap_(make_gap_ +
                   std::max(scene.effects.find<ContactDischargeOptions>()->hysteresis * make_gap_, tolerance_)),
      simultaneity_margin_(std::min(tolerance_, 0.25 * (release_gap_ - make_gap_))),
      terminals_(terminals_of(scene)),
      least_skin_(scene.smallest_radius() / 16) {}

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

std::vector<Contact> ContactDischarge::pairs_within(const Bodies& bodies, double range,
                                                    std::span<const double> travel) const {
  std::vector<Contact> found;
  for (const Pair pair : pairs_within_reach(near_, bodies, range, travel)) found.push_back({pair.i, pair.j});
  const auto conductors = static_cast<std::ptrdiff_t>(found.size());
  update_terminal_gaps(bodies);
  const int n = bodies.size(), terminals = static_cast<int>(terminals_.size());
  for (int i = 0; i < n; ++i)
    for (int t = 0; t < terminals; ++t)
      if (terminal_gap_[i * terminals + t] - near_.moved()[i] < range + travel[i] &&
          gap(bodies, {i, n + t}) < range + travel[i])
        found.push_back({i, n + t});
  std::inplace_merge(found.begin(), found.begin() + conductors, found.end());
  return found;
}

/// Computes the gaps of all bodies to all terminals if near_ has been rebuilt since the last call. Such a rebuild was
/// for the current positions.
void ContactDischarge::update_terminal_gaps(const Bodies& bodies) const {
  if (searches_ == near_.searches()) return;
  searches_ = near_.searches();
  terminal_gap_.clear();
  const int n = bodies.size();
  for (int i = 0; i < n; ++i)
    for (int t = 0; t < static_cast<int>(terminals_.size()); ++t) terminal_gap_.push_back(gap(bodies, {i, n + t}));
}

/// Updates close_ to contain all contacts that may change while body i moves by at most travel[i] (m; empty: no
/// motion).
void ContactDischarge::update_close_pairs(const Bodies& bodies, std::span<const Contact> contacts,
                                          std::span<const double> travel) const {
  if (is_valid_for(bodies, travel) && std::ranges::equal(contacts, search_contacts_)) return;
  skin_.resize(bodies.size(), least_skin_);
  // The skin exceeds `travel`, so that several calls can use one search.
  for (std::size_t i = 0; i < travel.size(); ++i) skin_[i] = std::max(least_skin_, 4 * travel[i]);
  find_close(bodies, contacts);
}

bool ContactDischarge::is_valid_for(const Bodies& bodies, std::span<const double> travel) const {
  if (search_positions_.size() != bodies.position.size()) return false;
  return bodies.dimension == 3 ? is_valid_for<3>(bodies, travel) : is_valid_for<2>(bodies, travel);
}

/// Returns true if close_ still has all contacts that may change while each body i moves by at most travel[i] (m;
/// empty: no motion). Tests bodies in blocks without branches, so that the compiler vectorizes the loop.
template <int d>
bool ContactDischarge::is_valid_for(const Bodies& bodies, std::span<const double> travel) const {
  const double *now = bodies.position.data(), *then = search_positions_.data();
  constexpr int block = 512;
  for (int first = 0; first < bodies.size(); first += block) {
    const int end = std::min(bodies.size(), first + block);
    bool valid = true;
    for (int i = first; i < end; ++i) {
      double moved2 = 0;
      for (int k = i * d; k < (i + 1) * d; ++k) moved2 += (now[k] - then[k]) * (now[k] - then[k]);
      const double allowed = travel.empty() ? skin_[i] : skin_[i] - travel[i];
      valid &= (allowed >= 0) & (moved2 <= allowed * allowed);
    }
    if (!valid) return false;
  }
  return true;
}

/// Searches the contacts whose gap can reach its threshold if each body moves by its skin. Contacts within
/// simultaneity_margin_ of the threshold are included.
void ContactDischarge::find_close(const Bodies& bodies, std::span<const Contact> contacts) const {
  search_positions_.clear();  // invalidated first, because a search may throw
  close_.clear();
  SortedLookup made(contacts);
  const PairScreen screen(bodies);
  const int n = bodies.size();
  // The range extends to the release gap, up to which contacts stay closed. A periodic box too short for it is refused.
  for (const Contact contact : pairs_within(bodies, release_gap_ + simultaneity_margin_, skin_))
    if (const double within = make_gap_ + simultaneity_margin_ + approach(contact, n, skin_);
        screen.may_be_below(contact, within) && !made.has(contact) && gap(bodies, contact) < within)
      close_.push_back({contact, false});
  const auto open_count = static_cast<std::ptrdiff_t>(close_.size());
  for (const Contact contact : contacts)
    if (const double beyond = release_gap_ - simultaneity_margin_ - approach(contact, n, skin_);
        screen.may_reach(contact, beyond) && gap(bodies, contact) >= beyond)
      close_.push_back({contact, true});
  std::ranges::inplace_merge(close_, close_.begin() + open_count, {}, &Close::contact);
  search_contacts_.assign(contacts.begin(), contacts.end());
  search_positions_ = bodies.position;
}

ContactDischarge::Changes ContactDischarge::update(const Bodies& bodies, std::vector<Contact>& contacts) const {
  const PairScreen screen(bodies);
  const auto made_now = [&](Contact contact) {
    if (!screen.may_be_below(contact, make_gap_ + simultaneity_margin_)) return false;
    const double g = gap(bodies, contact);
    return g <= make_gap_ || (g <= make_gap_ + simultaneity_margin_ && gap_rate(bodies, contact) < 0);
  };
  const auto lost_now = [&](Contact contact) {
    if (!screen.may_reach(contact, release_gap_ - simultaneity_margin_)) return false;
    const double g = gap(bodies, contact);
    return g >= release_gap_ || (g >= release_gap_ - simultaneity_margin_ && gap_rate(bodies, contact) > 0);
  };
  update_close_pairs(bodies, contacts, {});
  std::vector<Contact> made, lost;
  for (Close& pair : close_) {
    if (pair.made ? !lost_now(pair.contact) : !made_now(pair.contact)) continue;
    (pair.made ? lost : made).push_back(pair.contact);
    pair.made = !pair.made;
  }
  if (made.empty() && lost.empty()) return {};
  std::vector<Contact> stay;
  stay.reserve(contacts.size());
  std::ranges::set_difference(contacts, lost, std::back_inserter(stay));
  contacts.clear();
  std::ranges::merge(stay, made, std::back_inserter(contacts));
  search_contacts_ = contacts;
  return {std::move(made), std::move(lost)};
}

bool ContactDischarge::are_joined(const ElectricalGroups& groups, int bodies, Contact contact) const {
  return contact.partner < bodies ? groups.id[contact.conductor] == groups.id[contact.partner]
                                  : shares_group(groups, contact.conductor, terminals_[contact.partner - bodies]);
}

std::vector<ContactDischarge::Watch> ContactDischarge::watch(const Bodies& bodies, std::span<const Contact> contacts,
                                                             const ElectricalGroups& groups,
                                                             std::span<const double> travel) const {
  update_close_pairs(bodies, contacts, travel);
  const int n = bodies.size();
  const PairScreen screen(bodies);
  std::vector<Watch> watched, lost;
  for (const auto& [contact, made] : close_) {
    const double approach_distance = approach(contact, n, travel);
    if (made) {
      if (screen.may_reach(contact, release_gap_ - approach_distance) &&
          release_gap_ - gap(bodies, contact) <= approach_distance)
        lost.push_back({contact, true});
    } else if (screen.may_be_below(contact, make_gap_ + approach_distance) && !are_joined(groups, n, contact) &&
               gap(bodies, contact) < make_gap_ + approach_distance) {
      watched.push_back({contact, false});
    }
  }
  watched.insert(watched.end(), lost.begin(), lost.end());
  return watched;
}

double ContactDischarge::excess_of_deferred(const Bodies& bodies, const Watch& watch) const {
  const double g = gap(bodies, watch.contact);
  constexpr double second = 1;  // s; only the sign of the product matters
  const double no_longer = std::min(g - (1 - 1.0 / 16) * make_gap_, -second * gap_rate(bodies, watch.contact));
  return std::max(g - make_gap_, no_longer);
}

double ContactDischarge::undetected_travel(const Bodies& bodies, const Watch& watch) const {
  const int i = watch.contact.conductor, j = watch.contact.partner;
  // At the threshold, the centre of one body lies on a circle around the other, or on a curve around the electrode. The
  // curvature of this curve is at most that at a corner. A chord below an arc of height s is sqrt(8 r s) long.
  const double arm =
      bodies.radius[i] + (watch.made ? release_gap_ : make_gap_) + (j < bodies.size() ? bodies.radius[j] : 0);
  return std::max(std::abs(excess(bodies, watch)), std::sqrt(8 * arm * tolerance_));
}

}  // namespace lichtenberg::effects
