#pragma once

#include <string>

namespace lichtenberg {

/// Source folder that a test or validation program was built from, with its scenes and reference data.
std::string source_folder();

}  // namespace lichtenberg
