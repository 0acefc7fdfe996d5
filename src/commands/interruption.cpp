#include "src/commands/interruption.hpp"

#include <signal.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <string_view>

namespace lichtenberg {
namespace {

volatile sig_atomic_t noted = 0;

void note(int signal) {
  noted = signal;
  constexpr std::string_view message = "\nstopping at the next checkpoint; the same once more stops at once\n";
  [[maybe_unused]] const ssize_t written = write(STDERR_FILENO, message.data(), message.size());
}

void set_handler(void (*handler)(int)) {
  struct sigaction action {};
  action.sa_handler = handler;
  action.sa_flags = SA_RESTART | SA_RESETHAND;
  for (const int signal : {SIGINT, SIGTERM}) sigaction(signal, &action, nullptr);
}

}  // namespace

Interruption::Interruption() { set_handler(note); }
Interruption::~Interruption() { set_handler(SIG_DFL); }
bool Interruption::requested() { return noted != 0; }

void Interruption::obey() {
  const int signal = noted;
  std::fflush(nullptr);  // the signal will not
  set_handler(SIG_DFL);
  raise(signal);
  std::_Exit(128 + signal);
}

}  // namespace lichtenberg
