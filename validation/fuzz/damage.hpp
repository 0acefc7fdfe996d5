#pragma once

#include <string>

#include "validation/fuzz/fuzz.hpp"

namespace lichtenberg::fuzz {

/// Returns the bytes of a result file with one damage: of its bytes, or of an object by HDF5. In most cases the
/// checksum is that of the new bytes, so that a reader meets the damage.
std::string damaged(const std::string& file, Dice& dice);

}  // namespace lichtenberg::fuzz
