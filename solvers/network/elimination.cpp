#include "solvers/network/elimination.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <iterator>

#include "solvers/network/star_mesh.hpp"
#include "solvers/parallel/ranges.hpp"

namespace lichtenberg::network {
namespace {

using Border = std::span<const int>;

/// Returns the number of pairs of n nodes.
std::size_t pairs_of(std::size_t n) { return n * (n - 1) / 2; }

/// Returns where column k of a lower triangle with m rows begins, with columns stored contiguously.
std::int64_t start_of_column(std::int64_t k, std::int64_t m) { return k * m - k * (k - 1) / 2; }

/// Calls act(k) for each column k of a dense block, on threads if there are many.
template <class Act>
void for_each_column(int columns, parallel::Team& team, const Act& act) {
  parallel::for_each_range<256>(columns, team, [&](int first, int last) {
    for (int k = first; k < last; ++k) act(k);
  });
}

}  // namespace

/// Array whose values are not initialized, and which keeps its memory.
class Elimination::Buffer {
 public:
  /// Returns at least `size` elements. Values are lost if it allocates memory.
  double* get(std::size_t size) {
    if (size > size_) data_ = std::make_unique_for_overwrite<double[]>(size_ = size);
    return data_.get();
  }
  double* data() const { return data_.get(); }

 private:
  std::unique_ptr<double[]> data_;
  std::size_t size_ = 0;
};

/// Consecutive fronts: a subtree of the dissection, which one thread eliminates, or one front above all subtrees.
struct Elimination::Block {
  int first = 0, last = 0;  ///< Fronts [first, last)
  bool subtree = true;
  std::vector<int> border_start{0}, border{};  ///< Per front: the later nodes that its elimination joins, ascending
  std::vector<std::int64_t> factor_start{0};   ///< Start of each front in the factor
  std::size_t peak = 0;                        ///< Entries of the Results of a subtree
  Buffer factor{};  ///< Per front: lower triangle of its columns, with s_k on the diagonal; empty: not stored

  Border border_of(int front) const {
    const int f = front - first;
    return {border.data() + border_start[f], static_cast<std::size_t>(border_start[f + 1] - border_start[f])};
  }
};

/// Front: the nodes with the numbers first ... first + size - 1, which are eliminated, and its border.
struct Elimination::Front {
  int first = 0, size = 0;
  Border border{};
  double* factor = nullptr;

  Front(const Elimination& e, const Block& block, int f, double* factor_of_block)
      : first(e.dissection_.fronts[f].first),
        size(e.dissection_.fronts[f].last - first),
        border(block.border_of(f)),
        factor(factor_of_block == nullptr ? nullptr : factor_of_block + block.factor_start[f - block.first]) {}
  /// Front of the kept nodes.
  explicit Front(const Elimination& e) : first(e.network_.nodes - e.kept_), size(e.kept_) {}

  int rows() const { return size + static_cast<int>(border.size()); }
  /// Returns the conductances of star k from its diagonal on, [rows() - k].
  double* star(int k) const { return factor + start_of_column(k, rows()); }
  /// Finds the rows of nodes with ascending numbers.
  void find_rows(Border numbers, int* row) const {
    auto at = border.begin();
    for (const int n : numbers) {
      if (n >= first + size)
        while (*at != n) ++at;
      *row++ = n < first + size ? n - first : size + static_cast<int>(at - border.begin());
    }
  }
  /// Returns the row of the node with this number.
  int row(int number) const {
    return number < first + size ? number - first
                                 : size + static_cast<int>(std::ranges::lower_bound(border, number) - border.begin());
  }
};

/// Meshes on the borders of fronts that no later front has taken in yet. Each is stored as its entries below the
/// diagonal, by columns.
struct Elimination::Results {
  std::vector<Border> borders{};
  Buffer mesh{};
  std::size_t used = 0;

