#pragma once

// Share of a rank in a gas on several devices. Each rank owns a range of the sorted grains: layers of search cells
// along x, which is the slowest index. It moves these grains and computes the smooth forces on them. Each rank has
// arrays of all grains, but keeps only those near its own up to date.

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "solvers/error.hpp"
#include "solvers/neighbours/table.hpp"
#include "solvers/parallel/array.hpp"
#include "solvers/parallel/ranks.hpp"

namespace lichtenberg::granular::device {

/// Grains of a rank by their sorted indices. `own`: it moves them. `rows`: it has their rows of the table of candidate
/// pairs. `known`: it keeps their state up to date. Each range contains the one before.
struct ShareOfGrains {
  RingRange own, rows, known;

  static ShareOfGrains all(int n) { return {RingRange::whole(n), RingRange::whole(n), RingRange::whole(n)}; }
};

/// Number of contacts over which a contact acts on others within a substep. The force of a pair follows from the forces
/// on both grains in the middle of the substep, and these from the forces on their partners at its start.
constexpr int contacts_in_substep = 3;

/// Division of the sorted grains among ranks, and the exchange of values of grains between them.
template <class Executor>
class Share {
 public:
  explicit Share(const Executor& run) : run_(&run), index_(run), entry_(run) {}

  /// Returns true if there are several ranks.
  bool is_divided() const { return run_->ranks() > 1; }
  const ShareOfGrains& range() const { return range_; }

  /// Gives all n grains to one rank, or with several ranks to each.
  void take_all(int n) {
    range_ = ShareOfGrains::all(n);
    first_.clear();
  }
  /// Divides the grains into ranges of about equal size. `start`: index of the first grain of each layer, and the
  /// number of grains; `rows`, `known`: numbers of layers on each side of the own ones (ShareOfGrains). Throws Failure
  /// for fewer layers than ranks.
  void divide(const std::vector<int>& start, int rows, int known) {
    const int layers = static_cast<int>(start.size()) - 1, ranks = run_->ranks();
    if (layers < ranks)
      throw Failure("the box has " + std::to_string(layers) + " layers of search cells along x, too few for " +
                    std::to_string(ranks) + " devices");
    std::vector<int> border{0};
    for (int r = 1; r < ranks; ++r) {
      const auto wanted = static_cast<int>(static_cast<double>(start.back()) / ranks * r);
      const auto at = static_cast<int>(std::ranges::lower_bound(start, wanted) - start.begin());
      border.push_back(std::clamp(at, border.back() + 1, layers - (ranks - r)));
    }
    border.push_back(layers);
    first_.clear(), rows_.clear(), known_.clear();
    for (const int layer : border) first_.push_back(start[layer]);
    for (int r = 0; r < ranks; ++r) {
      const auto around = [&](int more) { return layers_around(start, border[r], border[r + 1], more); };
      const ShareOfGrains of{around(0), around(rows), around(known)};
      if (r == run_->rank()) range_ = of;
      add_segments(rows_, r, of.rows);
      add_segments(known_, r, of.known);
    }
  }
  /// Returns the number of grains that are kept up to date in addition to the own ones, and the k-th of them.
  int others() const { return range_.known.count - range_.own.count; }
  struct Other {
    RingRange own, known;
    LICHTENBERG_HOST_DEVICE int operator()(int k) const {
      const int after = own.first - known.first, before = after < 0 ? after + own.size : after;
      return known(k < before ? k : k + own.count);
    }
  };
  Other other() const { return {range_.own, range_.known}; }

