#include "solvers/laplace/spheres/near_field.hpp"

#include <algorithm>
#include <cmath>
#include <mutex>
#include <numeric>
#include <tuple>

namespace lichtenberg::laplace::spheres {

std::vector<int> starts(const std::vector<Site>& sites) {
  std::vector<int> start = {0};
  for (const Site& site : sites) start.push_back(start.back() + harmonics(site.degree));
  return start;
}

std::shared_ptr<const Translation> translation_up_to(int degree) {
  static std::mutex mutex;
  static std::shared_ptr<const Translation> kept;
  const std::lock_guard lock(mutex);
  if (!kept || kept->degree() < degree) kept = std::make_shared<const Translation>(degree);
  return kept;
}

namespace {

constexpr int targets_a_chunk = 32;

/// Degrees of a pair: beyond them (reach / distance)^l is below the accuracy. The same for both directions, so that the
/// matrix stays symmetric.
int degree_at_distance(double reach, double distance, double accuracy) {
  if (reach >= distance) return 1 << 20;
  const double terms = std::log(accuracy) / std::log(reach / distance);
  return terms > 1e6 ? 1 << 20 : std::max(1, static_cast<int>(std::ceil(terms)));
}

}  // namespace

NearField::NearField(const std::vector<Site>& targets, const std::vector<Site>& sources, std::vector<NearPair> pairs,
                     double accuracy)
    : target_start_(starts(targets)), source_start_(starts(sources)) {
  struct Ordered {
    int chunk, source_degree, target_degree, number;
  };
  std::vector<Ordered> order(pairs.size());
  for (std::size_t p = 0; p < pairs.size(); ++p) {
    const Site &target = targets[pairs[p].target], &source = sources[pairs[p].source];
    const double d = norm(pairs[p].way);
    const int source_most = degree_at_distance(source.radius, d - target.radius, accuracy);
    const int target_most = degree_at_distance(target.radius, d - source.radius, accuracy);
    order[p] = {pairs[p].target / targets_a_chunk, std::min(source.degree, source_most),
                std::min(target.degree, target_most), static_cast<int>(p)};
    largest_degree_ = std::max({largest_degree_, order[p].source_degree, order[p].target_degree});
  }
  std::sort(order.begin(), order.end(), [](const Ordered& a, const Ordered& b) {
    return std::tie(a.chunk, a.source_degree, a.target_degree, a.number) <
           std::tie(b.chunk, b.source_degree, b.target_degree, b.number);
  });
  int filled = lanes, chunk = -1;
  for (const Ordered& o : order) {
    for (; chunk < o.chunk; ++chunk) {
      chunk_.push_back(static_cast<int>(batches_.size()));
      filled = lanes;
    }
    if (filled == lanes || batches_.back().source_degree != o.source_degree ||
        batches_.back().target_degree != o.target_degree) {
      batches_.push_back({o.source_degree, o.target_degree});
      for (int k = 0; k < lanes; ++k) batches_.back().ways.set(k, {0, 0, 1});
      filled = 0;
    }
    const NearPair& pair = pairs[o.number];
    const Site &target = targets[pair.target], &source = sources[pair.source];
    const double d = norm(pair.way);
    batches_.back().ways.set(filled, pair.way);
    batches_.back().lane[filled++] = {
        pair.target,          pair.source, pair.mask, 2 * source.radius / d, pair.sign * source.radius / d,
        2 * target.radius / d};
  }
  chunk_.push_back(static_cast<int>(batches_.size()));
  translation_ = translation_up_to(largest_degree_);
  for (int mask = 0; mask < 8; ++mask)
    for (int l = 0; l <= largest_degree_; ++l)
      for (int m = -l; m <= l; ++m) signs_.push_back(mirror_sign(l, m, mask));
}

void NearField::add_batch(const Batch& batch, const double* multipoles, double* local, Lanes* value,
                          Lanes* scratch) const {
  for (int k = 0; k < lanes; ++k) {
    const Lane& lane = batch.lane[k];
    const double* from = multipoles + source_start_[lane.source];
    const double* signs = signs_.data() + static_cast<std::ptrdiff_t>(lane.mask) * harmonics(largest_degree_);
    double factor = lane.target < 0 ? 0 : lane.sign;
    for (int l = 0; l <= batch.source_degree; ++l, factor *= lane.source_factor)
      for (int h = at(l, -l); h <= at(l, l); ++h) value[h][k] = factor * from[h] * signs[h];
  }
  translation_->apply(batch.ways, batch.source_degree, batch.target_degree, value, scratch);
  for (int k = 0; k < lanes; ++k) {
    const Lane& lane = batch.lane[k];
    if (lane.target < 0) continue;
    double* to = local + target_start_[lane.target];
    double factor = 1;
    for (int l = 0; l <= batch.target_degree; ++l, factor *= lane.target_factor)
      for (int h = at(l, -l); h <= at(l, l); ++h) to[h] += factor * value[h][k];
  }
}

void NearField::add(const double* multipoles, double* local, parallel::Team& team) const {
  team.for_each(static_cast<int>(chunk_.size()) - 1, [&](int c) {
    std::vector<Lanes> value(harmonics(largest_degree_)), scratch(value.size());
    for (int b = chunk_[c]; b < chunk_[c + 1]; ++b)
      add_batch(batches_[b], multipoles, local, value.data(), scratch.data());
  });
}

}  // namespace lichtenberg::laplace::spheres
