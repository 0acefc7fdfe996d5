#pragma once

#include <atomic>
#include <cstdint>
#include <exception>
#include <functional>
#include <thread>
#include <vector>

namespace lichtenberg::parallel {

/// Threads that share loops of some microseconds. Who has nothing to do watches for the next loop for a moment, yields
/// for a millisecond, then sleeps; a loop never waits for a thread that has not come to help, so that a busy machine
/// delays nobody. What a task computes must not depend on who does it: then the results are the same bits for any
/// number of threads.
class Team {
 public:
  /// Threads in all, the caller's among them. Throws Failure if the machine does not give so many.
  explicit Team(int threads);
  ~Team();
  Team(const Team&) = delete;
  Team& operator=(const Team&) = delete;

  /// A team of the caller alone.
  static Team& single();

  int size() const { return static_cast<int>(helpers_.size()) + 1; }

  /// Calls task(k) for every k from 0 to count - 1, in any order, and returns when all are done. Fewer than 2^20 of
  /// them. Tasks must not throw and must not call for_each themselves.
  template <class Task>
  void for_each(int count, const Task& task) {
    if (helpers_.empty() || count == 1) {
      for (int k = 0; k < count; ++k) do_one<Task>(&task, k);
      return;
    }
    share(count, do_one<Task>, &task);
  }

  /// Leaves a longer task to a helper while the caller goes on; `finish` does it now if no helper has begun, waits for
  /// its end and rethrows what it threw. One at a time.
  void start(std::function<void()> task);
  void finish();

 private:
  using Call = void (*)(const void*, int);
  /// Compiled once, for who is alone and for who shares: inlined into one of the two, a task could be contracted or
  /// vectorized, and so be rounded, otherwise. The call costs about a nanosecond, so that a task should be a range.
  template <class Task>
  [[gnu::noinline, gnu::noclone]] static void do_one(const void* task, int k) {
    (*static_cast<const Task*>(task))(k);
  }
  void dismiss();
  void share(int count, Call call, const void* context);
  enum class From { first, last };
  bool help(From from);
  void help_until_stopped();
  bool run_side_task();

  // The loop in progress: its number and which indices are left in one word, so that taking one is one exchange that
  // fails if the loop is another one by now. The caller takes the first, helpers the last: what pass after pass is at
  // the same place of memory stays in the caches of who had it. call_ and context_ are read by who has an index only.
  std::atomic<std::uint64_t> loop_{0};
  std::atomic<int> done_{0};
  Call call_ = nullptr;
  const void* context_ = nullptr;

  enum SideTask : int { none, waiting, running, ended };
  std::atomic<int> side_task_{none};
  std::function<void()> side_work_;
  std::exception_ptr side_error_;

  std::atomic<bool> stop_{false};
  std::vector<std::jthread> helpers_;
};

}  // namespace lichtenberg::parallel
