#include <dlfcn.h>
#include <execinfo.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/time.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <map>
#include <new>
#include <nlohmann/json.hpp>
#include <regex>
#include <set>

#include "solvers/error.hpp"
#include "solvers/stop.hpp"
#include "src/commands/streams.hpp"
#include "src/model/motion.hpp"
#include "src/record/hdf5.hpp"
#include "src/scene/stopping.hpp"
#include "validation/fuzz/fuzz.hpp"

namespace lichtenberg::fuzz {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t largest_block = 256u << 20;  ///< bytes; larger requests are std::bad_alloc
constexpr double processor_limit = 10;             ///< s of processor time until a request to stop, then until a kill
constexpr unsigned wall_limit = 120;               ///< s, for a deadlock
#ifdef __SANITIZE_ADDRESS__
constexpr bool has_sanitizer = true;
#else
constexpr bool has_sanitizer = false;
#endif
constexpr std::uint64_t cases_of_a_child = 5000;  ///< bounds the memory that caches take

bool library_may_fork = false;
volatile sig_atomic_t stop_requested = 0;

extern "C" void request_stop(int signal) {
  stop_requested = 1;
  ::signal(signal, SIG_DFL);
}

/// Writes the calling functions to standard error, as sanitizers do, and ends the process by the signal.
extern "C" void report_signal(int signal) {
  std::array<void*, 12> frames{};
  constexpr int own = 2;  // this function and the kernel's frame
  backtrace_symbols_fd(frames.data() + own, std::max(backtrace(frames.data(), frames.size()) - own, 0), STDERR_FILENO);
  ::signal(signal, SIG_DFL);
  raise(signal);
}

/// Counters that the child writes and its parent reads.
struct Shared {
  std::uint64_t next = 0, faults = 0, hdf5_crashes = 0;
  static constexpr std::size_t kinds = 64, length = 32;
  std::array<std::array<char, length>, kinds> kind{};
  std::array<std::uint64_t, kinds> count{};

