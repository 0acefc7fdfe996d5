#include "solvers/network/elimination.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

namespace lichtenberg::network {
namespace {

/// Eliminates the first `stars` nodes of a dense network of m nodes by star-mesh transformations. `g`: [m, m],
/// column-major, with conductances below the diagonal. Column k is overwritten by the conductances of node k at its
/// elimination, with their sum s_k on the diagonal. The last m - stars columns become the remaining mesh. Other
/// diagonal entries are not conductances and are never read.
void eliminate_stars(double* g, int m, int stars) {
  constexpr int block = 48;         // Number of columns that stay in the cache during their elimination
  constexpr int worth_a_call = 24;  // Number of columns from which Eigen's blocked product is faster than a loop
  const auto spread = [&](int k, int from, int to) {  // Adds the mesh of star k in columns from ... to - 1
    const double* star = g + std::size_t(k) * m;
    for (int j = from; j < to; ++j) {
      const double share = star[j] / star[k];
      if (share == 0) continue;
      double* column = g + std::size_t(j) * m;
      for (int i = j + 1; i < m; ++i) column[i] += share * star[i];
    }
  };
  for (int begin = 0; begin < stars; begin += block) {
    const int end = std::min(begin + block, stars);
    const bool by_product = m - end >= worth_a_call && end - begin >= 4;
    for (int k = begin; k < end; ++k) {
      double* star = g + std::size_t(k) * m;
      double sum = 0;
      for (int i = k + 1; i < m; ++i) sum += star[i];
      star[k] = sum;
      spread(k, k + 1, by_product ? end : m);
    }
    if (!by_product) continue;
    const int rest = m - end;
    Eigen::Map<Eigen::MatrixXd, 0, Eigen::OuterStride<>> all(g, m, m, Eigen::OuterStride<>(m));
    Eigen::MatrixXd roots = all.block(end, begin, rest, end - begin);
    for (int k = begin; k < end; ++k) roots.col(k - begin) /= std::sqrt(all(k, k));
    all.block(end, end, rest, rest).selfadjointView<Eigen::Lower>().rankUpdate(roots);
  }
}

}  // namespace

/// Links by their earlier end, with both ends numbered in the order of elimination.
struct Elimination::ForwardLinks {
  std::vector<int> start, number;
  std::vector<double> conductance;

  ForwardLinks(const Network& network, const std::vector<int>& order) : start(network.nodes + 1, 0) {
    std::vector<int> number_of(network.nodes);
    for (int k = 0; k < network.nodes; ++k) number_of[order[k]] = k;
    for (const Link& link : network.links)
      if (link.a != link.b) ++start[std::min(number_of[link.a], number_of[link.b])];
    int sum = 0;
    for (int& s : start) sum += s, s = sum;
    number.resize(sum);
    conductance.resize(sum);
    for (const Link& link : network.links) {
      if (link.a == link.b) continue;
      const auto [earlier, later] = std::minmax(number_of[link.a], number_of[link.b]);
      const int slot = --start[earlier];
      number[slot] = later;
      conductance[slot] = link.conductance;
    }
  }
};

/// Construction of an elimination, with its temporary data.
class Elimination::Run {
 public:
  Run(Elimination& result, const Network& network)
      : r_(result), forward_(network, result.dissection_.order), local_(network.nodes, -1) {}

  /// Finds the later nodes that each front joins, and from these the sizes of all arrays.
  void symbolic() {
    std::vector<int> waiting;  // Fronts whose results have not been taken in yet
    r_.border_start_ = {0};
    r_.factor_start_ = {0};
    for (std::size_t f = 0; f < r_.dissection_.fronts.size(); ++f) {
      const auto [first, last, children] = r_.dissection_.fronts[f];
      const auto begin = static_cast<std::ptrdiff_t>(r_.border_.size());
      const auto add = [&](int n) {
        if (n < last || local_[n] == static_cast<int>(f)) return;
        local_[n] = static_cast<int>(f);
        r_.border_.push_back(n);
      };
      for (int e = forward_.start[first]; e < forward_.start[last]; ++e) add(forward_.number[e]);
      for (int c = 0; c < children; ++c) {
        for (int b = r_.border_start_[waiting.back()]; b < r_.border_start_[waiting.back() + 1]; ++b)
          add(r_.border_[b]);
        waiting.pop_back();
      }
      waiting.push_back(static_cast<int>(f));
      std::sort(r_.border_.begin() + begin, r_.border_.end());
      r_.border_start_.push_back(static_cast<int>(r_.border_.size()));
      const double s = last - first, m = s + r_.border(static_cast<int>(f));
      largest_ = std::max(largest_, static_cast<int>(m));
      r_.factor_start_.push_back(r_.factor_start_.back() + static_cast<std::int64_t>(s * m));
      for (double k = 0; k < s; ++k) r_.operations_ += (m - k - 1) * (m - k - 1);
    }
  }

