#pragma once

// A gas on an executor: the sequence of an outer step.

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "solvers/error.hpp"
#include "solvers/stopwatch.hpp"
#include "src/granular/device/choice.hpp"
#include "src/granular/device/follow_contacts.hpp"
#include "src/granular/device/induced.hpp"
#include "src/granular/device/lists.hpp"
#include "src/granular/device/snapshot_memory.hpp"

namespace lichtenberg::granular::device {

template <class Executor>
class GasImpl final : public DeviceGas {
  template <class T>
  using Array = parallel::Array<T, Executor>;

 public:
  GasImpl(std::unique_ptr<Executor> run, const GasOptions& options)
      : run_(std::move(run)), gas_(*run_, checked(*run_, options)), lists_(gas_) {
    if (options.tables) sums_.emplace(*run_, *options.tables);
    if (options.polarizability > 0) dipoles_.emplace(*run_, *sums_, options.polarizability, options.dipole_tolerance);
    for (const auto& form : options.parts) parts_.push_back(form.make(*run_));
    for (const auto& form : options.drives) drives_.push_back(form.make(*run_));
    pair_quanta_ = quanta_of_parts();
  }

  void load(const Checkpoint& checkpoint, const GrainContactLaw& law, bool elastic, double stage_begin) override {
    gas_.load(checkpoint, law, elastic, stage_begin);
    step_.clear();
    lists_.load(checkpoint);
    if (dipoles_) load_dipoles(checkpoint, gas_.n, *dipoles_);
  }

  Snapshot snapshot() const override {
    Snapshot now = memories_.take(gas_, lists_);
    now.time = gas_.time;
    now.count = gas_.count;
    now.dissipated = gas_.dissipated_energy();
    now.exchanged = gas_.book.download().front().exchanged;
    now.driven = gas_.driven_energy();
    now.overlap = gas_.extremes.download().front().overlap;
    now.restitution = gas_.restitution.saved();
    now.charged = gas_.options.charged, now.exchanges = gas_.options.exchanges;
    now.sums = gas_.options.tables.has_value();
    if (dipoles_) now.dipoles = taken(gas_, *sums_, *dipoles_);
    return now;
  }
  double potential_energy() override {
    if (!has_held_forces()) return 0;
    if (lists_.skin() == 0) begin();
    if (!std::exchange(energy_known_, true)) recharge_once();
    return gas_.book.download().front().energy;
  }
  double time() const override { return gas_.time; }
  StepCounts counts() const override { return counts_; }

  void step(double time, int most) override {
    const Stopwatch stopwatch(counts_.seconds);
    if (lists_.skin() == 0) begin();
    std::visit([&](const auto& law) { is_driven() ? step_driven(law, time) : steps(law, time, most, false); },
               gas_.law);
  }

  /// Makes up to `most` steps up to this time; `whole`: a single step to this time.
  template <class Law>
  void steps(const Law& law, double time, int most, bool whole) {
    Progress& now = progress_.host();
    now = Progress::towards(time, gas_.time, most, whole);
    while (now.wanted()) {
      if (!now.go) begin_steps(law);
      progress_.send();
      for (int k = steps_ahead(rule(law), found_.host(), now, parameters_.host()); k > 0; --k)
        run_->run(step_, [&] { record(law); });
      progress_.fetch();
      found_.fetch();
      run_->wait();
      book(now);
    }
  }
  /// Begins a series of steps. The host chooses the first one, the device the others, until the lists become invalid.
  template <class Law>
  void begin_steps(const Law& law) {
    choose_first(law);
    found_.host().begin_step();
    parameters_.send();
    found_.send();
    hold();
  }
  /// Chooses the first step of a series, and rebuilds the lists if needed.
  template <class Law>
  void choose_first(const Law& law) {
    Progress& now = progress_.host();
    choose(rule(law), found_.host(), now, parameters_.host());
    if (now.unresolved)
      throw Failure(gas_.options.path + ": at t = " + std::to_string(gas_.time) +
                    " t0 contacts are too short for steps of mechanics.step: softer contacts (stiffness), or a far "
                    "shorter mechanics.step, is needed");
    if (now.go) return;
    arrange(now.travel);
    choose(rule(law), found_.host(), now, parameters_.host());
  }
  void book(Progress& now) {
    gas_.time = now.time;
    Counters& count = gas_.count;
    count.steps += now.steps, counts_.steps += now.steps;
    count.contact_steps += now.contact_steps, counts_.contact_steps += now.contact_steps;
    count.collisions += now.begun, count.transfers += now.transfers;
    if (sums_) count.evaluations += now.steps + now.exchanges, counts_.evaluations += now.steps + now.exchanges;
    energy_known_ = gas_.options.exchanges || dipoles_;
    now.steps = now.exchanges = 0;
    now.contact_steps = now.begun = now.transfers = 0;
    check_found();
  }

