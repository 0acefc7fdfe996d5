#pragma once

// A gas on an executor: what it holds, how it is sorted, and the walk through an outer step.

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "solvers/error.hpp"
#include "solvers/periodic/device/charges.hpp"
#include "solvers/stopwatch.hpp"
#include "src/granular/device/contact_steps.hpp"
#include "src/granular/device/device.hpp"

namespace lichtenberg::granular::device {

using periodic::device::Charged;
using periodic::device::ChargeSums;
using periodic::device::Felt;
using periodic::device::Totals;

/// What a scene has that a device needs to know.
struct GasOptions {
  Vec3 lengths;
  std::vector<double> mass, radius;  ///< [N]
  double step = 0;                   ///< the longest
  int contact_steps = 1;
  std::uint64_t seed = 0;
  std::string path;
  std::optional<periodic::device::MeshTables> tables;  ///< of charges; empty: they do not act
  double strength = 0;                                 ///< K
  bool charged = false, exchanges = false;
  effects::ImpactExchange exchange{};
  double bytes = 0;  ///< of the device, by an estimate
};

/// Of a scene that check_scene does not refuse.
GasOptions gas_options(const Scene& scene);

/// An open contact, as a checkpoint has it.
struct OpenContact {
  int i, j;
  double since, impact_speed;
  int alone;
};

/// Things of which the largest is sought.
struct Largest {
  double speed2 = 0, acceleration2 = 0, moved2 = 0, impact2 = 0;
  int lost = 0, unused = 0;

  LICHTENBERG_HOST_DEVICE static double larger(double a, double b) { return b > a ? b : a; }
  LICHTENBERG_HOST_DEVICE Largest& operator+=(const Largest& o) {
    speed2 = larger(speed2, o.speed2), acceleration2 = larger(acceleration2, o.acceleration2);
    moved2 = larger(moved2, o.moved2), impact2 = larger(impact2, o.impact2);
    lost |= o.lost;
    return *this;
  }
  friend LICHTENBERG_HOST_DEVICE Largest operator+(Largest a, const Largest& b) { return a += b; }
};

struct TurnsAround {
  int x = 0, y = 0, z = 0;
};

/// The energy of the field, and what exchange has given to it.
struct FieldBook {
  double energy = 0, exchanged = 0;
  double scale = 1;           ///< of Charged::charge
  double largest_charge = 0;  ///< magnitude
};

/// The forces of charges on grains.
struct ForceView {
  const Charged* charges = nullptr;
  const Felt* felt = nullptr;
  const Totals* totals = nullptr;
  const FieldBook* book = nullptr;
  double strength = 0, background = 0;

  LICHTENBERG_HOST_DEVICE Vec3 operator()(int s) const {
    if (!felt || totals->square == 0) return {};
    const double q = charges[s].charge, over = q / totals->square, factor = strength * q / (book->scale * book->scale);
    return {factor * (felt[s].x - over * totals->x), factor * (felt[s].y - over * totals->y),
            factor * (felt[s].z - over * totals->z)};
  }
  LICHTENBERG_HOST_DEVICE double energy() const {
    if (!felt) return 0;
    return strength / (book->scale * book->scale) *
           (totals->energy + 0.5 * background * totals->charge * totals->charge);
  }
};

template <class Executor>
class GasOn final : public DeviceGas {
  template <class T>
  using Array = parallel::Array<T, Executor>;

 public:
  GasOn(std::unique_ptr<Executor> run, const GasOptions& options)
      : run_(std::move(run)),
        options_(options),
        n_(static_cast<int>(options.mass.size())),
        box_{options.lengths},
        cells_(*run_, options.lengths, cell_edges(options)),
        table_(*run_),
        partners_(*run_) {
    box_.sides.fill(Boundary::periodic);
    largest_radius_ = *std::ranges::max_element(options.radius);
    // A sum of all energies has 52 bits of so much.
    energy_quantum_ = std::ldexp(1.0, -32 + std::max(0, static_cast<int>(std::ceil(std::log2(n_ / 32768.0)))));
    run_->check_room(static_cast<std::size_t>(options.bytes));
    if (options.tables) sums_.emplace(*run_, *options.tables);
    found_.resize(1);
    parameters_.resize(1);
    book_.resize(1);
    for_each_grain_array([&](auto& array) { array.resize(n_); });
    held_.resize(n_);
    charges_.resize(n_);
    sorted_at_.resize(n_);
    touches_.resize(n_);
    busy_.resize(n_);
    near_count_.resize(n_);
    order_.resize(n_);
  }

