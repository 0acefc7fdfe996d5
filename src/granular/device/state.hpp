#pragma once

// State of the grains of a gas on an executor, in sorted order. It is loaded from a checkpoint of Gas and stored to
// one.

#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include "src/granular/device/contact_data.hpp"
#include "src/granular/device/device.hpp"
#include "src/granular/device/gas_parts.hpp"
#include "src/granular/device/restitution.hpp"
#include "src/granular/device/share.hpp"
#include "src/granular/pace.hpp"

namespace lichtenberg::granular::device {

/// State of the grains of a gas on an executor (CPU or CUDA device): arrays in device memory, sorted by search cells,
/// contact law, counters and energy sums. Reduced units.
template <class Executor>
struct GasState {
  template <class T>
  using Array = parallel::Array<T, Executor>;

  GasState(const Executor& executor, const GasOptions& o)
      : run(&executor), options(o), n(static_cast<int>(o.mass.size())), box{o.lengths} {
    box.sides = options.sides;
    for (int k = 0; k < 3; ++k) search_lengths[k] = (box.periodic(k) ? 1 : 2) * box.lengths[k];
    if (options.tables) search_lengths = options.tables->mesh.lengths;
    largest_radius = *std::ranges::max_element(options.radius);
    smallest_radius = *std::ranges::min_element(options.radius);
    lightest = *std::ranges::min_element(options.mass);
    units.energy = energy_quantum(n);
    share.take_all(n);
    if (options.exchanges) units.charge = effects::charge_quantum(options.exchange.impact.strength);
    field_energy.resize(1);
    extremes.resize(1);
    spare.resize(n);
    GrainsView& g = grains.view;
    g.count = n;
    grains.resize(n, g.position, g.momentum, g.image, g.charge, g.inverse_mass, g.radius, g.number, g.charged);
    grains.resize(n, g.collisions, g.moved_charge, g.dissipated, g.compact, g.slow_force, g.sorted_at);
    grains.resize(n, g.force, g.halfway, g.impulse, g.shift, g.busy, g.touches, g.begun);
    if (!options.parts.empty()) pair_force.resize(n), pair_energy.resize(1);
  }

  /// Loads the state from a checkpoint of Gas, except contacts. `with`: contact law; `in_elastic_stage`: true if no
  /// charge is exchanged and no drive acts; `stage_begin`: time since which the law applies (t0). `force_ratio`:
  /// largest forces over those of two grains with the law.
  void load(const Checkpoint& checkpoint, const GrainContactLaw& with, bool in_elastic_stage, double stage_begin,
            double force_ratio = 1) {
    law = with;
    std::vector<double> statistics = lichtenberg::reals(checkpoint, "restitution_check", 3 * RestitutionCheck::decades);
    if (run->rank() > 0) std::ranges::fill(statistics, 0);  // rank 0 has those before
    restitution.load(statistics, stage_begin, n);
    share.take_all(n);
    elastic = in_elastic_stage;
    const auto reals = [&](const char* name, std::size_t size) { return lichtenberg::reals(checkpoint, name, size); };
    const std::size_t size = n;
    GrainsView& g = grains.view;
    upload(g.position, vectors(reals("position", 3 * size)));
    upload(g.momentum, vectors(reals("momentum", 3 * size)));
    std::vector<double> over;
    for (const double mass : options.mass) over.push_back(1 / mass);
    upload(g.inverse_mass, over);
    upload(g.radius, options.radius);
    choose_units(force_ratio);
    upload(g.charge, options.charged ? reals("charge", size) : std::vector<double>(size));
    const auto& turned = integers(checkpoint, "image");
    std::vector<ImageCount> around(size);
    std::vector<int> numbers(size);
    for (std::size_t i = 0; i < size; ++i) {
      around[i] = {static_cast<int>(turned[3 * i]), static_cast<int>(turned[3 * i + 1]),
                   static_cast<int>(turned[3 * i + 2])};
      numbers[i] = static_cast<int>(i);
    }
    upload(g.image, around);
    upload(g.number, numbers);
    std::vector<std::int64_t> collided(size);
    if (options.exchanges) {
      const auto& before = integers(checkpoint, "effects.charge_exchange.collisions");
      if (before.size() == size) collided = before;
      const auto& transfers = integers(checkpoint, "effects.charge_exchange.counters");
      count.transfers = transfers.at(1), count.refused = transfers.at(2);
    }
    upload(g.collisions, collided);
    upload(g.begun, std::vector<int>(size, no_end));
    grains.zero(g.moved_charge, g.dissipated, g.busy, g.touches, g.force, g.halfway, g.impulse, g.shift, g.slow_force,
                g.charged);
    time = reals("time", 1).front();
    const auto& counters = integers(checkpoint, "counters");
    count.steps = counters.at(0), count.contact_steps = counters.at(1), count.collisions = counters.at(2);
    const auto before = reals("book", 5);
    dissipated_before = static_cast<std::int64_t>(std::nearbyint(before[0] / units.energy));
    extremes.upload({Extremes{.overlap = before[4]}});
    FieldEnergyBudget field;
    field.exchanged = before[1];
    field_energy.upload({field});
    driven_before = before[2];
    driven.upload({0});
    count.evaluations = options.tables ? integers(checkpoint, "effects.coulomb.counters").at(0) : 0;
  }