  bool is_driven() const { return !gas_.elastic && !drives_.empty(); }
  /// Makes one step, with Effect::drive before and after it; the host waits for both.
  template <class Law>
  void step_driven(const Law& law, double time) {
    Progress& now = progress_.host();
    now = Progress::towards(time, gas_.time, 1, false);
    choose(rule(law), found_.host(), now, parameters_.host());
    const double begin = gas_.time, end = now.end, half = 0.5 * (end - begin);
    drive(begin, half);
    steps(law, end, 1, true);
    drive(begin + half, half);
  }

  // Public because nvcc requires it of functions with kernels.

  /// Applies Effect::drive of all effects, and returns the largest speed to the host in found_.
  void drive(double time, double dt) {
    for (const auto& drive : drives_)
      drive->drive(grains(), time, dt, gas_.view().momentum, gas_.quanta.energy, gas_.driven.data());
    const GrainsView g = gas_.view();
    const int n = gas_.n;
    Found* found = found_.device();
    run_->for_each(1, [=] LICHTENBERG_HOST_DEVICE(int) { found->speed2 = 0; });
    run_->sum_segments((n + a_part - 1) / a_part,
                       [=] LICHTENBERG_HOST_DEVICE(int p) { return GasState<Executor>::part(n, p); },
                       [=] LICHTENBERG_HOST_DEVICE(int p, int t) {
                         const int s = p * a_part + t;
                         return MaxReduction{norm2(g.over_mass[s] * g.momentum[s])};
                       },
                       [=] LICHTENBERG_HOST_DEVICE(int, MaxReduction most) {
                         parallel::enlarge_atomically(&found->speed2, most.value);
                       });
    found_.fetch();
    run_->wait();
  }

  void begin() {
    arrange(0);
    if (has_held_forces()) recharge_once();
    energy_known_ = true;
    std::visit([&](const auto& law) { begin(law); }, gas_.law);
    run_->wait();
    gas_.count.collisions += found_.host().begun;
    check_found();
  }
  template <class Law>
  void begin(const Law& law) {
    parameters_.host() = {};
    parameters_.send();
    found_.host() = {};
    found_.send();
    progress_.host().go = 1;
    progress_.send();
    follow(law);  // contacts of grains that overlap
    find_impacts(law);
    finish(NoMore());
    found_.fetch();
  }

  void recharge_once() {
    typename Executor::Recording recording;
    const bool solved = dipoles_ && dipoles_->known();
    run_->run(recording, [&] { recharge(false, solved); });
    run_->wait();
  }
  void arrange(double travel) {
    const Stopwatch stopwatch(counts_.list_seconds);
    ++counts_.lists;
    lists_.arrange(travel, sums_, dipoles_);
    find_pair_forces();
    found_.host().moved2 = 0;
    if (auto seen = lists_.kernels(); !(seen == recorded_)) {
      step_.clear();
      recorded_ = std::move(seen);
    }
  }

  /// Computes forces and energy after a change of charges or of the order of grains. `booked`: the change of energy is
  /// due to exchange; `solved`: dipoles are known.
  void recharge(bool booked, bool solved = false) {
    if (sums_) recharge_sums(solved);
    find_pair_forces();
    FieldBook* book = gas_.book.data();
    const ForceView force = forces();
    run_->for_each(1, [=] LICHTENBERG_HOST_DEVICE(int) {
      const double energy = force.energy();
      if (booked) book->exchanged += energy - book->energy;
      book->energy = energy;
    });
    hold();
  }
  void recharge_sums(bool solved) {
    FieldBook* book = gas_.book.data();
    const GrainsView g = gas_.view();
    const int n = gas_.n;
    run_->for_each(1, [=] LICHTENBERG_HOST_DEVICE(int) { book->largest_charge = 0; });
    run_->sum_segments(
        (n + a_part - 1) / a_part, [=] LICHTENBERG_HOST_DEVICE(int p) { return GasState<Executor>::part(n, p); },
        [=] LICHTENBERG_HOST_DEVICE(int p, int t) { return MaxReduction{std::abs(g.charge[p * a_part + t])}; },
        [=] LICHTENBERG_HOST_DEVICE(int, MaxReduction most) {
          parallel::enlarge_atomically(&book->largest_charge, most.value);
        });
    const Vec3 over = gas_.turns_a_length();
    run_->for_each(n, [=] LICHTENBERG_HOST_DEVICE(int s) {
      const double scale = periodic::device::charge_scale(book->largest_charge);
      g.charged[s] = {turns_of(g.place[s], over), static_cast<float>(scale * g.charge[s])};
      if (s == 0) book->scale = scale;
    });
    if (!dipoles_)
      sums_->evaluate(g.charged, lists_.partners(), true);
    else if (!solved)
      dipoles_->follow_charges(g.charged, scale(), lists_.partners());
    else
      dipoles_->evaluate(g.charged, scale(), lists_.partners());
  }
  /// Computes forces and energy of pair laws. Sums of integers do not depend on the order of lists.
  void find_pair_forces() {
    if (parts_.empty()) return;
    gas_.pair_force.zero();
    gas_.pair_energy.zero();
    for (const auto& part : parts_)
      part->add_forces(grains(), pair_quanta_, gas_.pair_force.data(), gas_.pair_energy.data());
  }
  /// Stores the present forces, which stay constant until the end of the step.
  void hold() {
    const ForceView force = forces();
    const GrainsView g = gas_.view();
    run_->for_each(gas_.n, [=] LICHTENBERG_HOST_DEVICE(int s) { g.held[s] = force(s); });
  }

