// How long a run still takes, as its line of progress says.
#include <doctest/doctest.h>

#include "src/commands/progress.hpp"

namespace commands_progress_test {

using lichtenberg::seconds_left;

TEST_CASE("time left is that of the recent pace, once a tenth is done and if that agrees with the pace so far") {
  CHECK(seconds_left(0.5, 10, 0.2, 4) == doctest::Approx(10));  // all at .05 a second
  CHECK(seconds_left(0.5, 10, 0.2, 6) == doctest::Approx(15));
  CHECK_FALSE(seconds_left(0.09, 1, 0.09, 1));   // too early
  CHECK_FALSE(seconds_left(0.5, 10, 0.1, 4.1));  // slower than twice the mean by now
  CHECK_FALSE(seconds_left(0.5, 10, 0.25, 2));   // faster than that
  CHECK_FALSE(seconds_left(0.5, 10, 0, 0));
}

}  // namespace commands_progress_test
