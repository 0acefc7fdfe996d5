#pragma once

#include <atomic>
#include <cstdint>
#include <exception>
#include <functional>
#include <thread>
#include <vector>

namespace lichtenberg::parallel {

/// Thread pool for short parallel loops (some microseconds). An idle thread polls for the next loop, then yields, then
/// sleeps. A loop does not wait for threads that have not taken part in it, such as threads without a processor on a
/// busy machine. Tasks must not depend on the thread that executes them; results then have identical bits for any
/// number of threads.
class Team {
 public:
  /// Starts the worker threads. `threads`: total number of threads including the caller's. Throws Failure if the system
  /// cannot start as many.
  explicit Team(int threads);
  ~Team();
  Team(const Team&) = delete;
  Team& operator=(const Team&) = delete;

  /// Returns a team without worker threads: the caller executes all tasks.
  static Team& single();

  /// Returns the number of threads, including the caller's.
  int size() const { return static_cast<int>(workers_.size()) + 1; }

  /// Parallel loop: calls task(k) for every k from 0 to count - 1 on the threads of the team, in any order. Returns
  /// when all calls are finished. `count` must be below 2^20. Tasks must not throw and must not call for_each() of this
  /// team.
  template <class Task>
  void for_each(int count, const Task& task) {
    if (workers_.empty() || count == 1) {
      for (int k = 0; k < count; ++k) call_task<Task>(&task, k);
      return;
    }
    run_loop(count, call_task<Task>, &task);
  }

  /// Starts a longer task on a worker thread while the caller continues. Without worker threads finish() executes it.
  /// There is one such task at a time: finish() must be called before the next start().
  void start(std::function<void()> task);
  /// Waits for the end of the task of start(), or executes it if no worker has started it. Rethrows its exception. No
  /// effect without a task.
  void finish();

 private:
  using Call = void (*)(const void*, int);
  /// Calls a task with index k. The function is compiled once for all threads: if it were inlined separately for the
  /// caller and the workers, contraction or vectorization could round differently. The call has an overhead, so the
  /// task for one index should process a range of items.
  template <class Task>
  [[gnu::noinline, gnu::noclone]] static void call_task(const void* task, int k) {
    (*static_cast<const Task*>(task))(k);
  }
  void stop_workers();
  void run_loop(int count, Call call, const void* context);
  enum class End { first, last };  ///< End of the remaining indices from which a thread takes the next index
  bool run_next_piece(End from);
  void work_until_stopped();
  bool run_side_task();

  // Current loop: its number and the range of remaining indices in one word. A thread takes an index by one atomic
  // exchange, which fails if the loop has changed. The caller takes the first indices, workers the last ones, so that
  // data of repeated loops stay in the caches of the same thread. Only a thread with an index reads call_ and context_.
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