  double* add(Border border) {
    borders.push_back(border);
    used += pairs_of(border.size());
    return mesh.data() + used - pairs_of(border.size());
  }
  /// Returns the last mesh, which is valid until a mesh is added.
  const double* pop() {
    used -= pairs_of(borders.back().size());
    borders.pop_back();
    return mesh.data() + used;
  }
  /// Moves all meshes of `other` to the end.
  void append(Results& other) {
    std::copy_n(other.mesh.data(), other.used, mesh.data() + used);
    borders.insert(borders.end(), other.borders.begin(), other.borders.end());
    used += other.used;
    other.clear();
  }
  void clear() {
    borders.clear();
    used = 0;
  }
};

/// Memory of a task.
struct Elimination::Workspace {
  Buffer front{}, factor{};
  Results results{};
};

/// Finds the later nodes that each front joins, and from these the sizes of all arrays.
class Elimination::Sizes {
 public:
  explicit Sizes(Elimination& elimination) : e_(elimination) {
    std::vector<Waiting> subtree(e_.blocks_.size());
    e_.team_.for_each(static_cast<int>(subtree.size()), [&](int b) {
      if (e_.blocks_[b].subtree) find(e_.blocks_[b], subtree[b]);
    });
    for (std::size_t b = 0; b < subtree.size(); ++b) {
      Block& block = e_.blocks_[b];
      if (block.subtree)
        all_.take(subtree[b]);
      else
        find(block, all_);
      block.peak = subtree[b].peak;
      (block.subtree ? below_ : above_) += block.factor_start.back();
    }
    e_.entries_ = above_ + below_;
  }

  /// Returns the bytes of the factor, the largest front and the meshes that wait.
  double bytes(bool with_subtrees) const {
    const double largest = all_.largest, factor = static_cast<double>(above_ + (with_subtrees ? below_ : 0));
    return 8 * (factor + largest * largest + static_cast<double>(all_.peak));
  }
  std::size_t peak() const { return all_.peak; }
  double operations() const { return all_.operations; }

 private:
  /// Fronts that no later front has taken in yet, and the cost until then.
  struct Waiting {
    std::vector<std::pair<const Block*, int>> fronts;
    std::size_t entries = 0, peak = 0;
    int largest = 0;
    double operations = 0;

    void push(const Block& block, int front) {
      fronts.emplace_back(&block, front);
      entries += pairs_of(block.border_of(front).size());
      peak = std::max(peak, entries);
    }
    Border pop() {
      const auto [block, front] = fronts.back();
      fronts.pop_back();
      entries -= pairs_of(block->border_of(front).size());
      return block->border_of(front);
    }
    void take(const Waiting& subtree) {
      for (const auto& [block, front] : subtree.fronts) push(*block, front);
      largest = std::max(largest, subtree.largest);
      operations += subtree.operations;
    }
  };

  void find(Block& block, Waiting& waiting) const {
    std::vector<int> joined, more;
    for (int f = block.first; f < block.last; ++f) {
      const auto [first, last, children] = e_.dissection_.fronts[f];
      joined.clear();
      for (int k = first; k < last; ++k)
        for (const int link : e_.incidence_.of(e_.node(k)))
          if (const int n = e_.number_[other_end(e_.network_.links[link], e_.node(k))]; n >= last) joined.push_back(n);
      std::ranges::sort(joined);
      joined.erase(std::unique(joined.begin(), joined.end()), joined.end());
      for (int c = 0; c < children; ++c) {
        const Border border = waiting.pop();
        more.clear();
        std::set_union(joined.begin(), joined.end(), std::ranges::lower_bound(border, last), border.end(),
                       std::back_inserter(more));
        joined.swap(more);
      }
      block.border.insert(block.border.end(), joined.begin(), joined.end());
      block.border_start.push_back(static_cast<int>(block.border.size()));
      const std::int64_t s = last - first, m = s + static_cast<std::int64_t>(block.border_of(f).size());
      block.factor_start.push_back(block.factor_start.back() + start_of_column(s, m));
      waiting.largest = std::max(waiting.largest, static_cast<int>(m));
      for (double k = 0; k < static_cast<double>(s); ++k)
        waiting.operations += (static_cast<double>(m) - k - 1) * (static_cast<double>(m) - k - 1);
      waiting.push(block, f);
    }
  }