  const GrainsView& view() const { return grains.view; }
  /// Returns true if grains exchange charge in transfers that depend on earlier ones.
  bool exchanges_in_order() const { return options.exchanges && options.exchange.in_order(); }
  /// Returns the index in the scene of each sorted grain.
  std::vector<int> numbers() const {
    std::vector<int> all(n);
    run->to_host(all.data(), view().number, all.size() * sizeof(int));
    return all;
  }
  /// Sends the state of own grains to all ranks. `field_at_source`: electric fields at the grains, or null.
  void join(FieldSample* field_at_source) const {
    const GrainsView& g = view();
    field_at_source ? share.send_to_all(g.position, g.momentum, g.image, g.dissipated, field_at_source)
                    : share.send_to_all(g.position, g.momentum, g.image, g.dissipated);
    if (options.exchanges) share.send_to_all(g.charge, g.collisions);
  }
  double driven_energy() const { return driven_before + static_cast<double>(driven.download().front()) * units.energy; }
  double dissipated_energy() const {
    return static_cast<double>(dissipated_before + dissipated_quanta()) * units.energy;
  }

  // Public because nvcc requires it of functions with kernels.

  /// Writes the state of each grain for a checkpoint to `to` (device memory), in the order of the scene.
  void list_records(GrainRecord* to) const {
    const GrainsView g = view();
    run->for_each(n, [=] LICHTENBERG_HOST_DEVICE(int s) {
      to[g.number[s]] = {g.position[s], g.momentum[s], g.charge[s], g.collisions[s], g.image[s], 0};
    });
  }
  /// Sorts the data of the grains again: grain order[s] becomes the grain with the sorted index s. `field_at_source`:
  /// electric fields at the grains, sorted too, or null.
  void permute(const int* order, FieldSample* field_at_source) {
    Grain* to = spare.data();
    const GrainsView all = view();
    run->for_each(n, [=] LICHTENBERG_HOST_DEVICE(int s) { to[s] = all.take(order[s], field_at_source); });
    const Vec3 over = units_per_length();
    run->for_each(n, [=] LICHTENBERG_HOST_DEVICE(int s) {
      const Grain g = to[s];
      all.put(s, g, field_at_source);
      all.sorted_at[s] = all.charged[s].at = fixed_point_position(g.position, over);
      all.compact[s] = {all.sorted_at[s], static_cast<float>(g.radius)};
      all.touches[s] = 0;
    });
  }
  /// Joins the charges that grains of different ranks have exchanged. Then each rank can charge its own grains.
  void join_exchanged_charges() {
    if (share.is_divided() && options.exchanges && !elastic) share.add_to_owners(view().moved_charge, received_charge);
  }
  /// Returns the largest magnitude of a charge (q0), in device memory. Each rank must have all charges.
  const double* find_largest_charge() {
    double* largest = &field_energy.data()->largest_charge;
    const double* charge = view().charge;
    find_maximum(*run, n, largest, [=] LICHTENBERG_HOST_DEVICE(int s) { return std::abs(charge[s]); });
    return largest;
  }
  /// Computes the input of the sums over charges: fixed-point positions, and charges scaled to at most 1. `largest`:
  /// largest magnitude of a charge (q0) in device memory. With several ranks each has the charges near its own
  /// grains.
  void scale_charges(const double* largest) {
    FieldEnergyBudget* budget = field_energy.data();
    const GrainsView g = view();
    if (share.is_divided()) share.send_to_neighbours(g.charge);
    const Vec3 over = units_per_length();
    run->for_each(n, [=] LICHTENBERG_HOST_DEVICE(int s) {
      const double scale = periodic::device::charge_scale(*largest);
      g.charged[s] = {fixed_point_position(g.position[s], over), static_cast<float>(scale * g.charge[s])};
      if (s == 0) budget->scale = scale;
    });
  }
  /// Sets the fixed-point positions of the grains near those of this rank to the positions that other ranks have sent.
  void locate_others() {
    const auto other = share.other();
    const GrainsView g = view();
    const Vec3 over = units_per_length();
    run->for_each(share.others(), [=] LICHTENBERG_HOST_DEVICE(int k) {
      const int s = other(k);
      g.compact[s].at = g.charged[s].at = fixed_point_position(g.position[s], over);
    });
  }
  /// Returns the energy dissipated since the gas was loaded, in quanta units.energy.
  std::int64_t dissipated_quanta() const {
    const std::int64_t* quanta_of = view().dissipated;
    total.resize(1);
    total.zero();
    std::int64_t* to = total.data();
    const int all = n;
    run->sum_segments((all + a_part - 1) / a_part, [=] LICHTENBERG_HOST_DEVICE(int p) { return part(all, p); },
                      [=] LICHTENBERG_HOST_DEVICE(int p, int t) { return quanta_of[p * a_part + t]; },
                      [=] LICHTENBERG_HOST_DEVICE(int, std::int64_t sum) { parallel::add_atomically(to, sum); });
    return total.download().front();
  }

