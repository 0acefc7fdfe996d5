#pragma once

#include <exception>
#include <functional>
#include <string>

namespace lichtenberg {

/// Message of the action's exception of this class; empty if it throws none.
template <class Exception = std::exception>
std::string message_of(const std::function<void()>& action) {
  try {
    action();
  } catch (const Exception& error) {
    return error.what();
  }
  return "";
}

}  // namespace lichtenberg
