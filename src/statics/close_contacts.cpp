#include "src/statics/close_contacts.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "solvers/larger.hpp"
#include "src/effects/contact_law.hpp"
#include "src/model/neighbours.hpp"

namespace lichtenberg::statics {
namespace {

constexpr int particles_a_task = 2048;

template <int d>
double squared_distance(const double* a, const double* b) {
  double sum = 0;
  for (int k = 0; k < d; ++k) sum += (a[k] - b[k]) * (a[k] - b[k]);
  return sum;
}

template <int d>
double distance_from(const Wall& wall, const double* position) {
  double distance = 0;
  for (int k = 0; k < d; ++k) distance += (position[k] - wall.point[k]) * wall.normal[k];
  return distance;
}

/// Two components as one vector, which may start at any element of an array.
using Two [[gnu::vector_size(16), gnu::aligned(8), gnu::may_alias]] = double;

/// Computes difference = a - b.
template <int d>
void subtract(const double* a, const double* b, double* difference) {
  if constexpr (d == 2)
    *reinterpret_cast<Two*>(difference) = *reinterpret_cast<const Two*>(a) - *reinterpret_cast<const Two*>(b);
  else
    for (int k = 0; k < d; ++k) difference[k] = a[k] - b[k];
}

/// Computes difference = a - b of nearest images.
template <int d>
void subtract(const double* a, const double* b, const NearestImage<d>& nearest, double* difference) {
  for (int k = 0; k < d; ++k) difference[k] = nearest(a[k] - b[k], k);
}

/// Returns the part of the box of a scene in d dimensions.
template <int d>
Box<d> box_of(const Bodies& bodies) {
  Box<d> box;
  for (int k = 0; k < d; ++k) box.lengths[k] = bodies.box.lengths[k];
  std::copy_n(bodies.box.sides.begin(), 2 * d, box.sides.begin());
  return box;
}

/// Computes y += factor * x.
template <int d>
void add(double* y, double factor, const double* x) {
  if constexpr (d == 2)
    *reinterpret_cast<Two*>(y) += factor * *reinterpret_cast<const Two*>(x);
  else
    for (int k = 0; k < d; ++k) y[k] += factor * x[k];
}

/// A batch of candidates, for which a vectorized loop computes the law. q is the distance over the sum of radii (1
/// without overlap, where energy and slope are zero).
template <int d>
struct Batch {
  static constexpr int most = 256;
  std::array<std::array<double, d>, most> separation;  // m, from j to i
  std::array<double, most> squared;                    // m^2, distance
  std::array<double, most> q, energy;                  // energy in units of the stiffness
  std::array<double, most> factor;                     // 1/m^2; the gradient is stiffness * factor * apart

  template <bool periodic>
  void measure(const int* i, const int* j, int count, const double* x, const NearestImage<d>& nearest) {
    for (int c = 0; c < count; ++c) {
      if constexpr (periodic)
        subtract<d>(&x[d * i[c]], &x[d * j[c]], nearest, separation[c].data());
      else
        subtract<d>(&x[d * i[c]], &x[d * j[c]], separation[c].data());
      squared[c] = 0;
      for (int k = 0; k < d; ++k) squared[c] += separation[c][k] * separation[c][k];
    }
  }

  void apply(effects::RepulsionForm form, const double* per_reach, int count) {
    if (form == effects::RepulsionForm::harmonic)
      apply_form<effects::RepulsionForm::harmonic>(per_reach, count);
    else if (form == effects::RepulsionForm::hertzian)
      apply_form<effects::RepulsionForm::hertzian>(per_reach, count);
    else
      apply_logarithmic(per_reach, count);
  }

  template <effects::RepulsionForm form>
  void apply_form(const double* per_reach, int count) {
    for (int c = 0; c < count; ++c) {
      const double ratio = std::sqrt(squared[c]) * per_reach[c];
      q[c] = ratio > 1 ? 1 : ratio;
      const effects::ContactLaw law = effects::contact_law(form, q[c]);
      energy[c] = q[c] > 0 ? law.energy : INFINITY;  // without a direction of the force
      factor[c] = law.slope / q[c] * per_reach[c] * per_reach[c];
    }
  }

