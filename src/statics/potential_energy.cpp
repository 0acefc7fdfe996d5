#include "src/statics/potential_energy.hpp"

#include <algorithm>
#include <numeric>

#include "src/effects/contact_law.hpp"
#include "src/effects/effects.hpp"

namespace lichtenberg::statics {
namespace {

constexpr int particles_a_task = 2048;

/// Number of elements in a triangle of a symmetric matrix of `dimension` rows.
template <int dimension>
constexpr int triangle = dimension*(dimension + 1) / 2;

/// Computes y += block * v for a symmetric block.
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

/// Returns the matrix along * n n' + across * (1 - n n') of a central force with the unit vector n.
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

PotentialEnergy::PotentialEnergy(const Scene& scene, int threads)
    : PotentialEnergy(scene, std::make_unique<effects::SoftRepulsion>(scene), threads) {}
PotentialEnergy::PotentialEnergy(const Scene& scene, std::unique_ptr<effects::SoftRepulsion> potential, int threads)
    : potential_(*potential),
      model_(effects::make_model(scene, effects::made(std::move(potential)))),
      team_(threads),
      contacts_(potential_, model_.bodies, team_) {
  for (const std::unique_ptr<Effect>& effect : model_.effects) {
    if (effect.get() == &potential_) continue;  // the only other effect is gravity, whose forces are constant
    weight_.resize(model_.bodies.position.size());
    effect->add_forces({0, model_.bodies}, weight_);
  }
}

int PotentialEnergy::ranges() const { return (model_.bodies.size() + particles_a_task - 1) / particles_a_task; }

template <class Task>
void PotentialEnergy::for_each_range(const Task& task) const {
  const int n = model_.bodies.size();
  team_.for_each(ranges(), [&](int k) { task(k, k * particles_a_task, std::min(n, (k + 1) * particles_a_task)); });
}

State PotentialEnergy::move_to(std::span<const double> x) {
  std::ranges::copy(x, model_.bodies.position.begin());
  return {0, model_.bodies, contacts_.pairs(x)};
}

double PotentialEnergy::evaluate(std::span<const double> x, std::span<double> gradient) {
  double energy = contacts_.evaluate(x, gradient);
  for (std::size_t k = 0; k < weight_.size(); ++k) {
    energy -= weight_[k] * x[k];
    gradient[k] -= weight_[k];
  }
  return energy;
}

void PotentialEnergy::linearize(std::span<const double> x) {
  const State state = move_to(x);
  if (model_.bodies.dimension == 3)
    build_rows<3>(state);
  else
    build_rows<2>(state);
}

/// Computes the rows. Each task has a range of particles. Its contributions to the diagonal blocks of other particles
/// are added afterwards, in the order of the tasks. The sums are therefore the same for any number of threads.
template <int dimension>
void PotentialEnergy::build_rows(const State& state) {
  constexpr int t = triangle<dimension>;
  using Block = std::array<double, t>;
  struct LaterBlock {
    int particle = 0;
    Block block{}, positive{};
  };
  const int n = model_.bodies.size();
  const double k = potential_.stiffness();
  diagonal_.resize(static_cast<std::size_t>(t) * n);
  inverse_.resize(diagonal_.size());
  rows_.resize(ranges());
  std::vector<std::vector<LaterBlock>> later_blocks(ranges());
  const auto add = [&](int i, const Block& b, const Block& p) {
    for (int e = 0; e < t; ++e) diagonal_[t * i + e] += b[e], inverse_[t * i + e] += p[e];
  };
  for_each_range([&](int task, int first, int end) {
    std::fill(&diagonal_[t * first], diagonal_.data() + t * end, 0.0);
    std::fill(&inverse_[t * first], inverse_.data() + t * end, 0.0);
    Rows& rows = rows_[task];
    rows.start.assign(end - first + 1, 0);
    rows.column.clear(), rows.block.clear();
    for (const effects::Overlap& o : potential_.overlaps(state, first, end)) {
      const effects::ContactLaw w = potential_.contact(o.q);
      const double along = k * w.curvature / (o.reach * o.reach);
      const double across = o.partner < n ? k * w.slope / (o.reach * o.distance) : 0;
      const Block b = central<dimension>(o.normal, along, across), p = central<dimension>(o.normal, along, 0);
      add(o.particle, b, p);
      if (o.partner >= n) continue;
      if (o.partner < end)
        add(o.partner, b, p);
      else
        later_blocks[task].push_back({o.partner, b, p});
      ++rows.start[o.particle - first + 1];
      rows.column.push_back(o.partner);
      rows.block.insert(rows.block.end(), b.begin(), b.end());
    }
    std::partial_sum(rows.start.begin(), rows.start.end(), rows.start.begin());
  });
  for (const auto& range : later_blocks)
    for (const LaterBlock& b : range) add(b.particle, b.block, b.positive);
  for_each_range([&](int, int first, int end) {
    for (int i = first; i < end; ++i) invert<dimension>(&inverse_[t * i]);
  });
}

/// Inverts a diagonal block. Regularizes blocks that are singular because contacts fix a particle in one direction or
/// in none.
template <int dimension>
void PotentialEnergy::invert(double* positive) const {
  const double diameter = 2 * model_.bodies.radius[0];
  const double trace = dimension == 2 ? positive[0] + positive[2] : positive[0] + positive[3] + positive[5];
  const double least = 0.05 * trace + 1e-3 * potential_.stiffness() / (diameter * diameter);
  positive[0] += least, positive[dimension] += least;
  if (dimension == 3) positive[5] += least;
  std::ranges::copy(inverse<dimension>(positive), positive);
}

/// Multiplies rows, with the same division into tasks as `build_rows`. The upper half of the symmetric matrix is
/// sufficient and halves the memory traffic.
template <int d>
void PotentialEnergy::multiply_rows(std::span<const double> v, std::span<double> product) const {
  constexpr int t = triangle<d>;
  outside_forces_.resize(ranges());
  for_each_range([&](int task, int first, int end) {
    const Rows& rows = rows_[task];
    outside_forces_[task].clear();
    for (int i = first; i < end; ++i) {
      std::fill_n(&product[d * i], d, 0.0);
      multiply_add<d>(&diagonal_[t * i], &v[d * i], &product[d * i]);
    }
    for (int i = first; i < end; ++i) {
      double y[d] = {};
      for (int e = rows.start[i - first]; e < rows.start[i - first + 1]; ++e) {
        const double* block = &rows.block[static_cast<std::size_t>(t) * e];
        const int j = rows.column[e];
        double z[d] = {};
        multiply_add<d>(block, &v[d * j], y);
        multiply_add<d>(block, &v[d * i], z);
        if (j < end)
          for (int k = 0; k < d; ++k) product[d * j + k] -= z[k];
        else
          std::ranges::copy(z, outside_forces_[task].emplace_back(j).force.begin());
      }
      for (int k = 0; k < d; ++k) product[d * i + k] -= y[k];
    }
  });
  for (const auto& range : outside_forces_)
    for (const ParticleForce& one : range)
      for (int k = 0; k < d; ++k) product[d * one.particle + k] -= one.force[k];
}

void PotentialEnergy::multiply(std::span<const double> v, std::span<double> product) const {
  if (model_.bodies.dimension == 3)
    multiply_rows<3>(v, product);
  else
    multiply_rows<2>(v, product);
}

void PotentialEnergy::precondition(std::span<const double> r, std::span<double> z) const {
  const auto rows = [&]<int d>(std::integral_constant<int, d>) {
    for_each_range([&](int, int first, int end) {
      std::ranges::fill(z.subspan(d * first, d * (end - first)), 0.0);
      for (int i = first; i < end; ++i) multiply_add<d>(&inverse_[triangle<d> * i], &r[d * i], &z[d * i]);
    });
  };
  if (model_.bodies.dimension == 3)
    rows(std::integral_constant<int, 3>{});
  else
    rows(std::integral_constant<int, 2>{});
}

}  // namespace lichtenberg::statics