  void load(const Checkpoint& checkpoint, const GrainContactLaw& law, bool elastic) override {
    law_ = law;
    elastic_ = elastic;
    const auto reals = [&](const char* name, std::size_t size) { return lichtenberg::reals(checkpoint, name, size); };
    const std::size_t n = n_;
    upload_vectors(place_, reals("position", 3 * n));
    upload_vectors(momentum_, reals("momentum", 3 * n));
    mass_.upload(options_.mass);
    radius_.upload(options_.radius);
    charge_.upload(options_.charged ? reals("charge", n) : std::vector<double>(n));
    const auto& image = integers(checkpoint, "image");
    std::vector<TurnsAround> around(n);
    std::vector<int> number(n);
    for (std::size_t i = 0; i < n; ++i) {
      around[i] = {static_cast<int>(image[3 * i]), static_cast<int>(image[3 * i + 1]),
                   static_cast<int>(image[3 * i + 2])};
      number[i] = static_cast<int>(i);
    }
    image_.upload(around);
    number_.upload(number);
    std::vector<std::int64_t> collisions(n), zeros(n);
    if (options_.exchanges) {
      const auto& before = integers(checkpoint, "effects.charge_exchange.collisions");
      if (before.size() == n) collisions = before;
      transfers_ = integers(checkpoint, "effects.charge_exchange.counters").at(1);
    }
    collisions_.upload(collisions);
    moved_charge_.upload(zeros);
    dissipated_.upload(zeros);
    time_ = reals("time", 1).front();
    const auto& counters = integers(checkpoint, "counters");
    steps_ = counters.at(0), contact_steps_ = counters.at(1), collisions_counted_ = counters.at(2);
    const auto book = reals("book", 5);
    dissipated_before_ = static_cast<std::int64_t>(std::nearbyint(book[0] / energy_quantum_));
    largest_overlap_ = book[4];
    book_.upload({FieldBook{.exchanged = book[1]}});
    evaluations_ = sums_ ? integers(checkpoint, "effects.coulomb.counters").at(0) : 0;
    graphs_.clear();
    recharge_.clear();
    skin_ = 0;
    load_contacts(checkpoint);
  }

  void store(Checkpoint& checkpoint) const override {
    const std::vector<int> number = number_.download();
    const auto by_number = [&](const auto& values, std::size_t width, const auto& put) {
      for (int s = 0; s < n_; ++s) put(number[s] * width, values[s]);
    };
    const auto vectors = [&](const char* name, const Array<Vec3>& array) {
      std::vector<double>& to = checkpoint.reals[name];
      to.resize(3 * static_cast<std::size_t>(n_));
      by_number(array.download(), 3,
                [&](std::size_t at, const Vec3& v) { to[at] = v.x, to[at + 1] = v.y, to[at + 2] = v.z; });
    };
    vectors("position", place_);
    vectors("momentum", momentum_);
    std::vector<std::int64_t>& image = checkpoint.integers["image"];
    by_number(image_.download(), 3,
              [&](std::size_t at, const TurnsAround& t) { image[at] = t.x, image[at + 1] = t.y, image[at + 2] = t.z; });
    if (options_.charged) {
      std::vector<double>& charge = checkpoint.reals["charge"];
      by_number(charge_.download(), 1, [&](std::size_t at, double q) { charge[at] = q; });
    }
    if (options_.exchanges) {
      std::vector<std::int64_t>& collisions = checkpoint.integers["effects.charge_exchange.collisions"];
      collisions.resize(n_);
      by_number(collisions_.download(), 1, [&](std::size_t at, std::int64_t c) { collisions[at] = c; });
      checkpoint.integers["effects.charge_exchange.counters"].at(1) = transfers_;
    }
    if (sums_) checkpoint.integers["effects.coulomb.counters"].at(0) = evaluations_;
    checkpoint.reals["time"] = {time_};
    checkpoint.integers["counters"] = {steps_, contact_steps_, collisions_counted_};
    std::int64_t dissipated = dissipated_before_;
    for (const std::int64_t quanta : dissipated_.download()) dissipated += quanta;
    std::vector<double>& book = checkpoint.reals["book"];
    book[0] = static_cast<double>(dissipated) * energy_quantum_;
    book[1] = book_.download().front().exchanged;
    book[4] = largest_overlap_;
    store_contacts(checkpoint);
  }

