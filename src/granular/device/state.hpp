#pragma once

// What is known of the grains of a gas on an executor, as they are sorted: taken from a checkpoint of Gas, and given
// back to one.

#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include "src/granular/device/contact_steps.hpp"
#include "src/granular/device/device.hpp"
#include "src/granular/device/gas_parts.hpp"

namespace lichtenberg::granular::device {

template <class Executor>
struct GasState {
  template <class T>
  using Array = parallel::Array<T, Executor>;

  GasState(const Executor& executor, const GasOptions& o)
      : run(&executor), options(o), n(static_cast<int>(o.mass.size())), box{o.lengths} {
    box.sides.fill(Boundary::periodic);
    largest_radius = *std::ranges::max_element(options.radius);
    smallest_radius = *std::ranges::min_element(options.radius);
    lightest = *std::ranges::min_element(options.mass);
    quanta.energy = energy_quantum(n);
    if (options.exchanges) quanta.charge = effects::charge_quantum(options.exchange.strength);
    book.resize(1);
    extremes.resize(1);
    const auto make = [&](auto&... arrays) { (arrays.resize(n), ...); };
    make(place, momentum, image, charge, over_mass, radius, number, collisions, moved_charge, dissipated);
    make(located, held, charges, sorted_at, busy, touches, begun, spare);
    make(force, halfway, impulse, shift);
    if (!options.parts.empty()) pair_force.resize(n), pair_energy.resize(1);
  }

  /// All but contacts.
  void load(const Checkpoint& checkpoint, const GrainContactLaw& with, bool in_elastic_stage, double stage_begin) {
    law = with;
    restitution.load(lichtenberg::reals(checkpoint, "restitution_check", 3 * RestitutionCheck::decades), stage_begin,
                     n);
    elastic = in_elastic_stage;
    const auto reals = [&](const char* name, std::size_t size) { return lichtenberg::reals(checkpoint, name, size); };
    const std::size_t size = n;
    upload_vectors(place, reals("position", 3 * size));
    upload_vectors(momentum, reals("momentum", 3 * size));
    std::vector<double> over;
    for (const double mass : options.mass) over.push_back(1 / mass);
    over_mass.upload(over);
    radius.upload(options.radius);
    choose_quanta();
    charge.upload(options.charged ? reals("charge", size) : std::vector<double>(size));
    const auto& turned = integers(checkpoint, "image");
    std::vector<TurnsAround> around(size);
    std::vector<int> numbers(size);
    for (std::size_t i = 0; i < size; ++i) {
      around[i] = {static_cast<int>(turned[3 * i]), static_cast<int>(turned[3 * i + 1]),
                   static_cast<int>(turned[3 * i + 2])};
      numbers[i] = static_cast<int>(i);
    }
    image.upload(around);
    number.upload(numbers);
    std::vector<std::int64_t> collided(size), zeros(size);
    if (options.exchanges) {
      const auto& before = integers(checkpoint, "effects.charge_exchange.collisions");
      if (before.size() == size) collided = before;
      count.transfers = integers(checkpoint, "effects.charge_exchange.counters").at(1);
    }
    collisions.upload(collided);
    moved_charge.upload(zeros);
    dissipated.upload(zeros);
    begun.upload(std::vector<int>(size, no_end));
    const auto clear = [](auto&... arrays) { (arrays.zero(), ...); };
    clear(busy, touches, force, halfway, impulse, shift, held, charges);
    time = reals("time", 1).front();
    const auto& counters = integers(checkpoint, "counters");
    count.steps = counters.at(0), count.contact_steps = counters.at(1), count.collisions = counters.at(2);
    const auto before = reals("book", 5);
    dissipated_before = static_cast<std::int64_t>(std::nearbyint(before[0] / quanta.energy));
    extremes.upload({Extremes{.overlap = before[4]}});
    FieldBook field;
    field.exchanged = before[1];
    book.upload({field});
    driven_before = before[2];
    driven.upload({0});
    count.evaluations = options.tables ? integers(checkpoint, "effects.coulomb.counters").at(0) : 0;
  }

  GrainsView view() const {
    return {.count = n,
            .place = place.data(),
            .momentum = momentum.data(),
            .over_mass = over_mass.data(),
            .radius = radius.data(),
            .number = number.data(),
            .located = located.data(),
            .held = held.data(),
            .force = force.data(),
            .halfway = halfway.data(),
            .impulse = impulse.data(),
            .shift = shift.data(),
            .busy = busy.data(),
            .touches = touches.data(),
            .begun = begun.data(),
            .collisions = collisions.data(),
            .moved_charge = moved_charge.data(),
            .dissipated = dissipated.data()};
  }
  double driven_energy() const {
    return driven_before + static_cast<double>(driven.download().front()) * quanta.energy;
  }
  double dissipated_energy() const {
    return static_cast<double>(dissipated_before + dissipated_quanta()) * quanta.energy;
  }

  // With kernels, which nvcc wants to be public.

