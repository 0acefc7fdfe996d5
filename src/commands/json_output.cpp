#include "src/commands/json_output.hpp"

#include <fmt/format.h>

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <nlohmann/json.hpp>
#include <span>
#include <string_view>

#include "solvers/error.hpp"
#include "src/commands/python.hpp"
#include "src/commands/scratch_folder.hpp"
#include "src/commands/streams.hpp"
#include "src/record/atomic_file.hpp"

namespace lichtenberg {
namespace {

/// Returns JSON as text. Bytes that are not UTF-8, which names of a scene may have, are replaced.
std::string text_of(const nlohmann::ordered_json& json, int indent) {
  return json.dump(indent, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

bool is_same(const std::string& a, const std::string& b) {
  std::error_code error;
  return std::filesystem::weakly_canonical(a, error) == std::filesystem::weakly_canonical(b, error) ||
         std::filesystem::equivalent(a, b, error);
}

bool holds_hdf5(const std::string& path) {
  constexpr std::string_view signature = "\x89HDF";
  std::string begin(signature.size(), ' ');
  return std::ifstream(path, std::ios::binary).read(begin.data(), signature.size()) && begin == signature;
}

void check_output_file(const std::string& path, bool overwrite) {
  check_writable(path);
  if (holds_hdf5(path))
    throw InputError(
        fmt::format("the file {} is an HDF5 file, as results are, and is not overwritten: name another file", path));
  if (!overwrite && std::filesystem::exists(path))
    throw InputError(fmt::format("the file {} exists: name another file, or give --overwrite", path));
}

}  // namespace

void check_not_read(const std::string& file, const std::vector<std::string>& read) {
  for (const std::string& source : read)
    if (!source.empty() && is_same(file, source))
      throw InputError(
          fmt::format("the file {} is an input file and is not overwritten: name another file to write", file));
}

void check_different(const std::vector<std::string>& written) {
  for (auto file = written.begin(); file != written.end(); ++file)
    for (auto other = written.begin(); other != file; ++other)
      if (!file->empty() && !other->empty() && is_same(*file, *other))
        throw InputError(fmt::format("the file {} cannot be written twice: name another file", *file));
}

void check_outputs(const std::vector<std::string>& written, const std::vector<std::string>& read, bool overwrite) {
  check_different(written);
  for (const std::string& file : written) {
    if (file.empty()) continue;
    check_not_read(file, read);
    check_output_file(file, overwrite);
  }
}

void check_overwrite(bool overwrite, const std::vector<std::string>& written, const std::string& options) {
  if (!overwrite || !std::ranges::all_of(written, &std::string::empty)) return;
  throw InputError(fmt::format("--overwrite is not allowed where no file is written: it is for use with {}", options));
}

void JsonTarget::put(const nlohmann::ordered_json& json, int indent) const {
  if (printed()) return fmt::print("{}\n", text_of(json, indent));
  if (!word.empty()) write_json(word, json);
}

Argument json_argument(JsonTarget& target, const std::string& what) {
  return {"--json",
          &target.word,
          fmt::format("print JSON instead of the table, or write it to a FILE in addition to the table: {}", what),
          {.value_optional = true}};
}

void write_json(const std::string& path, const nlohmann::ordered_json& json) {
  const std::string text = text_of(json, 1) + "\n";
  write_atomically(path, std::as_bytes(std::span(text)));
}

void print_json_line(const nlohmann::ordered_json& json) {
  fmt::print("{}\n", text_of(json, -1));
  std::fflush(stdout);
}

void answer_questions(const std::function<nlohmann::ordered_json(const nlohmann::ordered_json& question)>& answer) {
  for (std::string line; std::getline(std::cin, line);) print_json_line(answer(nlohmann::ordered_json::parse(line)));
}

void draw_json(const std::string& function, const nlohmann::ordered_json& json, const std::string& picture,
               bool silently) {
  const ScratchFolder folder;
  const std::string data = folder.file("data.json");
  write_json(data, json);
  draw(function, {data, picture});
  if (!silently) fmt::print("\n{} shows it\n", printable(picture));
}

}  // namespace lichtenberg
