#pragma once

// A gas on an executor: the sequence of an outer step.

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "solvers/error.hpp"
#include "solvers/stopwatch.hpp"
#include "src/granular/device/bounds.hpp"
#include "src/granular/device/choice.hpp"
#include "src/granular/device/failures.hpp"
#include "src/granular/device/follow_contacts.hpp"
#include "src/granular/device/induced.hpp"
#include "src/granular/device/lists.hpp"
#include "src/granular/device/ordered_exchange.hpp"
#include "src/granular/device/rough_state.hpp"
#include "src/granular/device/snapshot_memory.hpp"
#include "src/granular/device/step_end.hpp"

namespace lichtenberg::granular::device {

/// Gas of grains on an executor (CPU or CUDA device): runs the sequence of an outer step of multiple time stepping.
template <class Executor>
class GasImpl final : public DeviceGas {
  template <class T>
  using Array = parallel::Array<T, Executor>;

 public:
  GasImpl(std::unique_ptr<Executor> run, const GasOptions& options)
      : run_(std::move(run)), gas_(*run_, checked(*run_, options)), lists_(gas_) {
    if (options.rough) rough_.emplace(*run_);
    if (options.tables) sums_.emplace(*run_, *options.tables);
    if (options.polarizability > 0) dipoles_.emplace(*run_, *sums_, options.polarizability, options.dipole_tolerance);
    for (const auto& form : options.parts) parts_.push_back(form.make(*run_));
    for (const auto& form : options.drives) drives_.push_back(form.make(*run_));
    pair_units_ = units_of(parts_);
    affinity_.upload(options.affinity);
    bounds_ = {options.tables && options.enclosure.unbounded, gas_.box};
  }

  void load(const Checkpoint& checkpoint, const GrainContactLaw& law, bool elastic, double stage_begin,
            const SurfaceLaw* surface) override {
    if (rough_) {
      const LawOnDevice rough = rough_law(law, *surface, gas_.grain_properties(), gas_.largest_radius);
      gas_.load(checkpoint, law, elastic, stage_begin, rough.force_ratio);
      rough_->load(checkpoint, *surface, rough, gas_);
    } else {
      gas_.load(checkpoint, law, elastic, stage_begin);
    }
    step_.clear();
    lists_.load(checkpoint);
    if (dipoles_) load_dipoles(checkpoint, gas_.n, *dipoles_);
  }

  /// Copies the current state to host memory. With several ranks each must call; rank 0 returns the state.
  Snapshot snapshot() const override {
    gas_.join(nullptr);
    Snapshot now = memories_.take(gas_, lists_);
    now.time = gas_.time;
    now.count = gas_.count;
    now.dissipated = gas_.dissipated_energy();
    now.exchanged = gas_.field_energy.download().front().exchanged;
    now.driven = gas_.driven_energy();
    for (const Extremes& most : run_->from_all(gas_.extremes.download().front()))
      now.overlap = std::max(now.overlap, most.overlap);
    now.restitution = gas_.restitution.saved();
    now.charged = gas_.options.charged, now.exchanges = gas_.options.exchanges;
    now.sums = gas_.options.tables.has_value();
    if (rough_) now.rough = rough_->snapshot(gas_.view(), lists_.springs());
    if (dipoles_) now.dipoles = dipole_writer(gas_, *sums_, *dipoles_);
    return now;
  }
  double potential_energy() override {
    if (!has_slow_forces()) return 0;
    if (lists_.skin() == 0) begin();
    if (!std::exchange(energy_known_, true)) recharge_once();
    return gas_.field_energy.download().front().energy;
  }
  double time() const override { return gas_.time; }
  StepCounts counts() const override { return counts_; }

  void step(double time, int most) override {
    const Stopwatch stopwatch(counts_.seconds);
    if (lists_.skin() == 0) begin();
    const bool is_driven = !gas_.elastic && !drives_.empty();
    with_law([&](const auto& law) { is_driven ? step_driven(law, time) : steps(law, time, most, false); });
  }

