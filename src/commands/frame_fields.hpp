#pragma once

#include <functional>
#include <string>
#include <vector>

#include "src/record/result.hpp"

namespace lichtenberg {

/// Whether the run has a field whose frames can be solved again.
bool has_field(const Result& result);

/// The potential around the conductors of some frames of a result, solved again from what the frames say: where the
/// conductors were and at which potential. Held in memory for a script that draws, under a path that this process,
/// what it starts and what it becomes can open: two integers of 32 bits, nx and ny, then 32-bit numbers
/// [frames][ny][nx], V, NaN for a frame that cannot be solved (standard error says why).
class FrameFields {
 public:
  /// `solved` is called with how many frames are done after each. Throws Failure if there is no memory for them.
  FrameFields(const Result& result, const std::vector<int>& frames, const std::function<void(int done)>& solved);

  const std::string& path() const { return path_; }

 private:
  int descriptor_;  ///< open until this process and all that have inherited it end: scripts read it by its number
  std::string path_;
};

}  // namespace lichtenberg
