// Tests of the search for the name that is nearest to a misspelt one.
#include <doctest/doctest.h>

#include <string>
#include <vector>

#include "src/scene/nearest.hpp"
#include "tests/scene_texts.hpp"

namespace scene_nearest_test {

using namespace lichtenberg;
using namespace lichtenberg::scene_texts;

TEST_CASE("unknown keys of a scene: the error names the nearest known one") {
  check_refused(box + "field.cell = 64\n", {"test.toml:3:", "unknown key field.cell:", "field.cells"});
  check_refused(box + disk("[0.01, 0.01]", "raduis = 0.001\n"), {"unknown key conductor.raduis:", "conductor.radius"});
  check_refused(box + "[[conductors]]\n", {"unknown key conductors:", "nearest known key is conductor"});
  check_refused(box + "[effects.stokes]\n", {"unknown key effects.stokes:", "effects.stokes_drag"});
  check_refused(box + "[material]\nviscosity = 0.7\n", {"unknown key material.viscosity:", "medium.viscosity"});
  check_refused(box + "[material]\npoisson = 0.3\n",
                {"unknown key material.poisson:", "the nearest known key is conductor.poisson"});
  check_refused(box + "sede = 4\n", {"unknown key sede:", "is seed"});
}

TEST_CASE("edit_distance: counts insertions, deletions and replacements") {
  CHECK(edit_distance("", "abc") == 3);
  CHECK(edit_distance("cells", "cells") == 0);
  CHECK(edit_distance("kitten", "sitting") == 3);  // k->s, e->i, +g
  CHECK(edit_distance("cell", "cells") == 1);
  CHECK(nearest("grond", {"wire", "ground"}) == "ground");
}

TEST_CASE("likely: finds the word for a slip or a prefix, none for a far word") {
  const std::vector<std::string> words{"run", "network", "analyse", "work-precision", "film"};
  CHECK(likely("analyze", words) == "analyse");
  CHECK(likely("analysis", words) == "analyse");  // s -> e after i -> s: two replacements and one deletion.
  CHECK(likely("work", words) == "work-precision");
  CHECK(likely("rnu", words) == "run");
  CHECK_FALSE(likely("electrode", words));
  CHECK_FALSE(likely("xy", words));  // Two edits would change the whole word.
  CHECK_FALSE(likely("run", {}));
}

}  // namespace scene_nearest_test