  /// Returns the bytes of the factor and of the largest front with its children's results, which are about as large
  /// again.
  double bytes() const {
    return 8.0 * (static_cast<double>(r_.factor_start_.back()) + 3.0 * largest_ * largest_) + 4.0 * r_.border_.size();
  }

  void numeric() {
    r_.factor_.resize(r_.factor_start_.back());
    front_.resize(std::size_t(largest_) * largest_);
    for (std::size_t f = 0; f < r_.dissection_.fronts.size(); ++f) {
      assemble(static_cast<int>(f));
      const int s = r_.size(static_cast<int>(f)), m = s + r_.border(static_cast<int>(f));
      eliminate_stars(front_.data(), m, s);
      std::copy_n(front_.begin(), std::size_t(s) * m, r_.factor_.begin() + r_.factor_start_[f]);
      push(static_cast<int>(f), s, m);
    }
    finish();
  }

 private:
  /// Assembles a front from its own links and its children's results.
  void assemble(int f) {
    const auto [first, last, children] = r_.dissection_.fronts[f];
    const int s = last - first, m = s + r_.border(f);
    for (int k = 0; k < s; ++k) local_[first + k] = k;
    for (int b = 0; b < m - s; ++b) local_[r_.border_[r_.border_start_[f] + b]] = s + b;
    std::fill_n(front_.begin(), std::size_t(m) * m, 0.0);
    for (int k = 0; k < s; ++k)
      for (int e = forward_.start[first + k]; e < forward_.start[first + k + 1]; ++e)
        front_[std::size_t(k) * m + local_[forward_.number[e]]] += forward_.conductance[e];
    for (int c = 0; c < children; ++c) take_in(front_.data(), m);
  }

  /// Adds the last pending result to a dense network of m nodes; local_ maps nodes to its rows.
  void take_in(double* into, int m) {
    const int child = waiting_.back();
    waiting_.pop_back();
    const int n = r_.border(child);
    const int* number = r_.border_.data() + r_.border_start_[child];
    row_.resize(n);
    for (int b = 0; b < n; ++b) row_[b] = local_[number[b]];
    const double* from = stack_.data() + stack_.size() - std::size_t(n) * n;
    for (int j = 0; j < n; ++j) {
      double* column = into + std::size_t(row_[j]) * m;
      for (int i = j + 1; i < n; ++i) column[row_[i]] += from[std::size_t(j) * n + i];
    }
    stack_.resize(stack_.size() - std::size_t(n) * n);
  }

  void push(int f, int s, int m) {
    const int n = m - s;
    const std::size_t end = stack_.size();
    stack_.resize(end + std::size_t(n) * n);
    for (int j = 0; j < n; ++j)
      std::copy_n(front_.begin() + std::size_t(s + j) * m + s, n, stack_.begin() + end + std::size_t(j) * n);
    waiting_.push_back(f);
  }

  /// Adds the remaining results to the mesh of the kept nodes.
  void finish() {
    const int kept = r_.kept_, first = r_.nodes_ - kept;
    Eigen::MatrixXd& mesh = r_.mesh_;
    mesh = Eigen::MatrixXd::Zero(kept, kept);
    for (int k = 0; k < kept; ++k) {
      local_[first + k] = k;
      for (int e = forward_.start[first + k]; e < forward_.start[first + k + 1]; ++e)
        mesh(forward_.number[e] - first, k) += forward_.conductance[e];
    }
    while (!waiting_.empty()) take_in(mesh.data(), kept);
    mesh.diagonal().setZero();
    mesh = Eigen::MatrixXd(mesh.selfadjointView<Eigen::Lower>());
  }

