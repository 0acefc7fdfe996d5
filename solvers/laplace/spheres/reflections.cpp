#include "solvers/laplace/spheres/reflections.hpp"

#include <algorithm>
#include <cmath>

#include "solvers/laplace/spheres/results.hpp"

namespace lichtenberg::laplace::spheres {
namespace {

/// Factors g_tl of one m, for t from m to the degree and increasing l.
class Links {
 public:
  Links(const Site& small, const Site& large, double distance, int m, int l)
      : m_(m), l_(l), ratio_(large.radius / distance), g_(small.degree + 1) {
    const auto log_factorial = [](int n) { return std::lgamma(n + 1.0); };
    for (int t = m; t <= small.degree; ++t)
      g_[t] =
          std::exp(log_factorial(l + t) -
                   0.5 * (log_factorial(l + m) + log_factorial(l - m) + log_factorial(t + m) + log_factorial(t - m)) +
                   (l + 1) * std::log(ratio_) + t * std::log(small.radius / distance));
  }
  double operator[](int t) const { return g_[t]; }
  double growth(int t) const { return ratio_ * (l_ + 1 + t) / std::sqrt((l_ + 1.0 + m_) * (l_ + 1.0 - m_)); }
  void advance() {
    for (int t = m_; t < static_cast<int>(g_.size()); ++t) g_[t] *= growth(t);
    ++l_;
  }

 private:
  int m_, l_;
  double ratio_;
  std::vector<double> g_;
};

/// Computes the sum over l of g_tl g_t'l, to rounding, into sum[t][t'].
void add_products(Links links, int m, int degree, double* sum) {
  constexpr double rounding = 1e-18;
  const int side = degree + 1;
  for (bool goes_on = true; goes_on; links.advance()) {
    goes_on = links.growth(degree) >= 1;
    for (int t = m; t <= degree; ++t) {
      for (int s = m; s <= t; ++s) sum[t * side + s] += links[t] * links[s];
      goes_on = goes_on || links[t] * links[t] > rounding * (1 - links.growth(t)) * sum[t * side + t];
    }
  }
}

/// Returns the target's local coefficients due to the source's multipoles, up to the target's degree.
std::vector<double> made_on(const Site& target, const Site& source, Vec3 way, const double* multipoles) {
  std::vector<double> local(harmonics(target.degree));
  NearField({target}, {source}, {{.way = way}}, 1e-300, parallel::Team::single())
      .add(multipoles, local.data(), parallel::Team::single());
  return local;
}

std::vector<double> negative(std::vector<double> local) {
  for (double& value : local) value = -value;
  return local;
}

}  // namespace

Reflection reflection_of(const NearPair& to_small, const Site& small, const Site& large) {
  Reflection reflection{to_small.target, to_small.source, to_small.way, small.degree, {}};
  const int side = small.degree + 1;
  const double distance = norm(to_small.way);
  reflection.factor.assign(static_cast<std::size_t>(side) * side * side, 0);
  for (int m = 0; m <= small.degree; ++m) {
    double* w = reflection.factor.data() + static_cast<std::size_t>(m) * side * side;
    add_products(Links(small, large, distance, m, std::max(large.degree + 1, m)), m, small.degree, w);
    for (int t = m; t <= small.degree; ++t)
      for (int s = m; s <= t; ++s) {
        const double sign = (t + s) & 1 ? -1 : 1;
        w[t * side + s] = w[s * side + t] = sign * small.radius / large.radius * w[t * side + s];
      }
  }
  return reflection;
}

void add_reflection(const Reflection& reflection, const Lanes* multipoles, Lanes* local) {
  const int size = harmonics(reflection.degree);
  std::vector<Lanes> value(multipoles, multipoles + size), scratch(size);
  Ways ways;
  for (int k = 0; k < lanes; ++k) ways.set(k, reflection.way);
  translation_up_to(reflection.degree)
      ->in_pair_frame(ways, reflection.degree, reflection.factor.data(), value.data(), scratch.data());
  for (int h = 0; h < size; ++h) local[h] -= value[h];
}

void add_reflection(const Reflection& reflection, const double* multipoles, double* local) {
  const int size = harmonics(reflection.degree);
  std::vector<Lanes> from(size), to(size);
  for (int h = 0; h < size; ++h) from[h] = Lanes{} + multipoles[h];
  add_reflection(reflection, from.data(), to.data());
  for (int h = 0; h < size; ++h) local[h] += to[h][0];
}

double carried_beyond(const NearPair& one, const NearPair& other, const std::vector<Site>& sites, int degree) {
  constexpr double of_higher_degrees = 4;
  const Site& large = sites[one.source];
  const double ratio = large.radius * large.radius / (norm(one.way) * norm(other.way));
  const double small = std::sqrt(sites[one.target].radius * sites[other.target].radius);
  return of_higher_degrees * small / large.radius * std::pow(ratio, degree + 2) / (1 - ratio);
}

Vec3 force_on_large(const Reflection& reflection, const std::vector<Site>& sites, const std::vector<int>& start,
                    const double* multipoles) {
  const Site &small = sites[reflection.small], &large = sites[reflection.large];
  const double *of_small = multipoles + start[reflection.small], *of_large = multipoles + start[reflection.large];
  std::vector<double> on_small = made_on(small, large, reflection.way, of_large);
  add_reflection(reflection, of_small, on_small.data());
  const std::vector<double> on_large = made_on(large, small, reflection.way * -1.0, of_small);
  return (force(of_small, small.degree, negative(on_small).data(), small.degree) +
          force(of_large, large.degree, negative(on_large).data(), large.degree)) *
         -1.0;
}

}  // namespace lichtenberg::laplace::spheres
