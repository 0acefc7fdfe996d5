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
#include "solvers/parallel/ranks.hpp"

namespace lichtenberg::parallel {

/// Atomic addition: adds `value` to *to, which other items of a parallel loop may change too. If the sum is exact, it
/// does not depend on the order: for integers, and for doubles that are small multiples of one power of two.
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
/// Takes the next free index of a list: atomically adds 1 to *count and returns the previous value.
LICHTENBERG_HOST_DEVICE inline int take_index(int* count) {
#ifdef __CUDA_ARCH__
  return atomicAdd(count, 1);
#else
  return (*count)++;
#endif
}
/// Reads a value by volatile loads, so that changes by other threads of the same kernel are visible.
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
/// Atomic exchange: replaces *at by `value` and returns the previous value.
LICHTENBERG_HOST_DEVICE inline int exchange_atomically(int* at, int value) {
#ifdef __CUDA_ARCH__
  return atomicExch(at, value);
#else
  return std::exchange(*at, value);
#endif
}
/// Atomic maximum: replaces *to by `value` if `value` is larger. Floating-point numbers must not be negative, because
/// CUDA compares their bits.
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

/// Partition of values for sums over segments (a sum per segment). Long segments consist of several pieces, which can
/// be summed in parallel. Segment s has the pieces start[s] ... start[s + 1] - 1; piece p has the values begin[p] ...
/// end[p] - 1.
struct SegmentPieces {
  int segments = 0;                            ///< Number of segments
  int capacity = 0;                            ///< Upper limit of the number of pieces, with which kernels are launched
  const int* start = nullptr;                  ///< First piece of each segment [segments + 1]
  const int *begin = nullptr, *end = nullptr;  ///< Range of values of each piece
  const int* of = nullptr;                     ///< Segment of each piece, plus `first_segment`
  int first_segment = 0;                       ///< Number that `of` has for segment 0
  int* done = nullptr;                         ///< Counter per segment for finished pieces: 0 before and after use
  /// Returns the number of pieces of segment s.
  LICHTENBERG_HOST_DEVICE int count(int s) const { return start[s + 1] - start[s]; }
};

/// List of the segments to be summed: an array of `count` segment numbers.
struct SegmentList {
  const int* segment;
  int count;
};

/// Argument `more` of sum_pieces() without additional values: count 0 for every segment.
struct NoAddedValues {
  LICHTENBERG_HOST_DEVICE int count(int) const { return 0; }
  LICHTENBERG_HOST_DEVICE float value(int, int) const { return 0; }
};

/// Executor for the CPU: runs device algorithms (loops, sums, scans, sorts, transfers) on one thread, item by item. It
/// is the reference for tests of CudaExecutor, which has the same functions.
class HostExecutor : public Communicator<HostExecutor> {
 public:
  HostExecutor() = default;
  /// Executor of one of several ranks, for tests of algorithms for several devices.
  explicit HostExecutor(std::shared_ptr<Link> link) : Communicator(std::move(link)) {}
  void* stream() const { return nullptr; }  ///< the CPU has no streams

  /// State of all executors of one thread that tests set and read.
  struct Observed {
    std::size_t memory = std::size_t{1} << 62;  ///< bytes that available_memory() returns
    int waits = 0;                              ///< calls after which a device has finished: wait(), to_host()
    int recordings = 0;                         ///< calls of run() for which a device records its kernels
  };
  /// Returns the state of the calling thread.
  static Observed& observed() {
    thread_local Observed observed;
    return observed;
  }

  /// Parallel loop: calls f(k) for k = 0 ... n - 1, in any order. On a CUDA device, `threads` successive calls form a
  /// block.
  template <int threads = 256, class F>
  void for_each(long n, F f) const {
    for (long k = 0; k < n; ++k) f(static_cast<int>(k));
  }

  /// Parallel loop over a matrix: calls f(row, column) for all rows and columns, in any order.
  template <class F>
  void for_each(int rows, int columns, F f) const {
    for (int row = 0; row < rows; ++row)
      for (int column = 0; column < columns; ++column) f(row, column);
  }