  /// Makes up to `most` outer steps (from one evaluation of the smooth forces to the next) until `time` (t0). `whole`:
  /// makes a single step to `time`.
  template <class Law>
  void steps(const Law& law, double time, int most, bool whole) {
    Progress& now = progress_.host();
    now = Progress::towards(time, gas_.time, most, whole);
    if (gas_.share.is_divided()) return steps_of_ranks(law, now);
    while (now.wanted()) {
      if (!now.go) begin_steps(law);
      progress_.send();
      for (int k = steps_ahead(rule(law), results_.host(), now, parameters_.host()); k > 0; --k)
        run_->run(step_, [&] { record(law); });
      progress_.fetch();
      results_.fetch();
      run_->wait();
      record_progress(now);
    }
  }
  /// Makes the outer steps of a series on several ranks. Each device chooses the steps from the results of all ranks,
  /// and the hosts wait for each choice.
  template <class Law>
  void steps_of_ranks(const Law& law, Progress& now) {
    while (now.wanted()) {
      if (!now.go) begin_steps(law);
      progress_.send();
      follow_on_ranks(law);
      run_->run_concurrently([&] { follow_charges(); }, [&] { find_impacts(law); });
      finish(NoAction());
      join_results();
      const ChooseNext<Law> next{rule(law),          results_.device(), parameters_.device(),
                                 progress_.device(), nullptr,           exchange_changes_forces()};
      run_->for_each(1, [=] LICHTENBERG_HOST_DEVICE(int) { next(); });
      fetch_results();
      if (now.exchanged) recharge(true);
      record_progress(now);
    }
  }
  /// Follows the contacts of a step on several ranks, which exchange grains after each substep.
  template <class Law>
  void follow_on_ranks(const Law& law) {
    const int count = parameters_.host().steps;
    const ContactsView contacts = lists_.view();
    const GrainsView& g = gas_.view();
    for (int step = 0; step < count; ++step) {
      follow(law, step, step + 1);
      step + 1 < count ? gas_.share.send_with_entries(contacts.since, g.position, g.touches, g.momentum)
                       : gas_.share.send_with_entries(contacts.since, g.position, g.touches);
      gas_.locate_others();
    }
  }
  /// Fetches the results of a step and the choice of the next. Meanwhile sends the momenta and smooth forces at the end
  /// of the step to other ranks.
  void fetch_results() {
    progress_.fetch(), parameters_.fetch(), results_.fetch();
    run_->mark(fetched_);
    if (gas_.share.is_divided()) gas_.share.send_to_neighbours(gas_.view().momentum, gas_.view().slow_force);
    run_->wait_until(fetched_);
  }
  /// Begins a series of outer steps (from one evaluation of the smooth forces to the next). The host chooses the first
  /// step, and the device the others, until the neighbour lists become invalid.
  template <class Law>
  void begin_steps(const Law& law) {
    choose_first(law);
    results_.host().begin_step();
    parameters_.send();
    results_.send();
    store_slow_forces();
  }
  /// Chooses the first outer step (from one evaluation of the smooth forces to the next) of a series, and rebuilds the
  /// neighbour lists if needed. Throws Failure if contacts are too short for the step.
  template <class Law>
  void choose_first(const Law& law) {
    Progress& now = progress_.host();
    choose(rule(law), results_.host(), now, parameters_.host());
    if (now.unresolved)
      throw Failure(gas_.options.path + ": at t = " + std::to_string(gas_.time) +
                    " t0 contacts are too short for steps of mechanics.step: softer contacts (stiffness), or a far "
                    "shorter mechanics.step, is needed");
    if (now.go) return;
    if (arrange(now.travel)) start(law);
    choose(rule(law), results_.host(), now, parameters_.host());
  }
  /// Adds the completed steps of a series to the counters, and throws Failure if a step failed.
  void record_progress(Progress& now) {
    gas_.time = now.time;
    Counters& count = gas_.count;
    count.steps += now.steps, counts_.steps += now.steps;
    count.contact_steps += now.contact_steps, counts_.contact_steps += now.contact_steps;
    count.collisions += now.begun, count.transfers += now.transfers, count.refused += now.refused;
    if (sums_) count.evaluations += now.steps + now.exchanges, counts_.evaluations += now.steps + now.exchanges;
    energy_known_ = gas_.options.exchanges || dipoles_;
    now.steps = now.exchanges = 0;
    now.contact_steps = now.begun = now.transfers = now.refused = 0;
    if (now.outran)
      throw Failure(gas_.options.path + ": at t = " + std::to_string(gas_.time) +
                    " t0 contacts have accelerated a grain within a step, and it has moved beyond its neighbours: a "
                    "shorter mechanics.step is needed");
    check_results();
  }

