#include "src/commands/interruption.hpp"

#include <signal.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <string_view>

namespace lichtenberg {
namespace {

volatile sig_atomic_t received_signal = 0, running = 0, writing = 0;
/// 1 while an Interruption object exists. Without one, timers and signals belong to the program that uses the library.
volatile sig_atomic_t handling = 0;

/// Seconds after a signal within which the program must call requested(). Later it is ended, because its step may never
/// end.
constexpr unsigned grace_seconds = 20;

void set_handler(void (*handler)(int));

void end_at_once(int) {
  constexpr std::string_view in_run =
      "\nstopping at once: the step has not ended; a result holds the run up to its last checkpoint\n";
  constexpr std::string_view before = "\nstopping at once: the preparation of the run has not ended\n";
  const std::string_view message = running ? in_run : before;
  [[maybe_unused]] const ssize_t written = write(STDERR_FILENO, message.data(), message.size());
  const int signal = received_signal;
  set_handler(SIG_DFL);
  raise(signal);
}

/// Starts the period within which the program must call requested() again.
void start_grace_period() { alarm(grace_seconds); }

void on_signal(int signal) {
  received_signal = signal;
  set_handler(SIG_DFL);  // the next signal of any kind ends the program
  if (!writing) start_grace_period();
  constexpr std::string_view before = "\nstopping; repeat the signal to stop at once\n";
  constexpr std::string_view patient = "\nstopping at the next checkpoint; repeat the signal to stop at once\n";
  constexpr std::string_view urgent = "\nstopping after this step; repeat the signal to stop at once\n";
  const std::string_view message = !running ? before : signal == SIGINT ? patient : urgent;
  [[maybe_unused]] const ssize_t written = write(STDERR_FILENO, message.data(), message.size());
}

void set_handler(void (*handler)(int)) {
  struct sigaction action {};
  action.sa_handler = handler;
  action.sa_flags = SA_RESTART | SA_RESETHAND;
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
    struct sigaction before {};
    const bool ignored = sigaction(signal, nullptr, &before) == 0 && before.sa_handler == SIG_IGN;
    if (signal != SIGHUP || !ignored) sigaction(signal, &action, nullptr);
  }
}

}  // namespace

Interruption::Interruption(Work work) {
  handling = 1;
  running = work == Work::run;
  struct sigaction action {};
  action.sa_handler = end_at_once;
  sigaction(SIGALRM, &action, nullptr);
  set_handler(on_signal);
}
Interruption::~Interruption() {
  handling = 0;
  alarm(0);
  signal(SIGALRM, SIG_DFL);
  set_handler(SIG_DFL);
}
void Interruption::begin() { running = 1; }
bool Interruption::requested() {
  writing = 0;
  if (received_signal == 0) return false;
  start_grace_period();
  return true;
}
bool Interruption::urgent() { return requested() && received_signal != SIGINT; }
void Interruption::suspend_time_limit() {
  if (handling == 0) return;
  writing = 1;  // set before the alarm is cleared, so that a signal between the two does not start it again
  alarm(0);
}

void Interruption::end_by_signal() {
  const int signal = received_signal;
  std::fflush(nullptr);  // raise() does not flush
  set_handler(SIG_DFL);
  raise(signal);
  std::_Exit(128 + signal);
}

}  // namespace lichtenberg
