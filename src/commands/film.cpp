#include <fmt/format.h>
#include <fmt/ranges.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <memory>
#include <numeric>
#include <optional>
#include <sstream>

#include "solvers/error.hpp"
#include "src/commands/commands.hpp"
#include "src/commands/draw.hpp"
#include "src/commands/drawn_frames.hpp"
#include "src/commands/frame_fields.hpp"
#include "src/commands/output.hpp"
#include "src/commands/progress.hpp"
#include "src/commands/reading.hpp"
#include "src/record/result.hpp"

namespace lichtenberg {
namespace {

struct FilmArguments {
  std::string file;
  double rate = 15;
  bool quiet = false;
  DrawnFrames drawn;
};

void check_ffmpeg() {
  const char* folders = std::getenv("PATH");
  std::istringstream list(folders ? folders : "");
  for (std::string folder; std::getline(list, folder, ':');)
    if (access((folder + "/ffmpeg").c_str(), X_OK) == 0) return;
  throw InputError("there is no ffmpeg, which makes films of pictures: install Debian's package ffmpeg");
}

std::string film_of(const FilmArguments& request) {
  if (!request.drawn.output.empty()) return request.drawn.output;
  const std::string stem = std::filesystem::path(request.file).replace_extension().string();
  return stem + (request.drawn.colour.empty() ? "" : "-" + request.drawn.colour) + ".mp4";
}

std::vector<int> frames_of(const FilmArguments& request, const Result& result) {
  if (!request.drawn.frames.empty()) return listed_frames(request.drawn.frames, result.path(), result.frames());
  std::vector<int> all(result.frames());
  std::iota(all.begin(), all.end(), 0);
  return all;
}

FrameFields solve_fields(const FilmArguments& request, const Result& result, const std::vector<int>& frames) {
  Progress progress(0, static_cast<double>(frames.size()), request.quiet || !isatty(STDERR_FILENO));
  return FrameFields(result, frames, [&](int done) {
    if (progress.due()) progress.show(fmt::format("field of frame {} of {} solved", done, frames.size()), done);
  });
}

[[noreturn]] void film(const FilmArguments& request) {
  DrawnFrames drawn = request.drawn;
  drawn.output = film_of(request);
  constexpr double least = 0.1, most = 1000;  // that players know
  if (!(request.rate >= least && request.rate <= most))
    throw InputError(fmt::format("--rate {:g} is not allowed: it must be from {:g} to {:g} frames a second",
                                 request.rate, least, most));
  if (!drawn.output.ends_with(".mp4"))
    throw InputError(fmt::format("--out {}: films are written as .mp4, and their names end so", drawn.output));
  check_output("--out", drawn.output, drawn.overwrite);
  check_ffmpeg();
  read_in_child({request.file});
  check_bytes(request.file);
  const Result result(request.file);
  const std::vector<int> frames = frames_of(request, result);
  std::vector<std::string> arguments = {as_word(request.file), fmt::format("--frames={}", fmt::join(frames, ",")),
                                        fmt::format("--rate={}", request.rate)};
  for (const std::string& option : drawn.options()) arguments.push_back(option);
  if (request.quiet) arguments.emplace_back("--quiet");
  std::optional<FrameFields> fields;
  if (drawn.may_show_field() && has_field(result))
    arguments.push_back("--fields=" + fields.emplace(solve_fields(request, result, frames)).path());
  become_script("film.py", arguments);
}

}  // namespace

Command film_command() {
  auto request = std::make_shared<FilmArguments>();
  Command command{"film", "Makes an mp4 of a run, on all cores, in one colour scale and layout; needs ffmpeg", {}};
  command.arguments = {
      {"FILE", &request->file, "result file of a run (.h5)", {.required = true}},
      frames_argument(request->drawn.frames, "all"),
      {"--rate", &request->rate, "frames a second", {.positive = true, .default_shown = true}},
      {"--out", &request->drawn.output, "film to write (default: FILE.mp4, with a --colour FILE-COLOUR.mp4)"},
      {"--quiet", &request->quiet, "show no progress"}};
  for (const Argument& argument : request->drawn.arguments()) command.arguments.push_back(argument);
  command.act = [request] { film(*request); };
  return command;
}

}  // namespace lichtenberg
