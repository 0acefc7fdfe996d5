#include "solvers/minimize/lbfgs.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "solvers/minimize/vectors.hpp"

namespace lichtenberg::minimize {
namespace {

/// Returns the products of a vector with three others of `size` components. Not inlined, because GCC 12 vectorizes the
/// inlined loop across the sums in place of the lanes, which is slower.
[[gnu::noinline]] std::array<double, 3> products(const float* v, const double* a, const double* b, const double* c,
                                                 std::size_t size) {
  constexpr std::size_t lanes = 8;  // Number of independent sums, since the compiler may not reorder a single one
  double with_a[lanes] = {}, with_b[lanes] = {}, with_c[lanes] = {};
  const std::size_t whole = size / lanes * lanes;
  for (std::size_t i = 0; i < whole; i += lanes)
    for (std::size_t lane = 0; lane < lanes; ++lane) {
      const double x = v[i + lane];
      with_a[lane] += x * a[i + lane];
      with_b[lane] += x * b[i + lane];
      with_c[lane] += x * c[i + lane];
    }
  std::array<double, 3> sum{};
  for (std::size_t lane = 0; lane < lanes; ++lane)
    sum[0] += with_a[lane], sum[1] += with_b[lane], sum[2] += with_c[lane];
  for (std::size_t i = whole; i < size; ++i) {
    const double x = v[i];
    sum[0] += x * a[i];
    sum[1] += x * b[i];
    sum[2] += x * c[i];
  }
  return sum;
}

/// Subtracts the sum of factor[v] * vectors[v][i] from sum[i], for i from `first` up to before `end`. Sums stay in
/// registers over all vectors.
[[gnu::noinline]] void subtract(std::span<const std::vector<float>> vectors, const double* factor, std::size_t first,
                                std::size_t end, double* sum) {
  constexpr std::size_t lanes = 32;
  std::size_t i = first;
  for (; i + lanes <= end; i += lanes) {
    std::array<double, lanes> part;
    std::copy_n(&sum[i], lanes, part.begin());
    for (std::size_t v = 0; v < vectors.size(); ++v) {
      const float* vector = &vectors[v][i];
#pragma GCC unroll 32
      for (std::size_t lane = 0; lane < lanes; ++lane) part[lane] -= factor[v] * static_cast<double>(vector[lane]);
    }
    std::copy_n(part.begin(), lanes, &sum[i]);
  }
  for (; i < end; ++i)
    for (std::size_t v = 0; v < vectors.size(); ++v) sum[i] -= factor[v] * static_cast<double>(vectors[v][i]);
}

double power_of_two(double x) { return std::exp2(std::floor(std::log2(x))); }

}  // namespace

Lbfgs::Lbfgs(Objective& objective, std::vector<double> x, double first_step, double largest_move)
    : Minimizer(objective, std::move(x)),
      first_step_(first_step),
      largest_move_(largest_move),
      length_(power_of_two(largest_move)),
      force_(length_ / power_of_two(first_step)),
      direction_(point_.x.size()),
      next_(point_) {}

/// Computes the factors of the vectors and, last, of the gradient (in units of force_) in H gradient (in units of
/// length_), by Nocedal's two-loop recursion.
std::vector<double> Lbfgs::factors() const {
  const int count = vectors(), corrections = count / 2;
  std::vector<double> factor(count + 1), share(corrections);
  factor[count] = 1;
  const auto product_with = [&](int v) {
    double sum = factor[count] * with_gradient_[v];
    for (int a = 0; a < count; ++a) sum += factor[a] * product_[v][a];
    return sum;
  };
  for (int k = corrections; k-- > 0;) {
    const int move = 2 * k, change = move + 1;
    share[k] = product_with(move) / product_[move][change];
    factor[change] -= share[k];
  }
  const int last = count - 1;
  const double scale =
      corrections == 0 ? first_step_ * force_ / length_ : product_[last - 1][last] / product_[last][last];
  for (double& f : factor) f *= scale;
  for (int k = 0; k < corrections; ++k) {
    const int move = 2 * k, change = move + 1;
    factor[move] += share[k] - product_with(change) / product_[move][change];
  }
  return factor;
}

/// Sets the direction -H gradient, with H the inverse Hessian approximated by the corrections.
void Lbfgs::find_direction() {
  std::vector<double> factor = factors();
  const int count = vectors();
  for (double& f : factor) f *= length_;
  factor[count] /= force_;
  const std::size_t size = direction_.size();
  std::vector<double> slopes(tasks_for(size)), largest(slopes);
  share_blocks(objective_, size, [&](int task, std::size_t first, std::size_t end) {
    for (std::size_t i = first; i < end; ++i) direction_[i] = -factor[count] * point_.gradient[i];
    subtract(vectors_, factor.data(), first, end, direction_.data());
    const std::span d = std::span(direction_).subspan(first, end - first);
    slopes[task] = dot(d, std::span(point_.gradient).subspan(first, end - first));
    largest[task] = minimize::largest(d);
  });
  slope_ = longest_ = 0;
  for (const double s : slopes) slope_ += s;
  for (const double l : largest) longest_ = larger(longest_, l);
}

bool Lbfgs::search() {
  find_direction();
  if (!(slope_ < 0)) return false;
  double step = std::min(1.0, largest_move_ / longest_);
  const double rounding = 1e-14 * std::abs(point_.value);
  constexpr double share = 1e-4;
  constexpr int most_halvings = 40;
  for (int halving = 0; halving < most_halvings; ++halving, step *= 0.5) {
    share_blocks(objective_, direction_.size(), [&](int, std::size_t first, std::size_t end) {
      for (std::size_t i = first; i < end; ++i) next_.x[i] = point_.x[i] + step * direction_[i];
    });
    evaluate(next_);
    if (next_.value <= point_.value + share * step * slope_ + rounding) return true;
  }
  return false;
}

/// Updates the products of the newest move and change, and of the next gradient, with all vectors.
void Lbfgs::measure_newest() {
  const int count = vectors(), move = count - 2, change = count - 1;
  const std::size_t size = direction_.size();
  const double per_length = 1 / length_, per_force = 1 / force_;
  std::vector<std::array<std::array<double, 3>, most_vectors>> sums(tasks_for(size));
  share_blocks(objective_, size, [&](int task, std::size_t first, std::size_t end) {
    constexpr std::size_t few = 1024;  // This many numbers of three vectors fit into the first-level cache
    std::array<double, few> moves, changes;
    for (std::size_t from = first; from < end; from += few) {
      const std::size_t n = std::min(few, end - from);
      for (std::size_t i = 0; i < n; ++i) {
        const std::size_t k = from + i;
        moves[i] = vectors_[move][k] = static_cast<float>((next_.x[k] - point_.x[k]) * per_length);
        changes[i] = vectors_[change][k] = static_cast<float>((next_.gradient[k] - point_.gradient[k]) * per_force);
      }
      for (int v = 0; v < count; ++v) {
        const std::array<double, 3> part =
            products(&vectors_[v][from], moves.data(), changes.data(), &next_.gradient[from], n);
        for (int p = 0; p < 3; ++p) sums[task][v][p] += part[p];
      }
    }
  });
  for (int v = 0; v < count; ++v) {
    double with_move = 0, with_change = 0;
    with_gradient_[v] = 0;
    for (const auto& sum : sums) with_move += sum[v][0], with_change += sum[v][1], with_gradient_[v] += sum[v][2];
    with_gradient_[v] *= per_force;
    product_[v][move] = product_[move][v] = with_move;
    product_[v][change] = product_[change][v] = with_change;
  }
}

/// Moves the memory of the oldest correction to the end, for the newest one.
void Lbfgs::replace_oldest() {
  std::ranges::rotate(vectors_, vectors_.begin() + 2);
  for (int a = 0; a < vectors() - 2; ++a)
    for (int b = 0; b < vectors() - 2; ++b) product_[a][b] = product_[a + 2][b + 2];
}

void Lbfgs::add_correction() {
  if (vectors() == most_vectors)
    replace_oldest();
  else
    vectors_.insert(vectors_.end(), 2, Vector(direction_.size()));
  measure_newest();
  const int move = vectors() - 2, change = move + 1;
  // Drops a correction of negative curvature: H must stay positive definite.
  if (product_[move][change] > 1e-12 * std::sqrt(product_[move][move] * product_[change][change])) return;
  vectors_.pop_back();
  vectors_.pop_back();
}

bool Lbfgs::iterate() {
  if (!search()) {
    if (vectors_.empty()) return false;
    vectors_.clear();
    if (!search()) return false;
  }
  add_correction();
  std::swap(point_, next_);
  return true;
}

Memory Lbfgs::memory() const {
  Memory memory;
  for (int v = 0; v < vectors(); ++v) memory[fmt::format("vector {:02}", v)] = {vectors_[v].begin(), vectors_[v].end()};
  for (int v = 0; v < vectors(); ++v)
    memory[fmt::format("products {:02}", v)] = {product_[v].begin(), product_[v].end()};
  memory["products with gradient"] = {with_gradient_.begin(), with_gradient_.end()};
  return memory;
}

void Lbfgs::remember(const Memory& memory) {
  vectors_.clear();
  for (int v = 0; v < most_vectors && memory.contains(fmt::format("vector {:02}", v)); ++v) {
    const std::vector<double>& vector = remembered(memory, fmt::format("vector {:02}", v), point().x.size());
    vectors_.emplace_back(vector.begin(), vector.end());
    std::ranges::copy(remembered(memory, fmt::format("products {:02}", v), most_vectors), product_[v].begin());
  }
  std::ranges::copy(remembered(memory, "products with gradient", most_vectors), with_gradient_.begin());
}

}  // namespace lichtenberg::minimize
