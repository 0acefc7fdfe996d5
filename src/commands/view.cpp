#include <memory>

#include "src/commands/commands.hpp"
#include "src/commands/drawn_frames.hpp"
#include "src/commands/package.hpp"

namespace lichtenberg {

Command view_command() {
  auto request = std::make_shared<PackageRequest>();
  return {"view",
          "Writes one HTML page to look at a run in a browser, without a network: particles over time, curves",
          {{"RESULT", &request->result, "result file of a run (.h5)", {.required = true}},
           {"--out", &request->out, "page to write (default: RESULT with .html)"},
           frames_argument(request->frames, "all"),
           {"--overwrite", &request->overwrite, "replace the page if it exists"}},
          [request] { become_package("view", "shown", *request); }};
}

}  // namespace lichtenberg
