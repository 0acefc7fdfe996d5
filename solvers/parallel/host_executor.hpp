#pragma once

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <numeric>
#include <type_traits>
#include <utility>
#include <vector>

#include "solvers/geometry/host_device.hpp"

namespace lichtenberg::parallel {

/// Adds a value atomically to one that other items of a loop change too. Integer sums do not depend on the order. The
/// same holds for doubles that are multiples of one power of two.
template <class T>
LICHTENBERG_HOST_DEVICE void add_atomically(T* to, T value) {
#ifdef __CUDA_ARCH__
  if constexpr (sizeof(T) == 8 && !std::is_same_v<T, double>)
    atomicAdd(reinterpret_cast<unsigned long long*>(to), static_cast<unsigned long long>(value));
  else
    atomicAdd(to, value);
#else
  *to += value;
#endif
}
/// Adds 1 and returns the previous value: the next index in a list of arbitrary order.
LICHTENBERG_HOST_DEVICE inline int take_index(int* count) {
#ifdef __CUDA_ARCH__
  return atomicAdd(count, 1);
#else
  return (*count)++;
#endif
}
/// Returns the current value in memory, as changed by other threads of the same kernel.
template <class T>
LICHTENBERG_HOST_DEVICE T fresh(const T* value) {
#ifdef __CUDA_ARCH__
  static_assert(sizeof(T) % sizeof(int) == 0);
  T copy;
  for (unsigned w = 0; w < sizeof(T) / sizeof(int); ++w)
    reinterpret_cast<int*>(&copy)[w] = reinterpret_cast<const volatile int*>(value)[w];
  return copy;
#else
  return *value;
#endif
}
/// Replaces a value and returns the previous one.
LICHTENBERG_HOST_DEVICE inline int exchange_atomically(int* at, int value) {
#ifdef __CUDA_ARCH__
  return atomicExch(at, value);
#else
  return std::exchange(*at, value);
#endif
}
/// Replaces a value by the maximum atomically. Not for negative values: floating-point numbers are compared by their
/// bits.
template <class T>
LICHTENBERG_HOST_DEVICE void max_atomically(T* to, T value) {
  if (!(value > *to)) return;  // True for most values
#ifdef __CUDA_ARCH__
  if constexpr (std::is_same_v<T, double>)
    atomicMax(reinterpret_cast<long long*>(to), __double_as_longlong(value));
  else if constexpr (std::is_same_v<T, float>)
    atomicMax(reinterpret_cast<int*>(to), __float_as_int(value));
  else
    atomicMax(to, value);
#else
  *to = value;
#endif
}

/// Values of segments in pieces, so that long segments can be summed in parallel: segment s has pieces start[s] ...
/// start[s + 1] - 1. `begin`, `end` and `of` are indexed by piece; begin and end are indices of values.
struct SegmentPieces {
  int segments = 0;
  int capacity = 0;  ///< Capacity in pieces
  const int* start = nullptr;
  const int *begin = nullptr, *end = nullptr;
  const int* of = nullptr;  ///< Segment of a piece, relative to `first_segment`
  int first_segment = 0;
  int* done = nullptr;  ///< Counter per segment: 0 before and after use
  LICHTENBERG_HOST_DEVICE int count(int s) const { return start[s + 1] - start[s]; }
};

/// Numbers of the segments to be summed.
struct SegmentList {
  const int* segment;
  int count;
};

/// Additional values of segments: none.
struct NoAddedValues {
  LICHTENBERG_HOST_DEVICE int count(int) const { return 0; }
  LICHTENBERG_HOST_DEVICE float value(int, int) const { return 0; }
};

/// Executes device algorithms on the CPU, one item after another; reference for tests. CudaExecutor has the same
/// functions.
class HostExecutor {
 public:
  /// Calls f(k) for k = 0 ... n - 1, in any order. On a device, `threads` of them form a block.
  template <int threads = 256, class F>
  void for_each(long n, F f) const {
    for (long k = 0; k < n; ++k) f(static_cast<int>(k));
  }

  /// Calls f(row, column) for all rows and columns, in any order.
  template <class F>
  void for_each(int rows, int columns, F f) const {
    for (int row = 0; row < rows; ++row)
      for (int column = 0; column < columns; ++column) f(row, column);
  }

