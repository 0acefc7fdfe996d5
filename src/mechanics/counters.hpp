#pragma once

#include <cstdint>

#include "solvers/stopwatch.hpp"

namespace lichtenberg {

/// What a run has done so far, and where its time went.
struct Counters {
  std::int64_t field_solves = 0;
  std::int64_t iterations = 0;                             ///< of the linear solver, all solves together
  std::int64_t predictions = 0;                            ///< solves on the predictor's grid
  std::int64_t steps = 0;                                  ///< coupling steps accepted
  std::int64_t rejected_steps = 0;                         ///< coupling steps repeated because of their error
  std::int64_t corrections = 0, rejected_corrections = 0;  ///< the same for steps from field solve to field solve
  std::int64_t contacts_made = 0, contacts_lost = 0;
  std::int64_t regroupings = 0;  ///< times that made or lost contacts changed who is one with whom
  // Wall time (s) since the program started; the last is that of all of a simulation's steps, the others included.
  double field_seconds = 0, mechanics_seconds = 0, contact_seconds = 0, all_seconds = 0;
};

}  // namespace lichtenberg
