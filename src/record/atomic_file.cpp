#include "src/record/atomic_file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <filesystem>
#include <functional>
#include <system_error>
#include <utility>

#include "solvers/error.hpp"

namespace lichtenberg {
namespace {

std::string folder_of(const std::string& path) {
  const std::string folder = std::filesystem::path(path).parent_path().string();
  return folder.empty() ? "." : folder;
}

int check_call(int result) {
  if (result < 0) throw std::system_error(errno, std::generic_category());
  return result;
}

/// A file descriptor. close() reports what the kernel could not write; the destructor only tidies up.
class Descriptor {
 public:
  Descriptor(const std::string& path, int flags) : fd_(check_call(::open(path.c_str(), flags | O_CLOEXEC, 0666))) {}
  Descriptor(const Descriptor&) = delete;
  ~Descriptor() {
    if (fd_ >= 0) ::close(fd_);
  }
  void write(std::span<const std::byte> bytes) {
    while (!bytes.empty()) {
      const ssize_t written = ::write(fd_, bytes.data(), bytes.size());
      if (written < 0 && errno == EINTR) continue;
      if (written < 0) throw std::system_error(errno, std::generic_category());
      bytes = bytes.subspan(static_cast<size_t>(written));
    }
  }
  void sync() { check_call(::fsync(fd_)); }
  void close() { check_call(::close(std::exchange(fd_, -1))); }

 private:
  int fd_;
};

void write_file(const std::string& path, std::span<const std::byte> bytes) {
  Descriptor file(path, O_WRONLY | O_CREAT | O_TRUNC);
  file.write(bytes);
  file.sync();
  file.close();
}

/// `check` may refuse the replacement by an exception, at the last moment.
void replace(const std::string& path, std::span<const std::byte> bytes, const std::function<void()>& check) {
  const std::string partial = fmt::format("{}.partial-{}", path, getpid());
  const auto remove_partial = [&] {
    std::error_code ignored;
    std::filesystem::remove(partial, ignored);
  };
  try {
    write_file(partial, bytes);
    check();
    std::filesystem::rename(partial, path);
    Descriptor(folder_of(path), O_RDONLY | O_DIRECTORY).sync();  // the new name itself
  } catch (const std::system_error& error) {
    remove_partial();
    throw Failure(fmt::format("{} cannot be written ({})", path, error.code().message()));
  } catch (const Failure&) {
    remove_partial();
    throw;
  }
}

}  // namespace

void write_atomically(const std::string& path, std::span<const std::byte> bytes) {
  replace(path, bytes, [] {});
}

FileIdentity identity_of(const std::string& path) {
  struct stat status {};
  if (stat(path.c_str(), &status) != 0) return {};
  return {status.st_dev, status.st_ino, status.st_mtim.tv_sec, status.st_mtim.tv_nsec};
}

void replace_if_same(const std::string& path, const FileIdentity& read, std::span<const std::byte> bytes) {
  replace(path, bytes, [&] {
    if (identity_of(path) != read)
      throw Failure(fmt::format("{} has changed since it was read: try again once its run is over", path));
  });
}

void check_writable(const std::string& path) {
  const std::string folder = folder_of(path);
  if (!std::filesystem::is_directory(folder))
    throw InputError(fmt::format("{} cannot be written: there is no folder {}", path, folder));
  if (std::filesystem::is_directory(path)) throw InputError(fmt::format("{} cannot be written: it is a folder", path));
  if (access(folder.c_str(), W_OK | X_OK) != 0)
    throw InputError(fmt::format("{} cannot be written: folder {} may not be written", path, folder));
}

}  // namespace lichtenberg