  double time() const override { return time_; }
  StepCounts counts() const override { return counts_; }

  void step(double time) override {
    const Stopwatch stopwatch(counts_.seconds);
    if (skin_ == 0) begin();
    const double speed = std::sqrt(now_.speed2), left = time - time_;
    constexpr double path = 0.2;  // Multirate's
    const double longest = speed * options_.step > path ? path / speed : options_.step;
    const double count = std::ceil(left / longest), end = count <= 1 ? time : time_ + left / count;
    const double dt = end - time_, gain = std::sqrt(now_.acceleration2) * dt;
    const double impact = std::max(2 * speed, std::sqrt(now_.impact2));
    const double resolved = shortest_contact(law_, impact + 2 * gain) / options_.contact_steps;
    const int inner = std::max(1, static_cast<int>(std::ceil(dt / resolved)));
    // Contacts may speed a grain up: twice the fastest is more than any has after a collision.
    const double travel = 2 * (speed + gain) * dt;
    if (std::sqrt(now_.moved2) + travel > 0.5 * skin_) arrange(travel);
    parameters_.upload(
        {StepParameters{time_, dt, dt / inner, 2 * travel, std::sqrt(now_.acceleration2), charge_quantum()}});
    run_->run(graphs_[inner], [&] { outer_step(inner); });
    read_found();
    time_ = end;
    ++steps_, ++counts_.steps;
    contact_steps_ += inner, counts_.contact_steps += inner;
    if (sums_) ++evaluations_, ++counts_.evaluations;
    if (now_.transfers > 0 && sums_) {
      run_->run(recharge_, [&] { recharge(true); });
      ++evaluations_, ++counts_.evaluations;
    }
  }

  // Public, as nvcc wants all functions that have kernels.

  void begin() {
    charges_.zero();
    arrange(0);
    if (sums_) recharge(false);
    parameters_.upload({StepParameters{}});
    std::visit([&](const auto& law) { list_near(law); }, law_);  // those that overlap
    look();
    read_found();
  }

  /// Sorts the grains, and lists those that may touch and whose charges are near, with room for moves.
  void arrange(double travel) {
    const Stopwatch stopwatch(counts_.list_seconds);
    ++counts_.lists;
    // Twice as much as is needed now may be kept: kernels that are recorded know the lists' range.
    const double skin = 5 * std::max(travel, least_travel);
    if (!(skin <= skin_ && skin_ <= 2 * skin)) skin_ = 1.2 * skin;
    const Vec3* place = place_.data();
    const Vec3 over{whole_turn / box_.lengths.x, whole_turn / box_.lengths.y, whole_turn / box_.lengths.z};
    const auto turned = [=] LICHTENBERG_HOST_DEVICE(int i) {
      return Turns{turns(place[i].x, over.x), turns(place[i].y, over.y), turns(place[i].z, over.z)};
    };
    cells_.sort(n_, turned);
    run_->copy(order_.data(), cells_.order(), n_ * sizeof(int));
    if (loaded_) list_open();
    for_each_grain_array([&](auto& array) { permute(array.data()); });
    Turns* at = sorted_at_.data();
    run_->for_each(n_, [=] LICHTENBERG_HOST_DEVICE(int s) { at[s] = turned(s); });
    const Turns* places = sorted_at_.data();
    const auto place_of = [=] LICHTENBERG_HOST_DEVICE(int s) { return places[s]; };
    table_.build(n_, cells_.view(), box_.lengths, 2 * largest_radius_ + skin_, place_of);
    resize_contacts();
    take_open();
    if (sums_) {
      partners_.build(n_, cells_.view(), box_.lengths, sums_->cutoff() + skin_, place_of);
      sums_->arrange(n_, cells_.view(), 0.5 * skin_);
      permute(charges_.data());
      permute(sums_->felt());
    }
    now_.moved2 = 0;
    if (const Kernels seen = kernels(); !(seen == recorded_)) {
      graphs_.clear();
      recharge_.clear();
      recorded_ = seen;
    }
  }

