// The field in limiting cases: one row per case, with a bound derived in the comment of the case. hard_cases_time
// covers limiting cases in time.
//
//   hard_cases          all cases except the ones below, 100 random scenes; seconds
//   hard_cases long     10000 random scenes, N = 20000 at S = 4096, more positions; minutes

#include "validation/hard_cases/gaps.hpp"
#include "validation/hard_cases/grid.hpp"
#include "validation/hard_cases/many_bodies.hpp"
#include "validation/hard_cases/random_scenes.hpp"
#include "validation/program.hpp"

namespace hard_cases_validation {

using namespace lichtenberg::validation;

int validate(int argc, char** argv) {
  const bool is_long = long_run_requested(argc, argv);
  Report report("Hard cases of the field");
  narrow_gaps(report, is_long);
  hard_for_the_grid(report, is_long);
  hard_for_many_bodies(report, is_long);
  random_scenes(report, is_long ? 10000 : 100);
  return report.exit_status();
}

const lichtenberg::validation::Program program("hard_cases", validate);

}  // namespace hard_cases_validation
