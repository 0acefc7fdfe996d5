#pragma once

#include <cstddef>
#include <span>
#include <string>

namespace lichtenberg {

/// Writes the bytes to `path` such that whatever happens (a kill, a full disk, a power cut) either the old file or the
/// whole new one stands there: they go to `path`.partial, reach the disk, and take the name over. Throws Failure, and
/// leaves no partial file, if that cannot be done.
void write_atomically(const std::string& path, std::span<const std::byte> bytes);

/// Throws InputError if no file can be created where `path` says: its folder is missing or may not be written.
void check_writable(const std::string& path);

}  // namespace lichtenberg