  /// After charges or the order of grains have changed: what charges feel. `booked`: the change of energy is what an
  /// exchange gave to the field.
  void recharge(bool booked) {
    FieldBook* book = book_.data();
    const double* charge = charge_.data();
    const int n = n_;
    run_->for_each(1, [=] LICHTENBERG_HOST_DEVICE(int) { book->largest_charge = 0; });
    run_->sum_segments(
        (n + a_part - 1) / a_part, [=] LICHTENBERG_HOST_DEVICE(int p) { return part(n, p); },
        [=] LICHTENBERG_HOST_DEVICE(int p, int t) { return Largest{.speed2 = std::abs(charge[p * a_part + t])}; },
        [=] LICHTENBERG_HOST_DEVICE(int, Largest most) {
          parallel::enlarge_atomically(&book->largest_charge, most.speed2);
        });
    Charged* charges = charges_.data();
    const Vec3* place = place_.data();
    const Vec3 over{whole_turn / box_.lengths.x, whole_turn / box_.lengths.y, whole_turn / box_.lengths.z};
    run_->for_each(n, [=] LICHTENBERG_HOST_DEVICE(int s) {
      const double scale = periodic::device::charge_scale(book->largest_charge);
      charges[s] = {{turns(place[s].x, over.x), turns(place[s].y, over.y), turns(place[s].z, over.z)},
                    static_cast<float>(scale * charge[s])};
      if (s == 0) book->scale = scale;
    });
    sums_->evaluate(charges, partners_.view(), true);
    const ForceView force = forces();
    run_->for_each(1, [=] LICHTENBERG_HOST_DEVICE(int) {
      const double energy = force.energy();
      if (booked) book->exchanged += energy - book->energy;
      book->energy = energy;
    });
  }

  /// Lists the pairs that may matter within a step; nothing has been found yet.
  template <class Law>
  void list_near(const Law& law) {
    found_.zero();
    const ContactSteps<Law> steps = contact_steps(law);
    // Kernels that are recorded read how many entries there are.
    const int n = n_, lanes = 16 * n_;
    run_->for_each(lanes, [=] LICHTENBERG_HOST_DEVICE(int k) {
      const int entries = steps.contacts.table.end(n - 1);
      for (int e = k; e < entries; e += lanes) steps.mark_near(e);
    });
    run_->for_each(n, [=] LICHTENBERG_HOST_DEVICE(int s) { steps.list_near(s); });
    run_->for_each(n, [=] LICHTENBERG_HOST_DEVICE(int s) { steps.list_pairs(s); });
  }