  /// Cooperative operations of the threads of a block (argument of for_each_block). All threads of the block must make
  /// the same calls, memory() excepted.
  class Block {
   public:
    explicit Block(void* memory) : memory_(memory) {}
    /// Parallel loop of a block: calls f(k) for k = 0 ... n - 1, in any order, and returns when all are finished. On a
    /// device each thread unrolls its loop `unrolled` times, so that memory accesses overlap.
    template <int unrolled = 1, class F>
    void each(int n, F f) const {
      for (int k = 0; k < n; ++k) f(k);
    }
    /// Parallel loop of a block over a matrix: calls f(row, column) for all rows and columns, in any order. Returns
    /// when all calls are finished.
    template <class F>
    void each(int rows, int columns, F f) const {
      for (int row = 0; row < rows; ++row)
        for (int column = 0; column < columns; ++column) f(row, column);
    }
    /// Segmented sum by the threads of a block: calls finish(s, sum) for the segments s = 0 ... n - 1, as
    /// HostExecutor::sum_segments does.
    template <int lanes = 8, class Count, class Value, class Finish>
    void sum_segments(int n, Count count, Value value, Finish finish) const {
      HostExecutor().sum_segments(n, count, value, finish);
    }
    /// Segmented sum in pieces by the threads of a block, see HostExecutor::sum_pieces; calls finish for the listed
    /// segments only.
    template <class Sum, class Value, class More, class Finish>
    void sum_pieces(const SegmentPieces& pieces, SegmentList listed, Sum* /*partial*/, Value value, More more,
                    Finish finish) const {
      for (int k = 0; k < listed.count; ++k)
        HostExecutor::sum_of_segment<Sum>(pieces, listed.segment[k], value, more, finish);
    }
    /// Sums `mine` over the threads of the block, and calls finish(sum) in one thread.
    template <class Sum, class Finish>
    void sum(const Sum& mine, Finish finish) const {
      finish(mine);
    }
    /// Returns the block's fast (shared) memory as an array of T; its size is an argument of for_each_block.
    template <class T>
    T* memory() const {
      return static_cast<T*>(memory_);
    }

   private:
    void* memory_;
  };
  /// Calls f(Block, b) for the blocks b = 0 ... blocks - 1, in any order; on a device by each of `threads` threads of
  /// the block. A block has `bytes` of fast (shared) memory, initially undefined and at most most_block_memory(). A
  /// multiprocessor must have registers for `at_once` blocks; 0: the compiler chooses.
  template <int threads = 128, int at_once = 0, class F>
  void for_each_block(int blocks, std::size_t bytes, F f) const {
    std::vector<double> memory(bytes / sizeof(double) + 1);
    for (int b = 0; b < blocks; ++b) f(Block(memory.data()), b);
  }
  /// Returns the maximum size of the fast (shared) memory of a block (bytes).
  std::size_t most_block_memory() const { return 200 << 10; }

  /// Cooperative operations of all threads of a kernel (argument of run_cooperative). All threads must make the same
  /// calls.
  class Grid {
   public:
    /// Parallel loop of the grid: calls f(k) for k = 0 ... n - 1, in any order, and returns when all are finished.
    template <class F>
    void each(int n, F f) const {
      for (int k = 0; k < n; ++k) f(k);
    }
    /// Conditional parallel loop: calls f(k) for all k = 0 ... n - 1 for which test(k) is true, in any order. Returns
    /// when all are finished. On a device a thread evaluates four tests at once, so that memory accesses overlap.
    template <class Test, class F>
    void each_that(int n, Test test, F f) const {
      for (int k = 0; k < n; ++k)
        if (test(k)) f(k);
    }
    /// Calls f(k) for k = 0 ... n - 1, in any order, without a wait at the end. The calls are finished when the
    /// following each(), each_that() or select() returns.
    template <class F>
    void begin(int n, F f) const {
      each(n, f);
    }
    /// Calls f(k) for k = 0 ... n - 1 without a wait at the end, as begin() does. On a device it uses the last threads
    /// first, which a short following loop leaves idle.
    template <class F>
    void begin_last(int n, F f) const {
      each(n, f);
    }
    /// Stream compaction: calls put(index, k) for all k = 0 ... n - 1 for which keep(k) is true, with indices as in
    /// HostExecutor::select. Returns when all are finished.
    template <class Keep, class Put>
    void select(int n, int* taken, Keep keep, Put put) const {
      for (int k = 0; k < n; ++k)
        if (keep(k)) put(take_index(taken), k);
    }
  };
  /// Calls f(Grid) in a single kernel, on a device by each of as many threads as it can execute at once. The function
  /// can execute several loops in sequence without the launch overhead of kernels. It is compiled once for all calls,
  /// which thus round in the same way.
  template <class F>
  [[gnu::noinline, gnu::noclone]] void run_cooperative(F f) const {
    f(Grid());
  }

