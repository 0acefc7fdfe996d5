#include <fmt/format.h>

#include <memory>
#include <optional>

#include "solvers/error.hpp"
#include "src/commands/commands.hpp"
#include "src/commands/draw.hpp"
#include "src/record/result_file.hpp"

namespace lichtenberg {
namespace {

struct PlotArguments {
  std::string file, picture, colour;
  std::optional<int> frame;
};

/// Python's HDF5 would crash on some damaged files.
void check_bytes(const std::string& path) {
  try {
    ResultFile(path, "drawn");
  } catch (const hdf5::Error& error) {
    throw InputError(fmt::format("{} is damaged and cannot be drawn ({})", path, error.what()));
  }
}

[[noreturn]] void plot(const PlotArguments& request) {
  check_bytes(request.file);
  std::vector<std::string> arguments{request.file};
  if (request.frame) arguments.insert(arguments.end(), {"--frame", std::to_string(*request.frame)});
  if (!request.picture.empty()) arguments.insert(arguments.end(), {"--out", request.picture});
  if (!request.colour.empty()) arguments.insert(arguments.end(), {"--colour", request.colour});
  become_script("plot.py", arguments);
}

}  // namespace

Command plot_command() {
  auto request = std::make_shared<PlotArguments>();
  return {"plot",
          "Draws a frame of a result file",
          {{"FILE", &request->file, "result file of a run (.h5)", {.required = true}},
           {"--frame", &request->frame, "index of the frame, from 0 (default: the last)"},
           {"--out", &request->picture,
            "picture to write (default: FILE with .png); of a gas of grains, a second one with -series"},
           {"--colour",
            &request->colour,
            "of grains: charge or cluster (default: charge, unless all have the same)",
            {.allowed = {"charge", "cluster"}}}},
          [request] { plot(*request); }};
}

}  // namespace lichtenberg