  void outer_step(int inner) {
    std::visit([&](const auto& law) { outer_step(law, inner); }, law_);
  }
  template <class Law>
  void outer_step(const Law& law, int inner) {
    const ForceView force = forces();
    list_near(law);
    const ContactSteps<Law> steps = contact_steps(law);
    const Found* found = found_.data();
    const int* active = active_.data();
    const int n = n_;
    Vec3* held = held_.data();
    run_->for_each(n, [=] LICHTENBERG_HOST_DEVICE(int s) { held[s] = force(s); });
    for (int step = 0; step < inner; ++step) {
      run_->template for_each<64>(n, [=] LICHTENBERG_HOST_DEVICE(int k) {
        for (int p = k; p < found->pairs; p += n) steps.note_and_push(p);
      });
      run_->template for_each<64>(n, [=] LICHTENBERG_HOST_DEVICE(int k) {
        for (int p = k; p < found->pairs; p += n) steps.push_halfway(p);
      });
      run_->template for_each<32>(n, [=] LICHTENBERG_HOST_DEVICE(int k) {
        for (int a = k; a < found->active; a += n) steps.integrate(active[a], step);
      });
      run_->template for_each<64>(n, [=] LICHTENBERG_HOST_DEVICE(int s) { steps.move(s); });
    }
    run_->template for_each<64>(n, [=] LICHTENBERG_HOST_DEVICE(int k) {
      for (int p = k; p < found->pairs; p += n) steps.note(p);
    });
    wrap();
    if (sums_) sums_->evaluate(charges_.data(), partners_.view(), options_.exchanges);
    finish();
    look();
  }

  /// Brings the grains back into the box.
  void wrap() {
    Vec3* place = place_.data();
    TurnsAround* image = image_.data();
    Charged* charges = charges_.data();
    const Box<3> box = box_;
    const Vec3 over{whole_turn / box_.lengths.x, whole_turn / box_.lengths.y, whole_turn / box_.lengths.z};
    run_->for_each(n_, [=] LICHTENBERG_HOST_DEVICE(int s) {
      Vec3 p = place[s];
      Image<3> around{image[s].x, image[s].y, image[s].z};
      box.wrap(p, around);
      place[s] = p;
      image[s] = {around[0], around[1], around[2]};
      charges[s].at = {turns(p.x, over.x), turns(p.y, over.y), turns(p.z, over.z)};
    });
  }

  /// Momenta change as if forces of charges had changed linearly; charges move.
  void finish() {
    const ForceView force = forces();
    const Vec3* held = held_.data();
    Vec3* momentum = momentum_.data();
    double* charge = charge_.data();
    std::int64_t* moved = moved_charge_.data();
    const StepParameters* parameters = parameters_.data();
    FieldBook* book = book_.data();
    run_->for_each(n_, [=] LICHTENBERG_HOST_DEVICE(int s) {
      momentum[s] += (0.5 * parameters->outer) * (force(s) - held[s]);
      if (s == 0) book->energy = force.energy();
      if (moved[s] == 0) return;
      charge[s] += parameters->charge_quantum * static_cast<double>(moved[s]);
      moved[s] = 0;
    });
  }

  /// What the host wants to know before the next step.
  void look() {
    std::visit([&](const auto& law) { look(law); }, law_);
  }
  template <class Law>
  void look(const Law& law) {
    const ContactSteps<Law> steps = contact_steps(law);
    const ForceView force = forces();
    const Turns* sorted_at = sorted_at_.data();
    const Vec3 lengths = box_.lengths;
    const int n = n_;
    Found* found = found_.data();
    run_->sum_segments((n + a_warp - 1) / a_warp,
                       [=] LICHTENBERG_HOST_DEVICE(int p) { return n - p * a_warp < a_warp ? n - p * a_warp : a_warp; },
                       [=] LICHTENBERG_HOST_DEVICE(int p, int t) {
                         const int s = p * a_warp + t;
                         const double over = 1 / steps.grains.mass[s];
                         const Vec3 at = steps.grains.place[s], velocity = over * steps.grains.momentum[s];
                         const Turns then = sorted_at[s];
                         const Vec3 moved{
                             lichtenberg::apart(turns(at.x, whole_turn / lengths.x), then.x) * lengths.x / whole_turn,
                             lichtenberg::apart(turns(at.y, whole_turn / lengths.y), then.y) * lengths.y / whole_turn,
                             lichtenberg::apart(turns(at.z, whole_turn / lengths.z), then.z) * lengths.z / whole_turn};
                         Largest here{.speed2 = norm2(velocity),
                                      .acceleration2 = norm2(over * force(s)),
                                      .moved2 = norm2(moved),
                                      .impact2 = steps.impact2(s)};
                         here.lost = !(here.speed2 < INFINITY) || !(norm2(at) < INFINITY);
                         return here;
                       },
                       [=] LICHTENBERG_HOST_DEVICE(int, Largest most) {
                         parallel::enlarge_atomically(&found->speed2, most.speed2);
                         parallel::enlarge_atomically(&found->acceleration2, most.acceleration2);
                         parallel::enlarge_atomically(&found->moved2, most.moved2);
                         parallel::enlarge_atomically(&found->impact2, most.impact2);
                         parallel::enlarge_atomically(&found->lost, most.lost);
                       });
  }