  void add(const std::string& word) {
    std::size_t k = 0;
    while (k + 1 < kinds && kind[k][0] != '\0' && word.substr(0, length - 1) != kind[k].data()) ++k;
    std::copy_n(word.c_str(), std::min(word.size(), length - 1), kind[k].begin());
    ++count[k];
  }
};

struct Streams {
  int out = -1, err = -1, report = -1;
};
Streams streams;

int memory_file(const char* name) {
  const int file = memfd_create(name, 0);
  if (file < 0 || fcntl(file, F_SETFL, O_APPEND) != 0) throw Failure("the system gives no file in memory");
  return file;
}

std::string content(int file) {
  std::string text(static_cast<std::size_t>(std::max<off_t>(lseek(file, 0, SEEK_END), 0)), '\0');
  const ssize_t count = pread(file, text.data(), text.size(), 0);
  text.resize(static_cast<std::size_t>(std::max<ssize_t>(count, 0)));
  return text;
}

void say(const std::string& text) {
  if (write(streams.report, text.data(), text.size()) < 0) std::abort();
}

/// Throws Fault unless the message of an error is in the program's words.
std::string checked(const std::exception& error, const std::string& word, bool names_hdf5 = false) {
  const std::string text = printable(error.what());
  if (text.empty()) throw Fault{"no message"};
  for (const char* foreign :
       {"boost", "H5", "HDF5", "std::", "filesystem", "basic_string", "terminate", "PETSC ERROR", "bad_", "vector::"})
    if (text.find(foreign) != std::string::npos && !(names_hdf5 && foreign[0] == 'H'))
      throw Fault{fmt::format("says {}: {}", foreign, text)};
  return word;
}

/// Returns a name of the outcome for the input. Throws Fault.
std::string end_of(const Target& target, const Input& input, Dice& dice) {
  try {
    return target.attempt(input, dice);
  } catch (const InputError& error) {
    return checked(error, "refused", target.hdf5_may_crash);
  } catch (const Failure& error) {
    return checked(error, "failed", target.hdf5_may_crash);
  } catch (const hdf5::Error& error) {
    return checked(error, "damaged", true);
  } catch (const Stopped&) {
    return "stopped";
  } catch (const Paused&) {
    return "stopped";
  } catch (const std::bad_alloc&) {
    return "too large";
  } catch (const std::exception& error) {
    throw Fault{fmt::format("foreign exception: {}", error.what())};
  }
}

void keep(const Request& request, const Input& input, std::uint64_t number) {
  if (request.keep.empty()) return;
  fs::create_directories(request.keep);
  for (const File& file : input) {
    std::string name = file.name;
    std::ranges::replace(name, '/', '-');
    std::ofstream(fmt::format("{}/{}-{}", request.keep, number, name), std::ios::binary) << file.bytes;
  }
}

void report(const Target& target, const Request& request, std::uint64_t number, const std::string& what) {
  Dice dice(request.seed, number);
  const Input input = target.draw(dice);
  keep(request, input, number);
  say(fmt::format("case {} of seed {}: {}\n", number, request.seed, what));
}

void try_case(const Target& target, const Request& request, Shared& shared) {
  for (const int file : {streams.out, streams.err})
    if (ftruncate(file, 0) != 0) std::abort();
  Dice dice(request.seed, shared.next);
  const Input input = target.draw(dice);
  write_files(input);
  constexpr timeval seconds{static_cast<time_t>(processor_limit), 0};
  const itimerval limit{seconds, seconds}, none{};
  stop_requested = 0;
  ::signal(SIGPROF, request_stop);
  setitimer(ITIMER_PROF, &limit, nullptr);
  alarm(wall_limit);
  try {
    const StopRequestScope scope(out_of_time);
    const std::string end = end_of(target, input, dice);
    shared.add(out_of_time() ? "out of time" : end);
  } catch (const Fault& fault) {
    ++shared.faults;
    report(target, request, shared.next, fault.what);
  }
  setitimer(ITIMER_PROF, &none, nullptr);
  alarm(0);
  for (const fs::directory_entry& left : fs::directory_iterator(".")) fs::remove_all(left.path());
}

/// Tries some cases and ends the process.
[[noreturn]] void be_child(const Target& target, const Request& request, Shared& shared, const std::string& folder) {
  fs::create_directory(folder);
  fs::current_path(folder);
  dup2(streams.out, STDOUT_FILENO);
  dup2(streams.err, STDERR_FILENO);
  if (!has_sanitizer) {
    std::array<void*, 1> first{};
    backtrace(first.data(), first.size());  // the first call allocates, which a signal's function must not
    for (const int signal : {SIGSEGV, SIGBUS, SIGABRT, SIGFPE, SIGILL}) ::signal(signal, report_signal);
  }
  const std::uint64_t end = std::min(shared.next + cases_of_a_child, request.first + request.cases);
  try {
    for (; shared.next < end; ++shared.next) try_case(target, request, shared);
  } catch (const std::exception& error) {
    fmt::print(stderr, "ERROR: the case was not tried: {}", error.what());
    std::fflush(nullptr);
    _exit(1);
  }
  _exit(0);
}

/// Returns true if the first frame of a report by a sanitizer or report_signal(), apart from the C library's, is in
/// HDF5's library.
bool is_in_hdf5(const std::string& report) {
  static const std::regex frame(R"(#\d+ 0x[0-9a-f]+ (in [^\n]*|\s*\([^\n]*)|[^\n]*\(.*\+0x[0-9a-f]+\)[^\n]*)");
  for (std::sregex_iterator at(report.begin(), report.end(), frame), end; at != end; ++at) {
    const std::string text = at->str();
    if (text.find("libhdf5") != std::string::npos) return true;
    for (const char* own : {"lichtenberg", "/validation/", "/fuzz("})
      if (text.find(own) != std::string::npos) return false;
  }
  return false;
}

/// Describes how a child ended without having tried its cases.
std::string death(int status) {
  const std::string text = content(streams.err);
  const std::size_t at = std::min(text.find("ERROR: "), text.find("runtime error: "));
  const std::string excerpt = at < text.size() ? text.substr(text.rfind('\n', at) + 1, 1800) : text.substr(0, 600);
  if (WIFSIGNALED(status) && (WTERMSIG(status) == SIGPROF || WTERMSIG(status) == SIGALRM))
    return fmt::format("no end after {:g} s of processor time or {} s", processor_limit, wall_limit);
  return fmt::format("ended by {} {}: {}", WIFSIGNALED(status) ? "signal" : "status",
                     WIFSIGNALED(status) ? WTERMSIG(status) : WEXITSTATUS(status), excerpt);
}

void write_figures(const Shared& shared, const Request& request, double seconds) {
  const char* path = std::getenv("LICHTENBERG_FIGURES");
  if (path == nullptr) return;
  nlohmann::ordered_json json{
      {"cases", request.cases}, {"broken rules", shared.faults}, {"cases per second", request.cases / seconds}};
  for (std::size_t k = 0; k < Shared::kinds && shared.count[k] > 0; ++k) json[shared.kind[k].data()] = shared.count[k];
  std::ofstream(path) << json.dump(1) << "\n";
}

}  // namespace

