#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace lichtenberg {

/// State of a run, or of one of its effects, as named arrays. A run can be resumed from its complete state.
struct Checkpoint {
  std::map<std::string, std::vector<double>> reals;
  std::map<std::string, std::vector<std::int64_t>> integers;
};

/// Returns the array `name` of real numbers in a checkpoint. Throws Failure if there is none, or if it does not have
/// `size` numbers. The checkpoint then belongs to another version of the program or to another scene.
const std::vector<double>& reals(const Checkpoint& checkpoint, const std::string& name, std::size_t size);
/// Returns the array `name` of integers in a checkpoint, of any size. Throws Failure if there is none.
const std::vector<std::int64_t>& integers(const Checkpoint& checkpoint, const std::string& name);

}  // namespace lichtenberg
