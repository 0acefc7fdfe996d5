#pragma once

#include <doctest/doctest.h>

#include "src/mechanics/simulation.hpp"

/// Checks that a simulation restored at `middle` (s) is bitwise identical at `end` to one that continues.
inline void check_restored(const lichtenberg::Scene& scene, double middle, double end) {
  lichtenberg::Simulation whole(scene), resumed(scene);
  whole.advance_to(middle);
  resumed.restore(whole.checkpoint());
  whole.advance_to(end);
  resumed.advance_to(end);
  REQUIRE(whole.model().bodies.size() > 0);
  CHECK(whole.checkpoint().reals == resumed.checkpoint().reals);
  CHECK(whole.now().potential == resumed.now().potential);
}
