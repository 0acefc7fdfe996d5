#include "src/commands/drawn_frames.hpp"

#include <fmt/format.h>

#include <charconv>
#include <cstdint>

#include "solvers/error.hpp"
#include "src/commands/reading.hpp"
#include "src/record/result_file.hpp"

namespace lichtenberg {
namespace {

std::vector<std::string> parts(const std::string& text, char separator) {
  std::vector<std::string> all(1);
  for (const char c : text)
    if (c == separator)
      all.emplace_back();
    else
      all.back() += c;
  return all;
}

int frame_number(const std::string& text, const std::string& path, int count) {
  int frame = -1;
  const char* end = text.data() + text.size();
  const auto [stopped, error] = std::from_chars(text.data(), end, frame);
  if (error != std::errc() || stopped != end)
    throw InputError(
        fmt::format("`{}` is no frame: indices and ranges are wanted, as in --frames 0,5,10:20,30:90:10", text));
  if (frame < 0 || frame >= count)
    throw InputError(fmt::format("frame {} is not in {}: it has frames 0 to {}", frame, path, count - 1));
  return frame;
}

int step_of(const std::string& text, const std::string& written) {
  int step = 0;
  const char* end = text.data() + text.size();
  const auto [stopped, error] = std::from_chars(text.data(), end, step);
  if (error != std::errc() || stopped != end || step < 1)
    throw InputError(fmt::format("--frames {}: the step `{}` must be a whole number from 1 on", written, text));
  return step;
}

}  // namespace

std::vector<int> listed_frames(const std::string& written, const std::string& path, int count) {
  std::vector<int> frames;
  for (const std::string& part : parts(written, ',')) {
    const std::vector<std::string> ends = parts(part, ':');
    if (ends.size() > 3)
      throw InputError(fmt::format("--frames {}: `{}` has more than FIRST:LAST:STEP", written, part));
    const bool range = ends.size() > 1;
    const int first = range && ends[0].empty() ? 0 : frame_number(ends[0], path, count);
    const int last = !range ? first : ends[1].empty() ? count - 1 : frame_number(ends[1], path, count);
    if (last < first)
      throw InputError(
          fmt::format("--frames {}: {} is the wrong way round, the first frame comes first", written, part));
    const int step = ends.size() > 2 ? step_of(ends[2], written) : 1;
    for (std::int64_t frame = first; frame <= last; frame += step) frames.push_back(static_cast<int>(frame));
  }
  return frames;
}

Argument frames_argument(std::string& frames, const std::string& otherwise) {
  return {"--frames", &frames,
          fmt::format("frames and ranges FIRST:LAST:STEP, with LAST among them, as in 0,5,10:20,30:90:10 or ::10 "
                      "(default: {})",
                      otherwise)};
}

std::vector<Argument> DrawnFrames::arguments() {
  return {
      {"--colour",
       &colour,
       "what particles are coloured by; conductors: potential, charge, force, cluster (of those in contact), "
       "current (to the ground), order (of the branch, by Strahler), joined (the tree, when), speed; gases: charge, "
       "cluster, force, speed; packings: force (default: potential or charge, unless all is 0 or the same)",
       {.allowed = {"potential", "charge", "force", "cluster", "current", "order", "joined", "speed"}}},
      {"--range", &range,
       "LOW,HIGH: of the colours, in the file's units without prefix, as in --range=-200,200 (default: that of the "
       "whole run, all frames together)"},
      {"--cmap", &cmap, "colour map by matplotlib's name, as viridis"},
      {"--cut", &cut, "AXIS=PLACE: of a scene in space only what lies behind, as in --cut z=0.005"},
      {"--overwrite", &overwrite, "replace files that exist"}};
}

std::vector<std::string> DrawnFrames::options() const {
  std::vector<std::string> words;
  const std::pair<const char*, const std::string&> all[] = {
      {"--colour", colour}, {"--range", range}, {"--cmap", cmap}, {"--cut", cut}, {"--out", output}};
  for (const auto& [name, value] : all)
    if (!value.empty()) words.push_back(fmt::format("{}={}", name, value));
  if (overwrite) words.emplace_back("--overwrite");
  return words;
}

void check_bytes(const std::string& path, const std::string& done) {
  try {
    warn_if_changed(ResultFile(path, done));
  } catch (const hdf5::Error& error) {
    throw InputError(fmt::format("{} is damaged and cannot be {} ({})", path, done, error.what()));
  }
}

}  // namespace lichtenberg
