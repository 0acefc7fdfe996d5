#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace lichtenberg {

/// Complete state of a run as named arrays. A run that is resumed from it continues as if it had not been interrupted.
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
