#pragma once

#include <optional>
#include <string>
#include <vector>

#include "src/commands/commands.hpp"

namespace lichtenberg {

/// What is asked of pictures of frames, one by one or as a film.
struct DrawnFrames {
  std::string frames;  ///< as in "0,5,10:20,30:90:10"; empty: what the command draws without
  std::string colour, range, cmap, cut;
  std::string output;
  bool overwrite = false;

  std::vector<Argument> arguments();
  /// As the scripts take them.
  std::vector<std::string> options() const;
  /// Whether the field may be wanted behind the particles.
  bool may_show_field() const { return colour.empty() || colour == "potential"; }
};

/// `--frames`; `otherwise`: what is taken without it.
Argument frames_argument(std::string& frames, const std::string& otherwise);

/// The indices of "0,5,10:20,30:90:10" in the order in which they are written; a range holds both its ends, and goes
/// from the first or to the last frame where it does not name them, as in "::10" (lichtenberg.result.chosen_frames
/// reads the same in Python). Throws InputError unless all are frames of `path`, which has `count`.
std::vector<int> listed_frames(const std::string& written, const std::string& path, int count);

/// Throws InputError, with what was to be `done`, if the result is damaged: Python's HDF5 would crash on some such
/// files.
void check_bytes(const std::string& path, const std::string& done = "drawn");

}  // namespace lichtenberg
