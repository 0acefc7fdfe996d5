#pragma once

#include <condition_variable>
#include <deque>
#include <exception>
#include <functional>
#include <mutex>
#include <thread>

namespace lichtenberg::parallel {

/// Task queue: one background thread executes tasks in the order of their addition.
class TaskQueue {
 public:
  /// Makes an empty queue. `capacity`: capacity in unfinished tasks; add() blocks when it is reached. 0: no thread,
  /// add() executes the task itself.
  explicit TaskQueue(std::size_t capacity) : capacity_(capacity) {}
  /// Executes all remaining tasks.
  ~TaskQueue();
  TaskQueue(const TaskQueue&) = delete;
  TaskQueue& operator=(const TaskQueue&) = delete;

  /// Adds a task. Rethrows the exception of an earlier task, once; tasks after the failed one are dropped.
  void add(std::function<void()> task);
  /// Waits until all tasks are finished. Throws like `add`.
  void finish();
  /// Returns true if the next call of `add` or `finish` will throw.
  bool has_failed() const;

 private:
  void work();
  void rethrow(std::unique_lock<std::mutex> lock);

  std::size_t capacity_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<std::function<void()>> tasks_;  ///< Unfinished tasks; the first one is running
  std::exception_ptr error_;
  bool stop_ = false;
  std::jthread thread_;  ///< Starts with the first task
};

}  // namespace lichtenberg::parallel