  template <class T>
  void permute(T* from) {
    spare_.resize((n_ * sizeof(T) + 7) / 8);
    T* to = reinterpret_cast<T*>(spare_.data());
    const int* order = order_.data();
    run_->for_each(n_, [=] LICHTENBERG_HOST_DEVICE(int s) { to[s] = from[order[s]]; });
    run_->copy(from, to, n_ * sizeof(T));
  }

  /// Room for what is known of entries and pairs.
  void resize_contacts() {
    const std::size_t entries = table_.entries(), pairs = entries / 2;
    for (Array<double>* array : {&since_, &impact_speed_}) array->resize(entries);
    for (Array<int>* array : {&alone_, &near_, &owner_, &pair_of_}) array->resize(entries);
    for (Array<Vec3>* array : {&contact_force_, &contact_halfway_, &contact_first_, &impulse_, &shift_})
      array->resize(pairs);
    pair_.resize(pairs);
    active_.resize(pairs);
    pair_dissipated_.resize(pairs);
    const TableView table = table_.view();
    int* owner = owner_.data();
    run_->for_each(n_, [=] LICHTENBERG_HOST_DEVICE(int s) {
      for (int e = table.begin(s); e < table.end(s); ++e) owner[e] = s;
    });
  }

  /// Lists open contacts, in any order.
  void list_open() const {
    const TableView table = table_.view();
    open_count_.resize(1);
    open_count_.zero();
    open_.resize(table_.entries() / 2);
    int* count = open_count_.data();
    OpenContact* open = open_.data();
    const double *since = since_.data(), *impact = impact_speed_.data();
    const int *alone = alone_.data(), *number = number_.data(), *owner = owner_.data();
    run_->for_each(static_cast<long>(table_.entries()), [=] LICHTENBERG_HOST_DEVICE(int e) {
      if (since[e] >= 0)
        open[parallel::take_place(count)] = {number[owner[e]], number[table.partner[e]], since[e], impact[e], alone[e]};
    });
    int all = 0;
    run_->to_host(&all, count, sizeof(int));
    open_.resize(all);
  }
  /// Puts the open contacts into the table, where those of the lower number have them.
  void take_open() {
    const int n = n_;
    place_of_.resize(n);
    int* place_of = place_of_.data();
    const int* number = number_.data();
    run_->for_each(n, [=] LICHTENBERG_HOST_DEVICE(int s) { place_of[number[s]] = s; });
    run_->fill(since_.data(), 0xff, since_.size() * sizeof(double));  // no numbers
    const TableView table = table_.view();
    double *since = since_.data(), *impact = impact_speed_.data();
    int* alone = alone_.data();
    const OpenContact* open = open_.data();
    run_->for_each(static_cast<long>(open_.size()), [=] LICHTENBERG_HOST_DEVICE(int k) {
      const int s = place_of[open[k].i], j = place_of[open[k].j];
      for (int e = table.begin(s); e < table.end(s); ++e)
        if (table.partner[e] == j) since[e] = open[k].since, impact[e] = open[k].impact_speed, alone[e] = open[k].alone;
    });
    loaded_ = true;
  }

 private:
  static constexpr int a_part = 256, a_warp = 32;
  static constexpr double least_travel = 0.1;  ///< lists for less are made no more seldom

