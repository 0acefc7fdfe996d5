#include "solvers/minimize/lbfgs.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "solvers/minimize/vectors.hpp"

namespace lichtenberg::minimize {
namespace {

/// What a task of a shared loop goes through: so much stays in a core's own memory while all vectors pass.
constexpr std::size_t block = 4096;

int tasks_for(std::size_t size) { return static_cast<int>((size + block - 1) / block); }

/// Calls part(task, first, end) for every block of `size` components.
template <class Part>
void share_blocks(const Objective& objective, std::size_t size, const Part& part) {
  objective.share(tasks_for(size), [&](int task) { part(task, block * task, std::min(block * (task + 1), size)); });
}

/// Products of a vector with three others, from component `first` on up to before `end`.
std::array<double, 3> products(const std::vector<float>& v, const std::vector<float>& a, const std::vector<float>& b,
                               const std::vector<double>& c, std::size_t first, std::size_t end) {
  constexpr int lanes = 8;  // so many sums at a time, or the compiler must add one after the other
  double with_a[lanes] = {}, with_b[lanes] = {}, with_c[lanes] = {};
  const auto add = [&](std::size_t i, int lane) {
    const double x = v[i];
    with_a[lane] += x * static_cast<double>(a[i]);
    with_b[lane] += x * static_cast<double>(b[i]);
    with_c[lane] += x * c[i];
  };
  std::size_t i = first;
  for (; i + lanes <= end; i += lanes)
    for (int lane = 0; lane < lanes; ++lane) add(i + lane, lane);
  for (; i < end; ++i) add(i, 0);
  std::array<double, 3> sum{};
  for (int lane = 0; lane < lanes; ++lane) sum[0] += with_a[lane], sum[1] += with_b[lane], sum[2] += with_c[lane];
  return sum;
}

}  // namespace

Lbfgs::Lbfgs(Objective& objective, std::vector<double> x, double first_step, double largest_move)
    : Minimizer(objective, std::move(x)),
      first_step_(first_step),
      largest_move_(largest_move),
      direction_(point_.x.size()),
      next_(point_) {}

/// Nocedal's two loops for H gradient, on the factors of the vectors and, last, of the gradient.
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
  const double scale = corrections == 0 ? first_step_ : product_[last - 1][last] / product_[last][last];
  for (double& f : factor) f *= scale;
  for (int k = 0; k < corrections; ++k) {
    const int move = 2 * k, change = move + 1;
    factor[move] += share[k] - product_with(change) / product_[move][change];
  }
  return factor;
}

/// -H gradient, with H the inverse Hessian as the corrections know it.
void Lbfgs::find_direction() {
  const std::vector<double> factor = factors();
  const int count = vectors();
  const std::size_t size = direction_.size();
  std::vector<double> slopes(tasks_for(size)), largest(slopes);
  share_blocks(objective_, size, [&](int task, std::size_t first, std::size_t end) {
    for (std::size_t i = first; i < end; ++i) direction_[i] = -factor[count] * point_.gradient[i];
    for (int v = 0; v < count; ++v) {
      const Vector& vector = vectors_[v];
      for (std::size_t i = first; i < end; ++i) direction_[i] -= factor[v] * static_cast<double>(vector[i]);
    }
    const std::span d = std::span(direction_).subspan(first, end - first);
    slopes[task] = dot(d, std::span(point_.gradient).subspan(first, end - first));
    largest[task] = minimize::largest(d);
  });
  slope_ = longest_ = 0;
  for (const double s : slopes) slope_ += s;
  for (const double l : largest) longest_ = std::max(longest_, l);
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

/// Products of the newest move and change, and of the next gradient, with all vectors.
void Lbfgs::measure_newest() {
  const int count = vectors(), move = count - 2, change = count - 1;
  const std::size_t size = direction_.size();
  std::vector<std::array<std::array<double, 3>, most_vectors>> sums(tasks_for(size));
  share_blocks(objective_, size, [&](int task, std::size_t first, std::size_t end) {
    for (std::size_t i = first; i < end; ++i) {
      vectors_[move][i] = static_cast<float>(next_.x[i] - point_.x[i]);
      vectors_[change][i] = static_cast<float>(next_.gradient[i] - point_.gradient[i]);
    }
    for (int v = 0; v < count; ++v) {
      sums[task][v] = products(vectors_[v], vectors_[move], vectors_[change], next_.gradient, first, end);
    }
  });
  for (int v = 0; v < count; ++v) {
    double with_move = 0, with_change = 0;
    with_gradient_[v] = 0;
    for (const auto& sum : sums) with_move += sum[v][0], with_change += sum[v][1], with_gradient_[v] += sum[v][2];
    product_[v][move] = product_[move][v] = with_move;
    product_[v][change] = product_[change][v] = with_change;
  }
}

void Lbfgs::forget_oldest() {
  vectors_.pop_front();
  vectors_.pop_front();
  for (int a = 0; a < vectors(); ++a)
    for (int b = 0; b < vectors(); ++b) product_[a][b] = product_[a + 2][b + 2];
}

void Lbfgs::learn() {
  if (vectors() == most_vectors) forget_oldest();
  vectors_.emplace_back(direction_.size());
  vectors_.emplace_back(direction_.size());
  measure_newest();
  const int move = vectors() - 2, change = move + 1;
  // A negative curvature has no place in an H that is to lead downhill.
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
  learn();
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
  for (int v = 0; memory.contains(fmt::format("vector {:02}", v)); ++v) {
    const std::vector<double>& vector = memory.at(fmt::format("vector {:02}", v));
    vectors_.emplace_back(vector.begin(), vector.end());
    std::ranges::copy(memory.at(fmt::format("products {:02}", v)), product_[v].begin());
  }
  std::ranges::copy(memory.at("products with gradient"), with_gradient_.begin());
}

}  // namespace lichtenberg::minimize