  /// Evaluates the logarithmic form with one division: 1/q and 1/(q + 1) follow from 1/(q (q + 1)).
  void apply_logarithmic(const double* per_reach, int count) {
    int deep = 0;
    for (int c = 0; c < count; ++c) {
      const double ratio = std::sqrt(squared[c]) * per_reach[c];
      q[c] = ratio > 1 ? 1 : ratio;
      const double excess = q[c] - 1, inverse = 1 / (q[c] * (q[c] + 1)), per_q = (q[c] + 1) * inverse;
      const double logarithm = effects::logarithm_of_ratio(excess * q[c] * inverse);
      energy[c] = excess * logarithm;
      factor[c] = (logarithm + excess * per_q) * per_q * per_reach[c] * per_reach[c];
      deep |= !(q[c] >= effects::near_one);
    }
    for (int c = 0; deep && c < count; ++c) {
      if (q[c] >= effects::near_one) continue;
      const effects::ContactLaw law = effects::contact_law(q[c]);
      energy[c] = law.energy;
      factor[c] = law.slope / q[c] * per_reach[c] * per_reach[c];
    }
  }
};

}  // namespace

CloseContacts::CloseContacts(const effects::SoftRepulsion& potential, const Bodies& bodies, parallel::Team& team)
    : potential_(potential),
      bodies_(bodies),
      team_(team),
      skin_(0.8 * *std::ranges::max_element(bodies.radius)),
      wanted_margin_(0.25 * skin_),
      ranges_((bodies.size() + particles_a_task - 1) / particles_a_task) {}

template <class Task>
void CloseContacts::for_each_range(const Task& task) {
  const int n = bodies_.size();
  team_.for_each(static_cast<int>(ranges_.size()),
                 [&](int k) { task(ranges_[k], k * particles_a_task, std::min(n, (k + 1) * particles_a_task)); });
}

template <class F>
decltype(auto) CloseContacts::in_kind_of_box(const F& f) const {
  const auto in_space_of = [&](auto dimension) {
    return bodies_.box.any_periodic() ? f(dimension, std::true_type{}) : f(dimension, std::false_type{});
  };
  return bodies_.dimension == 3 ? in_space_of(std::integral_constant<int, 3>{})
                                : in_space_of(std::integral_constant<int, 2>{});
}

double CloseContacts::evaluate(std::span<const double> x, std::span<double> gradient) {
  return in_kind_of_box([&]<int d, bool periodic>(std::integral_constant<int, d>, std::bool_constant<periodic>) {
    return evaluate<d, periodic>(x, gradient);
  });
}

/// Evaluates all ranges of particles. Each range checks if its candidates still include all contacts. If one check
/// fails, all candidates are collected again.
template <int d, bool periodic>
double CloseContacts::evaluate(std::span<const double> x, std::span<double> gradient) {
  if (collection_positions_.empty()) update<d, periodic>(x);
  const auto evaluate_all = [&] {
    for_each_range(
        [&](Range& range, int first, int end) { evaluate_range<d, periodic>(range, first, end, x, gradient); });
  };
  evaluate_all();
  if (!std::ranges::all_of(ranges_, &Range::valid)) {
    update<d, periodic>(x);
    evaluate_all();
  }
  ++uses_;
  double energy = 0;
  for (const Range& range : ranges_) {
    energy += range.energy;
    for (const ParticleForce& one : range.outside_forces)
      for (int k = 0; k < d; ++k) gradient[one.particle * d + k] += one.force[k];
  }
  return potential_.stiffness() * energy;
}

template <int d, bool periodic>
void CloseContacts::evaluate_range(Range& range, int first, int end, std::span<const double> x,
                                   std::span<double> gradient) const {
  range.valid = is_valid_for<d>(first, end, x);
  if (!range.valid) return;
  std::ranges::fill(gradient.subspan(d * first, d * (end - first)), 0.0);
  range.outside_forces.clear();
  range.energy = 0;
  if (add_walls<d>(range, x, gradient))
    add_pairs<d, periodic>(range, end, x, gradient);
  else
    range.energy = INFINITY;
}

/// Returns true if no particle of the range has moved by more than half of the margin since the candidates were
/// collected.
template <int d>
bool CloseContacts::is_valid_for(int first, int end, std::span<const double> x) const {
  const double most = 0.25 * margin_ * margin_;
  int left = 0;  // no branch, so that the loop is vectorized
  for (int i = first; i < end; ++i) left |= squared_distance<d>(&x[d * i], &collection_positions_[d * i]) > most;
  return !left;
}

template <int d>
bool CloseContacts::add_walls(Range& range, std::span<const double> x, std::span<double> gradient) const {
  for (const auto [i, w] : range.walls) {
    const Wall& wall = potential_.walls()[w];
    const double distance = distance_from<d>(wall, &x[d * i]), reach = bodies_.radius[i];
    if (!(distance < reach)) continue;
    if (distance <= 0) return false;
    const effects::ContactLaw law = potential_.contact(distance / reach);
    range.energy += law.energy;
    for (int k = 0; k < d; ++k) gradient[d * i + k] += potential_.stiffness() * law.slope / reach * wall.normal[k];
  }
  return true;
}

/// Sums in the order of the candidates. Candidates without overlap add zero, so a sum does not depend on their number.
template <int d, bool periodic>
void CloseContacts::add_pairs(Range& range, int end, std::span<const double> x, std::span<double> gradient) const {
  Batch<d> batch;
  const NearestImage<d> nearest(box_of<d>(bodies_));
  const int all = static_cast<int>(range.i.size());
  const double stiffness = potential_.stiffness();
  double energy = range.energy, *sum = gradient.data();
  for (int from = 0; from < all; from += batch.most) {
    const int count = std::min(batch.most, all - from), *i = &range.i[from], *j = &range.j[from];
    batch.template measure<periodic>(i, j, count, x.data(), nearest);
    batch.apply(potential_.form(), &range.per_reach[from], count);
    for (int c = 0; c < count; ++c) {
      energy += batch.energy[c];
      const double factor = stiffness * batch.factor[c];
      const double* separation = batch.separation[c].data();
      add<d>(&sum[d * i[c]], factor, separation);
      if (j[c] < end)
        add<d>(&sum[d * j[c]], -factor, separation);
      else if (factor != 0)
        add<d>(range.outside_forces.emplace_back(j[c]).force.data(), -factor, separation);
    }
  }
  range.energy = energy;
}

std::span<const Pair> CloseContacts::pairs(std::span<const double> x) {
  in_kind_of_box([&]<int d, bool periodic>(std::integral_constant<int, d>, std::bool_constant<periodic>) {
    if (collection_positions_.empty() || !is_valid_for<d>(0, bodies_.size(), x)) update<d, periodic>(x);
  });
  return pairs_;
}

/// Collects the candidates within a margin at x. The margin is wider if the candidates became invalid soon. It is
/// limited such that the last neighbour search contains all pairs within it.
template <int d, bool periodic>
void CloseContacts::update(std::span<const double> x) {
  constexpr int few = 4, many = 16;
  if (uses_ < few) wanted_margin_ = std::min(2 * wanted_margin_, skin_);
  if (uses_ > many) wanted_margin_ = std::max(0.5 * wanted_margin_, 1e-3 * skin_);
  margin_ = search_positions_.empty() ? 0 : skin_ - 2 * largest_move<d>(x);
  if (!(margin_ >= 0.25 * wanted_margin_)) {
    pairs_ = pairs_closer_than(Spheres<d>{x, bodies_.radius, box_of<d>(bodies_)}, skin_, team_);
    search_positions_.assign(x.begin(), x.end());
    margin_ = skin_;
  }
  margin_ = std::min(margin_, wanted_margin_);
  for_each_range([&](Range& range, int first, int end) { collect<d, periodic>(range, first, end, x); });
  collection_positions_.assign(x.begin(), x.end());
  uses_ = 0;
}

/// Returns the largest displacement (m) of a particle since the last neighbour search.
template <int d>
double CloseContacts::largest_move(std::span<const double> x) const {
  double most = 0;
  for (int i = 0; i < bodies_.size(); ++i)
    most = larger(most, squared_distance<d>(&x[d * i], &search_positions_[d * i]));
  return std::sqrt(most);
}

template <int d, bool periodic>
void CloseContacts::collect(Range& range, int first, int end, std::span<const double> x) const {
  const std::span pairs = pairs_of(pairs_, {first, end});
  [[maybe_unused]] const NearestImage<d> nearest(box_of<d>(bodies_));
  range.i.resize(pairs.size()), range.j.resize(pairs.size()), range.per_reach.resize(pairs.size());
  std::size_t count = 0;
  for (const auto [i, j] : pairs) {  // no branch, because close pairs are hard to predict
    const double reach = bodies_.radius[i] + bodies_.radius[j], within = reach + margin_;
    range.i[count] = i, range.j[count] = j, range.per_reach[count] = 1 / reach;
    if constexpr (periodic) {
      double separation[d], squared = 0;
      subtract<d>(&x[d * i], &x[d * j], nearest, separation);
      for (int k = 0; k < d; ++k) squared += separation[k] * separation[k];
      count += squared < within * within;
    } else {
      count += squared_distance<d>(&x[d * i], &x[d * j]) < within * within;
    }
  }
  range.i.resize(count), range.j.resize(count), range.per_reach.resize(count);
  range.walls.clear();
  for (std::size_t w = 0; w < potential_.walls().size(); ++w)
    for (int i = first; i < end; ++i)
      if (distance_from<d>(potential_.walls()[w], &x[d * i]) < bodies_.radius[i] + margin_)
        range.walls.push_back({i, static_cast<int>(w)});
}

}  // namespace lichtenberg::statics
