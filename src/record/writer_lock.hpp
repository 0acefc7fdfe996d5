#pragma once

#include <optional>
#include <string>

namespace lichtenberg {

/// Exclusive permission to write a result file, for one process of this machine at a time. It is a lock (flock) on the
/// file `path`.lock, which this object releases. The kernel releases it for a killed process, whose remaining lock file
/// blocks no other process. On a file system without locks, writing is permitted without exclusion.
class WriterLock {
 public:
  /// Locks the result file at `path`. Throws InputError that names the process with the lock, and the exceptions of
  /// if_free().
  explicit WriterLock(const std::string& path);
  /// Locks the result file at `path` and returns the lock; empty if it is locked already. Throws InputError if
  /// `path`.lock exists and is no lock file, Failure if it cannot be created.
  static std::optional<WriterLock> if_free(const std::string& path);
  WriterLock(WriterLock&& other) noexcept;
  WriterLock& operator=(WriterLock&& other) noexcept;
  ~WriterLock();

 private:
  WriterLock() = default;

  std::string path_;  ///< path of the lock file
  int descriptor_ = -1;
};

}  // namespace lichtenberg
