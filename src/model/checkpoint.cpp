#include "src/model/checkpoint.hpp"

#include <fmt/format.h>

#include "solvers/error.hpp"

namespace lichtenberg {

const std::vector<double>& reals(const Checkpoint& checkpoint, const std::string& name, std::size_t size) {
  const auto found = checkpoint.reals.find(name);
  if (found == checkpoint.reals.end())
    throw Failure(fmt::format("the checkpoint has no \"{}\": another version of the program wrote it", name));
  if (found->second.size() != size)
    throw Failure(
        fmt::format("the checkpoint holds {} values of \"{}\", but this scene needs {}: it is of another scene",
                    found->second.size(), name, size));
  return found->second;
}

const std::vector<std::int64_t>& integers(const Checkpoint& checkpoint, const std::string& name) {
  const auto found = checkpoint.integers.find(name);
  if (found == checkpoint.integers.end())
    throw Failure(fmt::format("the checkpoint has no \"{}\": another version of the program wrote it", name));
  return found->second;
}

}  // namespace lichtenberg
