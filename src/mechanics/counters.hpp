#pragma once

#include <cstdint>

#include "solvers/stopwatch.hpp"

namespace lichtenberg {

/// Work of a run: numbers of field solves, steps and contact changes since its start, and wall time by part since the
/// program started.
struct Counters {
  std::int64_t field_solves = 0;
  std::int64_t iterations = 0;      ///< of the linear solver, sum over all solves
  std::int64_t predictions = 0;     ///< solves on the predictor's grid
  std::int64_t steps = 0;           ///< coupling steps accepted
  std::int64_t rejected_steps = 0;  ///< coupling steps repeated because of their error
  /// Accepted and repeated intervals between two field solves; the steps in an interval use the predictor's field.
  std::int64_t corrections = 0, rejected_corrections = 0;
  std::int64_t contacts_made = 0, contacts_lost = 0;
  std::int64_t regroupings = 0;  ///< changes of the equipotential groups by contacts
  // Wall time (s) since the program started. The last is the time of all steps and includes the others.
  double field_seconds = 0, mechanics_seconds = 0, contact_seconds = 0, all_seconds = 0;
};

}  // namespace lichtenberg