  /// Cooperative operations of the threads of a block.
  class Block {
   public:
    explicit Block(void* memory) : memory_(memory) {}
    /// Calls f(k) for k = 0 ... n - 1, in any order, and returns when all are finished. On a device the loop of a
    /// thread is unrolled `unrolled` times, so that memory accesses overlap.
    template <int unrolled = 1, class F>
    void each(int n, F f) const {
      for (int k = 0; k < n; ++k) f(k);
    }
    /// Calls f(row, column) for all rows and columns, in any order.
    template <class F>
    void each(int rows, int columns, F f) const {
      for (int row = 0; row < rows; ++row)
        for (int column = 0; column < columns; ++column) f(row, column);
    }
    /// Like HostExecutor::sum_segments and sum_pieces; the latter only for the listed segments.
    template <int lanes = 8, class Count, class Value, class Finish>
    void sum_segments(int n, Count count, Value value, Finish finish) const {
      HostExecutor().sum_segments(n, count, value, finish);
    }
    template <class Sum, class Value, class More, class Finish>
    void sum_pieces(const SegmentPieces& pieces, SegmentList listed, Sum* /*partial*/, Value value, More more,
                    Finish finish) const {
      for (int k = 0; k < listed.count; ++k)
        HostExecutor::sum_of_segment<Sum>(pieces, listed.segment[k], value, more, finish);
    }
    /// Calls finish(sum over the threads of `mine`).
    template <class Sum, class Finish>
    void sum(const Sum& mine, Finish finish) const {
      finish(mine);
    }
    template <class T>
    T* memory() const {
      return static_cast<T*>(memory_);
    }

   private:
    void* memory_;
  };
  /// Calls f(Block, b) for b = 0 ... blocks - 1. Each block has `bytes` of fast memory, initially undefined and at most
  /// most_block_memory(). On a device `threads` threads form a block.
  template <int threads = 128, class F>
  void for_each_block(int blocks, std::size_t bytes, F f) const {
    std::vector<double> memory(bytes / sizeof(double) + 1);
    for (int b = 0; b < blocks; ++b) f(Block(memory.data()), b);
  }
  std::size_t most_block_memory() const { return 200 << 10; }

  /// Cooperative operations of all threads of a device, one loop after another.
  class Grid {
   public:
    /// Calls f(k) for k = 0 ... n - 1, in any order, and returns when all are finished.
    template <class F>
    void each(int n, F f) const {
      for (int k = 0; k < n; ++k) f(k);
    }
    /// Calls f(k) for all k = 0 ... n - 1 with test(k), in any order. On a device several tests run at once.
    template <class Test, class F>
    void each_that(int n, Test test, F f) const {
      for (int k = 0; k < n; ++k)
        if (test(k)) f(k);
    }
    /// Like each, but finished only when the following loop is.
    template <class F>
    void begin(int n, F f) const {
      each(n, f);
    }
    /// Like begin. On a device it prefers threads that the following loop leaves idle if that is short.
    template <class F>
    void begin_last(int n, F f) const {
      each(n, f);
    }
    /// Calls put(index, k) for all k = 0 ... n - 1 with keep(k), as HostExecutor::select does.
    template <class Keep, class Put>
    void select(int n, int* taken, Keep keep, Put put) const {
      for (int k = 0; k < n; ++k)
        if (keep(k)) put(take_index(taken), k);
    }
  };
  /// Calls f(Grid): loops in sequence without the launch overhead of kernels.
  template <class F>
  void run_cooperative(F f) const {
    f(Grid());
  }

  /// Calls put(index, k) for all k = 0 ... n() - 1 with keep(k), in any order; n() is at most `most`. Indices are
  /// successive numbers from *taken on, and *taken increases by their count. On a device, n() is evaluated there.
  template <class Count, class Keep, class Put>
  void select(long most, Count n, int* taken, Keep keep, Put put) const {
    const int end = n();
    for (int k = 0; k < end && k < most; ++k)
      if (keep(k)) put(take_index(taken), k);
  }

  /// Calls finish(s, sum of value(s, t) over t = 0 ... count(s) - 1) for every segment s. The order of summation is
  /// always the same. On a device `lanes` threads share a segment.
  template <int lanes = 32, class Count, class Value, class Finish>
  void sum_segments(long n, Count count, Value value, Finish finish) const {
    using Sum = decltype(value(0, 0));
    for (int s = 0; s < n; ++s) {
      Sum sum{};
      const int end = count(s);
      for (int t = 0; t < end; ++t) sum += value(s, t);
      finish(s, sum);
    }
  }

  /// Calls finish(s, sum) for every segment. The sum includes value(k) for the values k of the segment's pieces, and
  /// more.value(s, t) for t = 0 ... more.count(s) - 1. The order of summation is always the same. `partial`: one
  /// element per piece. No value may depend on data that finish changes.
  template <class Sum, class Value, class More, class Finish>
  void sum_pieces(const SegmentPieces& pieces, Sum* /*partial*/, Value value, More more, Finish finish) const {
    for (int s = 0; s < pieces.segments; ++s) sum_of_segment<Sum>(pieces, s, value, more, finish);
  }

