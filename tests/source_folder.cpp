#include "tests/source_folder.hpp"

namespace lichtenberg {

std::string source_folder() { return LICHTENBERG_SOURCE_DIR; }

}  // namespace lichtenberg
