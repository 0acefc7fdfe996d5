// Tests of the queue of tasks that a background thread executes for its owner.

#include <doctest/doctest.h>

#include <atomic>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "solvers/error.hpp"
#include "solvers/parallel/task_queue.hpp"
#include "tests/message.hpp"

namespace backlog_test {

using namespace lichtenberg;
using parallel::TaskQueue;

TEST_CASE("TaskQueue: tasks run in order and are complete after finish()") {
  for (const std::size_t most : {0, 1, 2, 100}) {
    std::vector<int> done;
    {
      TaskQueue queue(most);
      for (int k = 0; k < 50; ++k) queue.add([&, k] { done.push_back(k); });
      queue.finish();
      CHECK(done.size() == 50);
      queue.add([&] { done.push_back(50); });
    }
    REQUIRE(done.size() == 51);
    for (int k = 0; k <= 50; ++k) CHECK(done[k] == k);
  }
}

TEST_CASE("TaskQueue: add() blocks when full, completed tasks are released") {
  std::atomic<int> begun = 0, added = 0;
  std::atomic<bool> go = false;
  const auto held = std::make_shared<int>();
  {
    TaskQueue queue(2);
    const std::jthread owner([&] {
      for (int k = 0; k < 4; ++k) {
        queue.add([&begun, &go, held] {
          ++begun;
          go.wait(false);
        });
        ++added;
      }
    });
    while (added < 2 || begun < 1) std::this_thread::yield();
    // The first task runs, the second waits, and the third exceeds the capacity.
    CHECK(added == 2);
    go = true;
    go.notify_all();
  }
  CHECK(begun == 4);
  CHECK(held.use_count() == 1);
}

TEST_CASE("TaskQueue: the owner gets an exception once, later tasks are skipped") {
  int done = 0;
  TaskQueue queue(10);
  std::atomic<bool> go = false;
  queue.add([&] {
    go.wait(false);
    throw Failure("no room");
  });
  queue.add([&] { ++done; });
  go = true;
  go.notify_all();
  CHECK(message_of([&] { queue.finish(); }) == "no room");
  CHECK(done == 0);
  CHECK_FALSE(queue.has_failed());
  queue.add([&] { ++done; });
  queue.finish();
  CHECK(done == 1);
}

}  // namespace backlog_test
