#include "solvers/laplace/spheres/reflections.hpp"

#include <algorithm>
#include <cmath>

#include "solvers/laplace/spheres/results.hpp"

namespace lichtenberg::laplace::spheres {
namespace {

/// Factors g_tl of one m, for t from m to the degree and increasing l.
class TranslationFactors {
 public:
  TranslationFactors(const Site& small, const Site& large, double distance, int m, int l)
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
void add_products(TranslationFactors factors, int m, int degree, double* sum) {
  constexpr double rounding = 1e-18;
  const int side = degree + 1;
  for (bool continues = true; continues; factors.advance()) {
    continues = factors.growth(degree) >= 1;
    for (int t = m; t <= degree; ++t) {
      for (int s = m; s <= t; ++s) sum[t * side + s] += factors[t] * factors[s];
      continues = continues || factors[t] * factors[t] > rounding * (1 - factors.growth(t)) * sum[t * side + t];
    }
  }
}

/// Returns the target's local coefficients due to the source's multipoles, up to the target's degree.
std::vector<double> local_coefficients(const Site& target, const Site& source, Vec3 displacement,
                                       const double* multipoles) {
  std::vector<double> local(harmonics(target.degree));
  NearField({target}, {source}, {{.displacement = displacement}}, 1e-300, parallel::Team::single())
      .add(multipoles, local.data(), parallel::Team::single());
  return local;
}

std::vector<double> negative(std::vector<double> local) {
  for (double& value : local) value = -value;
  return local;
}

}  // namespace

Reflection reflection_of(const NearPair& to_small, const Site& small, const Site& large) {
  Reflection reflection{to_small.target, to_small.source, to_small.displacement, small.degree, {}};
  const int side = small.degree + 1;
  const double distance = norm(to_small.displacement);
  reflection.factor.assign(static_cast<std::size_t>(side) * side * side, 0);
  for (int m = 0; m <= small.degree; ++m) {
    double* w = reflection.factor.data() + static_cast<std::size_t>(m) * side * side;
    add_products(TranslationFactors(small, large, distance, m, std::max(large.degree + 1, m)), m, small.degree, w);
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
  PairDirections directions;
  for (int k = 0; k < lanes; ++k) directions.set(k, reflection.displacement);
  translation_up_to(reflection.degree)
      ->in_pair_frame(directions, reflection.degree, reflection.factor.data(), value.data(), scratch.data());
  for (int h = 0; h < size; ++h) local[h] -= value[h];
}

void add_reflection(const Reflection& reflection, const double* multipoles, double* local) {
  const int size = harmonics(reflection.degree);
  std::vector<Lanes> from(size), to(size);
  for (int h = 0; h < size; ++h) from[h] = Lanes{} + multipoles[h];
  add_reflection(reflection, from.data(), to.data());
  for (int h = 0; h < size; ++h) local[h] += to[h][0];
}

double omitted_interaction(const NearPair& one, const NearPair& other, const std::vector<Site>& sites, int degree) {
  constexpr double higher_degree_factor = 4;
  const Site& large = sites[one.source];
  const double ratio = large.radius * large.radius / (norm(one.displacement) * norm(other.displacement));
  const double small = std::sqrt(sites[one.target].radius * sites[other.target].radius);
  return higher_degree_factor * small / large.radius * std::pow(ratio, degree + 2) / (1 - ratio);
}

Vec3 force_on_large(const Reflection& reflection, const std::vector<Site>& sites, const std::vector<int>& start,
                    const double* multipoles) {
  const Site &small = sites[reflection.small], &large = sites[reflection.large];
  const double *small_multipoles = multipoles + start[reflection.small],
               *large_multipoles = multipoles + start[reflection.large];
  std::vector<double> on_small = local_coefficients(small, large, reflection.displacement, large_multipoles);
  add_reflection(reflection, small_multipoles, on_small.data());
  const std::vector<double> on_large =
      local_coefficients(large, small, reflection.displacement * -1.0, small_multipoles);
  return (force(small_multipoles, small.degree, negative(on_small).data(), small.degree) +
          force(large_multipoles, large.degree, negative(on_large).data(), large.degree)) *
         -1.0;
}

}  // namespace lichtenberg::laplace::spheres
