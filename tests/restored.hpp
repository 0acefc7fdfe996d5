#pragma once

#include <doctest/doctest.h>

#include "src/mechanics/simulation.hpp"

/// A simulation that is restored at `middle` (s) has the bits of one that goes on, at `end`.
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
