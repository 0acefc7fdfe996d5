// The field at its limits: one line a case, with the bound that it must meet and, in the case's comment, where the
// bound comes from. The same in time: hard_cases_time.
//
//   hard_cases          everything but what is below, 400 random scenes; seconds
//   hard_cases long     10000 random scenes, N = 20000 at S = 4096, more positions; minutes

#include "validation/hard_cases/crowds.hpp"
#include "validation/hard_cases/gaps.hpp"
#include "validation/hard_cases/grid.hpp"
#include "validation/hard_cases/random_scenes.hpp"
#include "validation/program.hpp"

namespace hard_cases_validation {

using namespace lichtenberg::validation;

int validate(int argc, char** argv) {
  const bool is_long = asked_for_long(argc, argv);
  Report report("Hard cases of the field");
  narrow_gaps(report, is_long);
  hard_for_the_grid(report, is_long);
  hard_for_crowds(report, is_long);
  random_scenes(report, is_long ? 10000 : 400);
  return report.exit_status();
}

const lichtenberg::validation::Program program("hard_cases", validate);

}  // namespace hard_cases_validation
