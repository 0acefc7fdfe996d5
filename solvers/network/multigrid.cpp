#include "solvers/network/multigrid.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <utility>

namespace lichtenberg::network {
namespace {

using Vector = Eigen::VectorXd;

/// Equations of the nodes that are not electrodes: sum_j g_ij (v_i - v_j) + ground_i v_i = fed_i.
struct Level {
  std::vector<int> start, neighbour;
  std::vector<double> conductance;  ///< Conductance to each neighbour
  Vector diagonal;                  ///< Sum of a node's conductances, including that to ground
  std::vector<int> coarse;          ///< Node on the next level, -1: smoothed only
  mutable Vector residual, correction;

  int size() const { return static_cast<int>(diagonal.size()); }
  double row(int i, const Vector& v) const {
    double sum = 0;
    for (int e = start[i]; e < start[i + 1]; ++e) sum += conductance[e] * v[neighbour[e]];
    return sum;
  }
  void multiply(const Vector& v, Vector& result) const {
    result.resize(size());
    for (int i = 0; i < size(); ++i) result[i] = diagonal[i] * v[i] - row(i, v);
  }
};

/// Returns the nodes in breadth-first order, so that neighbours are close in memory.
std::vector<int> breadth_first_order(const Network& network, int from) {
  const Incidence incidence(network);
  std::vector<int> order{from};
  std::vector<char> seen(network.nodes, 0);
  seen[from] = 1;
  order.reserve(network.nodes);
  for (std::size_t k = 0; k < order.size(); ++k)
    for (const int link : incidence.of(order[k])) {
      const int next = other_end(network.links[link], order[k]);
      if (std::exchange(seen[next], 1) == 0) order.push_back(next);
    }
  return order;
}

struct Entry {
  int row, column;
  double conductance;
};

/// Fills the rows from entries in any order; entries with the same indices are added up.
void fill(Level& level, int n, const std::vector<Entry>& entries) {
  std::vector<int> end(n + 1, 0);
  for (const Entry& e : entries) ++end[e.row + 1];
  for (int i = 0; i < n; ++i) end[i + 1] += end[i];
  std::vector<std::pair<int, double>> sorted(entries.size());
  std::vector<int> next(end.begin(), end.end() - 1);
  for (const Entry& e : entries) sorted[next[e.row]++] = {e.column, e.conductance};
  std::vector<int> slot(n, -1);
  level.start.assign(1, 0);
  for (int i = 0; i < n; ++i) {
    const int begin = level.start.back();
    for (int k = end[i]; k < end[i + 1]; ++k) {
      const auto [column, g] = sorted[k];
      if (slot[column] < begin) {
        slot[column] = static_cast<int>(level.neighbour.size());
        level.neighbour.push_back(column);
        level.conductance.push_back(0);
      }
      level.conductance[slot[column]] += g;
    }
    level.start.push_back(static_cast<int>(level.neighbour.size()));
  }
}

/// Merges nodes in pairs. Each unpaired node joins the unpaired neighbour of largest conductance, unless this is small
/// compared to the node's largest. A node whose neighbours are all paired joins the pair of the strongest; otherwise
/// merging would stop on networks with few loops. A node that is mostly grounded needs no coarse level (Notay 2010).
std::vector<int> pairs(const Level& level, int& number) {
  constexpr double mostly = 0.8, strong = 0.25;
  constexpr int single = -2;
  std::vector<int> coarse(level.size(), single);
  number = 0;
  for (int i = 0; i < level.size(); ++i) {
    if (coarse[i] != single) continue;
    double linked = 0, largest = 0, best = 0;
    int partner = -1, strongest = -1;
    for (int e = level.start[i]; e < level.start[i + 1]; ++e) {
      const double g = level.conductance[e];
      const int other = level.neighbour[e];
      linked += g;
      if (g > largest && coarse[other] != -1) largest = g, strongest = other;
      if (g > best && coarse[other] == single) best = g, partner = other;
    }
    if (linked < (1 - mostly) * level.diagonal[i]) {
      coarse[i] = -1;
    } else if (partner >= 0 && best >= strong * largest) {
      coarse[i] = coarse[partner] = number++;
    } else {
      coarse[i] = strongest >= 0 && coarse[strongest] >= 0 ? coarse[strongest] : number++;
    }
  }
  return coarse;
}

/// Returns the network of the merged nodes (Galerkin, with a constant on each).
Level merged(const Level& fine, const std::vector<int>& coarse, int number) {
  std::vector<Entry> entries;
  entries.reserve(fine.neighbour.size());
  Level result;
  result.diagonal = Vector::Zero(number);
  for (int i = 0; i < fine.size(); ++i) {
    const int a = coarse[i];
    if (a < 0) continue;
    result.diagonal[a] += fine.diagonal[i];
    for (int e = fine.start[i]; e < fine.start[i + 1]; ++e) {
      const int b = coarse[fine.neighbour[e]];
      if (b == a)
        result.diagonal[a] -= fine.conductance[e];
      else if (b >= 0)
        entries.push_back({a, b, fine.conductance[e]});
    }
  }
  fill(result, number, entries);
  return result;
}

class Hierarchy {
 public:
  explicit Hierarchy(Level finest) {
    levels_.push_back(std::move(finest));
    constexpr int small = 300;
    while (levels_.back().size() > small) {
      Level& fine = levels_.back();
      int half = 0, quarter = 0;
      const std::vector<int> once = pairs(fine, half);
      const Level between = merged(fine, once, half);
      const std::vector<int> twice = pairs(between, quarter);
      if (quarter > 0.9 * fine.size()) break;
      fine.coarse = once;
      for (int& c : fine.coarse)
        if (c >= 0) c = twice[c];
      Level next = merged(between, twice, quarter);
      levels_.push_back(std::move(next));
    }
    const Level& last = levels_.back();
    Eigen::MatrixXd dense = last.diagonal.asDiagonal();
    for (int i = 0; i < last.size(); ++i)
      for (int e = last.start[i]; e < last.start[i + 1]; ++e) dense(i, last.neighbour[e]) -= last.conductance[e];
    coarsest_.compute(dense);
  }

