#pragma once

#include <dlfcn.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <cstdio>
#include <functional>
#include <new>

/// Calls by which results change the disk. A test with this header replaces the C library's functions, so that a run
/// can be ended at a given call on any machine. Only these calls change the disk, so a kill between two of them leaves
/// the state of a kill before the second.
namespace lichtenberg::disk_calls {

/// Called with the number of each disk call of this process, from 0, before the call. It is empty by default, because
/// libraries make such calls before the initialization of this program.
inline std::function<void(long)> before;

/// Number of disk calls of this process and its children.
inline std::atomic<long>& done() {
  static auto* const count =
      new (mmap(nullptr, sizeof(std::atomic<long>), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0))
          std::atomic<long>(0);
  return *count;
}

/// Makes this process send itself the signal before its call of this number.
inline void interrupt_before(long call, int signal) {
  done() = 0;
  before = [call, signal](long number) {
    if (number == call) kill(getpid(), signal);
  };
}

/// Calls the C library's function of this name after the callback.
template <class Result, class... Arguments>
Result call(const char* name, Arguments... arguments) {
  if (const long number = done()++; before) before(number);
  return reinterpret_cast<Result (*)(Arguments...)>(dlsym(RTLD_NEXT, name))(arguments...);
}

}  // namespace lichtenberg::disk_calls

extern "C" {
ssize_t pwrite(int file, const void* bytes, size_t count, off_t offset) {
  return lichtenberg::disk_calls::call<ssize_t>("pwrite", file, bytes, count, offset);
}
int fsync(int file) { return lichtenberg::disk_calls::call<int>("fsync", file); }
int rename(const char* from, const char* to) noexcept { return lichtenberg::disk_calls::call<int>("rename", from, to); }
int link(const char* from, const char* to) noexcept { return lichtenberg::disk_calls::call<int>("link", from, to); }
int mkdir(const char* path, mode_t mode) noexcept { return lichtenberg::disk_calls::call<int>("mkdir", path, mode); }
int remove(const char* path) noexcept { return lichtenberg::disk_calls::call<int>("remove", path); }
}
