#include "src/commands/reading.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>

#include "solvers/error.hpp"
#include "solvers/parallel/petsc.hpp"
#include "src/record/result_file.hpp"

namespace lichtenberg {
namespace {

volatile pid_t reader = 0;

/// To the child, but for signals of a terminal, which reach it as well.
void pass_on(int signal, siginfo_t* about, void*) {
  if (about->si_code != SI_KERNEL) kill(reader, signal);
}

void pass_signals_on() {
  struct sigaction action {};
  action.sa_sigaction = pass_on;
  action.sa_flags = SA_RESTART | SA_SIGINFO;
  for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGQUIT}) {
    struct sigaction before {};
    if (sigaction(signal, nullptr, &before) == 0 && before.sa_handler != SIG_IGN) sigaction(signal, &action, nullptr);
  }
}

/// The child has the process number 0. None, and -1, where the system has no more.
pid_t fork_reader() {
  std::fflush(nullptr);  // or the child would write what waits once more
  const pid_t parent = getpid(), child = fork();
  if (child != 0) return child;
  prctl(PR_SET_PDEATHSIG, SIGTERM);
  if (getppid() != parent) _exit(1);
  return 0;
}

int status_of(pid_t child) {
  int status = 0;
  while (waitpid(child, &status, 0) < 0)
    if (errno != EINTR) throw Failure(fmt::format("lost the process that reads ({})", std::strerror(errno)));
  return status;
}

bool is_crash(int status) {
  if (!WIFSIGNALED(status)) return false;
  const int signal = WTERMSIG(status);
  return signal == SIGSEGV || signal == SIGBUS || signal == SIGABRT || signal == SIGFPE || signal == SIGILL;
}

std::string crash_in_words(const std::string& files, int status) {
  return fmt::format("{} is damaged and cannot be read (reading it ended with the signal {}, {})", files,
                     WTERMSIG(status), strsignal(WTERMSIG(status)));
}

}  // namespace

void read_in_child(const std::vector<std::string>& files) {
  if (parallel::process_count() > 1) return;
  reader = fork_reader();
  if (reader <= 0) return;
  pass_signals_on();
  const int status = status_of(reader);
  if (is_crash(status)) {
    fmt::print(stderr, "lichtenberg: {}\n", crash_in_words(fmt::format("{}", fmt::join(files, ", ")), status));
    _exit(2);
  }
  if (WIFEXITED(status)) _exit(WEXITSTATUS(status));
  signal(WTERMSIG(status), SIG_DFL);
  raise(WTERMSIG(status));
  _exit(128 + WTERMSIG(status));
}

void try_reading(const std::string& file, const std::function<void()>& read) {
  if (parallel::process_count() > 1) return;
  const pid_t child = fork_reader();
  if (child < 0) return;
  if (child == 0) {
    const int nothing = open("/dev/null", O_WRONLY);
    for (const int stream : {STDOUT_FILENO, STDERR_FILENO}) dup2(nothing, stream);
    try {
      read();
    } catch (...) {  // the parent meets it again
    }
    _exit(0);
  }
  if (const int status = status_of(child); is_crash(status)) throw InputError(crash_in_words(file, status));
}

void warn_if_changed(const ResultFile& result) {
  constexpr int without_checksums = 1;
  if (result.is_sealed() || result.format() == without_checksums) return;
  fmt::print(stderr, "lichtenberg: {} was changed by another program after its run: no checksum vouches for it\n",
             result.path());
}

}  // namespace lichtenberg
