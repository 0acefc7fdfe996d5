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

/// Adds to, or makes larger, what other items of a loop change too. Sums of whole numbers do not depend on the order;
/// nor do those of doubles that are all multiples of one power of two.
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
/// Adds 1, and returns what was there: the next place of a list whose order does not matter.
LICHTENBERG_HOST_DEVICE inline int take_place(int* count) {
#ifdef __CUDA_ARCH__
  return atomicAdd(count, 1);
#else
  return (*count)++;
#endif
}
/// A value as others have left it, in the kernel that changes it.
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
/// Puts a value there, and returns what was there before.
LICHTENBERG_HOST_DEVICE inline int exchange_atomically(int* at, int value) {
#ifdef __CUDA_ARCH__
  return atomicExch(at, value);
#else
  return std::exchange(*at, value);
#endif
}
/// Not for negative values: those of floating point are compared by their bits.
template <class T>
LICHTENBERG_HOST_DEVICE void enlarge_atomically(T* to, T value) {
  if (!(value > *to)) return;  // most are not
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

/// Segments' values in pieces, so that a long segment is no long serial sum: pieces start[s] ... start[s + 1] - 1 are
/// segment s's. `begin`, `end`, `of`: by piece, from the first to the last of all; begin's and end's values are
/// numbers.
struct Pieces {
  int segments = 0;
  int room = 0;  ///< for so many pieces
  const int* start = nullptr;
  const int *begin = nullptr, *end = nullptr;
  const int* of = nullptr;  ///< its segment, counted from `first_segment` on
  int first_segment = 0;
  int* done = nullptr;  ///< by segment: 0, and 0 again when all is done
  LICHTENBERG_HOST_DEVICE int count(int s) const { return start[s + 1] - start[s]; }
};

/// No more values than those of the pieces.
struct NoMore {
  LICHTENBERG_HOST_DEVICE int count(int) const { return 0; }
  LICHTENBERG_HOST_DEVICE float value(int, int) const { return 0; }
};

/// Runs a device's algorithms on the CPU, item after item: their reference, and what the tests run. CudaExecutor has
/// the same functions.
class HostExecutor {
 public:
  /// f(k) for k = 0 ... n - 1, in any order. On a device `threads` of them are one block.
  template <int threads = 256, class F>
  void for_each(long n, F f) const {
    for (long k = 0; k < n; ++k) f(static_cast<int>(k));
  }

  /// f(row, column), in any order.
  template <class F>
  void for_each(int rows, int columns, F f) const {
    for (int row = 0; row < rows; ++row)
      for (int column = 0; column < columns; ++column) f(row, column);
  }

  /// What the threads of a block do together.
  class Block {
   public:
    explicit Block(void* memory) : memory_(memory) {}
    /// f(k) for k = 0 ... n - 1, in any order; all of it is done when this returns. On a device a thread's calls are
    /// written out `unrolled` at a time, so that what they wait for comes together.
    template <int unrolled = 1, class F>
    void each(int n, F f) const {
      for (int k = 0; k < n; ++k) f(k);
    }
    /// f(row, column), likewise.
    template <class F>
    void each(int rows, int columns, F f) const {
      for (int row = 0; row < rows; ++row)
        for (int column = 0; column < columns; ++column) f(row, column);
    }
    /// As HostExecutor::sum_segments and sum_pieces; of the latter `listed` segments alone, n in number.
    template <int lanes = 8, class Count, class Value, class Finish>
    void sum_segments(int n, Count count, Value value, Finish finish) const {
      HostExecutor().sum_segments(n, count, value, finish);
    }
    template <class Sum, class Value, class More, class Finish>
    void sum_pieces(const Pieces& pieces, const int* listed, int n, Sum* /*partial*/, Value value, More more,
                    Finish finish) const {
      for (int k = 0; k < n; ++k) HostExecutor::sum_of_segment<Sum>(pieces, listed[k], value, more, finish);
    }
    /// finish(sum of what each thread has).
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
  /// f(Block, b) for b = 0 ... blocks - 1, each with so many bytes of fast memory of its own: undefined at first, no
  /// more than most_block_memory(). On a device `threads` threads share a block.
  template <int threads = 128, class F>
  void for_each_block(int blocks, std::size_t bytes, F f) const {
    std::vector<double> memory(bytes / sizeof(double) + 1);
    for (int b = 0; b < blocks; ++b) f(Block(memory.data()), b);
  }
  std::size_t most_block_memory() const { return 200 << 10; }

  /// What all threads of a device do together, one loop after the other.
  class Grid {
   public:
    /// f(k) for k = 0 ... n - 1, in any order; all of it is done when this returns.
    template <class F>
    void each(int n, F f) const {
      for (int k = 0; k < n; ++k) f(k);
    }
    /// f(k) for those k = 0 ... n - 1 with test(k), in any order. On a device several are tested at once.
    template <class Test, class F>
    void each_that(int n, Test test, F f) const {
      for (int k = 0; k < n; ++k)
        if (test(k)) f(k);
    }
    /// As each, but done when the loop that follows is.
    template <class F>
    void begin(int n, F f) const {
      each(n, f);
    }
    /// The same, but on a device threads that the loop which follows leaves idle, if it is short, come first.
    template <class F>
    void begin_last(int n, F f) const {
      each(n, f);
    }
    /// As HostExecutor::select.
    template <class Keep, class Put>
    void select(int n, int* taken, Keep keep, Put put) const {
      for (int k = 0; k < n; ++k)
        if (keep(k)) put(take_place(taken), k);
    }
  };
  /// f(Grid): loops that follow each other without the time that a kernel takes to start.
  template <class F>
  void together(F f) const {
    f(Grid());
  }

  /// put(place, k) for those k = 0 ... n() - 1, at most `most`, with keep(k), in any order; their places are the
  /// numbers from *taken on, to which their count is added. On a device n() is asked there.
  template <class Count, class Keep, class Put>
  void select(long most, Count n, int* taken, Keep keep, Put put) const {
    const int end = n();
    for (int k = 0; k < end && k < most; ++k)
      if (keep(k)) put(take_place(taken), k);
  }

  /// finish(s, sum of value(s, t) over t = 0 ... count(s) - 1) for every segment s; the same order of summation each
  /// time. On a device `lanes` threads share a segment.
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

  /// finish(s, sum over the values k of segment s's pieces of value(k), and over t = 0 ... more.count(s) - 1 of
  /// more.value(s, t)) for every segment; the same order of summation each time. `partial`: one a piece. What finish
  /// changes no value may depend on.
  template <class Sum, class Value, class More, class Finish>
  void sum_pieces(const Pieces& pieces, Sum* /*partial*/, Value value, More more, Finish finish) const {
    for (int s = 0; s < pieces.segments; ++s) sum_of_segment<Sum>(pieces, s, value, more, finish);
  }

  /// finish(sum of value(k) over k = 0 ... n - 1), in the same order of summation each time. Not within `beside` or
  /// `side_by_side`. On a device a thread takes `a_thread` values at least.
  template <int a_thread = 4, class Value, class Finish>
  void sum(long n, Value value, Finish finish) const {
    decltype(value(0)) sum{};
    for (long k = 0; k < n; ++k) sum += value(static_cast<int>(k));
    finish(sum);
  }

  /// Each of the n values becomes the sum of those before it.
  template <class T>
  void exclusive_scan(T* values, long n) const {
    T sum{};
    for (long k = 0; k < n; ++k) {
      const T value = values[k];
      values[k] = sum;
      sum = sum + value;
    }
  }

  /// Sorts the keys, 0 ... `largest`, and takes the values along; equal keys keep their order.
  void sort(int* keys, int* values, int n, int /*largest*/ = std::numeric_limits<int>::max()) const {
    std::vector<std::pair<int, int>> pairs(n);
    for (int k = 0; k < n; ++k) pairs[k] = {keys[k], values[k]};
    std::stable_sort(pairs.begin(), pairs.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
    for (int k = 0; k < n; ++k) {
      keys[k] = pairs[k].first;
      values[k] = pairs[k].second;
    }
  }

  /// Throws Failure if so much more memory cannot be had.
  void check_room(std::size_t) const {}
  /// Bytes of memory that can still be had.
  std::size_t room() const { return std::size_t{1} << 62; }
  void* allocate(std::size_t bytes) const { return std::malloc(bytes); }
  void release(void* memory) const { std::free(memory); }
  void fill(void* memory, int byte, std::size_t bytes) const { std::memset(memory, byte, bytes); }
  void copy(void* to, const void* from, std::size_t bytes) const { std::memcpy(to, from, bytes); }
  void to_device(void* to, const void* from, std::size_t bytes) const { std::memcpy(to, from, bytes); }
  void to_host(void* to, const void* from, std::size_t bytes) const { std::memcpy(to, from, bytes); }
  /// Memory of the host that copies are fast from and to; they have been made after a wait.
  void* allocate_on_host(std::size_t bytes) const { return std::malloc(bytes); }
  void release_on_host(void* memory) const { std::free(memory); }
  void begin_to_device(void* to, const void* from, std::size_t bytes) const { std::memcpy(to, from, bytes); }
  void begin_to_host(void* to, const void* from, std::size_t bytes) const { std::memcpy(to, from, bytes); }
  void wait() const {}

  /// A sequence of kernels that is run many times.
  struct Recording {
    void clear() {}
  };
  template <class F>
  void run(Recording&, F f) const {
    f();
  }
  /// Within what is recorded: f if, or while, *flag is not 0, as its kernels find it, on the device.
  template <class F>
  void when(const int* flag, F f) const {
    if (*flag) f();
  }
  template <class F>
  void repeat_while(const int* flag, F f) const {
    while (*flag) f();
  }
  /// Within what is recorded: f(Again), and again while the Again, which a kernel of it calls, was last given true.
  struct Again {
    bool* more;
    void operator()(bool go) const { *more = go; }
  };
  template <class F>
  void repeat(F f) const {
    for (bool more = true; more;) {
      more = false;
      f(Again{&more});
    }
  }

  /// Runs f(0) ... f(n - 1), which touch nothing in common, at the same time where that can be done.
  template <class F>
  void side_by_side(int n, F f) const {
    for (int k = 0; k < n; ++k) f(k);
  }

  /// Runs f and g, which touch nothing in common, at the same time where that can be done; g where f leaves room.
  template <class F, class G>
  void beside(F f, G g) const {
    f();
    g();
  }

  /// A moment in the sequence of kernels. The executor must have waited before the time between two is asked for.
  class Moment {
   public:
    double seconds_since(const Moment& earlier) const {
      return std::chrono::duration<double>(at_ - earlier.at_).count();
    }

   private:
    friend class HostExecutor;
    std::chrono::steady_clock::time_point at_;
  };
  void mark(Moment& moment) const { moment.at_ = std::chrono::steady_clock::now(); }

  /// Seconds that f's kernels take.
  template <class F>
  double seconds(F f) const {
    const auto start = std::chrono::steady_clock::now();
    f();
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  }

 private:
  template <class Sum, class Value, class More, class Finish>
  static void sum_of_segment(const Pieces& pieces, int s, Value value, More more, Finish finish) {
    Sum sum{};
    for (int p = pieces.start[s]; p < pieces.start[s + 1]; ++p)
      for (int k = pieces.begin[p]; k < pieces.end[p]; ++k) sum += value(k);
    for (int t = 0; t < more.count(s); ++t) sum += more.value(s, t);
    finish(s, sum);
  }
};

}  // namespace lichtenberg::parallel
