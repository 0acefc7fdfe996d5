#pragma once

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <numeric>
#include <utility>
#include <vector>

namespace lichtenberg::parallel {

/// Runs a device's algorithms on the CPU, item after item: their reference, and what the tests run. CudaExecutor has
/// the same functions.
class HostExecutor {
 public:
  /// f(k) for k = 0 ... n - 1, in any order.
  template <class F>
  void for_each(long n, F f) const {
    for (long k = 0; k < n; ++k) f(static_cast<int>(k));
  }

  /// f(row, column), in any order.
  template <class F>
  void for_each(int rows, int columns, F f) const {
    for (int row = 0; row < rows; ++row)
      for (int column = 0; column < columns; ++column) f(row, column);
  }

  /// finish(s, sum of value(s, t) over t = 0 ... count(s) - 1) for every segment s; the same order of summation each
  /// time.
  template <class Count, class Value, class Finish>
  void sum_segments(long n, Count count, Value value, Finish finish) const {
    using Sum = decltype(value(0, 0));
    for (int s = 0; s < n; ++s) {
      Sum sum{};
      const int end = count(s);
      for (int t = 0; t < end; ++t) sum += value(s, t);
      finish(s, sum);
    }
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

  /// Sorts the keys and takes the values along; equal keys keep their order.
  void sort(int* keys, int* values, int n) const {
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
  void* allocate(std::size_t bytes) const { return std::malloc(bytes); }
  void release(void* memory) const { std::free(memory); }
  void fill(void* memory, int byte, std::size_t bytes) const { std::memset(memory, byte, bytes); }
  void copy(void* to, const void* from, std::size_t bytes) const { std::memcpy(to, from, bytes); }
  void to_device(void* to, const void* from, std::size_t bytes) const { std::memcpy(to, from, bytes); }
  void to_host(void* to, const void* from, std::size_t bytes) const { std::memcpy(to, from, bytes); }
  void wait() const {}

  /// A sequence of kernels that is run many times.
  struct Recording {
    void clear() {}
  };
  template <class F>
  void run(Recording&, F f) const {
    f();
  }

  /// Seconds that f's kernels take.
  template <class F>
  double seconds(F f) const {
    const auto start = std::chrono::steady_clock::now();
    f();
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  }
};

}  // namespace lichtenberg::parallel
