#pragma once

#include <condition_variable>
#include <deque>
#include <exception>
#include <functional>
#include <mutex>
#include <thread>

namespace lichtenberg::parallel {

/// Tasks that a thread of its own does one after the other, in the order in which they came, while their owner goes on.
class Backlog {
 public:
  /// Of at most so many that are not done; who adds one more waits. 0: no thread, each is done where it is added.
  explicit Backlog(std::size_t most) : most_(most) {}
  /// Does all there are.
  ~Backlog();
  Backlog(const Backlog&) = delete;
  Backlog& operator=(const Backlog&) = delete;

  /// Throws what a task before has thrown, once; those that came after it are dropped.
  void add(std::function<void()> task);
  /// Waits until all are done; throws as `add` does.
  void finish();
  /// Whether the next of these will throw.
  bool has_failed() const;

 private:
  void work();
  void rethrow(std::unique_lock<std::mutex> lock);

  std::size_t most_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<std::function<void()>> tasks_;  ///< the first of which is being done
  std::exception_ptr error_;
  bool stop_ = false;
  std::jthread thread_;  ///< from the first task on
};

}  // namespace lichtenberg::parallel
