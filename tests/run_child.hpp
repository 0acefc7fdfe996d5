#pragma once

#include <doctest/doctest.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstddef>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "src/commands/command_line.hpp"
#include "src/record/hdf5.hpp"
#include "tests/disk_calls.hpp"
#include "tests/file_numbers.hpp"
#include "tests/folder.hpp"

/// Runs in child processes that may be killed, and the content of their result files.
namespace lichtenberg::run_child {

/// `lichtenberg run six.toml --out <file> ...` in a child process whose output goes to files.
class Child {
 public:
  Child(
      const Folder& folder, const std::string& file, std::vector<std::string> options = {},
      const std::function<void()>& prepare = [] {})
      : messages_(folder / "stderr"), summary_(folder / "stdout") {
    std::vector<std::string> arguments{"run", folder / "six.toml", "--out", folder / file};
    arguments.insert(arguments.end(), options.begin(), options.end());
    std::fflush(nullptr);  // Otherwise the child would print our buffers again.
    process_ = fork();
    if (process_ != 0) return;
    for (const auto& [path, stream] : {std::pair{messages_, stderr}, std::pair{summary_, stdout}})
      if (std::freopen(path.c_str(), "w", stream) == nullptr) _exit(99);
    prepare();
    const int status = run_command_line(arguments);
    std::fflush(nullptr);
    _exit(status);
  }
  Child(const Child&) = delete;
  ~Child() { wait(); }

  void send(int signal) const { kill(process_, signal); }
  /// Exit status, or 128 plus the number of the signal that ended the process.
  int wait() {
    if (process_ != 0) waitpid(process_, &status_, 0);
    process_ = 0;
    return WIFEXITED(status_) ? WEXITSTATUS(status_) : 128 + WTERMSIG(status_);
  }
  /// Waits until the file exists or the process has ended, for at most 10 minutes.
  void wait_for(const std::filesystem::path& file) {
    for (int ms = 0; ms < 600'000 && !std::filesystem::exists(file) && !has_ended(); ++ms) usleep(1000);
    REQUIRE(std::filesystem::exists(file));
  }
  std::string messages() const { return text_of(messages_); }
  std::string summary() const { return text_of(summary_); }

 private:
  bool has_ended() const {
    siginfo_t nothing{};
    return waitid(P_PID, static_cast<id_t>(process_), &nothing, WEXITED | WNOHANG | WNOWAIT) == 0 &&
           nothing.si_pid != 0;
  }

  std::string messages_, summary_;
  pid_t process_ = 0;
  int status_ = 0;
};

/// Prepares a child to receive the signal before its change of the disk number `call`, counted from 0.
inline std::function<void()> interrupted_before(long call, int signal) {
  return [=] { disk_calls::interrupt_before(call, signal); };
}

inline int run(const Folder& folder, const std::string& file, const std::vector<std::string>& options = {"--quiet"}) {
  return Child(folder, file, options).wait();
}

/// Runs six.toml with a file-size limit of `max_bytes` bytes, which fails a write as a full disk does, with another
/// error number. Checks for status 1, one message, and unchanged earlier data. Returns the message.
inline std::string run_on_full_disk(const Folder& folder, rlim_t max_bytes) {
  Child child(folder, "six.h5", {"--quiet"}, [max_bytes] {
    signal(SIGXFSZ, SIG_IGN);
    const rlimit at_most{max_bytes, max_bytes};
    setrlimit(RLIMIT_FSIZE, &at_most);
  });
  CHECK_EQ(child.wait(), 1);
  CHECK_NE(child.messages().find("six.h5 cannot be written (File too large); the state saved up to t = "),
           std::string::npos);
  for (const auto& entry : std::filesystem::directory_iterator(std::filesystem::path(folder / "six.h5").parent_path()))
    CHECK(entry.path().string().find(".partial") == std::string::npos);
  return child.messages();
}

/// All numbers of a result file except the provenance's, which are timings.
inline std::map<std::string, std::vector<std::byte>> numbers(const std::string& path) {
  std::map<std::string, std::vector<std::byte>> bytes = numbers_in(path);
  std::erase_if(bytes, [](const auto& entry) { return entry.first.starts_with("/provenance"); });
  return bytes;
}

/// Number of frames of a result of conductors.
inline std::size_t frames(const std::string& path) {
  return hdf5::shape(hdf5::load(path), "observables/energy/value")[0];
}

/// First number of a dataset.
inline double number(const std::string& path, const std::string& name) {
  return hdf5::get<double>(hdf5::load(path), name).at(0);
}

inline void check_same_numbers(const std::string& path, const std::string& reference) {
  const auto a = numbers(path), b = numbers(reference);
  REQUIRE_EQ(a.size(), b.size());
  for (const auto& [name, bytes] : a) {
    CAPTURE(name);
    CHECK(bytes == b.at(name));
  }
}

}  // namespace lichtenberg::run_child
