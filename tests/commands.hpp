#pragma once

#include <doctest/doctest.h>

#include <string>

#include "tests/near.hpp"
#include "tests/program.hpp"

/// Common definitions of tests of the command line, in their own namespace because test files are compiled together.
namespace lichtenberg::command_line_tests {

inline Ended run(const Folder& folder, const std::string& arguments) { return run_program(folder, arguments); }
inline Ended run(const std::string& arguments) { return run(Folder(), arguments); }

inline bool is_one_line(const std::string& text) {
  return text.starts_with("lichtenberg: ") && text.find('\n') == text.size() - 1;
}

inline void check_refused(const Ended& result, const std::string& part) {
  INFO(result.err);
  CHECK(result.status == 2);
  CHECK(result.out.empty());
  CHECK(is_one_line(result.err));
  CHECK(contains(result.err, part));
}

/// A small scene whose field takes milliseconds.
inline const std::string small_scene = R"(
  [domain]
  size = [16e-3, 16e-3]
  bottom = { potential = 0.0 }
  [medium]
  permittivity = 4e-11
  [[conductor]]
  position = [5e-3, 8e-3]
  radius = 1e-3
  charge = 1e-10
  [[conductor]]
  position = [11e-3, 8e-3]
  radius = 1e-3
  [effects.floating_conductors]
  [field]
  cells = 64
)";

}  // namespace lichtenberg::command_line_tests