  /// Calls finish(sum of value(k) over k = 0 ... n - 1). The order of summation is always the same. Not allowed within
  /// `run_concurrently` or `for_each_concurrently`. On a device a thread takes at least `a_thread` values.
  template <int a_thread = 4, class Value, class Finish>
  void sum(long n, Value value, Finish finish) const {
    decltype(value(0)) sum{};
    for (long k = 0; k < n; ++k) sum += value(static_cast<int>(k));
    finish(sum);
  }

  /// Replaces each of the n values by the sum of those before it.
  template <class T>
  void exclusive_scan(T* values, long n) const {
    T sum{};
    for (long k = 0; k < n; ++k) {
      const T value = values[k];
      values[k] = sum;
      sum = sum + value;
    }
  }

  /// Sorts the keys, 0 ... `largest`, together with the values; the sort is stable.
  void sort(int* keys, int* values, int n, int /*largest*/ = std::numeric_limits<int>::max()) const {
    std::vector<std::pair<int, int>> pairs(n);
    for (int k = 0; k < n; ++k) pairs[k] = {keys[k], values[k]};
    std::stable_sort(pairs.begin(), pairs.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
    for (int k = 0; k < n; ++k) {
      keys[k] = pairs[k].first;
      values[k] = pairs[k].second;
    }
  }

  /// Throws Failure if less memory than this is free.
  void check_memory(std::size_t) const {}
  /// Returns the number of bytes of free memory.
  std::size_t available_memory() const { return std::size_t{1} << 62; }
  void* allocate(std::size_t bytes) const { return std::malloc(bytes); }
  void release(void* memory) const { std::free(memory); }
  void fill(void* memory, int byte, std::size_t bytes) const { std::memset(memory, byte, bytes); }
  void copy(void* to, const void* from, std::size_t bytes) const { std::memcpy(to, from, bytes); }
  void to_device(void* to, const void* from, std::size_t bytes) const { std::memcpy(to, from, bytes); }
  void to_host(void* to, const void* from, std::size_t bytes) const { std::memcpy(to, from, bytes); }
  /// Allocates host memory from which begin_to_device() and begin_to_host() copy fast.
  void* allocate_on_host(std::size_t bytes) const { return std::malloc(bytes); }
  void release_on_host(void* memory) const { std::free(memory); }
  /// Starts a copy to the device, which is complete after wait().
  void begin_to_device(void* to, const void* from, std::size_t bytes) const { std::memcpy(to, from, bytes); }
  /// Starts a copy to the host, which is complete after wait().
  void begin_to_host(void* to, const void* from, std::size_t bytes) const { std::memcpy(to, from, bytes); }
  void wait() const {}

  /// Sequence of kernels that is executed many times.
  struct Recording {
    void clear() {}
  };
  template <class F>
  void run(Recording&, F f) const {
    f();
  }
  /// Within a recording: executes f if, or while, *flag is not 0. The flag is evaluated on the device.
  template <class F>
  void when(const int* flag, F f) const {
    if (*flag) f();
  }
  template <class F>
  void repeat_while(const int* flag, F f) const {
    while (*flag) f();
  }
  /// Within a recording: calls f(RepeatCondition), and repeats it while the last call of the RepeatCondition in a
  /// kernel had the argument true.
  struct RepeatCondition {
    bool* more;
    void operator()(bool go) const { *more = go; }
  };
  template <class F>
  void repeat(F f) const {
    for (bool more = true; more;) {
      more = false;
      f(RepeatCondition{&more});
    }
  }

  /// Runs f(0) ... f(n - 1) concurrently where possible; they must not share data.
  template <class F>
  void for_each_concurrently(int n, F f) const {
    for (int k = 0; k < n; ++k) f(k);
  }

  /// Runs f and g concurrently where possible; they must not share data. g has the lower priority.
  template <class F, class G>
  void run_concurrently(F f, G g) const {
    f();
    g();
  }

  /// Point in the sequence of kernels. The executor must have waited before the time between two is computed.
  class TimePoint {
   public:
    double seconds_since(const TimePoint& earlier) const {
      return std::chrono::duration<double>(at_ - earlier.at_).count();
    }

   private:
    friend class HostExecutor;
    std::chrono::steady_clock::time_point at_;
  };
  void mark(TimePoint& moment) const { moment.at_ = std::chrono::steady_clock::now(); }

  /// Returns the time (s) of f's kernels.
  template <class F>
  double seconds(F f) const {
    const auto start = std::chrono::steady_clock::now();
    f();
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  }

 private:
  template <class Sum, class Value, class More, class Finish>
  static void sum_of_segment(const SegmentPieces& pieces, int s, Value value, More more, Finish finish) {
    Sum sum{};
    for (int p = pieces.start[s]; p < pieces.start[s + 1]; ++p)
      for (int k = pieces.begin[p]; k < pieces.end[p]; ++k) sum += value(k);
    for (int t = 0; t < more.count(s); ++t) sum += more.value(s, t);
    finish(s, sum);
  }
};

}  // namespace lichtenberg::parallel
