#include "solvers/laplace/spheres/near_field.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <mutex>

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
class DegreesByDistance {
 public:
  explicit DegreesByDistance(double accuracy) {
    for (int l = 1; l <= largest_degree; ++l) largest_ratio_[l - 1] = std::pow(accuracy, 1.0 / l);
  }
  int at(double reach, double distance) const {
    if (reach >= distance) return 1 << 20;
    const auto first = std::ranges::lower_bound(largest_ratio_, reach / distance);
    return first == largest_ratio_.end() ? 1 << 20 : static_cast<int>(first - largest_ratio_.begin()) + 1;
  }

 private:
  std::array<double, largest_degree> largest_ratio_{};
};

/// In what order pairs are taken: by chunk of targets, then by degrees, as numbers that can be sorted.
std::vector<std::uint64_t> order_of(const std::vector<NearPair>& pairs, const std::vector<Site>& targets,
                                    const std::vector<Site>& sources, double accuracy) {
  const DegreesByDistance degrees(accuracy);
  std::vector<std::uint64_t> order(pairs.size());
  for (std::size_t p = 0; p < pairs.size(); ++p) {
    const Site &target = targets[pairs[p].target], &source = sources[pairs[p].source];
    const double d = norm(pairs[p].way);
    const int source_degree = std::min(source.degree, degrees.at(source.radius, d - target.radius));
    const int target_degree = std::min(target.degree, degrees.at(target.radius, d - source.radius));
    order[p] = (static_cast<std::uint64_t>(pairs[p].target / targets_a_chunk) << 48) +
               (static_cast<std::uint64_t>(source_degree) << 40) + (static_cast<std::uint64_t>(target_degree) << 32) +
               p;
  }
  std::sort(order.begin(), order.end());
  return order;
}

}  // namespace

NearField::NearField(const std::vector<Site>& targets, const std::vector<Site>& sources, std::vector<NearPair> pairs,
                     double accuracy)
    : target_start_(starts(targets)), source_start_(starts(sources)) {
  int filled = lanes, chunk = -1;
  for (const std::uint64_t key : order_of(pairs, targets, sources, accuracy)) {
    const int source_degree = key >> 40 & 255, target_degree = key >> 32 & 255;
    for (; chunk < static_cast<int>(key >> 48); ++chunk) {
      chunk_.push_back(static_cast<int>(batches_.size()));
      filled = lanes;
    }
    if (filled == lanes || batches_.back().source_degree != source_degree ||
        batches_.back().target_degree != target_degree) {
      batches_.push_back({source_degree, target_degree});
      largest_degree_ = std::max({largest_degree_, source_degree, target_degree});
      for (int k = 0; k < lanes; ++k) batches_.back().ways.set(k, {0, 0, 1});
      filled = 0;
    }
    const NearPair& pair = pairs[key & 0xffffffff];
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
