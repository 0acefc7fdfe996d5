#pragma once

#include <exception>
#include <functional>
#include <string>

namespace lichtenberg {

/// Message of the action's exception; empty if it throws none.
inline std::string message_of(const std::function<void()>& action) {
  try {
    action();
  } catch (const std::exception& error) {
    return error.what();
  }
  return "";
}

}  // namespace lichtenberg
