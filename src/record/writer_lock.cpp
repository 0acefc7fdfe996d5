#include "src/record/writer_lock.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <sys/utsname.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <string_view>
#include <system_error>
#include <utility>

#include "solvers/error.hpp"

namespace lichtenberg {
namespace {

std::string lock_of(const std::string& path) { return path + ".lock"; }

constexpr std::string_view signature = "process ";  // every lock file is empty or begins with it

std::string this_process() {
  utsname name{};
  return fmt::format("{}{} on {}", signature, getpid(), uname(&name) == 0 ? name.nodename : "an unknown machine");
}

/// Returns the text that the process with the lock has written into it.
std::string lock_owner(const std::string& lock) {
  std::array<char, 256> text{};
  const int descriptor = ::open(lock.c_str(), O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC);
  const ssize_t length = descriptor < 0 ? 0 : ::read(descriptor, text.data(), text.size());
  if (descriptor >= 0) ::close(descriptor);
  return length > 0 ? std::string(text.data(), static_cast<std::size_t>(length)) : "another process";
}

/// Returns true if the locked file still has the name, because its owner may have removed it before the lock was
/// obtained.
bool still_has_name(int descriptor, const std::string& lock) {
  struct stat locked {
  }, named{};
  return fstat(descriptor, &locked) == 0 && lstat(lock.c_str(), &named) == 0 && locked.st_dev == named.st_dev &&
         locked.st_ino == named.st_ino;
}

[[noreturn]] void refuse_name(const std::string& lock) {
  throw InputError(fmt::format(
      "the file {} exists and is not replaced: it is not a lock of this program, which needs that name", lock));
}

/// Returns true if a file may be written and removed as a lock: a regular file with one name and no foreign content.
bool is_lock(int descriptor) {
  struct stat status {};
  if (fstat(descriptor, &status) != 0 || !S_ISREG(status.st_mode) || status.st_nlink > 1) return false;
  std::array<char, signature.size()> begin{};
  const ssize_t length = pread(descriptor, begin.data(), begin.size(), 0);
  return length == 0 ||
         std::string_view(begin.data(), static_cast<std::size_t>(std::max<ssize_t>(length, 0))) == signature;
}

/// Opens or creates a lock file. It follows no links and opens only locks for writing. Throws InputError, or Failure if
/// it cannot be created.
int open_lock(const std::string& lock) {
  const int descriptor = ::open(lock.c_str(), O_RDWR | O_CREAT | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC, 0666);
  if (descriptor < 0 && (errno == ELOOP || errno == EISDIR || errno == ENXIO)) refuse_name(lock);
  if (descriptor < 0)
    throw Failure(fmt::format("{} cannot be written ({})", lock, std::generic_category().message(errno)));
  if (is_lock(descriptor)) return descriptor;
  ::close(descriptor);
  refuse_name(lock);
}

/// Returns the descriptor of the locked file; -1 if another process has the lock.
int take(const std::string& lock) {
  for (;;) {
    const int descriptor = open_lock(lock);
    if (flock(descriptor, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) {
      ::close(descriptor);
      return -1;
    }  // some network file systems do not support locks, which is ignored
    if (still_has_name(descriptor, lock)) return descriptor;
    ::close(descriptor);
  }
}

void sign(int descriptor) {
  const std::string text = this_process();
  // Failures are ignored, because the text is only informative.
  if (ftruncate(descriptor, 0) != 0 || pwrite(descriptor, text.data(), text.size(), 0) < 0) return;
}

}  // namespace

std::optional<WriterLock> WriterLock::if_free(const std::string& path) {
  WriterLock lock;
  lock.path_ = lock_of(path);
  lock.descriptor_ = take(lock.path_);
  if (lock.descriptor_ < 0) return {};
  sign(lock.descriptor_);
  return lock;
}

WriterLock::WriterLock(const std::string& path) {
  std::optional<WriterLock> lock = if_free(path);
  if (!lock)
    throw InputError(
        fmt::format("the result file {} is being written by {}: wait until that run is over, end it, or name another "
                    "file with --out",
                    path, lock_owner(lock_of(path))));
  *this = std::move(*lock);
}

WriterLock::WriterLock(WriterLock&& other) noexcept
    : path_(std::move(other.path_)), descriptor_(std::exchange(other.descriptor_, -1)) {}

WriterLock& WriterLock::operator=(WriterLock&& other) noexcept {
  std::swap(path_, other.path_);
  std::swap(descriptor_, other.descriptor_);
  return *this;
}

WriterLock::~WriterLock() {
  if (descriptor_ < 0) return;
  ::unlink(path_.c_str());  // removed while locked, so that a waiting process detects that it has another file
  ::close(descriptor_);
}

}  // namespace lichtenberg
