#pragma once

#include <condition_variable>
#include <deque>
#include <exception>
#include <functional>
#include <mutex>
#include <thread>

namespace lichtenberg::parallel {

/// Task queue of bounded length: one background thread executes tasks, such as writing files, in the order of their
/// addition.
class TaskQueue {
 public:
  /// Makes an empty queue. `capacity`: maximum number of unfinished tasks; add() blocks when it is reached. With
  /// capacity 0 there is no thread, and add() executes the task itself.
  explicit TaskQueue(std::size_t capacity) : capacity_(capacity) {}
  /// Waits until no task remains; ignores exceptions of the tasks.
  ~TaskQueue();
  TaskQueue(const TaskQueue&) = delete;
  TaskQueue& operator=(const TaskQueue&) = delete;

  /// Adds a task at the end of the queue. If an earlier task failed, rethrows its exception, once, in place of the
  /// addition. The tasks that were waiting behind a failed task are dropped.
  void add(std::function<void()> task);
  /// Waits until all tasks are finished. If one failed, rethrows its exception, once.
  void finish();
  /// Returns true if a task has failed and the next call of add() or finish() will rethrow its exception.
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
