#include <memory>
#include <optional>

#include "src/commands/commands.hpp"
#include "src/commands/draw.hpp"

namespace lichtenberg {
namespace {

struct PlotArguments {
  std::string file, picture;
  std::optional<int> frame;
};

[[noreturn]] void plot(const PlotArguments& request) {
  std::vector<std::string> arguments{request.file};
  if (request.frame) arguments.insert(arguments.end(), {"--frame", std::to_string(*request.frame)});
  if (!request.picture.empty()) arguments.insert(arguments.end(), {"--out", request.picture});
  become_script("plot.py", arguments);
}

}  // namespace

Command plot_command() {
  auto request = std::make_shared<PlotArguments>();
  return {"plot",
          "Draws a frame of a result file",
          {{"FILE", &request->file, "result file of a run (.h5)", {.required = true}},
           {"--frame", &request->frame, "index of the frame, from 0 (default: the last)"},
           {"--out", &request->picture, "picture to write (default: FILE with .png)"}},
          [request] { plot(*request); }};
}

}  // namespace lichtenberg