  /// Makes one outer step (from one evaluation of the smooth forces to the next) until at most `time` (t0), with half a
  /// step of Effect::drive before and after it. The host waits for the results of both half steps.
  template <class Law>
  void step_driven(const Law& law, double time) {
    Progress& now = progress_.host();
    now = Progress::towards(time, gas_.time, 1, false);
    choose(rule(law), results_.host(), now, parameters_.host());
    const double begin = gas_.time, end = now.end, half = 0.5 * (end - begin);
    drive(begin, half);
    steps(law, end, 1, true);
    drive(begin + half, half);
  }

  // Public because nvcc requires it of functions with kernels.

  /// Applies the external drives (Effect::drive) of all effects to the momenta from `time` to `time` + dt. Updates the
  /// largest speed in results_ on the host.
  void drive(double time, double dt) {
    for (const auto& drive : drives_)
      drive->drive(grains(), time, dt, gas_.view().momentum, gas_.units.energy, gas_.driven.data());
    const GrainsView g = gas_.view();
    StepResults* results = results_.device();
    find_maximum(*run_, gas_.n, &results->speed2,
                 [=] LICHTENBERG_HOST_DEVICE(int s) { return norm2(g.inverse_mass[s] * g.momentum[s]); });
    results_.fetch();
    run_->wait();
  }

  /// Prepares the first step after load(): neighbour lists, forces, and contacts of grains that overlap.
  void begin() {
    arrange(0);
    with_law([&](const auto& law) { start(law); });
    gas_.count.collisions += results_.host().begun;
    check_results();
  }
  /// Computes forces and the results of a step at the present positions, after load() or with a new mesh. The next step
  /// thus depends on the present state only.
  template <class Law>
  void start(const Law& law) {
    if (has_slow_forces()) recharge_once();
    energy_known_ = true;
    begin(law);
    join_results();
    fetch_results();
  }
  template <class Law>
  void begin(const Law& law) {
    parameters_.host() = {};
    parameters_.send();
    results_.host() = {};
    results_.send();
    progress_.host().go = 1, progress_.send();
    follow(law);  // contacts of grains that overlap
    find_impacts(law);
    if (has_bounds()) check_bounds(*run_, gas_.view(), bounds_, results_.device());
    finish(NoAction());
  }

  void recharge_once() {
    typename Executor::Recording recording;
    run_->run(recording, [&] { recharge(false, dipoles_ && dipoles_->known()); });
    run_->wait();
  }
  /// Sorts the grains and rebuilds the neighbour lists; `travel`: bound on displacements in the next step (d0). Returns
  /// true if an unbounded cloud has got a new mesh.
  bool arrange(double travel) {
    const Stopwatch stopwatch(counts_.list_seconds);
    ++counts_.lists;
    const bool fresh = fit_mesh();
    lists_.arrange(travel, sums_, dipoles_);
    if (rough_) rough_->permute(lists_.order());
    find_pair_forces();
    results_.host().moved2 = 0;
    if (auto kernels = lists_.kernels(); !(kernels == recorded_)) {
      step_.clear();
      recorded_ = std::move(kernels);
    }
    return fresh;
  }
  /// Makes the mesh of an unbounded cloud for its extents, if it has another one. Returns true if it is new. As on the
  /// CPU it depends on the extents only, so that resumed runs have identical bits.
  bool fit_mesh() {
    GasOptions& options = gas_.options;
    if (!bounds_.unbounded || !sums_) return false;
    const Span span = span_of(*run_, gas_.view());
    if (!bounds_.outgrown(span)) return false;
    if (!(norm(span.high - span.low) < INFINITY)) throw Failure(options.path + ": positions of grains are not finite");
    bounds_.surround(span);
    options.tables = cloud_tables(options, bounds_.most);
    sums_.emplace(*run_, *options.tables);
    gas_.search_lengths = options.tables->mesh.lengths;
    lists_.divide();
    step_.clear();
    return true;
  }

