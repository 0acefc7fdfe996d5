#include "src/granular/contact_motion.hpp"

#include <algorithm>
#include <cmath>

#include "src/granular/contact_event_queue.hpp"
#include "src/granular/contact_rows.hpp"
#include "src/granular/contacting_grains.hpp"
#include "src/granular/contacts.hpp"

namespace lichtenberg::granular {
namespace {

template <int d, class Law>
class Motion final : public ContactMotion {
 public:
  explicit Motion(const Law& law) : law_(law) {}

  ContactsFollowed advance(Bodies& bodies, std::vector<GrainContact>& contacts, std::span<const double> slow_force,
                           const ContactSteps& substeps, parallel::Team& team) override {
    const double time = substeps.begin, dt = substeps.time;
    ContactsFollowed followed{.record = {.time = time + dt, .dt = dt}};
    begin(bodies, slow_force, contacts, substeps, team);
    for (int n = 0; n < substeps.steps; ++n) {
      update_contacts(time + n * dt_, n == 0, team);
      if (n == 0)
        followed.stored_at_start = total(rows_.columns().stored, rows_.touching());
      else
        note(time + n * dt_, followed.record);
      if (!queue_.is_valid_for(dt_, substeps.fastest)) search(bodies, substeps, n, team), ++followed.searches;
      for (follow(n, team); !queue_.update_contact_acceleration(rows_.max_contact_acceleration()); follow(n, team))
        search(bodies, substeps, n, team), ++followed.searches;
      step(n, time + n * dt_, followed.record);
    }
    update_contacts(time + dt, false, team);
    followed.stored_at_end = total(rows_.columns().stored, rows_.touching());
    followed.fastest_release = fastest_release();
    note(time + dt, followed.record);
    close();
    followed.work = grains_.fly(bodies, substeps.steps, team);
    contacts.clear();
    for (const Open& one : open_) contacts.push_back(one.contact);
    followed.record.open = contacts;
    return followed;
  }

 private:
  /// An open contact, with the slots (indices of the copies) of its grains.
  struct Open {
    GrainContact contact;
    Pair slots;
  };
  /// A candidate pair (separate, but may touch), with the slots of its grains.
  struct Candidate {
    Pair pair, slots;
  };

  void begin(const Bodies& bodies, std::span<const double> slow_force, std::span<const GrainContact> contacts,
             const ContactSteps& substeps, parallel::Team& team) {
    dt_ = substeps.time / substeps.steps;
    nearest_ = NearestImage<d>(spheres<d>(bodies).box);
    rows_.begin(spheres<d>(bodies).box, dt_);
    grains_.begin(
        bodies, slow_force, dt_, static_cast<int>(contacts.size()), [&](int p) { return contacts[p].pair; }, team);
    open_.clear();
    for (const GrainContact& contact : contacts)
      open_.push_back({contact, {grains_.slot_of(contact.pair.i), grains_.slot_of(contact.pair.j)}});
    queue_.add_velocity_kick(substeps.velocity_change);
    queue_.set_external_acceleration(substeps.gain / substeps.time);
  }

