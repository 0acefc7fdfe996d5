#include "src/commands/interruption.hpp"

#include <signal.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <string_view>

namespace lichtenberg {
namespace {

volatile sig_atomic_t noted = 0, running = 0;

void note(int signal) {
  noted = signal;
  constexpr std::string_view before = "\nstopping; the same once more stops at once\n";
  constexpr std::string_view patient = "\nstopping at the next checkpoint; the same once more stops at once\n";
  constexpr std::string_view urgent = "\nstopping after this step; the same once more stops at once\n";
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
  running = work == Work::run;
  set_handler(note);
}
Interruption::~Interruption() { set_handler(SIG_DFL); }
void Interruption::begin() { running = 1; }
bool Interruption::requested() { return noted != 0; }
bool Interruption::urgent() { return noted != 0 && noted != SIGINT; }

void Interruption::obey() {
  const int signal = noted;
  std::fflush(nullptr);  // the signal will not
  set_handler(SIG_DFL);
  raise(signal);
  std::_Exit(128 + signal);
}

}  // namespace lichtenberg
