#pragma once

#include <exception>
#include <functional>
#include <string>

namespace lichtenberg {

/// What the action's exception says; empty if it throws none.
inline std::string message_of(const std::function<void()>& action) {
  try {
    action();
  } catch (const std::exception& error) {
    return error.what();
  }
  return "";
}

}  // namespace lichtenberg
