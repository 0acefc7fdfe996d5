#pragma once

#include <optional>
#include <string>

namespace lichtenberg {

/// The right to write a result file, which one process of this machine has at a time. It is a lock on `path`.lock,
/// which goes with this object; the kernel takes it from a process that is killed, and the file that then stays locks
/// nobody out.
class WriterLock {
 public:
  /// Throws InputError that names the process which has it.
  explicit WriterLock(const std::string& path);
  /// None if another has it.
  static std::optional<WriterLock> if_free(const std::string& path);
  WriterLock(WriterLock&& other) noexcept;
  WriterLock& operator=(WriterLock&& other) noexcept;
  ~WriterLock();

 private:
  WriterLock() = default;

  std::string path_;  ///< of the lock
  int descriptor_ = -1;
};

}  // namespace lichtenberg
