#pragma once

#include <stdexcept>
#include <string>

namespace lichtenberg {

/// Exception for an error in the user's input. Its message states the failure and, where they apply, the location
/// (file, key) and the allowed values. The command line prints the message and exits with status 2.
struct InputError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Exception for a failure in spite of valid input, such as a full disk or a failed solver. The command line prints its
/// message and exits with status 1.
struct Failure : std::runtime_error {
  using std::runtime_error::runtime_error;
};

}  // namespace lichtenberg
