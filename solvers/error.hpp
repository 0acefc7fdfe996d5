#pragma once

#include <stdexcept>
#include <string>

namespace lichtenberg {

/// Error in the user's input. The message states the failure, its location (file, key) and the allowed values. The
/// command line prints it and exits with status 2.
struct InputError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Failure with valid input (full disk, failed solver, damaged file). The command line prints its message and exits
/// with status 1.
struct Failure : std::runtime_error {
  using std::runtime_error::runtime_error;
};

}  // namespace lichtenberg