  /// Fills the queue with the pairs that may touch from step n on, until the fastest grain has moved by `search_path`.
  void search(const Bodies& bodies, const ContactSteps& substeps, int n, parallel::Team& team) {
    constexpr int most_steps = 64;
    constexpr double least = 0.1, more = 1.5;  // factors of the largest possible and of the observed acceleration
    constexpr double grows = 1.5;              // bound on the growth of slow forces until the next search
    const double external_acceleration = grows * substeps.gain / substeps.time,
                 velocity_change = std::isfinite(substeps.velocity_change) ? grows * substeps.velocity_change : 0;
    const auto horizon = [&](double speed) {
      return std::max(dt_, std::min(substeps.search_path / speed, most_steps * dt_));
    };
    const double longest = horizon(substeps.fastest),
                 velocity_kick = velocity_change * (std::ceil(longest / substeps.time) + 1);
    const double fastest = substeps.fastest + velocity_kick + external_acceleration * std::max(longest, substeps.time);
    const double largest = largest_acceleration(2 * fastest);
    Bounds bounds{.fastest = fastest,
                  .velocity_kick = velocity_kick,
                  .external_acceleration = external_acceleration,
                  .contact_acceleration = 2 * std::max(least * largest, more * queue_.max_contact_acceleration())};
    const double step = ContactEventQueue<d>::longer * dt_;  // the longest until the next search
    bounds.excess = std::min(largest, unseen_acceleration(step, 2 * bounds.speed())) * step * step / 4;
    const int contacts = static_cast<int>(open_.size());
    first_contact_.assign(bodies.size(), contacts);
    for (int p = contacts - 1; p >= 0; --p) first_contact_[open_[p].contact.pair.i] = p;
    const auto open = [&](Pair pair) {
      int p = first_contact_[pair.i];
      while (p < contacts && open_[p].contact.pair < pair) ++p;
      return p < contacts && open_[p].contact.pair == pair;
    };
    const auto search_in = [&](const Bodies& now) {
      queue_.search(now, bounds, (1 + rounding) * horizon(bounds.fastest), dt_, open, team);
    };
    if (n == 0) return search_in(bodies);
    if (flown_.size() == 0) flown_ = bodies;
    flown_.position = bodies.position;
    flown_.momentum = bodies.momentum;
    grains_.fly(flown_, n, team);
    search_in(flown_);
  }
  /// Returns an upper bound on the acceleration of a grain by a contact, for an impact speed (v0).
  double largest_acceleration(double speed) const {
    const double widest = grains_.widest(), scale = law_.scale(widest, widest), lightest = grains_.lightest();
    // At the overlap that stores all kinetic energy. Spring and dashpot never reach these values together.
    double low = 0, high = 2 * widest;
    for (int k = 0; k < 50; ++k) {
      const double middle = 0.5 * (low + high);
      (law_.parts(middle, scale).stored < 0.5 * lightest * speed * speed ? low : high) = middle;
    }
    const ContactParts deepest = law_.parts(high, scale);
    return (deepest.elastic + deepest.damping * speed) / lightest;
  }
  /// Returns an upper bound on the acceleration of a grain by a contact that begins in the second half of a step. The
  /// forces in the middle of the step do not include this contact. `step`: t0; `closing`: approach speed (v0).
  double unseen_acceleration(double step, double closing) const {
    const double widest = grains_.widest();
    const ContactParts parts = law_.parts(0.5 * step * closing, law_.scale(widest, widest));
    return (parts.elastic + parts.damping * closing) / grains_.lightest();
  }
  /// Removes contacts that have ended from the open ones, and adds their pairs to the queue again.
  void close() {
    int p = 0;
    std::erase_if(open_, [&](const Open& one) {
      const bool parted = !(rows_.columns().age[p++] >= 0);
      if (parted) queue_.wait(one.contact.pair, 0);
      return parted;
    });
  }
  double fastest_release() const {
    double square = 0;
    for (int p = 0; p < rows_.touching(); ++p)
      square = std::max(square, 2 * rows_.columns().stored[p] / rows_.columns().mass[p]);
    return std::sqrt(square);
  }

  /// Lists the pairs without contact that may touch in step n, in ascending order.
  void find_candidates(int n, parallel::Team& team) {
    constexpr int pairs_a_task = 512;  // a multiple of any vector width
    candidates_.clear();
    due_.clear();
    queue_.take(dt_, due_);
    const int count = static_cast<int>(due_.size());
    min_time_to_contact_.resize(count + width);
    team.for_each((count + pairs_a_task - 1) / pairs_a_task, [&](int task) {
      for (int first = task * pairs_a_task; first < std::min(count, (task + 1) * pairs_a_task); first += width)
        estimate_times(first, n);
    });
    for (int p = 0; p < count; ++p) {
      const Pair pair = due_[p];
      if (min_time_to_contact_[p] < (1 + rounding) * dt_)
        candidates_.push_back({pair, {grains_.slot_of(pair.i), grains_.slot_of(pair.j)}});
      else
        queue_.wait(pair, min_time_to_contact_[p]);
    }
    std::ranges::sort(candidates_, {}, &Candidate::pair);
  }
  /// Computes lower bounds on the times from the start of step n until contact, for a vector of pairs in `due_` that
  /// starts at index `first`. Assigns no slots.
  void estimate_times(int first, int n) {
    constexpr int ahead = ContactingGrains<d>::ahead;
    const int count = static_cast<int>(due_.size());
    for (int p = first + ahead; p < std::min(first + ahead + width, count); ++p) grains_.prefetch(due_[p]);
    const auto pair = [&](int lane) { return due_[std::min(first + lane, count - 1)]; };
    const GrainPack<d> lower = grains_.at([&](int lane) { return pair(lane).i; }, n),
                       higher = grains_.at([&](int lane) { return pair(lane).j; }, n);
    min_time_to_contact<d>(relative_state(lower, higher, nearest_), lower.radius + higher.radius, queue_.bounds())
        .copy_to(&min_time_to_contact_[first], anywhere);
  }

  void update_contacts(double time, bool all_touch, parallel::Team& team) {
    rows_.update_touching(
        static_cast<int>(open_.size()), [&](int p) { return open_[p].slots; },
        [&](int p) { return open_[p].contact.since; }, time, all_touch, team);
  }

