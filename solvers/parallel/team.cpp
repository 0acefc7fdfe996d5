#include "solvers/parallel/team.hpp"

#include <chrono>
#include <string>
#include <utility>

#include "solvers/error.hpp"

namespace lichtenberg::parallel {

namespace {

// Layout of loop_: 24 bits for the loop's number, 20 for the end of the remaining indices, 20 for the first of them.
constexpr int index_bits = 20;
constexpr std::uint64_t index_mask = (1u << index_bits) - 1;
constexpr std::uint64_t first_remaining(std::uint64_t loop) { return loop & index_mask; }
constexpr std::uint64_t end_of_remaining(std::uint64_t loop) { return (loop >> index_bits) & index_mask; }
constexpr bool any_remaining(std::uint64_t loop) { return first_remaining(loop) < end_of_remaining(loop); }

/// Times for which an idle thread polls, and then yields its processor, before it sleeps. Waking a thread takes longer
/// than most loops. The serial parts between a solve's loops are shorter than these times, and so are the parts between
/// two solves of a run. A sleeping worker would miss the loops that follow.
constexpr std::chrono::microseconds polling_time{50}, yielding_time{1000};

void pause() {
#if defined(__x86_64__)
  __builtin_ia32_pause();
#else
  std::this_thread::yield();
#endif
}

/// Waits a moment in a loop that polls since `start`. Returns false if the thread should sleep instead.
bool poll_again(std::chrono::steady_clock::time_point start) {
  const auto idle = std::chrono::steady_clock::now() - start;
  if (idle < polling_time)
    pause();
  else if (idle < yielding_time)
    std::this_thread::yield();
  else
    return false;
  return true;
}

}  // namespace

Team::Team(int threads) {
  for (int k = 1; k < threads; ++k) try {
      workers_.emplace_back([this] { work_until_stopped(); });
    } catch (const std::exception& error) {
      stop_workers();  // Stops the started threads: their destructors would wait for them
      throw Failure("thread " + std::to_string(k + 1) + " of " + std::to_string(threads) + " cannot be started (" +
                    error.what() + "): use fewer threads");
    }
}

Team::~Team() { stop_workers(); }

void Team::stop_workers() {
  stop_ = true;
  loop_.fetch_add(std::uint64_t{1} << (2 * index_bits));
  loop_.notify_all();
}

Team& Team::single() {
  static Team team(1);
  return team;
}

/// Executes the first or the last remaining piece of the current loop; returns false if there is none.
bool Team::run_next_piece(End from) {
  std::uint64_t loop = loop_.load(std::memory_order_acquire), taken = 0;
  do {
    if (!any_remaining(loop)) return false;
    taken = from == End::first ? loop + 1 : loop - (std::uint64_t{1} << index_bits);
  } while (!loop_.compare_exchange_weak(loop, taken, std::memory_order_acq_rel, std::memory_order_acquire));
  call_(context_, static_cast<int>(from == End::first ? first_remaining(loop) : end_of_remaining(taken)));
  done_.fetch_add(1, std::memory_order_release);
  return true;
}

void Team::run_loop(int count, Call call, const void* context) {
  call_ = call;
  context_ = context;
  done_.store(0, std::memory_order_relaxed);
  const std::uint64_t number = (loop_.load(std::memory_order_relaxed) >> (2 * index_bits)) + 1;
  loop_.store(number << (2 * index_bits) | static_cast<std::uint64_t>(count) << index_bits, std::memory_order_release);
  loop_.notify_all();
  while (run_next_piece(End::first)) {
  }
  while (done_.load(std::memory_order_acquire) < count) pause();
}

bool Team::run_side_task() {
  int expected = waiting;
  if (!side_task_.compare_exchange_strong(expected, running, std::memory_order_acq_rel)) return false;
  try {
    side_work_();
  } catch (...) {
    side_error_ = std::current_exception();
  }
  side_task_.store(ended, std::memory_order_release);
  side_task_.notify_all();
  return true;
}

void Team::work_until_stopped() {
  while (!stop_) {
    const auto start = std::chrono::steady_clock::now();
    while (!stop_ && !run_side_task() && !run_next_piece(End::last)) {
      if (poll_again(start)) continue;
      const std::uint64_t seen = loop_.load(std::memory_order_acquire);
      if (any_remaining(seen) || side_task_ == waiting || stop_) break;
      loop_.wait(seen, std::memory_order_acquire);
      break;
    }
  }
}

void Team::start(std::function<void()> task) {
  side_work_ = std::move(task);
  side_error_ = nullptr;
  side_task_.store(waiting, std::memory_order_release);
  if (workers_.empty()) return;
  // An empty loop wakes the workers.
  loop_.store(((loop_.load(std::memory_order_relaxed) >> (2 * index_bits)) + 1) << (2 * index_bits),
              std::memory_order_release);
  loop_.notify_all();
}

void Team::finish() {
  if (!run_side_task()) {
    const auto start = std::chrono::steady_clock::now();
    while (side_task_.load(std::memory_order_acquire) == running && poll_again(start)) {
    }
    side_task_.wait(running, std::memory_order_acquire);
  }
  side_task_.store(none, std::memory_order_relaxed);
  side_work_ = nullptr;
  if (side_error_) std::rethrow_exception(std::exchange(side_error_, nullptr));
}

}  // namespace lichtenberg::parallel
