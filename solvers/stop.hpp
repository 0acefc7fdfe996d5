#pragma once

#include <functional>
#include <utility>

namespace lichtenberg {

/// Exception that ends a computation after a stop request.
struct Stopped {};

/// Stop request of the field solves of one thread. While an object exists, solves of its thread call the function
/// between iterations and between parts of their setup. They throw Stopped if it returns true.
class StopRequestScope {
 public:
  explicit StopRequestScope(std::function<bool()> requested)
      : requested_(std::move(requested)), before_(std::exchange(current(), this)) {}
  StopRequestScope(const StopRequestScope&) = delete;
  StopRequestScope& operator=(const StopRequestScope&) = delete;
  ~StopRequestScope() { current() = before_; }

  /// Returns true if this thread has a scope, and its function returns true. For callbacks of C libraries, through
  /// which no exception may pass.
  static bool requested() { return current() && current()->requested_(); }

 private:
  static StopRequestScope*& current() {
    static thread_local StopRequestScope* scope = nullptr;
    return scope;
  }

  std::function<bool()> requested_;
  StopRequestScope* before_;
};

/// Throws Stopped if the scope of this thread has a stop request.
inline void stop_if_requested() {
  if (StopRequestScope::requested()) throw Stopped{};
}

}  // namespace lichtenberg
