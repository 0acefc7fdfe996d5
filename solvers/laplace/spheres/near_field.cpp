#include "solvers/laplace/spheres/near_field.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <mutex>

namespace lichtenberg::laplace::spheres {

std::vector<int> starts(const std::vector<Site>& sites, int beyond) {
  std::vector<int> start = {0};
  for (const Site& site : sites) start.push_back(start.back() + harmonics(site.degree + beyond));
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

/// Degrees of a pair, beyond which (reach / distance)^l is below the accuracy. They are the same for both directions,
/// so that the matrix stays symmetric.
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

/// Properties that the pairs of a batch share, followed by the pair's index, packed into one sortable number.
struct Key {
  int source_degree = 0, target_degree = 0, mask = 0;
  std::uint32_t pair = 0;

  std::uint64_t packed() const {
    return (static_cast<std::uint64_t>(source_degree) << 43) + (static_cast<std::uint64_t>(target_degree) << 35) +
           (static_cast<std::uint64_t>(mask) << 32) + pair;
  }
  static Key of(std::uint64_t packed) {
    return {static_cast<int>(packed >> 43), static_cast<int>(packed >> 35 & 255), static_cast<int>(packed >> 32 & 7),
            static_cast<std::uint32_t>(packed)};
  }
};

/// Returns the pairs sorted by degrees and mirrors.
std::vector<std::uint64_t> order_of(std::span<const NearPair> pairs, const std::vector<Site>& targets,
                                    const std::vector<Site>& sources, double accuracy) {
  const DegreesByDistance degrees(accuracy);
  std::vector<std::uint64_t> order(pairs.size());
  for (std::size_t p = 0; p < pairs.size(); ++p) {
    const Site &target = targets[pairs[p].target], &source = sources[pairs[p].source];
    const double d = norm(pairs[p].displacement);
    order[p] = Key{.source_degree = std::min(source.degree, degrees.at(source.radius, d - target.radius)),
                   .target_degree = std::min(target.degree, degrees.at(target.radius, d - source.radius)),
                   .mask = pairs[p].mask,
                   .pair = static_cast<std::uint32_t>(p)}
                   .packed();
  }
  std::sort(order.begin(), order.end());
  return order;
}

/// Returns the index of the first pair of each chunk of targets.
std::vector<std::size_t> chunk_starts(const std::vector<NearPair>& pairs, std::size_t targets) {
  std::vector<std::size_t> start;
  for (std::size_t first = 0; first < targets; first += targets_a_chunk)
    start.push_back(std::ranges::lower_bound(pairs, static_cast<int>(first), {}, &NearPair::target) - pairs.begin());
  start.push_back(pairs.size());
  return start;
}

/// Returns one harmonic of eight sources. It is built in a register, because a vector load after eight scalar stores
/// must wait for all of them.
Lanes gathered(const std::array<const double*, lanes>& from, int harmonic) {
  Lanes value;
  for (int k = 0; k < lanes; ++k) value[k] = from[k][harmonic];
  return value;
}

}  // namespace

NearField::NearField(const std::vector<Site>& targets, const std::vector<Site>& sources,
                     const std::vector<NearPair>& pairs, double accuracy, parallel::Team& team)
    : target_start_(starts(targets)), source_start_(starts(sources)) {
  const std::vector<std::size_t> start = chunk_starts(pairs, targets.size());
  chunks_.resize(start.size() - 1);
  team.for_each(static_cast<int>(chunks_.size()), [&](int c) {
    chunks_[c] = batches(std::span(pairs).subspan(start[c], start[c + 1] - start[c]), targets, sources, accuracy);
  });
  for (const std::vector<Batch>& chunk : chunks_)
    for (const Batch& batch : chunk)
      largest_degree_ = std::max({largest_degree_, batch.source_degree, batch.target_degree});
  translation_ = translation_up_to(largest_degree_);
  for (int mask = 0; mask < 8; ++mask)
    for (int l = 0; l <= largest_degree_; ++l)
      for (int m = -l; m <= l; ++m) signs_.push_back(mirror_sign(l, m, mask));
}

std::vector<NearField::Batch> NearField::batches(std::span<const NearPair> pairs, const std::vector<Site>& targets,
                                                 const std::vector<Site>& sources, double accuracy) const {
  std::vector<Batch> made;
  for (const std::uint64_t packed : order_of(pairs, targets, sources, accuracy)) {
    const Key key = Key::of(packed);
    const auto fits = [&](const Batch& batch) {
      return batch.count < lanes && batch.source_degree == key.source_degree &&
             batch.target_degree == key.target_degree && batch.mask == key.mask;
    };
    if (made.empty() || !fits(made.back())) made.push_back({key.source_degree, key.target_degree, key.mask});
    const NearPair& pair = pairs[key.pair];
    add_to_batch(made.back(), pair, targets[pair.target], sources[pair.source]);
  }
  return made;
}

void NearField::add_to_batch(Batch& batch, const NearPair& pair, const Site& target, const Site& source) const {
  if (batch.count == 0)
    for (int k = 0; k < lanes; ++k) batch.directions.set(k, {0, 0, 1});
  const int k = batch.count++;
  const double d = norm(pair.displacement);
  batch.directions.set(k, pair.displacement);
  batch.target[k] = target_start_[pair.target];
  batch.source[k] = source_start_[pair.source];
  batch.sign[k] = pair.sign * source.radius / d;
  batch.source_factor[k] = 2 * source.radius / d;
  batch.target_factor[k] = 2 * target.radius / d;
}

void NearField::add_batch(const Batch& batch, const double* multipoles, double* local, Lanes* value,
                          Lanes* scratch) const {
  std::array<const double*, lanes> from;
  for (int k = 0; k < lanes; ++k) from[k] = multipoles + batch.source[k];
  const double* sign = signs_.data() + static_cast<std::ptrdiff_t>(batch.mask) * harmonics(largest_degree_);
  Lanes factor = batch.sign;
  for (int l = 0; l <= batch.source_degree; ++l, factor *= batch.source_factor)
    for (int h = at(l, -l); h <= at(l, l); ++h) value[h] = factor * sign[h] * gathered(from, h);
  translation_->apply(batch.directions, batch.source_degree, batch.target_degree, value, scratch);
  factor = Lanes{} + 1;
  for (int l = 0; l <= batch.target_degree; ++l, factor *= batch.target_factor)
    for (int h = at(l, -l); h <= at(l, l); ++h) value[h] *= factor;
  for (int k = 0; k < batch.count; ++k)
    for (int h = 0; h < harmonics(batch.target_degree); ++h) local[batch.target[k] + h] += value[h][k];
}

void NearField::add(const double* multipoles, double* local, parallel::Team& team) const {
  team.for_each(static_cast<int>(chunks_.size()), [&](int c) {
    std::vector<Lanes> value(harmonics(largest_degree_)), scratch(value.size());
    for (const Batch& batch : chunks_[c]) add_batch(batch, multipoles, local, value.data(), scratch.data());
  });
}

void NearField::add_pair(const Batch& batch, int pair, const Lanes* multipoles, Lanes* local, Lanes* value,
                         Lanes* scratch) const {
  const double* sign = signs_.data() + static_cast<std::ptrdiff_t>(batch.mask) * harmonics(largest_degree_);
  const Lanes* from = multipoles + batch.source[pair];
  double factor = batch.sign[pair];
  for (int l = 0; l <= batch.source_degree; ++l, factor *= batch.source_factor[pair])
    for (int h = at(l, -l); h <= at(l, l); ++h) value[h] = factor * sign[h] * from[h];
  const Lanes none{};
  const PairDirections directions{none + batch.directions.cos_azimuth[pair], none + batch.directions.sin_azimuth[pair],
                                  none + batch.directions.cos_polar[pair], none + batch.directions.sin_polar[pair]};
  translation_->apply(directions, batch.source_degree, batch.target_degree, value, scratch);
  Lanes* to = local + batch.target[pair];
  factor = 1;
  for (int l = 0; l <= batch.target_degree; ++l, factor *= batch.target_factor[pair])
    for (int h = at(l, -l); h <= at(l, l); ++h) to[h] += factor * value[h];
}

void NearField::add(const Lanes* multipoles, Lanes* local, parallel::Team& team) const {
  team.for_each(static_cast<int>(chunks_.size()), [&](int c) {
    std::vector<Lanes> value(harmonics(largest_degree_)), scratch(value.size());
    for (const Batch& batch : chunks_[c])
      for (int k = 0; k < batch.count; ++k) add_pair(batch, k, multipoles, local, value.data(), scratch.data());
  });
}

}  // namespace lichtenberg::laplace::spheres
