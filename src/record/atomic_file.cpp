#include "src/record/atomic_file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <filesystem>
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

void replace(const std::string& path, const std::string& partial, std::span<const std::byte> bytes) {
  Descriptor file(partial, O_WRONLY | O_CREAT | O_TRUNC);
  file.write(bytes);
  file.sync();
  file.close();
  std::filesystem::rename(partial, path);
  Descriptor(folder_of(path), O_RDONLY | O_DIRECTORY).sync();  // the new name itself
}

}  // namespace

void write_atomically(const std::string& path, std::span<const std::byte> bytes) {
  const std::string partial = path + ".partial";
  try {
    replace(path, partial, bytes);
  } catch (const std::system_error& error) {
    std::error_code ignored;
    std::filesystem::remove(partial, ignored);
    throw Failure(fmt::format("{} cannot be written ({})", path, error.code().message()));
  }
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