  LICHTENBERG_HOST_DEVICE static int part(int n, int p) { return n - p * a_part < a_part ? n - p * a_part : a_part; }

  static Vec3 cell_edges(const GasOptions& options) {
    const double range = options.tables ? options.tables->cutoff + 0.6 : 2;
    return {range / 2, range / 2, range / 4};
  }
  static void upload_vectors(Array<Vec3>& array, const std::vector<double>& values) {
    std::vector<Vec3> vectors(values.size() / 3);
    for (std::size_t i = 0; i < vectors.size(); ++i) vectors[i] = {values[3 * i], values[3 * i + 1], values[3 * i + 2]};
    array.upload(vectors);
  }
  template <class Work>
  void for_each_grain_array(Work&& work) {
    work(place_), work(momentum_), work(image_), work(charge_), work(mass_), work(radius_), work(number_);
    work(collisions_), work(moved_charge_), work(dissipated_);
  }
  double charge_quantum() const { return options_.exchanges ? effects::charge_quantum(options_.exchange.strength) : 1; }

  ForceView forces() const {
    if (!sums_) return {};
    return {charges_.data(), sums_->felt(), sums_->totals(), book_.data(), options_.strength, sums_->background()};
  }
  template <class Law>
  ContactSteps<Law> contact_steps(const Law& law) const {
    const GrainsView grains{.count = n_,
                            .place = place_.data(),
                            .momentum = momentum_.data(),
                            .mass = mass_.data(),
                            .radius = radius_.data(),
                            .number = number_.data(),
                            .held = held_.data(),
                            .busy = busy_.data(),
                            .touches = touches_.data(),
                            .collisions = collisions_.data(),
                            .moved_charge = moved_charge_.data(),
                            .dissipated = dissipated_.data()};
    const ContactsView contacts{.table = table_.view(),
                                .owner = owner_.data(),
                                .near = near_.data(),
                                .count = near_count_.data(),
                                .pair_of = pair_of_.data(),
                                .since = since_.data(),
                                .impact_speed = impact_speed_.data(),
                                .alone = alone_.data(),
                                .pair = pair_.data(),
                                .active = active_.data(),
                                .force = contact_force_.data(),
                                .halfway = contact_halfway_.data(),
                                .first = contact_first_.data(),
                                .impulse = impulse_.data(),
                                .shift = shift_.data(),
                                .dissipated = pair_dissipated_.data()};
    return {grains,        contacts,          law,           NearestImage<3>(box_),           parameters_.data(),
            found_.data(), options_.exchange, options_.seed, options_.exchanges && !elastic_, energy_quantum_};
  }

  void read_found() {
    now_ = found_.download().front();
    collisions_counted_ += now_.begun;
    transfers_ += now_.transfers;
    largest_overlap_ = std::max(largest_overlap_, now_.largest_overlap);
    if (now_.passed)
      throw Failure("grain " + std::to_string(now_.passed - 1) +
                    " and another fly through each other: the contact is too soft for their impact; a larger "
                    "stiffness, of a stage its stage.stiffness, or a lower temperature is needed");
    if (now_.lost)
      throw Failure(options_.path + ": from t = " + std::to_string(time_) + " t0 on the grains' places are no numbers");
  }

  void load_contacts(const Checkpoint& checkpoint) {
    const auto& pairs = integers(checkpoint, "contact_pairs");
    const auto& touches = lichtenberg::reals(checkpoint, "contact_touches", pairs.size() / 3 * 2);
    std::vector<OpenContact> open;
    for (std::size_t k = 0; 3 * k < pairs.size(); ++k)
      open.push_back({static_cast<int>(pairs[3 * k]), static_cast<int>(pairs[3 * k + 1]), touches[2 * k],
                      touches[2 * k + 1], pairs[3 * k + 2] != 0});
    open_.upload(open);
    loaded_ = false;
  }
  void store_contacts(Checkpoint& checkpoint) const {
    if (loaded_) list_open();
    std::vector<OpenContact> open = open_.download();
    std::ranges::sort(open,
                      [](const OpenContact& a, const OpenContact& b) { return a.i != b.i ? a.i < b.i : a.j < b.j; });
    std::vector<std::int64_t>& pairs = checkpoint.integers["contact_pairs"];
    std::vector<double>& touches = checkpoint.reals["contact_touches"];
    pairs.clear();
    touches.clear();
    for (const OpenContact& c : open) {
      pairs.insert(pairs.end(), {c.i, c.j, c.alone});
      touches.insert(touches.end(), {c.since, c.impact_speed});
    }
  }