  /// Stream compaction: calls put(index, k) for all k = 0 ... n() - 1 for which keep(k) is true, in any order. Indices
  /// are successive numbers from *taken on; *taken increases by the number of kept items. n(), at most `most`, is
  /// evaluated on the device.
  template <class Count, class Keep, class Put>
  void select(long most, Count n, int* taken, Keep keep, Put put) const {
    const int end = n();
    for (int k = 0; k < end && k < most; ++k)
      if (keep(k)) put(take_index(taken), k);
  }

  /// Segmented sum (one sum per row of a sparse matrix, for example). For every segment s = 0 ... n - 1 it calls
  /// finish(s, sum) with the sum of value(s, t) over t = 0 ... count(s) - 1. An executor sums in the same order in each
  /// call. On a device `lanes` threads share a segment.
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

  /// Segmented sum in pieces, for segments of very different lengths: calls finish(s, sum) for every segment s. The sum
  /// contains value(k) for the values k of the segment's pieces, and more.value(s, t) for t = 0 ... more.count(s) - 1.
  /// An executor sums in the same order in each call. `partial`: memory for one sum per piece. No value may depend on
  /// data that `finish` changes.
  template <class Sum, class Value, class More, class Finish>
  void sum_pieces(const SegmentPieces& pieces, Sum* /*partial*/, Value value, More more, Finish finish) const {
    for (int s = 0; s < pieces.segments; ++s) sum_of_segment<Sum>(pieces, s, value, more, finish);
  }

  /// Sum over all items: calls finish(sum) with the sum of value(k) over k = 0 ... n - 1. An executor sums in the same
  /// order in each call. On a device each thread takes about `a_thread` values, or more if n is large. Of functions
  /// that run concurrently (run_concurrently, for_each_concurrently), at most one may call sum().
  template <int a_thread = 4, class Value, class Finish>
  void sum(long n, Value value, Finish finish) const {
    decltype(value(0)) sum{};
    for (long k = 0; k < n; ++k) sum += value(static_cast<int>(k));
    finish(sum);
  }

  /// Sum over a matrix: calls finish(sum) with the sum of value(row, column) over all rows and columns. An executor
  /// sums in the same order in each call. Restrictions are those of sum(n, value, finish).
  template <class Value, class Finish>
  void sum(int rows, int columns, Value value, Finish finish) const {
    decltype(value(0, 0)) sum{};
    for (int row = 0; row < rows; ++row)
      for (int column = 0; column < columns; ++column) sum += value(row, column);
    finish(sum);
  }

  /// Exclusive prefix sum: replaces each of the n values by the sum of the values before it.
  template <class T>
  void exclusive_scan(T* values, long n) const {
    T sum{};
    for (long k = 0; k < n; ++k) {
      const T value = values[k];
      values[k] = sum;
      sum = sum + value;
    }
  }

