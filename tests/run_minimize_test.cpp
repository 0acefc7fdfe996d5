// Tests of the command run for packings: continued minimizations.
#include <doctest/doctest.h>

#include <cstdint>
#include <numeric>
#include <string>
#include <vector>

#include "src/record/hdf5.hpp"
#include "src/record/result_file.hpp"
#include "tests/folder.hpp"
#include "tests/run_child.hpp"

namespace run_minimize_test {

using namespace lichtenberg;
using namespace lichtenberg::run_child;

TEST_CASE("minimize: resumed with other limits, it equals an uninterrupted run") {
  const Folder folder;
  std::string output;
  const auto relax_to = [&](const std::string& end, const std::string& file, std::vector<std::string> options = {}) {
    folder.write("six.toml",
                 "[domain]\nsize = [6.4, 6.4]\n[effects.soft_repulsion]\n[[population]]\ncount = 50\n"
                 "radius = [0.4, 0.6]\noverlapping = true\n[output]\npicture = false\n" +
                     output + "[minimize]\n" + end);
    options.push_back("--quiet");
    REQUIRE_EQ(run(folder, file, options), 0);
    return folder / file;
  };
  const auto at_rest = [](const std::string& path) { return number(path, "summary/at_rest") == 1; };
  const auto notes = [](const std::string& path) {
    return hdf5::get<std::int64_t>(hdf5::load(path), "relaxation/iteration");
  };
  // The last iteration is a frame, a checkpoint, a history row and the end; its row appears once.
  output = "checkpoint_every = 1\n";
  const std::string ten = relax_to("max_iterations = 10\nrecord_every = 1\n", "ten.h5");
  output.clear();
  std::vector<std::int64_t> each(11);
  std::iota(each.begin(), each.end(), 0);
  CHECK(notes(ten) == each);
  const std::string whole = relax_to("force_tolerance = 1e-9\n", "whole.h5");
  CHECK(at_rest(whole));
  std::string cut = relax_to("max_iterations = 30\nforce_tolerance = 1e-5\n", "cut.h5");
  CHECK(!at_rest(cut));
  const std::vector<std::string> warnings = ResultFile(cut, "read").warnings();
  REQUIRE(!warnings.empty());
  CHECK(warnings[0].starts_with("not at rest after 30 iterations: "));
  CHECK(number(cut, "summary/iterations") == 30);
  relax_to("force_tolerance = 1e-5\n", "cut.h5", {"--resume"});
  CHECK(at_rest(cut));
  CHECK(ResultFile(cut, "read").warnings().empty());
  const double earlier = number(cut, "summary/relative_largest_force");
  CHECK((earlier <= 1e-5 && earlier > 1e-9));
  // The state already meets the new tolerance: no frame and no history row are added.
  const auto before = frames(cut);
  const auto noted = notes(cut);
  relax_to("max_iterations = 30\nforce_tolerance = 1e-9\n", "cut.h5", {"--resume"});
  CHECK(!at_rest(cut));
  CHECK(frames(cut) == before);
  CHECK(notes(cut) == noted);
  relax_to("force_tolerance = 1e-9\n", "cut.h5", {"--resume"});
  CHECK(at_rest(cut));
  for (const std::string same :
       {"summary/iterations", "summary/energy", "summary/largest_force", "summary/evaluations"})
    CHECK(number(cut, same) == number(whole, same));
}

}  // namespace run_minimize_test
