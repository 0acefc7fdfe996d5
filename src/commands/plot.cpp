#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <optional>

#include "solvers/error.hpp"
#include "src/commands/commands.hpp"
#include "src/commands/draw.hpp"
#include "src/commands/drawn_frames.hpp"
#include "src/commands/frame_fields.hpp"
#include "src/commands/reading.hpp"
#include "src/record/result.hpp"

namespace lichtenberg {
namespace {

struct PlotArguments {
  std::vector<std::string> files;
  std::optional<int> frame;
  bool series = false;
  std::string observables;
  DrawnFrames drawn;
};

std::vector<std::string> words_of(const std::vector<std::string>& files) {
  std::vector<std::string> words;
  for (const std::string& file : files) words.push_back(as_word(file));
  return words;
}

/// Those asked for, which every run must have; empty: each run's last.
std::string frames_asked(const PlotArguments& request) {
  return request.frame ? std::to_string(*request.frame) : request.drawn.frames;
}

std::vector<int> frames_of(const PlotArguments& request, const Result& result) {
  const std::string asked = frames_asked(request);
  if (asked.empty()) return {result.frames() - 1};
  return listed_frames(asked, result.path(), result.frames());
}

[[noreturn]] void plot_frames(const PlotArguments& request) {
  std::vector<Result> results;
  for (const std::string& file : request.files) {
    check_bytes(file);
    results.emplace_back(file);
  }
  std::vector<std::string> arguments = words_of(request.files);
  for (const std::string& option : request.drawn.options()) arguments.push_back(option);
  std::string frames;
  for (const Result& result : results) frames = fmt::format("{}", fmt::join(frames_of(request, result), ","));
  if (!frames_asked(request).empty()) arguments.push_back("--frames=" + frames);  // the same of all
  std::vector<std::string> fields;
  if (request.drawn.may_show_field() && std::ranges::all_of(results, has_field))
    for (const Result& result : results)
      fields.push_back(FrameFields(result, frames_of(request, result), [](int) {}).path());
  if (!fields.empty()) arguments.push_back(fmt::format("--fields={}", fmt::join(fields, ",")));
  become_script("plot.py", arguments);
}

/// The folder of an ensemble, or a table in it.
bool is_ensemble(const std::string& path) { return std::filesystem::is_directory(path) || path.ends_with(".json"); }

bool names_ensemble(const std::vector<std::string>& files) { return std::ranges::any_of(files, is_ensemble); }

[[noreturn]] void plot_series(const PlotArguments& request) {
  std::vector<std::string> arguments = words_of(request.files);
  for (const std::string& file : request.files)
    if (!is_ensemble(file)) check_bytes(file);
  if (!request.observables.empty()) arguments.push_back("--observables=" + request.observables);
  if (!request.drawn.output.empty()) arguments.push_back("--out=" + request.drawn.output);
  if (request.drawn.overwrite) arguments.emplace_back("--overwrite");
  if (!request.series) arguments.emplace_back("--table");
  become_script("plot_series.py", arguments);
}

void check(const PlotArguments& request) {
  const bool of_frames = request.frame || !request.drawn.frames.empty();
  const DrawnFrames& drawn = request.drawn;
  if (!drawn.frames.empty() && request.frame) throw InputError("--frame and --frames say the same: give one of them");
  if (!request.observables.empty() && !request.series && !names_ensemble(request.files))
    throw InputError("--observables is for curves over time: it needs --series");
  const bool for_pictures =
      of_frames || !drawn.colour.empty() || !drawn.range.empty() || !drawn.cmap.empty() || !drawn.cut.empty();
  if (for_pictures && (request.series || names_ensemble(request.files)))
    throw InputError(
        "--frame, --frames, --colour, --range, --cmap and --cut are for pictures of frames, not for curves");
}

[[noreturn]] void plot(const PlotArguments& request) {
  check(request);
  read_in_child(request.files);
  if (request.series || names_ensemble(request.files)) plot_series(request);
  plot_frames(request);
}

}  // namespace

Command plot_command() {
  auto request = std::make_shared<PlotArguments>();
  Command command{
      "plot",
      "Draws frames of results as PNG, PDF or SVG, or with --series what they record over time; a name that "
      "is free says what a picture shows, and nothing is replaced unless told",
      {}};
  command.arguments = {
      {"FILE",
       &request->files,
       "result file of a run (.h5); several are drawn beside each other in the same colours; with --series in the same "
       "axes, and the folder of an ensemble (or a table in it, as ensemble-2.json), whose means are drawn without "
       "--series",
       {.required = true}},
      {"--frame", &request->frame, "index of the frame, from 0 (default: the last)"},
      frames_argument(request->drawn.frames, "the last"),
      {"--out", &request->drawn.output,
       "picture to write, its kind by its end: .png, .pdf or .svg; of several frames each name gets its index "
       "(default: "
       "FILE-frame-N-COLOUR.png, FILE-series.png)"},
      {"--series", &request->series, "curves of what the runs record over time, in place of a frame"},
      {"--observables", &request->observables,
       "names of such, as in energy,connected; one that a result lacks gets the list of those it has"}};
  for (const Argument& argument : request->drawn.arguments()) command.arguments.push_back(argument);
  command.act = [request] { plot(*request); };
  return command;
}

}  // namespace lichtenberg
