#include "src/commands/package.hpp"

#include <filesystem>
#include <vector>

#include "src/commands/draw.hpp"
#include "src/commands/drawn_frames.hpp"
#include "src/commands/reading.hpp"

namespace lichtenberg {

void become_package(const std::string& command, const std::string& done, const PackageRequest& request) {
  read_in_child({request.result});
  if (!std::filesystem::is_directory(request.result)) check_bytes(request.result, done);
  std::vector<std::string> words{command, as_word(request.result)};
  if (!request.format.empty()) words.insert(words.end(), {"--to", request.format});
  if (!request.out.empty()) words.push_back("--out=" + request.out);
  if (!request.frames.empty()) words.push_back("--frames=" + request.frames);  // which may begin with a minus
  if (request.overwrite) words.emplace_back("--overwrite");
  become_script("package.py", words);
}

}  // namespace lichtenberg