  const Level& finest() const { return levels_.front(); }
  int levels() const { return static_cast<int>(levels_.size()); }

  /// Applies one K-cycle: x ~ A^-1 r.
  void precondition(const Vector& r, Vector& x, std::size_t l = 0) const {
    if (l + 1 == levels_.size()) {
      x = coarsest_.solve(r);
      return;
    }
    const Level &level = levels_[l], &next = levels_[l + 1];
    x.setZero(level.size());
    for (int i = 0; i < level.size(); ++i) x[i] = (r[i] + row_before(level, i, x)) / level.diagonal[i];
    Vector coarse = Vector::Zero(next.size());
    for (int i = 0; i < level.size(); ++i)
      if (level.coarse[i] >= 0) coarse[level.coarse[i]] += r[i] - level.diagonal[i] * x[i] + level.row(i, x);
    Vector correction;
    improve(coarse, correction, l + 1);
    for (int i = 0; i < level.size(); ++i)
      if (level.coarse[i] >= 0) x[i] += correction[level.coarse[i]];
    for (int i = level.size() - 1; i >= 0; --i) x[i] = (r[i] + level.row(i, x)) / level.diagonal[i];
  }

 private:
  /// Returns the row sum over the nodes before i: x starts at 0, so the later ones contribute nothing.
  static double row_before(const Level& level, int i, const Vector& x) {
    double sum = 0;
    for (int e = level.start[i]; e < level.start[i + 1]; ++e)
      if (level.neighbour[e] < i) sum += level.conductance[e] * x[level.neighbour[e]];
    return sum;
  }