  /// Sorts n pairs of a key and a value by their keys, which are between 0 and `largest`. The sort is stable.
  void sort(int* keys, int* values, int n, int /*largest*/ = std::numeric_limits<int>::max()) const {
    std::vector<std::pair<int, int>> pairs(n);
    for (int k = 0; k < n; ++k) pairs[k] = {keys[k], values[k]};
    std::stable_sort(pairs.begin(), pairs.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
    for (int k = 0; k < n; ++k) {
      keys[k] = pairs[k].first;
      values[k] = pairs[k].second;
    }
  }

  /// Checks that the given number of bytes is free on the device. CudaExecutor throws Failure otherwise; on the CPU
  /// nothing is checked.
  void check_memory(std::size_t) const {}
  /// Returns the free memory of the device (bytes); on the CPU a number without meaning.
  std::size_t available_memory() const { return observed().memory; }
  // Functions for device memory. On the CPU they act on host memory.
  void* allocate(std::size_t bytes) const { return std::malloc(bytes); }
  void release(void* memory) const { std::free(memory); }
  void fill(void* memory, int byte, std::size_t bytes) const {
    if (bytes > 0) std::memset(memory, byte, bytes);
  }
  void copy(void* to, const void* from, std::size_t bytes) const {
    if (bytes > 0) std::memcpy(to, from, bytes);
  }
  void to_device(void* to, const void* from, std::size_t bytes) const { copy(to, from, bytes); }
  void to_host(void* to, const void* from, std::size_t bytes) const {
    ++observed().waits;
    copy(to, from, bytes);
  }
  /// Allocates (pinned) host memory for the transfers begin_to_device() and begin_to_host().
  void* allocate_on_host(std::size_t bytes) const { return std::malloc(bytes); }
  void release_on_host(void* memory) const { std::free(memory); }
  /// Starts a copy from host to device, which is complete after wait().
  void begin_to_device(void* to, const void* from, std::size_t bytes) const { copy(to, from, bytes); }
  /// Starts a copy from device to host, which is complete after wait().
  void begin_to_host(void* to, const void* from, std::size_t bytes) const { copy(to, from, bytes); }
  /// Waits until all kernels and copies started before are complete.
  void wait() const { ++observed().waits; }

  /// Recorded sequence of kernels for repeated execution. On the CPU run() calls f each time.
  struct Recording {
    bool is_made = false;
    void clear() { is_made = false; }
  };
  /// Executes the kernels that f launches. CudaExecutor calls f at the first call with a Recording and records the
  /// kernels; later calls repeat them. With cuda_loops_on_host() every call calls f.
  template <class F>
  void run(Recording& recording, F f) const {
    observed().recordings += !std::exchange(recording.is_made, true);
    f();
  }
  /// Conditional execution within run(): executes the kernels of f if *flag is not 0 after all earlier kernels. The
  /// flag is in device memory.
  template <class F>
  void when(const int* flag, F f) const {
    if (*flag) f();
  }
  /// Loop within run(): executes the kernels of f while *flag is not 0, tested before each execution. The flag is in
  /// device memory.
  template <class F>
  void repeat_while(const int* flag, F f) const {
    while (*flag) f();
  }
  /// Argument of the function f of repeat(): a kernel calls it with true to repeat f, with false to end the loop.
  struct RepeatCondition {
    bool* more;
    void operator()(bool go) const { *more = go; }
  };
  /// Loop within run(): executes the kernels of f(RepeatCondition) once, then repeats them as long as the last call of
  /// the RepeatCondition had the argument true.
  template <class F>
  void repeat(F f) const {
    for (bool more = true; more;) {
      more = false;
      f(RepeatCondition{&more});
    }
  }

  /// Executes the kernels of f(0) ... f(n - 1), on a device concurrently. None may change data that another one uses.
  template <class F>
  void for_each_concurrently(int n, F f) const {
    for (int k = 0; k < n; ++k) f(k);
  }

  /// Executes the kernels of f and of g, on a device concurrently. Neither may change data that the other one uses, and
  /// at most one may call sort() or exclusive_scan(). Within run() the kernels of g have the lower priority.
  template <class F, class G>
  void run_concurrently(F f, G g) const {
    f();
    g();
  }

  /// Time stamp in the sequence of kernels, set by mark().
  class TimePoint {
   public:
    /// Returns the time (s) between an earlier time stamp and this one. wait() must have been called after the later
    /// mark().
    double seconds_since(const TimePoint& earlier) const {
      return std::chrono::duration<double>(at_ - earlier.at_).count();
    }

   private:
    friend class HostExecutor;
    std::chrono::steady_clock::time_point at_;
  };
  /// Waits until all kernels and copies before a time stamp are complete.
  void wait_until(const TimePoint&) const {}
  /// Sets a time stamp to the time at which all earlier kernels are complete.
  void mark(TimePoint& moment) const { moment.at_ = std::chrono::steady_clock::now(); }

  /// Measures the time (s) that the kernels of f take.
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
