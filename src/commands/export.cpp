#include <memory>

#include "src/commands/commands.hpp"
#include "src/commands/drawn_frames.hpp"
#include "src/commands/package.hpp"

namespace lichtenberg {

Command export_command() {
  auto request = std::make_shared<PackageRequest>();
  return {
      "export",
      "Writes particles, field, observables and tables for ParaView, ASE or a spreadsheet",
      {{"RESULT",
        &request->result,
        "result file of a run (.h5), or for csv the folder of an ensemble",
        {.required = true}},
       {"--to",
        &request->format,
        "vtk: a folder with .pvd and .vtp of particles, contacts and tree and the last frame's field as .vti; xyz: one "
        "extended XYZ file; csv: a folder with one file a table",
        {.required = true, .offered = {"vtk", "xyz", "csv"}}},
       {"--out", &request->out, "file or folder to write (default: RESULT with .xyz, -vtk or -csv)"},
       frames_argument(request->frames, "all"),
       {"--overwrite", &request->overwrite, "replace what exists, of an earlier export all its files"}},
      [request] { become_package("export", "exported", *request); }};
}

}  // namespace lichtenberg