  /// Returns the number of units of fixed-point positions per length (1/d0), 2^32 over the search length, for each
  /// axis.
  Vec3 units_per_length() const {
    return {units_per_box / search_lengths.x, units_per_box / search_lengths.y, units_per_box / search_lengths.z};
  }
  GrainProperties grain_properties() const { return {lightest, smallest_radius, typical_impact(options.mass.size())}; }
  static constexpr int a_part = 256;  ///< number of grains in a segment of sums over all grains
  /// Returns the number of grains in segment p of n grains.
  LICHTENBERG_HOST_DEVICE static int part(int n, int p) { return n - p * a_part < a_part ? n - p * a_part : a_part; }

  const Executor* run;
  GasOptions options;
  int n;
  Box<3> box;
  /// Periods (d0) of neighbour searches: lengths of the box, and longer ones between sides that are not periodic. There
  /// they are those of the mesh of charges, or twice the length. Searches can find pairs beyond these sides, which are
  /// too distant to act on each other.
  Vec3 search_lengths;
  GrainContactLaw law;
  bool elastic = false;  ///< true in an elastic stage: no charge is exchanged, and no drive acts
  double largest_radius = 0, smallest_radius = 0, lightest = 0;
  FixedPointScale units;
  double time = 0;
  Counters count;
  Share<Executor> share{*run};  ///< with several ranks: the grains of this one

  parallel::Arrays<GrainsView, Executor> grains{*run};
  Array<FixedPointVec> pair_force{*run};  ///< forces of pair laws in quanta; empty without such laws
  Array<std::int64_t> pair_energy{*run};
  Array<Grain> spare{*run};
  Array<std::int64_t> received_charge{*run};  ///< from other ranks (join_exchanged_charges())

  Array<Extremes> extremes{*run};
  RestitutionOn<Executor> restitution{*run};
  Array<std::int64_t> driven{*run};  ///< energy that drives have given since the gas was loaded, in quanta
  Array<FieldEnergyBudget> field_energy{*run};
  double driven_before = 0;            ///< energy that drives had given when the gas was loaded
  std::int64_t dissipated_before = 0;  ///< energy dissipated when the gas was loaded, in quanta

 private:
  static std::vector<Vec3> vectors(const std::vector<double>& values) {
    std::vector<Vec3> vectors(values.size() / 3);
    for (std::size_t i = 0; i < vectors.size(); ++i) vectors[i] = {values[3 * i], values[3 * i + 1], values[3 * i + 2]};
    return vectors;
  }
  template <class T>
  void upload(T* to, const std::vector<T>& values) {
    run->to_device(to, values.data(), values.size() * sizeof(T));
  }
  /// Chooses the quanta (powers of two) of fixed-point sums of forces, impulses and shifts. For forces the quantum is
  /// about 2^-58 of a very large contact force, so that a sum may be 2^5 times this force. For impulses it is about
  /// 2^-52 of the largest mass times v0, and for shifts (displacement times mass) about 2^-54 of the largest mass times
  /// d0.
  void choose_units(double force_ratio) {
    const double heaviest = *std::ranges::max_element(options.mass);
    const double force = std::visit(
        [&](const auto& one) {
          const ContactParts most = one.parts(largest_radius, one.scale(largest_radius, largest_radius));
          constexpr double fast = 100;  // v0; a faster grain would pass through others
          return force_ratio * (most.elastic + fast * most.damping);
        },
        law);
    const auto power = [](double value) { return static_cast<int>(std::ceil(std::log2(value))); };
    units.force = std::ldexp(1.0, power(force) - 58);
    units.impulse = std::ldexp(1.0, power(heaviest) - 52);
    units.shift = std::ldexp(1.0, power(heaviest) - 54);
  }

  mutable Array<std::int64_t> total{*run};
};

}  // namespace lichtenberg::granular::device