  Elimination& e_;
  Waiting all_;
  std::int64_t above_ = 0, below_ = 0;  ///< Entries of the factor above the subtrees, and of these
};

Elimination::Elimination(const Network& network, const std::vector<int>& kept, const Options& options)
    : network_(network),
      team_(*options.team),
      kept_(static_cast<int>(kept.size())),
      incidence_(network),
      number_(network.nodes) {
  std::vector<char> stays(network.nodes, 0);
  for (const int n : kept) stays[n] = 1;
  dissection_ = dissect(network, incidence_, stays, team_);
  std::copy(kept.begin(), kept.end(), dissection_.order.end() - kept_);
  for (int k = 0; k < network.nodes; ++k) number_[node(k)] = k;
  find_blocks();
  const Sizes sizes(*this);
  done_ = options.required || (sizes.operations() <= options.operations && sizes.bytes(false) <= options.bytes);
  if (done_) eliminate_all(sizes, !options.mesh_only && sizes.bytes(true) <= options.bytes, !options.mesh_only);
}

Elimination::~Elimination() = default;

/// Divides the fronts into the largest subtrees of a limited size, and single fronts above them. Neighbouring subtrees
/// that are small together are one block.
void Elimination::find_blocks() {
  const int most = std::max(1 << 14, network_.nodes / 128);  // Nodes of a block
  const std::vector<int> parent = parents();
  std::vector<int> first;  // First node of each front's subtree
  for (const Dissection::Front& front : dissection_.fronts) first.push_back(front.first);
  for (std::size_t f = 0; f < first.size(); ++f)
    if (parent[f] >= 0) first[parent[f]] = std::min(first[parent[f]], first[f]);
  const auto first_front = [&](int f) {  // of the subtree
    const auto begins = [](const Dissection::Front& front, int n) { return front.first < n; };
    const auto& fronts = dissection_.fronts;
    return static_cast<int>(std::lower_bound(fronts.begin(), fronts.begin() + f, first[f], begins) - fronts.begin());
  };
  for (int f = static_cast<int>(first.size()) - 1; f >= 0; f = blocks_.back().first - 1) {
    const int last = dissection_.fronts[f].last;
    if (last - first[f] > most) {
      blocks_.push_back({.first = f, .last = f + 1, .subtree = false});
      continue;
    }
    int begin = first_front(f);
    while (begin > 0 && last - first[begin - 1] <= most) begin = first_front(begin - 1);
    blocks_.push_back({.first = begin, .last = f + 1});
  }
  std::ranges::reverse(blocks_);
}

/// Eliminates batches of subtrees on threads, each followed by the fronts above that have all their children.
void Elimination::eliminate_all(const Sizes& sizes, bool stores_subtrees, bool stores_others) {
  Workspace above;
  Results results;
  results.mesh.get(sizes.peak());
  std::vector<Workspace> below(std::max(8, 2 * team_.size()));
  const auto factor = [](Block& block, bool stores) {
    return stores ? block.factor.get(block.factor_start.back()) : nullptr;
  };
  for (std::size_t b = 0; b < blocks_.size();) {
    std::vector<Block*> batch;
    for (std::size_t next = b; next < blocks_.size() && batch.size() < below.size(); ++next)
      if (blocks_[next].subtree) batch.push_back(&blocks_[next]);
    team_.for_each(static_cast<int>(batch.size()), [&](int k) {
      eliminate(*batch[k], below[k].results, below[k], factor(*batch[k], stores_subtrees), parallel::Team::single());
    });
    for (std::size_t k = 0; b < blocks_.size() && !(blocks_[b].subtree && k == batch.size()); ++b)
      if (blocks_[b].subtree)
        results.append(below[k++].results);
      else
        eliminate(blocks_[b], results, above, factor(blocks_[b], stores_others), team_);
  }
  mesh_.resize(kept_, kept_);
  assemble(Front(*this), static_cast<int>(results.borders.size()), results, mesh_.data(), team_);
  mesh_.diagonal().setZero();
  mesh_ = Eigen::MatrixXd(mesh_.selfadjointView<Eigen::Lower>());
}

/// Eliminates the fronts of a block. `factor`: where their columns are stored, or null.
void Elimination::eliminate(const Block& block, Results& results, Workspace& workspace, double* factor,
                            parallel::Team& team) const {
  if (block.subtree) results.mesh.get(block.peak);
  for (int f = block.first; f < block.last; ++f) {
    const Front front(*this, block, f, factor);
    const std::size_t m = front.rows();
    double* g = workspace.front.get(m * m);
    assemble(front, dissection_.fronts[f].children, results, g, team);
    eliminate_stars(g, front.rows(), front.size, team);
    double* mesh = results.add(front.border);
    for_each_column(front.rows(), team, [&](int k) {
      const double* column = g + k * (m + 1);
      if (k >= front.size)
        std::copy_n(column + 1, m - k - 1, mesh + start_of_column(k - front.size, front.rows() - front.size - 1));
      else if (factor != nullptr)
        std::copy_n(column, m - k, front.star(k));
    });
  }
}

/// Assembles a front, [rows, rows], from its own links and the last `children` results.
void Elimination::assemble(const Front& front, int children, Results& results, double* g, parallel::Team& team) const {
  const int m = front.rows();
  for_each_column(m, team, [&](int k) { std::fill_n(g + std::size_t(k) * (m + 1), m - k, 0.0); });
  for (int k = 0; k < front.size; ++k)
    for (const int link : incidence_.of(node(front.first + k)))
      if (const int other = number_[other_end(network_.links[link], node(front.first + k))]; other > front.first + k)
        g[std::size_t(k) * m + front.row(other)] += network_.links[link].conductance;
  std::vector<int> row;
  for (int c = 0; c < children; ++c) {
    const Border border = results.borders.back();
    const double* mesh = results.pop();
    const int n = static_cast<int>(border.size());
    row.resize(n);
    front.find_rows(border, row.data());
    for_each_column(n, team, [&](int k) {
      double* column = g + std::size_t(row[k]) * m;
      const double* from = mesh + start_of_column(k, n - 1);
      for (int i = k + 1; i < n; ++i) column[row[i]] += from[i - k - 1];
    });
  }
}

/// Returns the factor of a block; if it is not stored, the block is eliminated again.
double* Elimination::factor_of(const Block& block, Workspace& workspace) const {
  if (block.factor.data() != nullptr) return block.factor.data();
  double* factor = workspace.factor.get(block.factor_start.back());
  eliminate(block, workspace.results, workspace, factor, parallel::Team::single());
  workspace.results.clear();
  return factor;
}

/// Carries the currents that are injected into nodes, by number, on to later nodes.
void Elimination::inject(double* x) const {
  Workspace workspace;
  for (const Block& block : blocks_) {
    double* factor = factor_of(block, workspace);
    for (int f = block.first; f < block.last; ++f) {
      const Front front(*this, block, f, factor);
      for (int k = 0; k < front.size; ++k) {
        const double *star = front.star(k) - k, *own = x + front.first;
        for (int i = k + 1; i < front.size; ++i) x[front.first + i] += star[i] / star[k] * own[k];
        for (int i = front.size; i < front.rows(); ++i) x[front.border[i - front.size]] += star[i] / star[k] * own[k];
      }
    }
  }
}

/// Replaces the currents that reach nodes, by number, by potentials. Those of the kept nodes are given.
void Elimination::substitute(double* x) const {
  std::vector<const Block*> subtrees;
  for (auto block = blocks_.rbegin(); block != blocks_.rend(); ++block)
    if (block->subtree)
      subtrees.push_back(&*block);
    else
      substitute(*block, block->factor.data(), x);
  std::vector<Workspace> workspaces(std::max(8, 2 * team_.size()));
  for (std::size_t done = 0; done < subtrees.size(); done += workspaces.size())
    team_.for_each(static_cast<int>(std::min(workspaces.size(), subtrees.size() - done)), [&](int k) {
      const Block& block = *subtrees[done + k];
      substitute(block, factor_of(block, workspaces[k]), x);
    });
}

void Elimination::substitute(const Block& block, double* factor, double* x) const {
  Eigen::VectorXd v;
  for (int f = block.last - 1; f >= block.first; --f) {
    const Front front(*this, block, f, factor);
    v.resize(front.rows());
    for (int i = front.size; i < front.rows(); ++i) v[i] = x[front.border[i - front.size]];
    for (int k = front.size - 1; k >= 0; --k) {
      const Eigen::Map<const Eigen::VectorXd> star(front.star(k), front.rows() - k);
      const Eigen::Index later = front.rows() - k - 1;
      v[k] = (x[front.first + k] + star.tail(later).dot(v.tail(later))) / star[0];
    }
    std::copy_n(v.data(), front.size, x + front.first);
  }
}

Eigen::MatrixXd Elimination::potentials(const Eigen::MatrixXd& kept_potential, const Eigen::MatrixXd& injected) const {
  const int nodes = network_.nodes;
  Eigen::MatrixXd potential(nodes, kept_potential.cols());
  Eigen::VectorXd x(nodes);
  for (Eigen::Index c = 0; c < potential.cols(); ++c) {
    x.setZero();
    if (injected.size() > 0) {
      for (int k = 0; k < nodes - kept_; ++k) x[k] = injected(node(k), c);
      inject(x.data());
    }
    x.tail(kept_) = kept_potential.col(c);
    substitute(x.data());
    for (int k = 0; k < nodes; ++k) potential(node(k), c) = x[k];
  }
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
void Elimination::invert_stars(const Front& front, Eigen::MatrixXd& inverse) {
  const Eigen::Index m = inverse.rows();
  for (Eigen::Index k = front.size - 1; k >= 0; --k) {
    const Eigen::Map<const Eigen::VectorXd> star(front.star(static_cast<int>(k)), m - k);
    const Eigen::Index later = m - k - 1;
    const Eigen::VectorXd weight = star.tail(later) / star(0);
    inverse.col(k).tail(later) = inverse.bottomRightCorner(later, later) * weight;
    inverse.row(k).tail(later) = inverse.col(k).tail(later).transpose();
    inverse(k, k) = 1 / star(0) + weight.dot(inverse.col(k).tail(later));
  }
}

const Elimination::Block& Elimination::block_of(int front) const {
  return *std::ranges::upper_bound(blocks_, front, {}, [](const Block& block) { return block.last; });
}

Eigen::VectorXd Elimination::resistances() const {
  Eigen::VectorXd result = Eigen::VectorXd::Zero(network_.nodes);
  const std::vector<int> parent = parents();
  std::vector<std::vector<int>> children(parent.size());
  for (std::size_t f = 0; f < parent.size(); ++f)
    if (parent[f] >= 0) children[parent[f]].push_back(static_cast<int>(f));
  std::vector<Eigen::MatrixXd> border_inverse(parent.size());  // Inverse of each front's border, taken from its parent
  Workspace workspace;
  std::vector<int> rows;
  for (auto block = blocks_.rbegin(); block != blocks_.rend(); ++block) {
    double* factor = factor_of(*block, workspace);
    for (int f = block->last - 1; f >= block->first; --f) {
      const Front front(*this, *block, f, factor);
      const int s = front.size, m = front.rows();
      Eigen::MatrixXd inverse = Eigen::MatrixXd::Zero(m, m);
      if (border_inverse[f].size() > 0) inverse.bottomRightCorner(m - s, m - s) = border_inverse[f];
      border_inverse[f].resize(0, 0);
      invert_stars(front, inverse);
      for (int k = 0; k < s; ++k) result(node(front.first + k)) = inverse(k, k);
      for (const int child : children[f]) {
        rows.clear();
        for (const int n : block_of(child).border_of(child)) rows.push_back(front.row(n));
        border_inverse[child] = inverse(rows, rows);
      }
    }
  }
  return result;
}

}  // namespace lichtenberg::network
