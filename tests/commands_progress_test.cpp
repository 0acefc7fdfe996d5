// Test of the remaining time in a run's line of progress.
#include <doctest/doctest.h>

#include "src/commands/progress.hpp"

namespace commands_progress_test {

using lichtenberg::seconds_left;

TEST_CASE("seconds_left: from the recent pace; none if far from the mean pace") {
  CHECK(seconds_left(0.5, 10, 0.2, 4) == doctest::Approx(10));  // Uniform pace of 0.05 per second.
  CHECK(seconds_left(0.5, 10, 0.2, 6) == doctest::Approx(15));
  CHECK_FALSE(seconds_left(0.09, 1, 0.09, 1));   // Less than 10 % is done.
  CHECK_FALSE(seconds_left(0.5, 10, 0.1, 4.1));  // The recent pace is below half of the mean.
  CHECK_FALSE(seconds_left(0.5, 10, 0.25, 2));   // The recent pace is more than twice the mean.
  CHECK_FALSE(seconds_left(0.5, 10, 0, 0));
}

}  // namespace commands_progress_test
