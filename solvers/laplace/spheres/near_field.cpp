#include "solvers/laplace/spheres/near_field.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <mutex>
#include <utility>

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

}  // namespace

/// Degrees of a pair, beyond which (reach / distance)^l is below the accuracy. They are at least 2, because the force
/// on a neutral sphere begins with its dipole and the field's gradient. They are the same for both directions, so that
/// the matrix stays symmetric.
class NearField::DegreesByDistance {
 public:
  explicit DegreesByDistance(double accuracy) {
    for (int l = 1; l <= largest_degree; ++l) largest_ratio_[l - 1] = std::pow(accuracy, 1.0 / l);
  }
  /// Returns the degree, at most `most`.
  int at(double reach, double distance, int most) const {
    if (reach >= distance) return most;
    const auto first = std::lower_bound(largest_ratio_.begin(), largest_ratio_.begin() + std::min(most, largest_degree),
                                        reach / distance);
    return std::min(std::max(static_cast<int>(first - largest_ratio_.begin()) + 1, 2), most);
  }

 private:
  std::array<double, largest_degree> largest_ratio_{};
};

namespace {

Lanes root(Lanes value) {
  for (int k = 0; k < lanes; ++k) value[k] = std::sqrt(value[k]);
  return value;
}

/// Returns the index of the first pair of each chunk of targets.
std::vector<std::size_t> chunk_starts(const std::vector<NearPair>& pairs, std::size_t targets) {
  std::vector<std::size_t> start;
  for (std::size_t first = 0; first < targets; first += targets_a_chunk)
    start.push_back(std::ranges::lower_bound(pairs, static_cast<int>(first), {}, &NearPair::target) - pairs.begin());
  start.push_back(pairs.size());
  return start;
}

/// Transposes eight vectors of one register each: exchanges the off-diagonal halves of blocks of two, four and eight.
template <class Eight>
void transpose_registers(std::array<Eight, lanes>& row) {
  for (const int k : {0, 2, 4, 6}) {
    const Eight a = row[k], b = row[k + 1];
    row[k] = __builtin_shufflevector(a, b, 0, 8, 2, 10, 4, 12, 6, 14);
    row[k + 1] = __builtin_shufflevector(a, b, 1, 9, 3, 11, 5, 13, 7, 15);
  }
  for (const int k : {0, 1, 4, 5}) {
    const Eight a = row[k], b = row[k + 2];
    row[k] = __builtin_shufflevector(a, b, 0, 1, 8, 9, 4, 5, 12, 13);
    row[k + 2] = __builtin_shufflevector(a, b, 2, 3, 10, 11, 6, 7, 14, 15);
  }
  for (const int k : {0, 1, 2, 3}) {
    const Eight a = row[k], b = row[k + 4];
    row[k] = __builtin_shufflevector(a, b, 0, 1, 2, 3, 8, 9, 10, 11);
    row[k + 4] = __builtin_shufflevector(a, b, 4, 5, 6, 7, 12, 13, 14, 15);
  }
}

/// Transposes eight vectors of eight numbers, which take one or two registers each.
template <class Eight>
void transpose(std::array<Eight, lanes>& row) {
  if constexpr (std::is_class_v<Eight>) {
    for (const int k : {0, 1, 2, 3}) std::swap(row[k].high, row[k + 4].low);
    for (auto half : {&Eight::low, &Eight::high}) {
      for (const int k : {0, 2, 4, 6}) {
        const auto a = row[k].*half, b = row[k + 1].*half;
        row[k].*half = __builtin_shufflevector(a, b, 0, 4, 2, 6);
        row[k + 1].*half = __builtin_shufflevector(a, b, 1, 5, 3, 7);
      }
      for (const int k : {0, 1, 4, 5}) {
        const auto a = row[k].*half, b = row[k + 2].*half;
        row[k].*half = __builtin_shufflevector(a, b, 0, 1, 4, 5);
        row[k + 2].*half = __builtin_shufflevector(a, b, 2, 3, 6, 7);
      }
    }
  } else {
    transpose_registers(row);
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

/// Adds `count` numbers to each of up to eight targets, which may be equal: to[k][h] += value[h][k]. Successive equal
/// targets are common, and are read and stored once.
void scatter(const Lanes* value, int count, std::span<double* const> to) {
  int h = 0;
  for (; h + lanes <= count; h += lanes) {
    std::array<Lanes, lanes> block;
    std::copy(value + h, value + h + lanes, block.begin());
    transpose(block);
    for (std::size_t k = 0; k < to.size();) {
      Lanes sum;
      std::memcpy(&sum, to[k] + h, sizeof sum);
      double* const target = to[k];
      while (k < to.size() && to[k] == target) sum += block[k++];
      std::memcpy(target + h, &sum, sizeof sum);
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
  const DegreesByDistance degrees(accuracy);
  chunks_.resize(start.size() - 1);
  team.for_each(static_cast<int>(chunks_.size()), [&](int c) {
    chunks_[c] = batches(std::span(pairs).subspan(start[c], start[c + 1] - start[c]), targets, sources, degrees);
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
                                                 const std::vector<Site>& sources,
                                                 const DegreesByDistance& degrees) const {
  int highest = 0;
  std::vector<std::array<int, 2>> degree(pairs.size());  // Degrees of source and target
  for (std::size_t p = 0; p < pairs.size(); ++p) {
    const Site &target = targets[pairs[p].target], &source = sources[pairs[p].source];
    const double d = norm(pairs[p].displacement);
    degree[p] = {degrees.at(source.radius, d - target.radius, source.degree),
                 degrees.at(target.radius, d - source.radius, target.degree)};
    highest = std::max({highest, degree[p][0], degree[p][1]});
  }
  // Pairs of equal degrees and mirrors are counted first, so that batches do not grow.
  const int side = highest + 1;
  const auto kind = [&](std::size_t p) { return (degree[p][0] * side + degree[p][1]) * 8 + pairs[p].mask; };
  std::vector<int> next(static_cast<std::size_t>(8) * side * side);
  for (std::size_t p = 0; p < pairs.size(); ++p) ++next[kind(p)];
  int count = 0;
  for (int& one : next) count += (std::exchange(one, count * lanes) + lanes - 1) / lanes;
  std::vector<Batch> all(count);
  for (std::size_t p = 0; p < pairs.size(); ++p) {
    const int slot = next[kind(p)]++;
    Batch& batch = all[slot / lanes];
    if (batch.count == 0) {
      batch.source_degree = degree[p][0], batch.target_degree = degree[p][1], batch.mask = pairs[p].mask;
      batch.source.fill(source_start_[pairs[p].source]);  // Empty lanes read any source
    }
    add_to_batch(batch, pairs[p], targets[pairs[p].target], sources[pairs[p].source]);
  }
  for (Batch& batch : all) complete(batch);
  return all;
}

/// Adds a pair. Displacement and radii are stored in place of the numbers that complete() computes from them.
void NearField::add_to_batch(Batch& batch, const NearPair& pair, const Site& target, const Site& source) const {
  const int k = batch.count++;
  batch.directions.cos_azimuth[k] = pair.displacement.x;
  batch.directions.sin_azimuth[k] = pair.displacement.y;
  batch.directions.cos_polar[k] = pair.displacement.z;
  batch.target[k] = target_start_[pair.target];
  batch.source[k] = source_start_[pair.source];
  batch.sign[k] = pair.sign;
  batch.source_factor[k] = source.radius;
  batch.target_factor[k] = target.radius;
}

/// Computes the directions and factors of a batch, for all lanes at once.
void NearField::complete(Batch& batch) {
  PairDirections& direction = batch.directions;
  for (int k = batch.count; k < lanes; ++k) direction.cos_polar[k] = 1;
  const Lanes x = direction.cos_azimuth, y = direction.sin_azimuth, z = direction.cos_polar, across2 = x * x + y * y,
              across = root(across2), d = root(across2 + z * z);
  direction.cos_polar = z / d;
  direction.sin_polar = across / d;
  direction.cos_azimuth = x / across;
  direction.sin_azimuth = y / across;
  for (int k = 0; k < lanes; ++k)
    if (!(across[k] > 0)) direction.cos_azimuth[k] = 1, direction.sin_azimuth[k] = 0;
  batch.sign *= batch.source_factor / d;
  batch.source_factor *= 2 / d;
  batch.target_factor *= 2 / d;
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
