#include "solvers/parallel/task_queue.hpp"

#include <utility>

namespace lichtenberg::parallel {

TaskQueue::~TaskQueue() {
  {
    const std::lock_guard lock(mutex_);
    stop_ = true;
  }
  changed_.notify_all();
}

void TaskQueue::add(std::function<void()> task) {
  if (capacity_ == 0) return task();
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [&] { return tasks_.size() < capacity_ || error_; });
  if (error_) return rethrow(std::move(lock));
  if (!thread_.joinable()) thread_ = std::jthread([this] { work(); });
  tasks_.push_back(std::move(task));
  lock.unlock();
  changed_.notify_all();
}

void TaskQueue::finish() {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [&] { return tasks_.empty(); });
  if (error_) rethrow(std::move(lock));
}

bool TaskQueue::has_failed() const {
  const std::lock_guard lock(mutex_);
  return error_ != nullptr;
}

void TaskQueue::rethrow(std::unique_lock<std::mutex> lock) {
  const std::exception_ptr error = std::exchange(error_, nullptr);
  lock.unlock();
  std::rethrow_exception(error);
}

void TaskQueue::work() {
  std::unique_lock lock(mutex_);
  while (true) {
    changed_.wait(lock, [&] { return stop_ || !tasks_.empty(); });
    if (tasks_.empty()) return;
    std::exception_ptr error;
    {
      const std::function<void()> task = std::exchange(tasks_.front(), nullptr);
      lock.unlock();
      try {
        task();
      } catch (...) {
        error = std::current_exception();
      }
    }  // Destroys the task with its captured data before the lock
    lock.lock();
    tasks_.pop_front();
    if (error) {
      error_ = error;
      std::exchange(tasks_, {});
    }
    changed_.notify_all();
  }
}

}  // namespace lichtenberg::parallel
