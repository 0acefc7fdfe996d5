#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>

namespace lichtenberg {

/// New file that gets its name only when it is complete (atomic replacement). Until then its name is
/// `path`.partial-PID, which no other process of this machine writes. It is always a new file, never the target of a
/// link. A kill, a full disk or a power failure preserves an old file at `path`. Members throw Failure if a read or
/// write fails. The destructor removes the partial file.
class NewFile {
 public:
  /// Creates an empty file under the temporary name `path`.partial-PID.
  explicit NewFile(std::string path);
  NewFile(const NewFile&) = delete;
  ~NewFile();

  /// Writes bytes at an offset (bytes). Skipped bytes are zero.
  void write(std::uint64_t offset, std::span<const std::byte> bytes);
  /// Reads bytes at an offset (bytes).
  void read(std::uint64_t offset, std::span<std::byte> bytes) const;
  /// Renames the partial file to its final name once all data are on the disk. `check` is called just before the
  /// renaming and may prevent it by an exception.
  void publish(const std::function<void()>& check = [] {});

 private:
  std::string path_, partial_;
  int descriptor_;
};

/// Writes the bytes to the file at `path` through a NewFile: an old file remains until the new one is complete.
void write_atomically(const std::string& path, std::span<const std::byte> bytes);

/// Identity of the file at a path: device, inode and time of modification. It differs after a NewFile has replaced the
/// file.
struct FileIdentity {
  std::uint64_t device = 0, inode = 0;
  std::int64_t seconds = 0, nanoseconds = 0;
  friend bool operator==(const FileIdentity&, const FileIdentity&) = default;
};
/// Returns the identity of a file; all zeros if the system does not report it, as for a missing file.
FileIdentity identity_of(const std::string& path);

/// File opened for reading. Its bytes do not change when another file takes its name.
class OpenFile {
 public:
  /// Opens the file. Throws std::system_error if it cannot be opened.
  explicit OpenFile(const std::string& path);
  OpenFile(OpenFile&& other) noexcept;
  OpenFile& operator=(OpenFile&& other) noexcept;
  ~OpenFile();

  std::uint64_t size() const { return size_; }
  const FileIdentity& identity() const { return identity_; }
  /// Reads bytes at an offset (bytes). Throws std::system_error if the file cannot be read or is too short.
  void read(std::uint64_t offset, std::span<std::byte> bytes) const;

 private:
  int descriptor_ = -1;
  std::uint64_t size_ = 0;
  FileIdentity identity_;
};

/// Throws InputError if no file can be created at `path`: its folder is missing or not writable, or its name is too
/// long with the suffix of a NewFile. Also throws if the path is a folder, a link, a device, a pipe or an existing
/// scene
/// (.toml).
void check_writable(const std::string& path);

/// Returns true if `name` is a name of a partial NewFile for the file named `of`.
bool is_partial_name(const std::string& name, const std::string& of);

/// Removes partial files (NewFile) that killed processes have left for this path. There must be no other writer.
void remove_partial_files(const std::string& path);

/// Returns the path of the folder that contains `path`; "." for a plain name.
std::string folder_of(const std::string& path);

}  // namespace lichtenberg