bool out_of_time() { return stop_requested != 0; }

Printed printed() {
  std::fflush(nullptr);
  return {content(streams.out), content(streams.err)};
}

void check_no_nan(const std::string& text) {
  static const std::regex nan(R"([^\n]*(?:^|[^\w"])-?nan(?![\w"])[^\n]*)");
  if (text.find("nan") == std::string::npos) return;
  if (std::smatch found; std::regex_search(text, found, nan)) throw Fault{"silent nan: " + found.str()};
}

void write_files(const Input& input) {
  for (const File& file : input) {
    fs::create_directories(fs::absolute(file.name).parent_path());
    std::ofstream(file.name, std::ios::binary) << file.bytes;
  }
}

std::uint64_t supervise(const Target& target, const Request& request) {
  streams = {memory_file("out"), memory_file("err"), dup(STDOUT_FILENO)};
  auto& shared = *new (mmap(nullptr, sizeof(Shared), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0)) Shared;
  shared.next = request.first;
  const std::string folder = fs::current_path() / "child";
  const auto began = std::chrono::steady_clock::now();
  while (shared.next < request.first + request.cases) {
    std::fflush(nullptr);
    library_may_fork = true;
    const pid_t child = fork();
    library_may_fork = false;
    if (child == 0) be_child(target, request, shared, folder);
    int status = 0;
    while (waitpid(child, &status, 0) < 0)
      if (errno != EINTR) throw Failure("the child process is lost");
    fs::remove_all(folder);
    if (WIFEXITED(status) && WEXITSTATUS(status) == 0) continue;
    if (target.hdf5_may_crash && is_in_hdf5(content(streams.err))) {
      shared.add("HDF5 crashed");
    } else {
      ++shared.faults;
      report(target, request, shared.next, death(status));
    }
    ++shared.next;
  }
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
  std::string ends;
  for (std::size_t k = 0; k < Shared::kinds && shared.count[k] > 0; ++k)
    ends += fmt::format(", {} {}", shared.kind[k].data(), shared.count[k]);
  say(fmt::format("{} cases from {} of seed {} on: {} break a rule{}; {:.0f} a second\n", request.cases, request.first,
                  request.seed, shared.faults, ends, request.cases / seconds));
  write_figures(shared, request, seconds);
  return shared.faults;
}

}  // namespace lichtenberg::fuzz

// Functions of the C and C++ libraries, replaced.

extern "C" {
/// Commands that read in a child process read in this one, so that a case takes no fork and a crash is seen.
pid_t fork() noexcept {
  if (lichtenberg::fuzz::library_may_fork) return reinterpret_cast<pid_t (*)()>(dlsym(RTLD_NEXT, "fork"))();
  errno = EAGAIN;
  return -1;
}
clock_t clock() noexcept {
  static clock_t now = 0;
  return now += static_cast<clock_t>(lichtenberg::fuzz::clock_gain * CLOCKS_PER_SEC);
}
}

// The sanitizer's operator new ends the process where no memory is left; the program reports std::bad_alloc.
// Without inlining, GCC does not compare new with free().
[[gnu::noinline]] void* operator new(std::size_t bytes) {
  void* const memory = operator new(bytes, std::nothrow);
  if (memory == nullptr) throw std::bad_alloc();
  return memory;
}
[[gnu::noinline]] void* operator new[](std::size_t bytes) { return operator new(bytes); }
[[gnu::noinline]] void* operator new(std::size_t bytes, const std::nothrow_t&) noexcept {
  return bytes <= lichtenberg::fuzz::largest_block ? std::malloc(std::max<std::size_t>(bytes, 1)) : nullptr;
}
[[gnu::noinline]] void operator delete(void* memory) noexcept { std::free(memory); }
[[gnu::noinline]] void operator delete[](void* memory) noexcept { std::free(memory); }
[[gnu::noinline]] void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }
[[gnu::noinline]] void operator delete[](void* memory, std::size_t) noexcept { std::free(memory); }