  /// What kernels were recorded with: where lists lie, and how they are cut.
  struct Kernels {
    TableView table, partners;
    const void *since = nullptr, *alone = nullptr, *force = nullptr, *pair = nullptr, *dissipated = nullptr;
    double skin = 0;

    bool operator==(const Kernels& o) const {
      const auto same = [](const TableView& a, const TableView& b) {
        return a.start == b.start && a.partner == b.partner && a.columns == b.columns;
      };
      return same(table, o.table) && same(partners, o.partners) && since == o.since && alone == o.alone &&
             force == o.force && pair == o.pair && dissipated == o.dissipated && skin == o.skin;
    }
  };
  Kernels kernels() const {
    return {table_.view(),         partners_.view(), since_.data(),           alone_.data(),
            contact_force_.data(), pair_.data(),     pair_dissipated_.data(), skin_};
  }

  std::unique_ptr<Executor> run_;
  GasOptions options_;
  int n_;
  Box<3> box_;
  GrainContactLaw law_;
  bool elastic_ = false, loaded_ = false;
  double largest_radius_ = 0, energy_quantum_ = 1;
  double skin_ = 0;  ///< of the lists: they hold while no grain has moved by half of it; 0: there are none

  CellGrid<Executor> cells_;
  NeighbourTable<Executor> table_, partners_;  ///< of those that may touch; whose charges are near
  std::optional<ChargeSums<Executor>> sums_;

  // Of each grain, as they are sorted.
  Array<Vec3> place_{*run_}, momentum_{*run_};
  Array<TurnsAround> image_{*run_};
  Array<double> charge_{*run_}, mass_{*run_}, radius_{*run_};
  Array<int> number_{*run_};
  Array<std::int64_t> collisions_{*run_}, moved_charge_{*run_}, dissipated_{*run_};
  Array<Vec3> held_{*run_};
  Array<Charged> charges_{*run_};
  Array<Turns> sorted_at_{*run_};
  Array<int> busy_{*run_}, touches_{*run_}, near_count_{*run_}, order_{*run_}, place_of_{*run_};
  Array<double> spare_{*run_};

  // Of each entry of table_, and of pairs that may matter within a step.
  Array<double> since_{*run_}, impact_speed_{*run_};
  Array<int> alone_{*run_}, near_{*run_}, owner_{*run_}, pair_of_{*run_}, active_{*run_};
  Array<NearPair> pair_{*run_};
  Array<Vec3> contact_force_{*run_}, contact_halfway_{*run_}, contact_first_{*run_}, impulse_{*run_}, shift_{*run_};
  Array<double> pair_dissipated_{*run_};

  mutable Array<OpenContact> open_{*run_};
  mutable Array<int> open_count_{*run_};
  Array<Found> found_{*run_};
  Array<StepParameters> parameters_{*run_};
  Array<FieldBook> book_{*run_};
  std::map<int, typename Executor::Recording> graphs_;  ///< of an outer step, by its steps of contacts
  typename Executor::Recording recharge_;
  Kernels recorded_;

  Found now_;
  StepCounts counts_;
  double time_ = 0, largest_overlap_ = 0;
  std::int64_t steps_ = 0, contact_steps_ = 0, collisions_counted_ = 0, transfers_ = 0, evaluations_ = 0;
  std::int64_t dissipated_before_ = 0;  ///< quanta, when the gas was loaded
};

}  // namespace lichtenberg::granular::device
