#pragma once

#include <stdexcept>
#include <string>

namespace lichtenberg {

/// The user's input cannot be used: one sentence that says what is wrong, where (file, key) and what is allowed.
/// The command line prints it and exits with status 2.
struct InputError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// The work could not be done although the input is fine (full disk, a solver that failed, a damaged file): one
/// sentence. The command line prints it and exits with status 1.
struct Failure : std::runtime_error {
  using std::runtime_error::runtime_error;
};

}  // namespace lichtenberg
