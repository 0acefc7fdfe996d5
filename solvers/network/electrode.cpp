#include "solvers/network/electrode.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <optional>

#include "solvers/error.hpp"

namespace lichtenberg::network {
namespace {

std::string without_blanks(const std::string& text) {
  const std::size_t first = text.find_first_not_of(' ');
  return first == std::string::npos ? "" : text.substr(first, text.find_last_not_of(' ') + 1 - first);
}

std::optional<int> number(const std::string& text) {
  int value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return {};
  return value;
}

}  // namespace

PackingElectrode read_electrode(const std::string& text, const std::vector<std::string>& walls, int particles) {
  const std::string name = without_blanks(text);
  if (const auto wall = std::ranges::find(walls, name); wall != walls.end())
    return {.wall = true, .index = static_cast<int>(wall - walls.begin())};
  const std::optional<int> particle = number(name);
  if (!particle)
    throw InputError(walls.empty() ? fmt::format("there is no wall \"{}\"; particles by number are allowed", name)
                                   : fmt::format("there is no wall \"{}\"; allowed are {} and particles by number",
                                                 name, fmt::join(walls, ", ")));
  if (*particle < 0 || *particle >= particles)
    throw InputError(fmt::format("there is no particle {}; allowed are 0 to {}", *particle, particles - 1));
  return {.wall = false, .index = *particle};
}

std::vector<PackingElectrode> read_electrodes(const std::string& between, const std::vector<std::string>& walls,
                                              int particles) {
  const std::size_t comma = between.find(',');
  if (comma == std::string::npos || between.find(',', comma + 1) != std::string::npos)
    throw InputError(fmt::format("\"{}\" is not allowed: two electrodes are needed, as in bottom,top", between));
  const std::vector<PackingElectrode> electrodes = {read_electrode(between.substr(0, comma), walls, particles),
                                                    read_electrode(between.substr(comma + 1), walls, particles)};
  if (electrodes[0] == electrodes[1])
    throw InputError(fmt::format("\"{}\" names the same electrode twice: two different ones are needed", between));
  return electrodes;
}

bool is_electrode_name(const std::string& name) {
  const bool digits = std::ranges::all_of(name, [](char c) { return c >= '0' && c <= '9'; });
  return !digits && !number(name) && name != all_particles && name.find(',') == std::string::npos &&
         without_blanks(name) == name;
}

}  // namespace lichtenberg::network
