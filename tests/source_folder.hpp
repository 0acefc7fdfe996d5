#pragma once

#include <string>

namespace lichtenberg {

/// The checkout that a test or validation program was built from: its scenes and reference data are read from there.
std::string source_folder();

}  // namespace lichtenberg