  /// Computes smooth forces and potential energy after a change of charges or of the order of grains. `by_exchange`:
  /// the change of energy enters the budget of charge exchange; `solved`: the induced dipoles are known.
  void recharge(bool by_exchange, bool solved = false) {
    if (sums_) recharge_sums(by_exchange, solved);
    find_pair_forces();
    FieldEnergyBudget* budget = gas_.field_energy.data();
    const ForceView force = forces();
    run_->for_each(1, [=] LICHTENBERG_HOST_DEVICE(int) {
      const double energy = force.energy();
      if (by_exchange) budget->exchanged += energy - budget->energy;
      budget->energy = energy;
    });
    store_slow_forces();
  }
  void recharge_sums(bool by_exchange, bool solved) {
    gas_.scale_charges(by_exchange ? &results_.device()->charge : gas_.find_largest_charge());
    const PointCharge* charged = gas_.view().charged;
    if (!dipoles_)
      sums_->evaluate(charged, lists_.partners(), true);
    else if (!solved)
      dipoles_->follow_charges(charged, scale(), lists_.partners());
    else
      dipoles_->evaluate(charged, scale(), lists_.partners());
  }
  /// Computes forces and energy of all pair force laws. Fixed-point sums do not depend on the order of lists.
  void find_pair_forces() {
    if (parts_.empty()) return;
    gas_.pair_force.zero();
    gas_.pair_energy.zero();
    for (const auto& part : parts_)
      part->add_forces(grains(), pair_units_, gas_.pair_force.data(), gas_.pair_energy.data());
  }
  /// Stores the current smooth forces (all forces except contacts), which are constant until the end of the outer step.
  void store_slow_forces() {
    const ForceView force = forces();
    const GrainsView g = gas_.view();
    const int first = gas_.share.range().own.first;
    run_->for_each(gas_.share.range().own.count,
                   [=] LICHTENBERG_HOST_DEVICE(int k) { g.slow_force[first + k] = force(first + k); });
    if (gas_.share.is_divided()) gas_.share.send_to_neighbours(g.slow_force);
  }

  /// Records the kernels of an outer step, to be executed many times; on a device as a CUDA graph. An outer step lasts
  /// from one evaluation of the smooth forces to the next. The device chooses the next step (ChooseNext), and the host
  /// starts several graphs ahead. Graphs without a chosen step compute the forces again and leave the gas unchanged.
  template <class Law>
  void record(const Law& law) {
    Progress* now = progress_.device();
    follow(law);
    if (gas_.exchanges_in_order() && !gas_.elastic)
      exchange_in_order(*run_, smooth_steps(law), gas_.options.exchange, affinity_.data(), &now->go);
    run_->run_concurrently([&] { follow_charges(); }, [&] { find_impacts(law); });
    if (has_bounds()) check_bounds(*run_, gas_.view(), bounds_, results_.device());
    finish(ChooseNext<Law>{rule(law), results_.device(), parameters_.device(), now,
                           dipoles_ ? dipoles_->unstable() : nullptr, exchange_changes_forces()});
    if (exchange_changes_forces()) run_->when(&now->exchanged, [&] { recharge(true); });
  }
  /// Lists candidate pairs and runs the contact substeps of the chosen outer step (from one evaluation of the smooth
  /// forces to the next). `from`, `to`: only the substeps from ... to - 1.
  template <class Law>
  void follow(const Law& law, int from = 0, int to = std::numeric_limits<int>::max()) {
    const PositionWrap wrap{gas_.box, gas_.units_per_length()};
    const int* go = &progress_.device()->go;
    if constexpr (is_rough<Law>)
      run_->run_cooperative(FollowRough<typename Law::Normal>{contact_steps(law), wrap, go});
    else
      run_->run_cooperative(FollowContacts<Law>{contact_steps(law), wrap, go, from, to});
  }
  /// Computes smooth forces at the positions after the contact substeps.
  void follow_charges() {
    if (dipoles_)
      dipoles_->follow(gas_.view().charged, scale(), lists_.partners(), &progress_.device()->go);
    else if (sums_)
      sums_->evaluate(gas_.view().charged, lists_.partners(), gas_.options.exchanges);
    find_pair_forces();
  }
  /// Computes the bound on impact speeds after the last contact substep (find_impact_speeds()).
  template <class Law>
  void find_impacts(const Law& law) {
    find_impact_speeds(*run_, contact_steps(law), gas_.n);
  }
  /// Ends an outer step (finish_step()), and then calls action().
  template <class Action>
  void finish(Action action) {
    gas_.join_exchanged_charges();
    finish_step(gas_, forces(), parameters_.device(), results_.device(), action);
  }
  /// Joins the results of a step of all ranks.
  void join_results() {
    if (gas_.share.is_divided()) device::join_results(*run_, results_.device(), rank_results_);
  }

 private:
  static const GasOptions& checked(const Executor& run, const GasOptions& options) {
    check_memory(options, static_cast<double>(run.available_memory()));
    return options;
  }

  DeviceGrains grains() const {
    return {gas_.n,
            gas_.box,
            gas_.view().position,
            gas_.view().radius,
            gas_.view().charge,
            gas_.view().inverse_mass,
            gas_.view().number,
            &gas_.view().image->x,
            lists_.in_reach()};
  }
  bool has_slow_forces() const { return sums_ || !parts_.empty(); }
  bool exchange_changes_forces() const { return has_slow_forces() && gas_.options.exchanges; }
  bool has_bounds() const { return sums_ && !gas_.options.enclosure.is_periodic(); }

