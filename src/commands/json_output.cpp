#include "src/commands/json_output.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <span>

#include "solvers/error.hpp"
#include "src/commands/draw.hpp"
#include "src/record/atomic_file.hpp"

namespace lichtenberg {
namespace {

/// A file of no name of one's own choosing, gone with this.
struct TemporaryFile {
  std::string path = (std::filesystem::temp_directory_path() / "lichtenberg-XXXXXX").string();
  TemporaryFile() {
    const int file = mkstemp(path.data());
    if (file < 0) throw Failure(fmt::format("cannot draw: no file can be made at {}", path));
    close(file);
  }
  ~TemporaryFile() { std::remove(path.c_str()); }
  TemporaryFile(const TemporaryFile&) = delete;
};

}  // namespace

void write_json(const std::string& path, const nlohmann::ordered_json& json) {
  const std::string text = json.dump(1) + "\n";
  write_atomically(path, std::as_bytes(std::span(text)));
}

void draw_json(const std::string& script, const nlohmann::ordered_json& json, const std::string& picture) {
  try {
    const TemporaryFile data;
    write_json(data.path, json);
    draw(script, {data.path, "--out", picture});
    fmt::print("\n{} shows it\n", picture);
  } catch (const Failure& failure) {
    fmt::print(stderr, "lichtenberg: {}\n", failure.what());
  }
}

}  // namespace lichtenberg