  /// Records the kernels of a step. They do nothing if no step has been chosen, because the host starts several ahead.
  template <class Law>
  void record(const Law& law) {
    Progress* now = progress_.device();
    const bool exchanges = has_held_forces() && gas_.options.exchanges;
    follow(law);
    run_->beside([&] { follow_charges(); }, [&] { find_impacts(law); });
    finish(GoOn<Law>{rule(law), found_.device(), parameters_.device(), now, dipoles_ ? dipoles_->unstable() : nullptr,
                     exchanges});
    if (exchanges) run_->when(&now->exchanged, [&] { recharge(true); });
  }
  template <class Law>
  void follow(const Law& law) {
    run_->together(FollowContacts<Law>{contact_steps(law), {gas_.box, gas_.turns_a_length()}, &progress_.device()->go});
  }
  void follow_charges() {
    if (dipoles_)
      dipoles_->follow(gas_.view().charged, scale(), lists_.partners(), &progress_.device()->go);
    else if (sums_)
      sums_->evaluate(gas_.view().charged, lists_.partners(), gas_.options.exchanges);
    find_pair_forces();
  }
  /// Computes, after the last substep, the bound on impact speeds, and counts the ended contacts.
  template <class Law>
  void find_impacts(const Law& law) {
    const ContactSteps<Law> steps = contact_steps(law);
    Found* found = found_.device();
    const int parts = std::max(gas_.n / 16, 1);
    run_->sum_segments(
        parts,
        [=] LICHTENBERG_HOST_DEVICE(int p) {
          const int share = (found->pairs + parts - 1) / parts, left = found->pairs - p * share;
          return left < share ? left : share;
        },
        [=] LICHTENBERG_HOST_DEVICE(int p, int t) {
          return MaxReduction{steps.impact2(p * ((found->pairs + parts - 1) / parts) + t)};
        },
        [=] LICHTENBERG_HOST_DEVICE(int, MaxReduction most) {
          parallel::enlarge_atomically(&found->impact2, most.value);
        });
    run_->for_each(steps.restitution.room, [=] LICHTENBERG_HOST_DEVICE(int k) { steps.count_end(k); });
  }
  /// Corrects momenta for a linear change of the smooth forces, adds exchanged charges, and computes the maxima from
  /// which the next step is chosen; then calls `then`.
  template <class Then>
  void finish(Then then) {
    const ForceView force = forces();
    const GrainsView g = gas_.view();
    const double quantum = gas_.quanta.charge;
    const StepParameters* parameters = parameters_.device();
    FieldBook* book = gas_.book.data();
    Found* found = found_.device();
    const Vec3 over = gas_.turns_a_length();
    run_->template sum<1>(
        gas_.n,
        [=] LICHTENBERG_HOST_DEVICE(int s) {
          const Vec3 now = force(s), at = g.place[s];
          const Vec3 p = g.momentum[s] + (0.5 * parameters->outer) * (now - g.held[s]);
          g.momentum[s] = p, g.held[s] = now;
          if (s == 0) book->energy = force.energy();
          std::int64_t& moved = g.moved_charge[s];
          if (moved != 0) g.charge[s] += quantum * static_cast<double>(moved), moved = 0;
          const Turns from = g.sorted_at[s], to = turns_of(at, over);
          const Vec3 path{lichtenberg::apart(to.x, from.x) / over.x, lichtenberg::apart(to.y, from.y) / over.y,
                          lichtenberg::apart(to.z, from.z) / over.z};
          StepMaxima here;
          here.speed2 = norm2(g.over_mass[s] * p), here.acceleration2 = norm2(g.over_mass[s] * now);
          here.moved2 = norm2(path), here.charge = std::abs(g.charge[s]);
          here.lost = !(here.speed2 < INFINITY) || !(norm2(at) < INFINITY);
          return here;
        },
        [=] LICHTENBERG_HOST_DEVICE(StepMaxima most) {
          found->speed2 = most.speed2, found->acceleration2 = most.acceleration2;
          found->moved2 = most.moved2, found->charge = most.charge;
          found->lost = most.lost;
          then();
        });
  }

