#include "src/statics/potential_energy.hpp"

#include <algorithm>
#include <cmath>

#include "src/effects/contact_law.hpp"

namespace lichtenberg::statics {
namespace {

constexpr int rows_a_task = 4096;
constexpr std::size_t pairs_a_task = 8192;

/// Of a symmetric matrix of `dimension` rows.
template <int dimension>
constexpr int triangle = dimension*(dimension + 1) / 2;

/// y += block * v
template <int dimension>
void multiply_add(const double* block, const double* v, double* y) {
  if constexpr (dimension == 2) {
    y[0] += block[0] * v[0] + block[1] * v[1];
    y[1] += block[1] * v[0] + block[2] * v[1];
  } else {
    y[0] += block[0] * v[0] + block[1] * v[1] + block[2] * v[2];
    y[1] += block[1] * v[0] + block[3] * v[1] + block[4] * v[2];
    y[2] += block[2] * v[0] + block[4] * v[1] + block[5] * v[2];
  }
}

/// along * n n' + across * (1 - n n')
template <int dimension>
std::array<double, triangle<dimension>> central(const std::array<double, 3>& n, double along, double across) {
  std::array<double, triangle<dimension>> block;
  int e = 0;
  for (int k = 0; k < dimension; ++k)
    for (int l = k; l < dimension; ++l) block[e++] = (along - across) * n[k] * n[l] + (k == l) * across;
  return block;
}

template <int dimension>
std::array<double, triangle<dimension>> inverse(const double* a) {
  if constexpr (dimension == 2) {
    const double det = a[0] * a[2] - a[1] * a[1];
    return {a[2] / det, -a[1] / det, a[0] / det};
  } else {
    const double c0 = a[3] * a[5] - a[4] * a[4], c1 = a[2] * a[4] - a[1] * a[5], c2 = a[1] * a[4] - a[2] * a[3];
    const double det = a[0] * c0 + a[1] * c1 + a[2] * c2;
    return {c0 / det,
            c1 / det,
            c2 / det,
            (a[0] * a[5] - a[2] * a[2]) / det,
            (a[1] * a[2] - a[0] * a[4]) / det,
            (a[0] * a[3] - a[1] * a[1]) / det};
  }
}

}  // namespace

PotentialEnergy::PotentialEnergy(Model model, int threads)
    : model_(std::move(model)), potential_(*model_.find<effects::ContactPotential>()), team_(threads) {}

State PotentialEnergy::move_to(std::span<const double> x) {
  model_.bodies.position.assign(x.begin(), x.end());
  model_.neighbours->update(model_.bodies);
  return {0, model_.bodies, model_.neighbours->pairs()};
}

/// Threads find the pushes, which is most of the work; they are added in the order of the pairs, whoever found them.
double PotentialEnergy::evaluate(std::span<const double> x, std::span<double> gradient) {
  const State state = move_to(x);
  const int d = model_.bodies.dimension;
  const std::size_t tasks = (state.neighbours.size() + pairs_a_task - 1) / pairs_a_task;
  pushes_.resize(std::max(pushes_.size(), tasks));
  std::vector<double> energies(tasks);
  team_.for_each(static_cast<int>(tasks), [&](int task) {
    const std::size_t first = pairs_a_task * task, count = std::min(pairs_a_task, state.neighbours.size() - first);
    pushes_[task].clear();
    energies[task] =
        potential_.pair_pushes({state.time, state.bodies, state.neighbours.subspan(first, count)}, pushes_[task]);
  });
  std::ranges::fill(gradient, 0.0);
  double energy = potential_.wall_energy_and_forces(state, gradient);
  for (double& g : gradient) g = -g;
  for (std::size_t task = 0; task < tasks; ++task) {
    energy += energies[task];
    for (const effects::Push& push : pushes_[task])
      for (int k = 0; k < d; ++k) {
        gradient[push.particle * d + k] -= push.force[k];
        gradient[push.partner * d + k] += push.force[k];
      }
  }
  return energy;
}

void PotentialEnergy::linearize(std::span<const double> x) {
  const std::vector<effects::Overlap> overlaps = potential_.overlaps(move_to(x));
  if (model_.bodies.dimension == 3)
    build_rows<3>(overlaps);
  else
    build_rows<2>(overlaps);
}

template <int dimension>
void PotentialEnergy::build_rows(const std::vector<effects::Overlap>& overlaps) {
  constexpr int t = triangle<dimension>;
  const int n = model_.bodies.size();
  const double k = potential_.stiffness();
  row_start_.assign(n + 1, 0);
  for (const effects::Overlap& o : overlaps)
    if (o.partner < n) ++row_start_[o.particle + 1], ++row_start_[o.partner + 1];
  for (int i = 0; i < n; ++i) row_start_[i + 1] += row_start_[i];
  column_.resize(row_start_[n]);
  block_.resize(static_cast<std::size_t>(t) * row_start_[n]);
  diagonal_.assign(static_cast<std::size_t>(t) * n, 0);
  std::vector<double> positive(static_cast<std::size_t>(t) * n, 0);
  std::vector<int> next(row_start_.begin(), row_start_.end() - 1);
  const auto put = [&](int i, int j, const std::array<double, t>& b) {
    column_[next[i]] = j;
    for (int e = 0; e < t; ++e) block_[static_cast<std::size_t>(t) * next[i] + e] = -b[e];
    ++next[i];
  };
  const auto add = [&](int i, const std::array<double, t>& b, const std::array<double, t>& p) {
    for (int e = 0; e < t; ++e) diagonal_[t * i + e] += b[e], positive[t * i + e] += p[e];
  };
  for (const effects::Overlap& o : overlaps) {
    const effects::ContactLaw w = effects::contact_law(o.q);
    const double along = k * w.curvature / (o.reach * o.reach);
    const double across = o.partner < n ? k * w.slope / (o.reach * o.distance) : 0;
    const auto b = central<dimension>(o.normal, along, across), p = central<dimension>(o.normal, along, 0);
    add(o.particle, b, p);
    if (o.partner >= n) continue;
    add(o.partner, b, p);
    put(o.particle, o.partner, b);
    put(o.partner, o.particle, b);
  }
  // What holds a particle in one direction only, or in none, is made up for.
  inverse_.resize(diagonal_.size());
  const double diameter = 2 * model_.bodies.radius[0];
  for (int i = 0; i < n; ++i) {
    double* p = &positive[t * i];
    const double trace = dimension == 2 ? p[0] + p[2] : p[0] + p[3] + p[5];
    const double least = 0.05 * trace + 1e-3 * k / (diameter * diameter);
    p[0] += least, p[dimension] += least;
    if (dimension == 3) p[5] += least;
    std::ranges::copy(inverse<dimension>(p), &inverse_[t * i]);
  }
}

void PotentialEnergy::multiply(std::span<const double> v, std::span<double> product) const {
  const auto rows = [&]<int d>(std::integral_constant<int, d>) {
    constexpr int t = triangle<d>;
    const int n = model_.bodies.size();
    team_.for_each((n + rows_a_task - 1) / rows_a_task, [&](int task) {
      for (int i = task * rows_a_task; i < std::min(n, (task + 1) * rows_a_task); ++i) {
        double y[d] = {};
        multiply_add<d>(&diagonal_[t * i], &v[d * i], y);
        for (int e = row_start_[i]; e < row_start_[i + 1]; ++e)
          multiply_add<d>(&block_[static_cast<std::size_t>(t) * e], &v[d * column_[e]], y);
        for (int k = 0; k < d; ++k) product[d * i + k] = y[k];
      }
    });
  };
  if (model_.bodies.dimension == 3)
    rows(std::integral_constant<int, 3>{});
  else
    rows(std::integral_constant<int, 2>{});
}

void PotentialEnergy::precondition(std::span<const double> r, std::span<double> z) const {
  const auto rows = [&]<int d>(std::integral_constant<int, d>) {
    std::ranges::fill(z, 0.0);
    for (int i = 0; i < model_.bodies.size(); ++i) multiply_add<d>(&inverse_[triangle<d> * i], &r[d * i], &z[d * i]);
  };
  if (model_.bodies.dimension == 3)
    rows(std::integral_constant<int, 3>{});
  else
    rows(std::integral_constant<int, 2>{});
}

}  // namespace lichtenberg::statics
