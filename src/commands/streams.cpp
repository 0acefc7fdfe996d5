#include "src/commands/streams.hpp"

#include <fcntl.h>
#include <signal.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>

namespace lichtenberg {
namespace {

int first_error = 0;  // errno of the first failed write to standard output
bool output_repeats_files = false, closed_pipe_ends_process = false;

/// Opens /dev/null for closed standard descriptors. Ascending order ensures that each open() returns the closed one.
void open_closed_descriptors() {
  for (const int descriptor : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
    if (fcntl(descriptor, F_GETFD) >= 0 || errno != EBADF) continue;
    // The opposite direction keeps reads and writes failing as on a closed descriptor.
    if (open("/dev/null", descriptor == STDIN_FILENO ? O_WRONLY : O_RDONLY) < 0) return;
  }
}

/// Writes all bytes to the descriptor. Returns 0, or the errno of a failure.
int write_all(int descriptor, const char* bytes, std::size_t count) {
  while (count > 0) {
    const ssize_t written = write(descriptor, bytes, count);
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return errno;
    bytes += written;
    count -= static_cast<std::size_t>(written);
  }
  return 0;
}

ssize_t write_message(void*, const char* bytes, std::size_t count) {
  write_all(STDERR_FILENO, bytes, count);
  return static_cast<ssize_t>(count);
}

ssize_t write_output(void*, const char* bytes, std::size_t count) {
  // after an error nothing more is written, which avoids gaps
  if (first_error == 0) first_error = write_all(STDOUT_FILENO, bytes, count);
  return static_cast<ssize_t>(count);
}

std::FILE* stream(cookie_write_function_t* write, int buffering) {
  std::FILE* file = fopencookie(nullptr, "w", {.read = nullptr, .write = write, .seek = nullptr, .close = nullptr});
  if (file != nullptr) std::setvbuf(file, nullptr, buffering, BUFSIZ);
  return file;
}

/// Installs a handler for SIGPIPE. Child processes would inherit SIG_IGN.
void survive_closed_pipes() {
  struct sigaction action {
  }, before{};
  action.sa_handler = [](int) {};
  action.sa_flags = SA_RESTART;
  closed_pipe_ends_process = sigaction(SIGPIPE, nullptr, &before) == 0 && before.sa_handler == SIG_DFL;
  if (closed_pipe_ends_process) sigaction(SIGPIPE, &action, nullptr);
}

}  // namespace

void prepare_streams() {
  static bool done = false;
  if (done) return;
  done = true;
  open_closed_descriptors();
  survive_closed_pipes();
  std::fflush(nullptr);
  if (std::FILE* messages = stream(write_message, _IONBF)) stderr = messages;
  if (std::FILE* output = stream(write_output, isatty(STDOUT_FILENO) ? _IOLBF : _IOFBF)) stdout = output;
}

void output_is_optional() { output_repeats_files = true; }
bool is_output_optional() { return output_repeats_files; }

int output_error() {
  std::fflush(stdout);
  return first_error;
}

bool closed_pipe_ends_program() { return closed_pipe_ends_process && !output_repeats_files && output_error() == EPIPE; }

void end_by_closed_pipe() {
  signal(SIGPIPE, SIG_DFL);
  raise(SIGPIPE);
}

std::string printable(std::string_view text) {
  constexpr std::string_view digits = "0123456789abcdef";
  std::string shown;
  for (std::size_t k = 0; k < text.size(); ++k) {
    const unsigned char c = text[k], next = k + 1 < text.size() ? text[k + 1] : 0;
    const bool control = (c < 0x20 && c != '\t') || c == 0x7f;
    const bool second_set = c == 0xc2 && next >= 0x80 && next < 0xa0;  // U+0080 to U+009F in UTF-8
    if (!control && !second_set) {
      shown += text[k];
      continue;
    }
    const unsigned char code = control ? c : (++k, next);
    shown += {'\\', 'x', digits[code / 16], digits[code % 16]};
  }
  return shown;
}

}  // namespace lichtenberg
