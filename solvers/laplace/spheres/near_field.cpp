#include "solvers/laplace/spheres/near_field.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>
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

/// Returns the index of the first pair of each chunk of targets.
std::vector<std::size_t> chunk_starts(const std::vector<NearPair>& pairs, std::size_t targets) {
  std::vector<std::size_t> start;
  for (std::size_t first = 0; first < targets; first += targets_a_chunk)
    start.push_back(std::ranges::lower_bound(pairs, static_cast<int>(first), {}, &NearPair::target) - pairs.begin());
  start.push_back(pairs.size());
  return start;
}

/// Transposes eight vectors of eight numbers: exchanges the off-diagonal halves of blocks of two, four and eight.
void transpose(std::array<Lanes, lanes>& row) {
  for (const int k : {0, 2, 4, 6}) {
    const Lanes a = row[k], b = row[k + 1];
    row[k] = __builtin_shufflevector(a, b, 0, 8, 2, 10, 4, 12, 6, 14);
    row[k + 1] = __builtin_shufflevector(a, b, 1, 9, 3, 11, 5, 13, 7, 15);
  }
  for (const int k : {0, 1, 4, 5}) {
    const Lanes a = row[k], b = row[k + 2];
    row[k] = __builtin_shufflevector(a, b, 0, 1, 8, 9, 4, 5, 12, 13);
    row[k + 2] = __builtin_shufflevector(a, b, 2, 3, 10, 11, 6, 7, 14, 15);
  }
  for (const int k : {0, 1, 2, 3}) {
    const Lanes a = row[k], b = row[k + 4];
    row[k] = __builtin_shufflevector(a, b, 0, 1, 2, 3, 8, 9, 10, 11);
    row[k + 4] = __builtin_shufflevector(a, b, 4, 5, 6, 7, 12, 13, 14, 15);
  }
}

/// Collects `count` numbers of each of eight sources: value[h][k] = from[k][h].
void gather(const std::array<const double*, lanes>& from, int count, Lanes* value) {
  int h = 0;
  for (; h + lanes <= count; h += lanes) {
    std::array<Lanes, lanes> block;
    for (int k = 0; k < lanes; ++k) std::memcpy(&block[k], from[k] + h, sizeof block[k]);
    transpose(block);
    std::copy(block.begin(), block.end(), value + h);
  }
  for (; h < count; ++h) {
    Lanes one;  // A register: a vector load after eight scalar stores would wait for all of them
    for (int k = 0; k < lanes; ++k) one[k] = from[k][h];
    value[h] = one;
  }
}

/// Adds `count` numbers to each of up to eight targets, which may be equal: to[k][h] += value[h][k].
void scatter(const Lanes* value, int count, std::span<double* const> to) {
  int h = 0;
  for (; h + lanes <= count; h += lanes) {
    std::array<Lanes, lanes> block;
    std::copy(value + h, value + h + lanes, block.begin());
    transpose(block);
    for (std::size_t k = 0; k < to.size(); ++k) {
      Lanes sum;
      std::memcpy(&sum, to[k] + h, sizeof sum);
      sum += block[k];
      std::memcpy(to[k] + h, &sum, sizeof sum);
    }
  }
  for (; h < count; ++h)
    for (std::size_t k = 0; k < to.size(); ++k) to[k][h] += value[h][k];
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
  const DegreesByDistance degrees(accuracy);
  std::map<std::array<int, 3>, std::vector<Batch>> made;  // By degrees and mirrors
  std::size_t count = 0;
  for (const NearPair& pair : pairs) {
    const Site &target = targets[pair.target], &source = sources[pair.source];
    const double d = norm(pair.displacement);
    const int source_degree = std::min(source.degree, degrees.at(source.radius, d - target.radius));
    const int target_degree = std::min(target.degree, degrees.at(target.radius, d - source.radius));
    std::vector<Batch>& equal = made[{source_degree, target_degree, pair.mask}];
    if (equal.empty() || equal.back().count == lanes) {
      equal.push_back({source_degree, target_degree, pair.mask});
      ++count;
    }
    add_to_batch(equal.back(), pair, target, source);
  }
  std::vector<Batch> all;
  all.reserve(count);
  for (const auto& [degrees_and_mirrors, equal] : made) all.insert(all.end(), equal.begin(), equal.end());
  return all;
}

void NearField::add_to_batch(Batch& batch, const NearPair& pair, const Site& target, const Site& source) const {
  if (batch.count == 0) {
    for (int k = 0; k < lanes; ++k) batch.directions.set(k, {0, 0, 1});
    batch.source.fill(source_start_[pair.source]);  // Empty lanes read any source
  }
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
  std::array<double*, lanes> to;
  for (int k = 0; k < lanes; ++k) from[k] = multipoles + batch.source[k], to[k] = local + batch.target[k];
  gather(from, harmonics(batch.source_degree), value);
  const double* sign = signs_.data() + static_cast<std::ptrdiff_t>(batch.mask) * harmonics(largest_degree_);
  Lanes factor = batch.sign;
  for (int l = 0; l <= batch.source_degree; ++l, factor *= batch.source_factor)
    for (int h = at(l, -l); h <= at(l, l); ++h) value[h] *= factor * sign[h];
  translation_->apply(batch.directions, batch.source_degree, batch.target_degree, value, scratch);
  factor = Lanes{} + 1;
  for (int l = 0; l <= batch.target_degree; ++l, factor *= batch.target_factor)
    for (int h = at(l, -l); h <= at(l, l); ++h) value[h] *= factor;
  scatter(value, harmonics(batch.target_degree), std::span(to).first(batch.count));
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