  /// Sends values of own grains to the ranks that keep them up to date. `values`: arrays of all grains.
  template <class... T>
  void send_to_neighbours(T*... values) const {
    std::vector<parallel::Transfer> transfers;
    (append(transfers, known_, values), ...);
    run_->exchange(transfers);
  }
  /// As send_to_neighbours, and sends values of the entries of own rows to the ranks that have these rows.
  template <class E, class... T>
  void send_with_entries(E* entry_values, T*... values) const {
    std::vector<parallel::Transfer> transfers;
    (append(transfers, known_, values), ...);
    append(transfers, entries_, entry_values);
    run_->exchange(transfers);
  }
  /// Adds the values of grains of other ranks to those of the ranks that own them, and sets them to 0 here. The sums
  /// must be exact. `received`: memory for values from other ranks.
  template <class T>
  void add_to_owners(T* values, parallel::Array<T, Executor>& received) const {
    const int rank = run_->rank();
    long size = 0;
    for (const Segment& s : known_) size += s.from == rank ? s.end - s.begin : 0;
    received.resize(size);
    std::vector<parallel::Transfer> transfers;
    T* at = received.data();
    for (const Segment& s : known_) {
      const std::size_t bytes = (s.end - s.begin) * sizeof(T);
      if (s.from == rank) transfers.push_back({std::exchange(at, at + (s.end - s.begin)), bytes, s.to, false});
      if (s.to == rank) transfers.push_back({values + s.begin, bytes, s.from, true});
    }
    run_->exchange(transfers);
    const T* from = received.data();
    for (const Segment& s : known_) {
      T* to = values + s.begin;
      const int count = s.end - s.begin;
      if (s.from == rank) {
        run_->for_each(count, [=] LICHTENBERG_HOST_DEVICE(int k) { to[k] += from[k]; });
        from += count;
      }
      if (s.to == rank) run_->for_each(count, [=] LICHTENBERG_HOST_DEVICE(int k) { to[k] = 0; });
    }
  }
  /// Sends values of own grains to all ranks, so that each rank has all.
  template <class... T>
  void send_to_all(T*... values) const {
    if (!is_divided() || first_.empty()) return;
    std::vector<Segment> all;
    for (int from = 0; from < run_->ranks(); ++from)
      for (int to = 0; to < run_->ranks(); ++to)
        if (from != to) all.push_back({from, to, first_[from], first_[from + 1]});
    std::vector<parallel::Transfer> transfers;
    (append(transfers, all, values), ...);
    run_->exchange(transfers);
  }
  /// Sends the first values of an array, `mine` of this rank, to all ranks. Afterwards the array has the values of all
  /// ranks, in the order of the ranks.
  template <class T>
  void join(parallel::Array<T, Executor>& values, parallel::Array<T, Executor>& spare) const {
    if (!is_divided()) return;
    std::vector<int> end{0};
    for (const int count : run_->from_all(static_cast<int>(values.size()))) end.push_back(end.back() + count);
    spare.resize(end.back());
    const int rank = run_->rank();
    run_->copy(spare.data() + end[rank], values.data(), values.size() * sizeof(T));
    std::vector<Segment> all;
    for (int from = 0; from < run_->ranks(); ++from)
      for (int to = 0; to < run_->ranks(); ++to)
        if (from != to && end[from] < end[from + 1]) all.push_back({from, to, end[from], end[from + 1]});
    std::vector<parallel::Transfer> transfers;
    append(transfers, all, spare.data());
    run_->exchange(transfers);
    std::swap(values, spare);
  }

  // Public because nvcc requires it of functions with kernels.

  /// Finds the entries of the rows that ranks exchange, in the present table.
  void find_entries(const TableView& table) {
    if (!is_divided()) return;
    std::vector<int> index;
    for (const Segment& s : rows_) index.push_back(s.begin), index.push_back(s.end);
    index_.upload(index);
    entry_.resize(index.size());
    const int* of = index_.data();
    int* to = entry_.data();
    run_->for_each(static_cast<long>(index.size()), [=] LICHTENBERG_HOST_DEVICE(int k) { to[k] = table.begin(of[k]); });
    const std::vector<int> entry = entry_.download();
    entries_ = rows_;
    for (std::size_t k = 0; k < entries_.size(); ++k)
      entries_[k].begin = entry[2 * k], entries_[k].end = entry[2 * k + 1];
  }

 private:
  /// Indices begin ... end - 1 of an array that rank `from` sends to rank `to`.
  struct Segment {
    int from = 0, to = 0, begin = 0, end = 0;
  };

  /// Returns the grains in the layers begin ... end - 1 and in `more` layers on each side, in the periodic box.
  static RingRange layers_around(const std::vector<int>& start, int begin, int end, int more) {
    const int layers = static_cast<int>(start.size()) - 1, n = start.back();
    if (end - begin + 2 * more >= layers) return {start[begin], n, n};
    const auto index = [&](int layer) {  // of the first grain of a layer, in a box that continues on both sides
      const int turns = layer < 0 ? -1 : layer / layers;
      return start[layer - turns * layers] + turns * n;
    };
    const int first = index(begin - more), last = index(end + more);
    return {first < 0 ? first + n : first, last - first, n};
  }
  /// Adds the segments of the grains `all` that other ranks own and send to this rank.
  void add_segments(std::vector<Segment>& segments, int rank, const RingRange& all) const {
    const auto add = [&](int begin, int end) {  // of indices 0 ... n - 1
      for (int owner = 0; owner < run_->ranks(); ++owner) {
        const int low = std::max(begin, first_[owner]), high = std::min(end, first_[owner + 1]);
        if (low < high && owner != rank) segments.push_back({owner, rank, low, high});
      }
    };
    const int end = all.first + all.count;
    add(all.first, std::min(end, all.size));
    if (end > all.size) add(0, end - all.size);
  }
  template <class T>
  void append(std::vector<parallel::Transfer>& to, const std::vector<Segment>& segments, T* values) const {
    for (const Segment& s : segments) {
      const bool sends = s.from == run_->rank();
      if (sends || s.to == run_->rank())
        to.push_back({values + s.begin, (s.end - s.begin) * sizeof(T), sends ? s.to : s.from, sends});
    }
  }

  const Executor* run_;
  ShareOfGrains range_;
  std::vector<int> first_;                       ///< first own grain of each rank, and the number of grains
  std::vector<Segment> rows_, known_, entries_;  ///< entries: as rows, but entries of the table of this rank
  parallel::Array<int, Executor> index_, entry_;
};

}  // namespace lichtenberg::granular::device
