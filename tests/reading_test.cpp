// Tests of commands that read results in a child process: each end of the child determines the end of the command.
#include <doctest/doctest.h>
#include <fcntl.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cstdio>
#include <cstring>
#include <functional>
#include <stdexcept>
#include <string>

#include "solvers/error.hpp"
#include "src/commands/reading.hpp"
#include "tests/folder.hpp"
#include "tests/message.hpp"

namespace reading_test {

using namespace lichtenberg;

namespace {

constexpr std::array crashes = {SIGSEGV, SIGBUS, SIGABRT, SIGFPE, SIGILL};

/// Ends this process by the signal, without a core file or output of the test's own handlers.
void end_by(int number) {
  const rlimit none{0, 0};
  setrlimit(RLIMIT_CORE, &none);
  signal(number, SIG_DFL);
  raise(number);
}

struct Ended {
  int status = 0;  ///< As of waitpid.
  std::string err;
};

/// Process that executes `read` in a child, as a command with two input files does.
Ended command(const std::function<void()>& read) {
  const Folder folder;
  std::fflush(nullptr);
  const pid_t process = fork();
  REQUIRE(process >= 0);
  if (process == 0) {
    if (dup2(open((folder / "err").c_str(), O_WRONLY | O_CREAT, 0600), STDERR_FILENO) < 0) _exit(99);
    read_in_child({"a.h5", "b.h5"});
    read();
    _exit(0);
  }
  Ended ended;
  REQUIRE(waitpid(process, &ended.status, 0) == process);
  ended.err = text_of(folder / "err");
  return ended;
}

}  // namespace

TEST_CASE("read_in_child: a crash with readable files gives a message, status 1") {
  for (const int number : crashes) {
    CAPTURE(number);
    const Ended ended = command([=] { end_by(number); });
    REQUIRE(WIFEXITED(ended.status));
    CHECK(WEXITSTATUS(ended.status) == 1);
    CHECK(ended.err ==
          std::string("lichtenberg: the program crashed (signal ") + std::to_string(number) + ", " + strsignal(number) +
              "), though a.h5, b.h5 can be read: this is an error of the program, please report it with the command "
              "and the file\n");
  }
}

TEST_CASE("read_in_child: exit status or signal of the reader become the command's") {
  for (const int status : {0, 1, 2, 7}) {
    const Ended ended = command([=] { _exit(status); });
    REQUIRE(WIFEXITED(ended.status));
    CHECK(WEXITSTATUS(ended.status) == status);
    CHECK(ended.err == "");
  }
  for (const int number : {SIGTERM, SIGKILL}) {
    const Ended ended = command([=] { end_by(number); });
    REQUIRE(WIFSIGNALED(ended.status));
    CHECK(WTERMSIG(ended.status) == number);
    CHECK(ended.err == "");
  }
}

TEST_CASE("try_reading: a crash becomes an InputError, exceptions are ignored") {
  for (const int number : crashes) {
    CAPTURE(number);
    CHECK_THROWS_WITH_AS(try_reading("a.h5", [=] { end_by(number); }),
                         doctest::Contains("a.h5 is damaged and cannot be read"), InputError);
  }
  CHECK(message_of([] { try_reading("a.h5", [] { throw std::runtime_error("no frames"); }); }) == "");
  CHECK(message_of([] { try_reading("a.h5", [] {}); }) == "");
}

}  // namespace reading_test