  /// Records the largest overlap, and the contacts that have ended by `time` (t0). Throws Failure if the centres of two
  /// grains have come too close.
  void note(double time, ContactRecord& record) {
    const PairColumns<d>& columns = rows_.columns();
    for (int p = 0; p < rows_.touching(); ++p) {
      const auto& [contact, slots] = open_[p];
      const double overlap = columns.overlap[p], sum = columns.reach[p];
      record.largest_overlap = std::max(record.largest_overlap, overlap / sum);
      // The stiffness factor is the energy that must be stored to stop the grains here, over the stored energy.
      if (sum - overlap < too_close * sum) {
        const double speed = closing(columns.state(p));
        refuse_flight_through(contact, 1 + columns.mass[p] * speed * speed / 2 / columns.stored[p]);
      }
      if (columns.age[p] >= 0) continue;
      record.ended.push_back({contact, -closing(columns.state(p)), time, speed_across(columns.state(p))});
      --grains_.forces(slots.i).touches, --grains_.forces(slots.j).touches;
    }
  }

  /// Computes the motion of all pairs in contact and of all candidate pairs in step n, without moving their grains.
  void follow(int n, parallel::Team& team) {
    find_candidates(n, team);
    rows_.add(
        static_cast<int>(candidates_.size()), [&](int p) { return candidates_[p].slots; }, n, team);
    rows_.follow(team);
  }

  /// Moves the grains by the computed motion of step n, which begins at `time` (t0), and records new contacts.
  void step(int n, double time, ContactRecord& record) {
    rows_.move(n);
    const PairColumns<d>& columns = rows_.columns();
    record.dissipated += total(columns.dissipated, rows_.touching());
    for (int p = rows_.touching(); p < rows_.count(); ++p)
      if (columns.onset[p] >= 0) record.dissipated += columns.dissipated[p];
    queue_.pass(dt_);
    begin_contacts(time, record);
  }

  /// Updates the list of open contacts after a step that began at `time` (t0): adds new ones and removes ended ones.
  void begin_contacts(double time, ContactRecord& record) {
    const PairColumns<d>& columns = rows_.columns();
    const int touching = rows_.touching();
    begun_.clear();
    for (int p = 0; p < rows_.count(); ++p) {
      if (columns.age[p] >= 0) continue;
      const Pair pair = p < touching ? open_[p].contact.pair : candidates_[p - touching].pair;
      if (columns.onset[p] >= 0)
        begun_.push_back({{pair, time + columns.onset[p], columns.impact_speed[p]}, rows_.slots(p)});
      else
        queue_.wait(pair, 0);
    }
    int p = 0;
    std::erase_if(open_, [&](const Open&) { return !(columns.age[p++] >= 0); });
    if (begun_.empty()) return;
    mark_shared_contacts();
    const auto pair = [](const Open& one) { return one.contact.pair; };
    std::ranges::sort(begun_, {}, pair);
    for (const Open& one : begun_) record.begun.push_back(one.contact);
    sorted_.resize(open_.size() + begun_.size());
    std::ranges::merge(open_, begun_, sorted_.begin(), {}, pair, pair);
    open_.swap(sorted_);
  }
  /// Marks contacts that a third grain has joined because of new contacts.
  void mark_shared_contacts() {
    for (const Open& one : begun_) ++grains_.forces(one.slots.i).touches, ++grains_.forces(one.slots.j).touches;
    const auto alone = [&](Pair slots) {
      return grains_.forces(slots.i).touches == 1 && grains_.forces(slots.j).touches == 1;
    };
    for (Open& one : begun_) one.contact.alone = alone(one.slots);
    for (Open& one : open_) one.contact.alone = one.contact.alone && alone(one.slots);
  }

  Law law_;
  double dt_ = 0;
  NearestImage<d> nearest_{Box<d>{}};
  ContactingGrains<d> grains_;
  ContactRows<d, Law> rows_{law_, grains_};
  ContactEventQueue<d> queue_;
  Bodies flown_;  ///< moved to the step at which a search is made

  std::vector<Pair> due_;
  std::vector<int> first_contact_;           ///< by particle, during a search: first contact in which it is the lower
  std::vector<double> min_time_to_contact_;  ///< t0, of the pairs that are due
  std::vector<Candidate> candidates_;
  std::vector<Open> open_, begun_, sorted_;
};

}  // namespace

std::unique_ptr<ContactMotion> make_contact_motion(const GrainContactLaw& law, int dimension) {
  return std::visit(
      [&](const auto& one) -> std::unique_ptr<ContactMotion> {
        using Law = std::decay_t<decltype(one)>;
        if (dimension == 3) return std::make_unique<Motion<3, Law>>(one);
        return std::make_unique<Motion<2, Law>>(one);
      },
      law);
}

}  // namespace lichtenberg::granular