  /// What a checkpoint has of each, by number.
  void list_records(GrainRecord* to) const {
    const Vec3 *at = place.data(), *p = momentum.data();
    const double* q = charge.data();
    const std::int64_t* collided = collisions.data();
    const TurnsAround* around = image.data();
    const int* of = number.data();
    run->for_each(n,
                  [=] LICHTENBERG_HOST_DEVICE(int s) { to[of[s]] = {at[s], p[s], q[s], collided[s], around[s], 0}; });
  }
  /// Puts all that goes with grains into this order; `felt`: what their charges feel, or null.
  void permute(const int* order, Felt* felt) {
    Grain* to = spare.data();
    const GrainArrays from = arrays(felt);
    run->for_each(n, [=] LICHTENBERG_HOST_DEVICE(int s) { to[s] = from.take(order[s]); });
    const Vec3 over = turns_a_length();
    Turns* at = sorted_at.data();
    Located* where = located.data();
    int* touched = touches.data();
    run->for_each(n, [=] LICHTENBERG_HOST_DEVICE(int s) {
      const Grain g = to[s];
      from.put(s, g);
      at[s] = {turns(g.place.x, over.x), turns(g.place.y, over.y), turns(g.place.z, over.z)};
      where[s] = {at[s], static_cast<float>(g.radius)};
      touched[s] = 0;
    });
  }
  std::int64_t dissipated_quanta() const {
    const std::int64_t* quanta_of = dissipated.data();
    total.resize(1);
    total.zero();
    std::int64_t* to = total.data();
    const int all = n;
    run->sum_segments((all + a_part - 1) / a_part, [=] LICHTENBERG_HOST_DEVICE(int p) { return part(all, p); },
                      [=] LICHTENBERG_HOST_DEVICE(int p, int t) { return quanta_of[p * a_part + t]; },
                      [=] LICHTENBERG_HOST_DEVICE(int, std::int64_t sum) { parallel::add_atomically(to, sum); });
    return total.download().front();
  }

  Vec3 turns_a_length() const {
    return {whole_turn / box.lengths.x, whole_turn / box.lengths.y, whole_turn / box.lengths.z};
  }
  static constexpr int a_part = 256;
  LICHTENBERG_HOST_DEVICE static int part(int n, int p) { return n - p * a_part < a_part ? n - p * a_part : a_part; }

  const Executor* run;
  GasOptions options;
  int n;
  Box<3> box;
  GrainContactLaw law;
  bool elastic = false;  ///< the gas is being mixed: no charge moves
  double largest_radius = 0, smallest_radius = 0, lightest = 0;
  Quanta quanta;
  double time = 0;
  Counters count;

  Array<Vec3> place{*run}, momentum{*run};
  Array<TurnsAround> image{*run};
  Array<double> charge{*run}, over_mass{*run}, radius{*run};
  Array<int> number{*run};
  Array<std::int64_t> collisions{*run}, moved_charge{*run}, dissipated{*run};
  Array<Located> located{*run};
  Array<Vec3> held{*run};
  Array<Charged> charges{*run};
  Array<Turns> sorted_at{*run};
  Array<WholeVec> force{*run}, halfway{*run}, impulse{*run}, shift{*run};
  Array<int> busy{*run}, touches{*run}, begun{*run};
  Array<WholeVec> pair_force{*run};  ///< of laws of pairs; empty if there are none
  Array<std::int64_t> pair_energy{*run};
  Array<Grain> spare{*run};

  Array<Extremes> extremes{*run};
  RestitutionOn<Executor> restitution{*run};
  Array<std::int64_t> driven{*run};  ///< quanta of energy, since the gas was loaded
  Array<FieldBook> book{*run};
  double driven_before = 0;
  std::int64_t dissipated_before = 0;  ///< quanta, when the gas was loaded

 private:
  GrainArrays arrays(Felt* felt) const {
    return {place.data(),      momentum.data(), charge.data(), over_mass.data(), radius.data(), collisions.data(),
            dissipated.data(), charges.data(),  felt,          image.data(),     number.data()};
  }
  static void upload_vectors(Array<Vec3>& array, const std::vector<double>& values) {
    std::vector<Vec3> vectors(values.size() / 3);
    for (std::size_t i = 0; i < vectors.size(); ++i) vectors[i] = {values[3 * i], values[3 * i + 1], values[3 * i + 2]};
    array.upload(vectors);
  }
  /// Multiples of the largest power that a contact could well have over 2^58, of momenta over 2^52: no sum of pairs is
  /// 2^5 times as large, or the law is not one of grains.
  void choose_quanta() {
    const double heaviest = *std::ranges::max_element(options.mass);
    const double push = std::visit(
        [&](const auto& one) {
          const ContactParts most = one.parts(largest_radius, one.scale(largest_radius, largest_radius));
          constexpr double fast = 100;  // a grain that is as fast flies through others
          return most.elastic + fast * most.damping;
        },
        law);
    const auto power = [](double value) { return static_cast<int>(std::ceil(std::log2(value))); };
    quanta.force = std::ldexp(1.0, power(push) - 58);
    quanta.impulse = std::ldexp(1.0, power(heaviest) - 52);
    quanta.shift = std::ldexp(1.0, power(heaviest) - 54);
  }

  mutable Array<std::int64_t> total{*run};
};

}  // namespace lichtenberg::granular::device
