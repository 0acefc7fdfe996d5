#pragma once

#include <atomic>
#include <cstdint>
#include <exception>
#include <functional>
#include <thread>
#include <vector>

namespace lichtenberg::parallel {

/// Team of threads for short loops. An idle thread polls for the next loop, then yields, then sleeps. A loop never
/// waits for a thread that has not joined it, so that a busy machine causes no delay. Tasks must not depend on the
/// thread that executes them; results are then bitwise identical for any number of threads.
class Team {
 public:
  /// Starts the worker threads. `threads`: total number, including the caller's. Throws Failure if the system cannot
  /// start that many.
  explicit Team(int threads);
  ~Team();
  Team(const Team&) = delete;
  Team& operator=(const Team&) = delete;

  /// Returns a team of the caller alone.
  static Team& single();

  int size() const { return static_cast<int>(workers_.size()) + 1; }

  /// Calls task(k) for every k from 0 to count - 1, in any order, and returns when all are finished. `count` must be
  /// below 2^20. Tasks must not throw and must not call for_each.
  template <class Task>
  void for_each(int count, const Task& task) {
    if (workers_.empty() || count == 1) {
      for (int k = 0; k < count; ++k) call_task<Task>(&task, k);
      return;
    }
    run_loop(count, call_task<Task>, &task);
  }

  /// Starts a longer task on a worker thread while the caller continues. `finish` executes the task if no worker has
  /// started it, waits for its end and rethrows its exception. Only one task at a time.
  void start(std::function<void()> task);
  void finish();

 private:
  using Call = void (*)(const void*, int);
  /// Compiled once for all threads. If it were inlined separately for the caller and the workers, contraction or
  /// vectorization could round differently. The call has an overhead, so a task should be a range.
  template <class Task>
  [[gnu::noinline, gnu::noclone]] static void call_task(const void* task, int k) {
    (*static_cast<const Task*>(task))(k);
  }
  void stop_workers();
  void run_loop(int count, Call call, const void* context);
  enum class End { first, last };
  bool run_next_piece(End from);
  void work_until_stopped();
  bool run_side_task();

  // Current loop: its number and the remaining indices in one word. Taking an index is one atomic exchange, which fails
  // if the loop has changed. The caller takes the first indices, workers the last ones, so that data of repeated loops
  // stay in the caches of the same thread. Only a thread with an index reads call_ and context_.
  std::atomic<std::uint64_t> loop_{0};
  std::atomic<int> done_{0};
  Call call_ = nullptr;
  const void* context_ = nullptr;

  enum SideTask : int { none, waiting, running, ended };
  std::atomic<int> side_task_{none};
  std::function<void()> side_work_;
  std::exception_ptr side_error_;

  std::atomic<bool> stop_{false};
  std::vector<std::jthread> workers_;
};

}  // namespace lichtenberg::parallel
