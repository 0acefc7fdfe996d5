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
#include "solvers/stopwatch.hpp"
#include "src/granular/device/contact_steps.hpp"
#include "src/granular/device/device.hpp"
#include "src/granular/device/gas_parts.hpp"

namespace lichtenberg::granular::device {

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
    quanta_.energy = std::ldexp(1.0, -32 + std::max(0, static_cast<int>(std::ceil(std::log2(n_ / 32768.0)))));
    if (options.exchanges) quanta_.charge = effects::charge_quantum(options.exchange.strength);
    check_room();
    if (options.tables) sums_.emplace(*run_, *options.tables);
    book_.resize(1);
    extremes_.resize(1);
    const auto make = [&](auto&... arrays) { (arrays.resize(n_), ...); };
    make(place_, momentum_, image_, charge_, over_mass_, radius_, number_, collisions_, moved_charge_, dissipated_);
    make(located_, held_, charges_, sorted_at_, busy_, touches_, begun_, spare_, place_of_);
    make(force_, halfway_, impulse_, shift_);
  }

  void load(const Checkpoint& checkpoint, const GrainContactLaw& law, bool elastic) override {
    law_ = law;
    elastic_ = elastic;
    const auto reals = [&](const char* name, std::size_t size) { return lichtenberg::reals(checkpoint, name, size); };
    const std::size_t n = n_;
    upload_vectors(place_, reals("position", 3 * n));
    upload_vectors(momentum_, reals("momentum", 3 * n));
    std::vector<double> over_mass;
    for (const double mass : options_.mass) over_mass.push_back(1 / mass);
    over_mass_.upload(over_mass);
    radius_.upload(options_.radius);
    choose_quanta();
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
    begun_.upload(std::vector<int>(n, no_end));
    const auto clear = [](auto&... arrays) { (arrays.zero(), ...); };
    clear(busy_, touches_, force_, halfway_, impulse_, shift_, held_, charges_);
    time_ = reals("time", 1).front();
    const auto& counters = integers(checkpoint, "counters");
    steps_ = counters.at(0), contact_steps_ = counters.at(1), collisions_counted_ = counters.at(2);
    const auto book = reals("book", 5);
    dissipated_before_ = static_cast<std::int64_t>(std::nearbyint(book[0] / quanta_.energy));
    extremes_.upload({Extremes{.overlap = book[4]}});
    book_.upload({FieldBook{.exchanged = book[1]}});
    driven_before_ = book[2];
    driven_.upload({0});
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
    const std::int64_t dissipated = dissipated_before_ + dissipated_quanta();
    std::vector<double>& book = checkpoint.reals["book"];
    book[0] = static_cast<double>(dissipated) * quanta_.energy;
    book[1] = book_.download().front().exchanged;
    book[2] = driven();
    book[4] = extremes_.download().front().overlap;
    store_contacts(checkpoint);
  }

  Snapshot snapshot() override {
    Snapshot now{.time = time_, .potential = potential_energy()};
    now.number = number_.download();
    now.place = place_.download();
    now.momentum = momentum_.download();
    if (options_.charged) now.charge = charge_.download();
    list_open();
    for (const OpenContact& c : open_.download())
      now.contacts.push_back({{c.i, c.j}, c.since, c.impact_speed, c.alone != 0});
    now.dissipated = static_cast<double>(dissipated_before_ + dissipated_quanta()) * quanta_.energy;
    now.exchanged = book_.download().front().exchanged;
    now.driven = driven();
    now.collisions = collisions_counted_;
    return now;
  }
  double potential_energy() override {
    if (skin_ == 0) begin();
    return book_.download().front().energy;
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
    const double begin_time = time_, half = 0.5 * (end - time_);
    drive(begin_time, half);
    const double speed_now = std::sqrt(now_.speed2);
    const double dt = end - time_, gain = std::sqrt(now_.acceleration2) * dt;
    const double impact = std::max(2 * speed_now, std::sqrt(now_.impact2));
    const double resolved = shortest_contact(law_, impact + 2 * gain) / options_.contact_steps;
    const int inner = std::max(1, static_cast<int>(std::ceil(dt / resolved)));
    // Contacts may speed a grain up: twice the fastest is more than any has after a collision.
    const double travel = 2 * (speed_now + gain) * dt;
    if (std::sqrt(now_.moved2) + travel > 0.5 * skin_) arrange(travel);
    const double acceleration = std::sqrt(now_.acceleration2);
    parameters_.host() = {time_, dt, dt / inner, 2 * travel, 2 * hardest_push(impact + 2 * gain) + acceleration};
    run_->run(graphs_[inner], [&] { outer_step(inner); });
    read_found();
    drive(begin_time + half, half);
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

  /// What surrounds the grains acts on them; then the host knows how fast they are.
  void drive(double time, double dt) {
    if (elastic_ || (!options_.wind && !options_.acceleration)) return;
    const Drive act{options_.wind.value_or(effects::Wind{}), options_.acceleration.value_or(Vec3{}),
                    options_.wind.has_value()};
    Vec3* momentum = momentum_.data();
    const double *over_mass = over_mass_.data(), quantum = quanta_.energy;
    const int *number = number_.data(), n = n_;
    std::int64_t* driven = driven_.data();
    Found* found = found_.device();
    run_->for_each(1, [=] LICHTENBERG_HOST_DEVICE(int) { found->speed2 = 0; });
    run_->sum_segments(
        (n + a_warp - 1) / a_warp,
        [=] LICHTENBERG_HOST_DEVICE(int w) { return n - w * a_warp < a_warp ? n - w * a_warp : a_warp; },
        [=] LICHTENBERG_HOST_DEVICE(int w, int t) {
          const int s = w * a_warp + t;
          const double over = over_mass[s];
          const Vec3 before = momentum[s], p = act(time, dt, number[s], 1 / over, before);
          momentum[s] = p;
          parallel::add_atomically(driven, whole(0.5 * over * (norm2(p) - norm2(before)) / quantum));
          return Most{norm2(over * p)};
        },
        [=] LICHTENBERG_HOST_DEVICE(int, Most most) { parallel::enlarge_atomically(&found->speed2, most.value); });
    found_.fetch();
    run_->wait();
    now_.speed2 = found_.host().speed2;
  }

  void begin() {
    arrange(0);
    if (sums_) recharge(false);
    parameters_.host() = {};
    std::visit([&](const auto& law) { begin(law); }, law_);
    read_found();
  }
  template <class Law>
  void begin(const Law& law) {
    enter(law);  // those that overlap
    look_at_contacts(law);
    finish();
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
    cells_.sort(n_, [=] LICHTENBERG_HOST_DEVICE(int i) {
      return Turns{turns(place[i].x, over.x), turns(place[i].y, over.y), turns(place[i].z, over.z)};
    });
    if (loaded_) list_open();
    permute();
    const Located* located = located_.data();
    const auto place_of = [=] LICHTENBERG_HOST_DEVICE(int s) { return located[s].at; };
    table_.build(n_, cells_.view(), box_.lengths, 2 * largest_radius_ + skin_, place_of, true);
    resize_contacts();
    take_open();
    if (sums_) {
      partners_.build(n_, cells_.view(), box_.lengths, sums_->cutoff() + skin_, place_of);
      sums_->arrange(n_, cells_.view(), 0.5 * skin_);
    }
    now_.moved2 = 0;
    if (const Kernels seen = kernels(); !(seen == recorded_)) {
      graphs_.clear();
      recharge_.clear();
      recorded_ = seen;
    }
  }

  /// Puts all that goes with grains in the order of cells.
  void permute() {
    Grain* spare = spare_.data();
    const int* order = cells_.order();
    Vec3 *place = place_.data(), *momentum = momentum_.data();
    double *charge = charge_.data(), *over_mass = over_mass_.data(), *radius = radius_.data();
    std::int64_t *collisions = collisions_.data(), *dissipated = dissipated_.data();
    Charged* charged = charges_.data();
    if (sums_) sums_->make_room(n_);
    Felt* felt = sums_ ? sums_->felt() : nullptr;
    TurnsAround* image = image_.data();
    int* number = number_.data();
    Turns* at = sorted_at_.data();
    Located* located = located_.data();
    const Vec3 over{whole_turn / box_.lengths.x, whole_turn / box_.lengths.y, whole_turn / box_.lengths.z};
    run_->for_each(n_, [=] LICHTENBERG_HOST_DEVICE(int s) {
      const int i = order[s];
      spare[s] = {place[i],      momentum[i], charge[i],
                  over_mass[i],  radius[i],   collisions[i],
                  dissipated[i], charged[i],  felt ? felt[i] : Felt{},
                  image[i],      number[i]};
    });
    run_->for_each(n_, [=] LICHTENBERG_HOST_DEVICE(int s) {
      const Grain g = spare[s];
      place[s] = g.place, momentum[s] = g.momentum, charge[s] = g.charge, over_mass[s] = g.over_mass;
      radius[s] = g.radius, collisions[s] = g.collisions, dissipated[s] = g.dissipated, charged[s] = g.charged;
      if (felt) felt[s] = g.felt;
      image[s] = g.image, number[s] = g.number;
      at[s] = located[s].at = {turns(g.place.x, over.x), turns(g.place.y, over.y), turns(g.place.z, over.z)};
    });
  }

  /// After charges or the order of grains have changed: what charges feel. `booked`: the change of energy is what an
  /// exchange gave to the field.
  void recharge(bool booked) {
    FieldBook* book = book_.data();
    const double* charge = charge_.data();
    const int n = n_;
    run_->for_each(1, [=] LICHTENBERG_HOST_DEVICE(int) { book->largest_charge = 0; });
    run_->sum_segments((n + a_part - 1) / a_part, [=] LICHTENBERG_HOST_DEVICE(int p) { return part(n, p); },
                       [=] LICHTENBERG_HOST_DEVICE(int p, int t) { return Most{std::abs(charge[p * a_part + t])}; },
                       [=] LICHTENBERG_HOST_DEVICE(int, Most most) {
                         parallel::enlarge_atomically(&book->largest_charge, most.value);
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

  /// Forces at the start of a step, and the pairs that may matter within it.
  template <class Law>
  void enter(const Law& law) {
    parameters_.send();
    const ContactSteps<Law> steps = contact_steps(law);
    const ForceView force = forces();
    Found* found = found_.device();
    Vec3* held = held_.data();
    const int n = n_;
    run_->for_each(n, [=] LICHTENBERG_HOST_DEVICE(int s) {
      held[s] = force(s);
      steps.grains.located[s].radius = static_cast<float>(steps.grains.radius[s]);
      steps.grains.touches[s] = 0;
      steps.locate(s, steps.grains.place[s]);
      if (s == 0) *found = {};
    });
    // Kernels that are recorded ask how many entries there are.
    run_->select(
        static_cast<long>(near_.size()), [=] LICHTENBERG_HOST_DEVICE() { return steps.contacts.table.end(n - 1); },
        &found->pairs, [=] LICHTENBERG_HOST_DEVICE(int e) { return steps.is_near(e); },
        [=] LICHTENBERG_HOST_DEVICE(int place, int e) { steps.list_near(place, e); });
  }

  void outer_step(int inner) {
    std::visit([&](const auto& law) { outer_step(law, inner); }, law_);
  }
  template <class Law>
  void outer_step(const Law& law, int inner) {
    enter(law);
    for (int step = 0; step < inner; ++step) step_contacts(law, step, step == inner - 1);
    look_at_contacts(law);
    if (sums_) sums_->evaluate(charges_.data(), partners_.view(), options_.exchanges);
    finish();
  }
  template <class Law>
  void step_contacts(const Law& law, int step, bool last) {
    const ContactSteps<Law> steps = contact_steps(law);
    const Found* found = found_.device();
    const int n = n_;
    // How many there are is known on the device alone.
    const int blocks = 2 * n / FindActive<Law>::a_block + 1;
    run_->template for_each_block<128>(blocks, FindActive<Law>::bytes, FindActive<Law>{steps, blocks});
    run_->template for_each<64>(n, [=] LICHTENBERG_HOST_DEVICE(int a) {
      for (; a < found->active; a += n) steps.push_halfway(a);
    });
    run_->template for_each<32>(n, [=] LICHTENBERG_HOST_DEVICE(int a) {
      for (; a < found->active; a += n) steps.integrate(a, step);
    });
    Vec3* place = place_.data();
    TurnsAround* image = image_.data();
    Charged* charges = charges_.data();
    const Box<3> box = box_;
    const Vec3 over{whole_turn / box_.lengths.x, whole_turn / box_.lengths.y, whole_turn / box_.lengths.z};
    run_->template for_each<128>(n, [=] LICHTENBERG_HOST_DEVICE(int s) {
      steps.move(s);
      if (!last) return;
      Vec3 p = place[s];
      Image<3> around{image[s].x, image[s].y, image[s].z};
      box.wrap(p, around);
      place[s] = p;
      image[s] = {around[0], around[1], around[2]};
      charges[s].at = {turns(p.x, over.x), turns(p.y, over.y), turns(p.z, over.z)};
    });
  }
  /// What the last step of contacts has left.
  template <class Law>
  void look_at_contacts(const Law& law) {
    const ContactSteps<Law> steps = contact_steps(law);
    Found* found = found_.device();
    const int warps = (n_ + a_warp - 1) / a_warp, round = warps * a_warp;
    run_->sum_segments(
        warps,
        [=] LICHTENBERG_HOST_DEVICE(int w) {
          const int left = found->pairs - w * a_warp;
          return left > 0 ? (left + round - 1) / round * a_warp : 0;
        },
        [=] LICHTENBERG_HOST_DEVICE(int w, int t) {
          const int k = t / a_warp * round + w * a_warp + t % a_warp;
          return k < found->pairs ? Most{steps.impact2(k)} : Most{};
        },
        [=] LICHTENBERG_HOST_DEVICE(int, Most most) { parallel::enlarge_atomically(&found->impact2, most.value); });
  }

  /// Momenta change as if forces of charges had changed linearly; charges move; and what the host wants to know before
  /// the next step.
  void finish() {
    const ForceView force = forces();
    const Vec3 *held = held_.data(), *place = place_.data();
    Vec3* momentum = momentum_.data();
    double* charge = charge_.data();
    const double *over_mass = over_mass_.data(), quantum = quanta_.charge;
    std::int64_t* moved = moved_charge_.data();
    const StepParameters* parameters = parameters_.device();
    FieldBook* book = book_.data();
    Found* found = found_.device();
    const Turns* sorted_at = sorted_at_.data();
    const Vec3 lengths = box_.lengths, over{whole_turn / lengths.x, whole_turn / lengths.y, whole_turn / lengths.z};
    const int n = n_;
    run_->sum_segments(
        (n + a_warp - 1) / a_warp,
        [=] LICHTENBERG_HOST_DEVICE(int w) { return n - w * a_warp < a_warp ? n - w * a_warp : a_warp; },
        [=] LICHTENBERG_HOST_DEVICE(int w, int t) {
          const int s = w * a_warp + t;
          const Vec3 now = force(s), at = place[s], p = momentum[s] + (0.5 * parameters->outer) * (now - held[s]);
          momentum[s] = p;
          if (s == 0) book->energy = force.energy();
          if (moved[s] != 0) charge[s] += quantum * static_cast<double>(moved[s]), moved[s] = 0;
          const Turns then = sorted_at[s];
          const Vec3 path{lichtenberg::apart(turns(at.x, over.x), then.x) / over.x,
                          lichtenberg::apart(turns(at.y, over.y), then.y) / over.y,
                          lichtenberg::apart(turns(at.z, over.z), then.z) / over.z};
          Largest here{
              .speed2 = norm2(over_mass[s] * p), .acceleration2 = norm2(over_mass[s] * now), .moved2 = norm2(path)};
          here.lost = !(here.speed2 < INFINITY) || !(norm2(at) < INFINITY);
          return here;
        },
        [=] LICHTENBERG_HOST_DEVICE(int, Largest most) {
          parallel::enlarge_atomically(&found->speed2, most.speed2);
          parallel::enlarge_atomically(&found->acceleration2, most.acceleration2);
          parallel::enlarge_atomically(&found->moved2, most.moved2);
          parallel::enlarge_atomically(&found->lost, most.lost);
        });
    found_.fetch();
  }

  double driven() const { return driven_before_ + static_cast<double>(driven_.download().front()) * quanta_.energy; }
  std::int64_t dissipated_quanta() const {
    const std::int64_t* quanta = dissipated_.data();
    total_.resize(1);
    total_.zero();
    std::int64_t* total = total_.data();
    const int n = n_;
    run_->sum_segments((n + a_part - 1) / a_part, [=] LICHTENBERG_HOST_DEVICE(int p) { return part(n, p); },
                       [=] LICHTENBERG_HOST_DEVICE(int p, int t) { return quanta[p * a_part + t]; },
                       [=] LICHTENBERG_HOST_DEVICE(int, std::int64_t sum) { parallel::add_atomically(total, sum); });
    return total_.download().front();
  }

  /// Room for what is known of entries and pairs.
  void resize_contacts() {
    const std::size_t entries = table_.entries();
    const auto resize = [&](auto&... arrays) { (arrays.resize(entries), ...); };
    resize(since_, impact_speed_, alone_, owner_, near_);
    resize(active_, seen_, scale_, active_force_, active_halfway_, active_first_);
    next_.resize(2 * entries);
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
    open_.resize(table_.entries());
    int* count = open_count_.data();
    OpenContact* open = open_.data();
    const double *since = since_.data(), *impact = impact_speed_.data();
    const int *alone = alone_.data(), *number = number_.data(), *owner = owner_.data();
    const long entries = static_cast<long>(table_.entries());
    run_->select(
        entries, [=] LICHTENBERG_HOST_DEVICE() { return static_cast<int>(entries); }, count,
        [=] LICHTENBERG_HOST_DEVICE(int e) { return since[e] >= 0; },
        [=] LICHTENBERG_HOST_DEVICE(int place, int e) {
          const int i = number[owner[e]], j = number[table.partner[e]];
          open[place] = {i < j ? i : j, i < j ? j : i, since[e], impact[e], alone[e]};
        });
    int all = 0;
    run_->to_host(&all, count, sizeof(int));
    open_.resize(all);
  }
  /// Puts the open contacts into the table.
  void take_open() {
    int* place_of = place_of_.data();
    const int* number = number_.data();
    run_->for_each(n_, [=] LICHTENBERG_HOST_DEVICE(int s) { place_of[number[s]] = s; });
    run_->fill(since_.data(), 0xff, since_.size() * sizeof(double));  // no numbers
    const TableView table = table_.view();
    double *since = since_.data(), *impact = impact_speed_.data();
    int* alone = alone_.data();
    const OpenContact* open = open_.data();
    run_->for_each(static_cast<long>(open_.size()), [=] LICHTENBERG_HOST_DEVICE(int k) {
      const int i = place_of[open[k].i], j = place_of[open[k].j], s = i < j ? i : j, other = i < j ? j : i;
      for (int e = table.begin(s); e < table.end(s); ++e)
        if (table.partner[e] == other)
          since[e] = open[k].since, impact[e] = open[k].impact_speed, alone[e] = open[k].alone;
    });
    loaded_ = true;
  }

 private:
  static constexpr int a_part = 256, a_warp = 32;
  static constexpr double least_travel = 0.1;  ///< lists for less are made no more seldom

  LICHTENBERG_HOST_DEVICE static int part(int n, int p) { return n - p * a_part < a_part ? n - p * a_part : a_part; }

  static Vec3 cell_edges(const GasOptions& options) {
    return options.tables ? periodic::device::cell_edges(*options.tables, 0.6) : Vec3{1, 1, 0.5};
  }
  static void upload_vectors(Array<Vec3>& array, const std::vector<double>& values) {
    std::vector<Vec3> vectors(values.size() / 3);
    for (std::size_t i = 0; i < vectors.size(); ++i) vectors[i] = {values[3 * i], values[3 * i + 1], values[3 * i + 2]};
    array.upload(vectors);
  }
  /// Throws Failure, with the number of grains that would fit, if the device has too little memory.
  void check_room() const {
    const auto room = static_cast<double>(run_->room());
    if (options_.bytes <= room) return;
    const auto in_words = [](double value, double unit) { return std::to_string(static_cast<long>(value / unit)); };
    throw Failure(options_.path + ": " + std::to_string(n_) + " grains take about " +
                  in_words(options_.bytes, 1 << 20) + " MiB of the CUDA device, of which " + in_words(room, 1 << 20) +
                  " are free: " + in_words(n_ * (room / options_.bytes), 1) + " of them would fit");
  }
  /// Multiples of the largest power that a contact could well have over 2^58, of momenta over 2^52: no sum of pairs is
  /// 2^5 times as large, or the law is not one of grains.
  void choose_quanta() {
    const double heaviest = *std::ranges::max_element(options_.mass);
    const double push = std::visit(
        [&](const auto& law) {
          const ContactParts most = law.parts(largest_radius_, law.scale(largest_radius_, largest_radius_));
          constexpr double fast = 100;  // a grain that is as fast flies through others
          return most.elastic + fast * most.damping;
        },
        law_);
    const auto power = [](double value) { return static_cast<int>(std::ceil(std::log2(value))); };
    quanta_.force = std::ldexp(1.0, power(push) - 58);
    quanta_.impulse = std::ldexp(1.0, power(heaviest) - 52);
    quanta_.shift = std::ldexp(1.0, power(heaviest) - 54);
  }
  /// Acceleration that a contact of two that meet at this speed does not exceed: even if nothing is lost, the overlap
  /// is less than half of the way that they would fly meanwhile.
  double hardest_push(double speed) const {
    if (!(speed > 0)) return 0;
    const double overlap = 0.5 * speed * shortest_contact(law_, speed);
    return std::visit(
               [&](const auto& law) {
                 const ContactParts most = law.parts(overlap, law.scale(largest_radius_, largest_radius_));
                 return most.elastic + most.damping * speed;
               },
               law_) /
           *std::ranges::min_element(options_.mass);
  }

  ForceView forces() const {
    if (!sums_) return {};
    return {charges_.data(), sums_->felt(), sums_->totals(), book_.data(), options_.strength, sums_->background()};
  }
  template <class Law>
  ContactSteps<Law> contact_steps(const Law& law) const {
    const GrainsView grains{.count = n_,
                            .place = place_.data(),
                            .momentum = momentum_.data(),
                            .over_mass = over_mass_.data(),
                            .radius = radius_.data(),
                            .number = number_.data(),
                            .located = located_.data(),
                            .held = held_.data(),
                            .force = force_.data(),
                            .halfway = halfway_.data(),
                            .impulse = impulse_.data(),
                            .shift = shift_.data(),
                            .busy = busy_.data(),
                            .touches = touches_.data(),
                            .begun = begun_.data(),
                            .collisions = collisions_.data(),
                            .moved_charge = moved_charge_.data(),
                            .dissipated = dissipated_.data()};
    const ContactsView contacts{.table = table_.view(),
                                .owner = owner_.data(),
                                .since = since_.data(),
                                .impact_speed = impact_speed_.data(),
                                .alone = alone_.data(),
                                .near = near_.data(),
                                .active = active_.data(),
                                .seen = seen_.data(),
                                .scale = scale_.data(),
                                .force = active_force_.data(),
                                .halfway = active_halfway_.data(),
                                .first = active_first_.data(),
                                .next = next_.data()};
    const auto turn = [&](int k) { return static_cast<float>(box_.lengths[k] / whole_turn); };
    return {.grains = grains,
            .contacts = contacts,
            .law = law,
            .nearest = NearestImage<3>(box_),
            .turn = {turn(0), turn(1), turn(2)},
            .parameters = parameters_.device(),
            .found = found_.device(),
            .extremes = extremes_.data(),
            .exchange = options_.exchange,
            .quanta = quanta_,
            .seed = options_.seed,
            .exchanges = options_.exchanges && !elastic_};
  }

  void read_found() {
    run_->wait();
    now_ = found_.host();
    collisions_counted_ += now_.begun;
    transfers_ += now_.transfers;
    if (const int passed = now_.passed; passed)
      throw Failure("grain " + std::to_string(passed - 1) +
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
    std::vector<const void*> arrays;
    std::size_t room = 0;
    int columns = 0, partner_columns = 0;
    double skin = 0;

    bool operator==(const Kernels&) const = default;
  };
  Kernels kernels() const {
    const TableView table = table_.view(), partners = partners_.view();
    return {{table.start, table.partner, partners.start, partners.partner, since_.data(), impact_speed_.data(),
             alone_.data(), owner_.data(), near_.data(), active_.data(), seen_.data(), scale_.data(),
             active_force_.data(), active_halfway_.data(), active_first_.data(), next_.data()},
            near_.capacity(),
            table.columns,
            partners.columns,
            skin_};
  }

  std::unique_ptr<Executor> run_;
  GasOptions options_;
  int n_;
  Box<3> box_;
  GrainContactLaw law_;
  bool elastic_ = false, loaded_ = false;
  double largest_radius_ = 0;
  Quanta quanta_;
  double skin_ = 0;  ///< of the lists: they hold while no grain has moved by half of it; 0: there are none

  CellGrid<Executor> cells_;
  NeighbourTable<Executor> table_, partners_;  ///< of those that may touch; whose charges are near
  std::optional<ChargeSums<Executor>> sums_;

  // Of each grain, as they are sorted.
  Array<Vec3> place_{*run_}, momentum_{*run_};
  Array<TurnsAround> image_{*run_};
  Array<double> charge_{*run_}, over_mass_{*run_}, radius_{*run_};
  Array<int> number_{*run_};
  Array<std::int64_t> collisions_{*run_}, moved_charge_{*run_}, dissipated_{*run_};
  Array<Located> located_{*run_};
  Array<Vec3> held_{*run_};
  Array<Charged> charges_{*run_};
  Array<Turns> sorted_at_{*run_};
  Array<WholeVec> force_{*run_}, halfway_{*run_}, impulse_{*run_}, shift_{*run_};
  Array<int> busy_{*run_}, touches_{*run_}, begun_{*run_}, place_of_{*run_};
  Array<Grain> spare_{*run_};

  // Of each entry of table_; as many of near and of active pairs have room.
  Array<double> since_{*run_}, impact_speed_{*run_};
  Array<int> alone_{*run_}, owner_{*run_}, next_{*run_};
  Array<NearPair> near_{*run_};
  Array<ActivePair> active_{*run_};
  Array<PairState<3>> seen_{*run_};
  Array<double> scale_{*run_};
  Array<Vec3> active_force_{*run_}, active_halfway_{*run_}, active_first_{*run_};

  mutable Array<OpenContact> open_{*run_};
  mutable Array<int> open_count_{*run_};
  mutable Array<std::int64_t> total_{*run_};
  parallel::Mirrored<Found, Executor> found_{*run_};
  parallel::Mirrored<StepParameters, Executor> parameters_{*run_};
  Array<Extremes> extremes_{*run_};
  Array<std::int64_t> driven_{*run_};  ///< quanta of energy, since the gas was loaded
  Array<FieldBook> book_{*run_};
  std::map<int, typename Executor::Recording> graphs_;  ///< of an outer step, by its steps of contacts
  typename Executor::Recording recharge_;
  Kernels recorded_;

  Found now_;
  StepCounts counts_;
  double time_ = 0;
  std::int64_t steps_ = 0, contact_steps_ = 0, collisions_counted_ = 0, transfers_ = 0, evaluations_ = 0;
  double driven_before_ = 0;
  std::int64_t dissipated_before_ = 0;  ///< quanta, when the gas was loaded
};

}  // namespace lichtenberg::granular::device