 private:
  static constexpr int a_part = GasState<Executor>::a_part;

  static const GasOptions& checked(const Executor& run, const GasOptions& options) {
    check_room(options, static_cast<double>(run.room()));
    return options;
  }

  DeviceGrains grains() const {
    return {gas_.n,
            gas_.box,
            gas_.view().place,
            gas_.view().radius,
            gas_.view().charge,
            gas_.view().over_mass,
            gas_.view().number,
            lists_.in_reach()};
  }
  bool has_held_forces() const { return sums_ || !parts_.empty(); }

  ForceView forces() const {
    ForceView view;
    if (sums_)
      view = {gas_.view().charged,
              sums_->felt(),
              sums_->totals(),
              gas_.book.data(),
              gas_.options.strength,
              sums_->background(),
              dipoles_ ? sums_->force() : nullptr};
    if (!parts_.empty())
      view.of_pairs = gas_.pair_force.data(), view.pair_energy = gas_.pair_energy.data(), view.quanta = pair_quanta_;
    return view;
  }
  /// Powers of two: 2^-44 of the largest force and energy of a pair. Sums may be 2^18 times as large.
  PairQuanta quanta_of_parts() const {
    PairQuanta most{0, 0};
    for (const auto& part : parts_) {
      const PairQuanta size = part->size();
      most.force = std::max(most.force, std::abs(size.force)),
      most.energy = std::max(most.energy, std::abs(size.energy));
    }
    const auto quantum = [](double value) {
      return value > 0 ? std::ldexp(1.0, static_cast<int>(std::ceil(std::log2(value))) - 44) : 0x1p-44;
    };
    return {quantum(most.force), quantum(most.energy)};
  }
  template <class Law>
  ContactSteps<Law> contact_steps(const Law& law) const {
    const auto turn = [&](int k) { return static_cast<float>(gas_.box.lengths[k] / whole_turn); };
    return {.grains = gas_.view(),
            .contacts = lists_.view(),
            .law = law,
            .nearest = NearestImage<3>(gas_.box),
            .turn = {turn(0), turn(1), turn(2)},
            .parameters = parameters_.device(),
            .found = found_.device(),
            .extremes = gas_.extremes.data(),
            .restitution = gas_.restitution.view(),
            .exchange = gas_.options.exchange,
            .quanta = gas_.quanta,
            .over_quanta = gas_.quanta.inverse(),
            .seed = gas_.options.seed,
            .exchanges = gas_.options.exchanges && !gas_.elastic};
  }

  template <class Law>
  StepRule<Law> rule(const Law& law) const {
    return {law,
            gas_.options.step,
            gas_.options.way,
            static_cast<double>(gas_.options.contact_steps),
            {gas_.lightest, gas_.smallest_radius, typical_impact(gas_.options.mass.size())},
            gas_.largest_radius,
            gas_.lightest,
            gas_.options.attraction,
            lists_.skin()};
  }
  const double* scale() const { return &gas_.book.data()->scale; }

  void check_found() {
    if (dipoles_) check_dipoles(dipoles_->download(), gas_.options);
    if (const int passed = found_.host().passed; passed)
      throw Failure("grain " + std::to_string(passed - 1) +
                    " and another fly through each other: the contact is too soft for their impact; a larger "
                    "stiffness, of a stage its equilibration.stiffness, or a lower temperature is needed");
    if (found_.host().lost)
      throw Failure(gas_.options.path + ": from t = " + std::to_string(gas_.time) +
                    " t0 on the grains' positions are not finite");
  }

  std::unique_ptr<Executor> run_;
  GasState<Executor> gas_;
  GasLists<Executor> lists_;
  typename GasLists<Executor>::Sums sums_;
  typename GasLists<Executor>::Dipoles dipoles_;
  std::vector<std::unique_ptr<DevicePart>> parts_;
  std::vector<std::unique_ptr<DeviceDrive>> drives_;
  PairQuanta pair_quanta_;
  mutable SnapshotMemories<Executor> memories_{*run_};
  parallel::Mirrored<Found, Executor> found_{*run_};
  parallel::Mirrored<StepParameters, Executor> parameters_{*run_};
  parallel::Mirrored<Progress, Executor> progress_{*run_};
  typename Executor::Recording step_;
  typename GasLists<Executor>::Kernels recorded_;
  bool energy_known_ = false;  ///< the field energy for the present charges is known
  StepCounts counts_;
};

}  // namespace lichtenberg::granular::device