  /// Performs two steps of flexible conjugate gradients, or one if it suffices (Notay 2010, algorithm 3.2).
  void improve(const Vector& r, Vector& x, std::size_t l) const {
    if (l + 1 == levels_.size()) return precondition(r, x, l);
    Vector c, v, d, w;
    precondition(r, c, l);
    levels_[l].multiply(c, v);
    const double rho1 = c.dot(v), alpha1 = c.dot(r);
    if (rho1 <= 0) {
      x = c;
      return;
    }
    const Vector rest = r - alpha1 / rho1 * v;
    if (rest.squaredNorm() <= 0.0625 * r.squaredNorm()) {
      x = alpha1 / rho1 * c;
      return;
    }
    precondition(rest, d, l);
    levels_[l].multiply(d, w);
    const double gamma = d.dot(v), beta = d.dot(w), alpha2 = d.dot(rest), rho2 = beta - gamma * gamma / rho1;
    if (rho2 <= 0) {
      x = alpha1 / rho1 * c;
      return;
    }
    x = (alpha1 / rho1 - gamma * alpha2 / (rho1 * rho2)) * c + alpha2 / rho2 * d;
  }

  std::vector<Level> levels_;
  Eigen::LLT<Eigen::MatrixXd> coarsest_;
};

/// Equations of all nodes except the two electrodes, in breadth-first order, and the currents from those.
struct InnerEquations {
  std::vector<int> order;
  Level finest;
  Vector injected;
};

InnerEquations inner_equations(const Network& network, int low, int high, double voltage) {
  InnerEquations result;
  std::vector<int>& order = result.order;
  std::vector<int> number(network.nodes, -1);
  order = breadth_first_order(network, low);
  std::erase_if(order, [&](int n) { return n == low || n == high; });
  const int n = static_cast<int>(order.size());
  for (int k = 0; k < n; ++k) number[order[k]] = k;
  result.finest.diagonal = result.injected = Vector::Zero(n);
  std::vector<Entry> entries;
  entries.reserve(2 * network.links.size());
  for (const Link& link : network.links) {
    const int a = number[link.a], b = number[link.b];
    if (link.a == link.b) continue;
    if (a >= 0) result.finest.diagonal[a] += link.conductance;
    if (b >= 0) result.finest.diagonal[b] += link.conductance;
    if (a >= 0 && b >= 0) {
      entries.push_back({a, b, link.conductance});
      entries.push_back({b, a, link.conductance});
    } else {
      if (a >= 0 && link.b == high) result.injected[a] += link.conductance * voltage;
      if (b >= 0 && link.a == high) result.injected[b] += link.conductance * voltage;
    }
  }
  fill(result.finest, n, entries);
  return result;
}

/// Solves by flexible conjugate gradients, since the preconditioner is not a fixed linear map. Returns the potentials.
Vector conjugate_gradients(const Hierarchy& hierarchy, const Vector& injected, double voltage, double tolerance,
                           MultigridSolution& result) {
  const Level& a = hierarchy.finest();
  Vector v = Vector::Zero(injected.size()), r = injected, z, p, ap;
  double last_pap = 0;
  constexpr int most = 200;
  for (result.iterations = 0;; ++result.iterations) {
    result.imbalance = r.lpNorm<1>();
    const double current = std::abs(injected.sum() - (injected.array() * v.array()).sum() / voltage);
    if (result.iterations > 0 && result.imbalance <= tolerance * current) return v;
    result.converged = result.iterations < most;
    if (!result.converged) return v;
    hierarchy.precondition(r, z);
    p = result.iterations == 0 ? z : Vector(z - z.dot(ap) / last_pap * p);
    a.multiply(p, ap);
    last_pap = p.dot(ap);
    const double step = p.dot(r) / last_pap;
    v += step * p;
    r -= step * ap;
  }
}

}  // namespace

MultigridSolution solve_by_multigrid(const Network& network, int low, int high, double voltage, double tolerance) {
  MultigridSolution result{.potential = std::vector<double>(network.nodes, 0)};
  result.potential[high] = voltage;
  InnerEquations equations = inner_equations(network, low, high, voltage);
  if (equations.order.empty()) return result;
  const Hierarchy hierarchy(std::move(equations.finest));
  result.levels = hierarchy.levels();
  const Vector v = conjugate_gradients(hierarchy, equations.injected, voltage, tolerance, result);
  for (std::size_t k = 0; k < equations.order.size(); ++k) result.potential[equations.order[k]] = v[k];
  return result;
}

}  // namespace lichtenberg::network
