#pragma once

#include <optional>
#include <string>
#include <variant>

#include "src/commands/commands.hpp"

namespace lichtenberg::fuzz {

/// Sets an argument of a command, as the command line does. The value of an option without one is not read.
inline void set(const Command& command, const std::string& name, const std::string& value) {
  struct Set {
    const std::string& value;
    void operator()(bool* target) const { *target = true; }
    void operator()(int* target) const { *target = std::stoi(value); }
    void operator()(std::optional<int>* target) const { *target = std::stoi(value); }
    void operator()(std::string* target) const { *target = value; }
    void operator()(std::optional<std::string>* target) const { *target = value; }
    void operator()(std::vector<std::string>* target) const { target->push_back(value); }
    void operator()(std::vector<int>* target) const { target->push_back(std::stoi(value)); }
    void operator()(double* target) const { *target = std::stod(value); }
    void operator()(std::optional<double>* target) const { *target = std::stod(value); }
  };
  for (const Argument& argument : command.arguments)
    if (argument.name == name) std::visit(Set{value}, argument.target);
}

}  // namespace lichtenberg::fuzz
