#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

namespace lichtenberg {

/// Writes the bytes to `path` such that whatever happens (a kill, a full disk, a power cut) either the old file or the
/// whole new one stands there: they go to `path`.partial-PID, which no other process of this machine writes to, reach
/// the disk, and take the name over. Throws Failure, and leaves no partial file, if that cannot be done.
void write_atomically(const std::string& path, std::span<const std::byte> bytes);

/// Which file stands at a path: write_atomically puts another one there.
struct FileIdentity {
  std::uint64_t device = 0, inode = 0;
  std::int64_t seconds = 0, nanoseconds = 0;
  friend bool operator==(const FileIdentity&, const FileIdentity&) = default;
};
/// All zeros if there is none.
FileIdentity identity_of(const std::string& path);

/// write_atomically over the file that was read, whose identity was taken before. Throws Failure, and leaves what
/// stands there alone, if it is another one by now: a run that goes on has saved.
void replace_if_same(const std::string& path, const FileIdentity& read, std::span<const std::byte> bytes);

/// Throws InputError if no file can be created where `path` says: its folder is missing or may not be written.
void check_writable(const std::string& path);

}  // namespace lichtenberg