  ForceView forces() const {
    ForceView view;
    if (sums_)
      view = {gas_.view().charged,
              sums_->field_at_source(),
              sums_->totals(),
              gas_.field_energy.data(),
              gas_.options.strength,
              sums_->background(),
              dipoles_ ? sums_->force() : nullptr};
    if (!parts_.empty())
      view.pair_force = gas_.pair_force.data(), view.pair_energy = gas_.pair_energy.data(), view.units = pair_units_;
    return view;
  }
  /// Calls use(law) with the contact law of the grains.
  template <class Use>
  void with_law(const Use& use) {
    rough_ ? std::visit(use, rough_->law()) : std::visit(use, gas_.law);
  }
  template <class Law>
  auto contact_steps(const Law& law) const {
    if constexpr (is_rough<Law>)
      return RoughContactSteps<typename Law::Normal>{smooth_steps(law), rough_->view()};
    else
      return smooth_steps(law);
  }
  template <class Law>
  ContactSteps<Law> smooth_steps(const Law& law) const {
    const auto unit_length = [&](int k) { return static_cast<float>(gas_.search_lengths[k] / units_per_box); };
    return {.grains = gas_.view(),
            .contacts = lists_.view(),
            .law = law,
            .nearest = NearestImage<3>(gas_.box),
            .unit_length = {unit_length(0), unit_length(1), unit_length(2)},
            .parameters = parameters_.device(),
            .results = results_.device(),
            .extremes = gas_.extremes.data(),
            .restitution = gas_.restitution.view(),
            .exchange = gas_.options.exchange.impact,
            .units = gas_.units,
            .inverse_units = gas_.units.inverse(),
            .seed = gas_.options.seed,
            .exchanges = gas_.options.exchanges && !gas_.exchanges_in_order() && !gas_.elastic,
            .units_per_length = gas_.units_per_length(),
            .range = gas_.share.range(),
            .is_divided = gas_.share.is_divided()};
  }

  template <class Law>
  StepRule<Law> rule(const Law& law) const {
    return {law,
            gas_.options.step,
            gas_.options.max_path,
            static_cast<double>(gas_.options.contact_steps),
            gas_.grain_properties(),
            gas_.largest_radius,
            gas_.lightest,
            gas_.options.attraction,
            lists_.skin()};
  }
  const double* scale() const { return &gas_.field_energy.data()->scale; }

  /// Throws Failure if a step failed (require_success()), if induced dipoles cannot be computed, or if a cloud has
  /// grown too far in a step.
  void check_results() {
    if (dipoles_) check_dipoles(dipoles_->download(), gas_.options);
    if (bounds_.unbounded && 2 * progress_.host().travel > ChargeBounds::growth)
      throw Failure(gas_.options.path + ": at t = " + std::to_string(gas_.time) +
                    " t0 grains of an unbounded cloud move too far in a step: a shorter mechanics.step is needed");
    require_success(results_.host(), gas_.options.path, gas_.time);
  }

  std::unique_ptr<Executor> run_;
  GasState<Executor> gas_;
  GasLists<Executor> lists_;
  typename GasLists<Executor>::Sums sums_;
  typename GasLists<Executor>::Dipoles dipoles_;
  std::optional<RoughOn<Executor>> rough_;
  std::vector<std::unique_ptr<DevicePart>> parts_;
  std::vector<std::unique_ptr<DeviceDrive>> drives_;
  PairUnits pair_units_;
  ChargeBounds bounds_;
  Array<double> affinity_{*run_};  ///< of each grain by its number, for the exchange of charge by material
  mutable SnapshotMemories<Executor> memories_{*run_};
  parallel::Mirrored<StepResults, Executor> results_{*run_};
  parallel::Mirrored<StepParameters, Executor> parameters_{*run_};
  parallel::Mirrored<Progress, Executor> progress_{*run_};
  Array<StepResults> rank_results_{*run_};
  typename Executor::TimePoint fetched_;  ///< the results of a step are on the host
  typename Executor::Recording step_;
  typename GasLists<Executor>::Kernels recorded_;
  bool energy_known_ = false;  ///< the field energy for the present charges is known
  StepCounts counts_;
};

}  // namespace lichtenberg::granular::device
