#include "src/record/atomic_file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <filesystem>
#include <system_error>
#include <utility>

#include "solvers/error.hpp"

namespace lichtenberg {
namespace {

[[noreturn]] void refuse(const std::string& path, int error) {
  throw Failure(fmt::format("{} cannot be written ({})", path, std::generic_category().message(error)));
}

/// Flushes the folder's directory entries to the disk.
void sync_folder(const std::string& path) {
  const int folder = ::open(folder_of(path).c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  const bool done = folder >= 0 && ::fsync(folder) == 0;
  const int error = errno;
  if (folder >= 0) ::close(folder);
  if (!done) refuse(path, error);
}

/// Calls `move(done)` until all `bytes` are moved; `move` returns the result of pread or pwrite.
template <class Move>
bool move_all(std::size_t bytes, Move move) {
  for (std::size_t done = 0; done < bytes;) {
    const ssize_t now = move(done);
    if (now < 0 && errno == EINTR) continue;
    if (now == 0) errno = EIO;  // unexpected end of the file
    if (now <= 0) return false;
    done += static_cast<std::size_t>(now);
  }
  return true;
}

bool read_all(int descriptor, std::uint64_t offset, std::span<std::byte> bytes) {
  return move_all(bytes.size(), [&](std::size_t done) {
    return ::pread(descriptor, bytes.data() + done, bytes.size() - done, static_cast<off_t>(offset + done));
  });
}

/// Returns the descriptor of a new, empty file. An existing file of this name belongs to a former process with the same
/// number, or is a link. It is removed, but the target of a link is not.
int create(const std::string& path) {
  constexpr int flags = O_RDWR | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC;
  const int descriptor = ::open(path.c_str(), flags, 0666);
  if (descriptor >= 0 || errno != EEXIST || ::unlink(path.c_str()) != 0) return descriptor;
  return ::open(path.c_str(), flags, 0666);
}

FileIdentity to_identity(const struct stat& status) {
  return {status.st_dev, status.st_ino, status.st_mtim.tv_sec, status.st_mtim.tv_nsec};
}

}  // namespace

std::string folder_of(const std::string& path) {
  const std::string folder = std::filesystem::path(path).parent_path().string();
  return folder.empty() ? "." : folder;
}

NewFile::NewFile(std::string path)
    : path_(std::move(path)), partial_(fmt::format("{}.partial-{}", path_, getpid())), descriptor_(create(partial_)) {
  if (descriptor_ < 0) refuse(path_, errno);
}

NewFile::~NewFile() {
  if (descriptor_ >= 0) ::close(descriptor_);
  if (!partial_.empty()) ::unlink(partial_.c_str());
}

void NewFile::write(std::uint64_t offset, std::span<const std::byte> bytes) {
  const bool done = move_all(bytes.size(), [&](std::size_t written) {
    return ::pwrite(descriptor_, bytes.data() + written, bytes.size() - written, static_cast<off_t>(offset + written));
  });
  if (!done) refuse(path_, errno);
}

void NewFile::read(std::uint64_t offset, std::span<std::byte> bytes) const {
  if (!read_all(descriptor_, offset, bytes)) refuse(path_, errno);
}

void NewFile::publish(const std::function<void()>& check) {
  if (::fsync(descriptor_) != 0) refuse(path_, errno);
  if (::close(std::exchange(descriptor_, -1)) != 0) refuse(path_, errno);
  check();
  if (::rename(partial_.c_str(), path_.c_str()) != 0) refuse(path_, errno);
  partial_.clear();
  sync_folder(path_);
}

void write_atomically(const std::string& path, std::span<const std::byte> bytes) {
  NewFile file(path);
  file.write(0, bytes);
  file.publish();
}

FileIdentity identity_of(const std::string& path) {
  struct stat status {};
  if (stat(path.c_str(), &status) != 0) return {};
  return to_identity(status);
}

OpenFile::OpenFile(const std::string& path) : descriptor_(::open(path.c_str(), O_RDONLY | O_CLOEXEC)) {
  struct stat status {};
  if (descriptor_ < 0 || fstat(descriptor_, &status) != 0) {
    const int error = errno;
    if (descriptor_ >= 0) ::close(descriptor_);
    throw std::system_error(error, std::generic_category());
  }
  size_ = static_cast<std::uint64_t>(status.st_size);
  identity_ = to_identity(status);
}

OpenFile::OpenFile(OpenFile&& other) noexcept
    : descriptor_(std::exchange(other.descriptor_, -1)), size_(other.size_), identity_(other.identity_) {}

OpenFile& OpenFile::operator=(OpenFile&& other) noexcept {
  std::swap(descriptor_, other.descriptor_);
  size_ = other.size_;
  identity_ = other.identity_;
  return *this;
}

OpenFile::~OpenFile() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

void OpenFile::read(std::uint64_t offset, std::span<std::byte> bytes) const {
  if (!read_all(descriptor_, offset, bytes)) throw std::system_error(errno, std::generic_category());
}

bool is_partial_name(const std::string& name, const std::string& of) {
  const std::string before = of + ".partial-";
  return name.size() > before.size() && name.starts_with(before) &&
         name.find_first_not_of("0123456789", before.size()) == std::string::npos;
}

void remove_partial_files(const std::string& path) {
  const std::string name = std::filesystem::path(path).filename().string();
  std::error_code ignored;
  for (const auto& entry : std::filesystem::directory_iterator(folder_of(path), ignored))
    // unlink never removes a folder
    if (is_partial_name(entry.path().filename().string(), name)) ::unlink(entry.path().c_str());
}

void check_writable(const std::string& path) {
  namespace fs = std::filesystem;
  const auto refuse_it = [&](const std::string& why) {
    throw InputError(fmt::format("the file {} cannot be written: {}", path, why));
  };
  const std::string folder = folder_of(path), beside = path + ".partial-0000000";  // the longest name that is needed
  std::error_code error;
  if (!fs::is_directory(folder, error)) refuse_it("there is no folder " + folder);
  const fs::file_status status = fs::symlink_status(beside, error);
  if (status.type() == fs::file_type::none) refuse_it(error.message());
  const fs::file_type type = fs::symlink_status(path, error).type();
  if (type == fs::file_type::directory) refuse_it("it is a folder");
  if (type != fs::file_type::regular && type != fs::file_type::not_found)
    throw InputError(fmt::format("the path {} is no plain file and is not overwritten: name another one", path));
  if (type == fs::file_type::regular && fs::path(path).extension() == ".toml")
    throw InputError(
        fmt::format("the file {} ends in .toml as scenes do and is not overwritten: name another file", path));
  if (access(folder.c_str(), W_OK | X_OK) == 0) return;
  if (errno == EROFS) refuse_it("folder " + folder + " is on a file system that is read-only");
  refuse_it("folder " + folder + " may not be written");
}

}  // namespace lichtenberg