  Elimination& r_;
  ForwardLinks forward_;
  std::vector<int> local_, row_, waiting_;
  int largest_ = 0;
  std::vector<double> front_, stack_;
};

Elimination::Elimination(const Network& network, const std::vector<int>& kept, const Limits& limits)
    : nodes_(network.nodes), kept_(static_cast<int>(kept.size())) {
  std::vector<char> stays(network.nodes, 0);
  for (const int n : kept) stays[n] = 1;
  dissection_ = dissect(network, stays);
  std::copy(kept.begin(), kept.end(), dissection_.order.end() - kept_);
  Run run(*this, network);
  run.symbolic();
  done_ = operations_ <= limits.operations && run.bytes() <= limits.bytes;
  if (done_) run.numeric();
}

Eigen::MatrixXd Elimination::potentials(const Eigen::MatrixXd& kept_potential, const Eigen::MatrixXd& injected) const {
  const auto columns = kept_potential.cols();
  // Rows by number in the order of elimination: first the currents that reach a node, then its potential.
  Eigen::MatrixXd x = Eigen::MatrixXd::Zero(nodes_, columns);
  const int fronts = static_cast<int>(dissection_.fronts.size());
  const auto star = [&](int f, int k) {
    return factor_.data() + factor_start_[f] + std::int64_t(k) * (size(f) + border(f));
  };
  const auto number = [&](int f, int row) {
    return row < size(f) ? dissection_.fronts[f].first + row : border_[border_start_[f] + row - size(f)];
  };
  if (injected.size() > 0) {
    for (int k = 0; k < nodes_ - kept_; ++k) x.row(k) = injected.row(node(k));
    for (int f = 0; f < fronts; ++f)
      for (int k = 0; k < size(f); ++k)
        for (int i = k + 1; i < size(f) + border(f); ++i)
          x.row(number(f, i)) += star(f, k)[i] / star(f, k)[k] * x.row(dissection_.fronts[f].first + k);
  }
  x.bottomRows(kept_) = kept_potential;
  for (int f = fronts - 1; f >= 0; --f)
    for (int k = size(f) - 1; k >= 0; --k) {
      const double* g = star(f, k);
      auto mine = x.row(dissection_.fronts[f].first + k);
      for (int i = k + 1; i < size(f) + border(f); ++i) mine += g[i] * x.row(number(f, i));
      mine /= g[k];
    }
  Eigen::MatrixXd potential(nodes_, columns);
  for (int k = 0; k < nodes_; ++k) potential.row(node(k)) = x.row(k);
  return potential;
}

/// Returns the parent of each front (the front that adds its Schur complement), -1 if it has none.
std::vector<int> Elimination::parents() const {
  std::vector<int> parent(dissection_.fronts.size(), -1), waiting;
  for (std::size_t f = 0; f < parent.size(); ++f) {
    for (int c = 0; c < dissection_.fronts[f].children; ++c) {
      parent[waiting.back()] = static_cast<int>(f);
      waiting.pop_back();
    }
    waiting.push_back(static_cast<int>(f));
  }
  return parent;
}

/// Computes the rows and columns of the inverse for a front's own nodes, from the last to the first. The potential of a
/// star's centre is the mean of those of its ends with weights w. Hence Z_ki = sum_j w_j Z_ji, and Z_kk = 1 / s_k +
/// sum_i w_i Z_ki.
void Elimination::invert_stars(int front, Eigen::MatrixXd& inverse) const {
  const Eigen::Index m = inverse.rows();
  for (Eigen::Index k = size(front) - 1; k >= 0; --k) {
    const Eigen::Map<const Eigen::VectorXd> star(factor_.data() + factor_start_[front] + k * m, m);
    const Eigen::Index later = m - k - 1;
    const Eigen::VectorXd weight = star.tail(later) / star(k);
    inverse.col(k).tail(later) = inverse.bottomRightCorner(later, later) * weight;
    inverse.row(k).tail(later) = inverse.col(k).tail(later).transpose();
    inverse(k, k) = 1 / star(k) + weight.dot(inverse.col(k).tail(later));
  }
}

Eigen::VectorXd Elimination::resistances() const {
  Eigen::VectorXd result = Eigen::VectorXd::Zero(nodes_);
  const std::vector<int> parent = parents();
  std::vector<std::vector<int>> children(parent.size());
  for (std::size_t f = 0; f < parent.size(); ++f)
    if (parent[f] >= 0) children[parent[f]].push_back(static_cast<int>(f));
  std::vector<Eigen::MatrixXd> border_inverse(parent.size());  // Inverse of each front's border, taken from its parent
  std::vector<int> row(nodes_, -1), rows;
  for (int f = static_cast<int>(parent.size()) - 1; f >= 0; --f) {
    const int s = size(f), m = s + border(f);
    Eigen::MatrixXd inverse = Eigen::MatrixXd::Zero(m, m);
    if (border_inverse[f].size() > 0) inverse.bottomRightCorner(m - s, m - s) = border_inverse[f];
    border_inverse[f].resize(0, 0);
    invert_stars(f, inverse);
    const int first = dissection_.fronts[f].first;
    for (int k = 0; k < s; ++k) result(node(first + k)) = inverse(k, k), row[first + k] = k;
    for (int b = 0; b < m - s; ++b) row[border_[border_start_[f] + b]] = s + b;
    for (const int child : children[f]) {
      rows.clear();
      for (int b = border_start_[child]; b < border_start_[child + 1]; ++b) rows.push_back(row[border_[b]]);
      border_inverse[child] = inverse(rows, rows);
    }
  }
  return result;
}

}  // namespace lichtenberg::network
