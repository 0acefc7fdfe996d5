#include "solvers/periodic/window.hpp"

#include <algorithm>
#include <cmath>

#include "solvers/periodic/cloud.hpp"

namespace lichtenberg::periodic {

namespace {

using Polynomial = std::vector<double>;  ///< Coefficients of s^d

constexpr int lowest_order = 4, highest_order = 8;

double value(const Polynomial& of, double s) {
  double sum = 0;
  for (auto term = of.rbegin(); term != of.rend(); ++term) sum = sum * s + *term;
  return sum;
}

Polynomial integral(const Polynomial& of) {
  Polynomial result{0};
  for (std::size_t d = 0; d < of.size(); ++d) result.push_back(of[d] / static_cast<double>(d + 1));
  return result;
}

void add(Polynomial& to, double factor, const Polynomial& of) {
  to.resize(std::max(to.size(), of.size()));
  for (std::size_t d = 0; d < of.size(); ++d) to[d] += factor * of[d];
}

/// Returns the interpolation polynomial through the points, in Newton's form.
Polynomial through(const std::vector<double>& s, std::vector<double> values) {
  const int terms = static_cast<int>(s.size());
  for (int order = 1; order < terms; ++order)
    for (int n = terms - 1; n >= order; --n) values[n] = (values[n] - values[n - 1]) / (s[n] - s[n - order]);
  Polynomial result{values[terms - 1]};
  for (int n = terms - 2; n >= 0; --n) {
    Polynomial next{values[n]};
    for (std::size_t d = 0; d < result.size(); ++d) {
      next.resize(std::max(next.size(), d + 2));
      next[d] -= s[n] * result[d];
      next[d + 1] += result[d];
    }
    result = next;
  }
  return result;
}

/// Returns a prolate function `spacings` wide as a polynomial of the given degree for each spacing.
std::vector<Polynomial> prolate_pieces(int spacings, double band_limit, int degree) {
  const Cloud psi = prolate_cloud(band_limit * M_PI * spacings, 1);
  std::vector<double> nodes;
  for (int n = 0; n <= degree; ++n) nodes.push_back(0.5 * std::cos(M_PI * (n + 0.5) / (degree + 1)));
  std::vector<Polynomial> pieces;
  for (int j = 0; j < spacings; ++j) {
    std::vector<double> values;
    for (const double s : nodes)
      values.push_back(psi.transform(std::abs(j + 0.5 + s - 0.5 * spacings) * 2 / spacings * psi.band_limit));
    pieces.push_back(through(nodes, values));
  }
  return pieces;
}

/// Convolves a function with a box one spacing wide: each new piece is an integral over parts of two old ones.
std::vector<Polynomial> folded(const std::vector<Polynomial>& pieces) {
  std::vector<Polynomial> result(pieces.size() + 1, Polynomial{0});
  for (std::size_t j = 0; j < pieces.size(); ++j) {
    const Polynomial sum = integral(pieces[j]);
    add(result[j], 1, sum);
    result[j][0] -= value(sum, -0.5);
    add(result[j + 1], -1, sum);
    result[j + 1][0] += value(sum, 0.5);
  }
  return result;
}

/// Function with which the boxes are convolved, and the number of boxes.
struct Core {
  int boxes;
  std::vector<Polynomial> pieces;
};

Core prolate_core(int order, ProlateRecipe recipe) {
  const int rest = order - recipe.boxes;
  return {recipe.boxes, prolate_pieces(rest, recipe.band_limit, rest - 1)};
}

double total(const std::vector<Polynomial>& pieces) {
  double sum = 0;
  for (const Polynomial& piece : pieces) {
    const Polynomial of = integral(piece);
    sum += value(of, 0.5) - value(of, -0.5);
  }
  return sum;
}

}  // namespace

/// The recipes have the least mesh_error at the spacings of accuracies from 1e-2 (order 4) to 1e-6 (order 8).
ProlateRecipe prolate_recipe(int order) {
  constexpr ProlateRecipe recipes[] = {{1, 0.64}, {2, 0.64}, {2, 0.67}, {3, 0.66}, {4, 0.68}};
  return recipes[order - lowest_order];
}

std::vector<std::vector<double>> window_pieces(Window window, int order) {
  auto [boxes, pieces] = window == Window::spline ? Core{order - 1, {{1}}} : prolate_core(order, prolate_recipe(order));
  const double size = total(pieces);
  for (int n = 0; n < boxes; ++n) pieces = folded(pieces);
  std::vector<std::vector<double>> weights(pieces.front().size(), std::vector<double>(order));
  for (int c = 0; c < order; ++c)
    for (std::size_t d = 0; d < weights.size(); ++d) weights[d][c] = pieces[order - 1 - c][d] / size;
  return weights;
}

const WindowTransform& WindowTransform::of(Window window, int order) {
  static const std::vector<WindowTransform> all = [] {
    std::vector<WindowTransform> made;
    for (int n = lowest_order; n <= highest_order; ++n) made.push_back(WindowTransform(n));
    for (int n = lowest_order; n <= highest_order; ++n) made.push_back(WindowTransform(n, prolate_recipe(n)));
    return made;
  }();
  return all[(window == Window::spline ? 0 : highest_order - lowest_order + 1) + order - lowest_order];
}

WindowTransform::WindowTransform(int order, ProlateRecipe recipe) : boxes_(recipe.boxes) {
  // Six-point Gauss quadrature is exact for polynomials up to degree 11. It integrates cos(k s) for k up to
  // (`far_aliases` + 1/2) 2 pi / spacing, of which k below pi / spacing matters most.
  constexpr double at[] = {0.2386191860831969, 0.6612093864662645, 0.9324695142031521};
  constexpr double weights[] = {0.4679139345726910, 0.3607615730481386, 0.1713244923791704};
  const std::vector<Polynomial> pieces = prolate_core(order, recipe).pieces;
  constexpr int parts = 4;  // Parts of a spacing
  const double middle = 0.5 * static_cast<double>(pieces.size()), size = total(pieces);
  for (std::size_t j = 0; j < pieces.size(); ++j)
    for (int part = 0; part < parts; ++part)
      for (int n = 0; n < 6; ++n) {
        const double s = (part + 0.5 + (n % 2 == 0 ? 0.5 : -0.5) * at[n / 2]) / parts - 0.5;
        const double x = static_cast<double>(j) + 0.5 - middle + s;
        if (x < 0) continue;  // The window is even
        nodes_.push_back(
            {x, weights[n / 2] / parts * value(pieces[j], s) / size, std::cos(2 * M_PI * x), std::sin(2 * M_PI * x)});
      }
  fill_sample();
}

void WindowTransform::fill_sample() {
  for (int mode = 0; mode <= sample_points / 2; ++mode) sample_[mode] = (*this)(2 * M_PI * mode / sample_points);
}

WindowTransform::Aliases WindowTransform::operator()(double k) const {
  Aliases result{};
  if (nodes_.empty()) result.fill(1);
  for (const Node& node : nodes_) {
    double re = std::cos((k - 2 * M_PI * far_aliases) * node.position),
           im = std::sin((k - 2 * M_PI * far_aliases) * node.position);
    for (double& sum : result) {
      sum += node.weight * re;
      const double next = re * node.cosine - im * node.sine;
      im = re * node.sine + im * node.cosine;
      re = next;
    }
  }
  for (int m = -far_aliases; m <= far_aliases; ++m) {
    const double phase = 0.5 * k + M_PI * m;
    if (phase != 0) result[m + far_aliases] *= std::pow(std::sin(phase) / phase, boxes_);
  }
  return result;
}

}  // namespace lichtenberg::periodic
