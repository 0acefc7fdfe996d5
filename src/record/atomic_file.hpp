#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>

namespace lichtenberg {

/// A file that takes its name when it is whole: until then it is `path`.partial-PID, which no other process of this
/// machine writes to and which is always a new file, never one that a link leads to, and whatever happens (a kill, a
/// full disk, a power cut) the old file stands. Members throw Failure if the disk does not take it; the partial file
/// goes with this object.
class NewFile {
 public:
  explicit NewFile(std::string path);
  NewFile(const NewFile&) = delete;
  ~NewFile();

  /// Bytes that are skipped are zero.
  void write(std::uint64_t offset, std::span<const std::byte> bytes);
  void read(std::uint64_t offset, std::span<std::byte> bytes) const;
  /// Takes the name over once all is on the disk. `check` may refuse that by an exception, at the last moment.
  void publish(const std::function<void()>& check = [] {});

 private:
  std::string path_, partial_;
  int descriptor_;
};

/// Writes the bytes as a NewFile.
void write_atomically(const std::string& path, std::span<const std::byte> bytes);

/// Which file stands at a path: a NewFile puts another one there.
struct FileIdentity {
  std::uint64_t device = 0, inode = 0;
  std::int64_t seconds = 0, nanoseconds = 0;
  friend bool operator==(const FileIdentity&, const FileIdentity&) = default;
};
/// All zeros if there is none.
FileIdentity identity_of(const std::string& path);

/// A file to read, whose bytes stay what they are when another one takes its name.
class OpenFile {
 public:
  /// Throws std::system_error.
  explicit OpenFile(const std::string& path);
  OpenFile(OpenFile&& other) noexcept;
  OpenFile& operator=(OpenFile&& other) noexcept;
  ~OpenFile();

  std::uint64_t size() const { return size_; }
  const FileIdentity& identity() const { return identity_; }
  /// Throws std::system_error; of a file that is too short, too.
  void read(std::uint64_t offset, std::span<std::byte> bytes) const;

 private:
  int descriptor_ = -1;
  std::uint64_t size_ = 0;
  FileIdentity identity_;
};

/// Throws InputError if no file can be created where `path` says: its folder is missing or may not be written, its name
/// is too long, or what stands there is no file: a folder, a link, a device, a pipe.
void check_writable(const std::string& path);

/// Whether a file of this name is what a NewFile for a file of the name `of` has been.
bool is_partial_name(const std::string& name, const std::string& of);

/// Removes what processes that were killed have left of a NewFile for this path; there must be no other writer.
void remove_partial_files(const std::string& path);

/// The folder that `path` is in.
std::string folder_of(const std::string& path);

}  // namespace lichtenberg
