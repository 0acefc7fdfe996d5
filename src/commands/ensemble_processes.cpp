#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <deque>
#include <filesystem>
#include <functional>
#include <thread>
#include <utility>

#include "solvers/error.hpp"
#include "src/commands/ensemble.hpp"
#include "src/commands/interruption.hpp"
#include "src/commands/progress.hpp"
#include "src/commands/streams.hpp"

namespace lichtenberg::ensemble {
namespace {

using Clock = std::chrono::steady_clock;

/// `lichtenberg run` in a process of its own, in a process group of its own: an interruption from the keyboard reaches
/// us only, and we pass it on once. If we die, the system interrupts it.
class Process {
 public:
  Process(const std::string& folder, Member& member, const std::string& device) : member_(&member) {
    messages_ = check(memfd_create("messages", MFD_CLOEXEC));
    const std::string result = result_file(folder, member);
    std::vector<std::string> words{"lichtenberg", "run", scene_file(folder, member), "--out", result, "--quiet"};
    if (!device.empty()) words.insert(words.end(), {"--device", device});
    if (std::filesystem::exists(result)) words.push_back("--resume");
    std::vector<char*> arguments;
    for (std::string& word : words) arguments.push_back(word.data());
    arguments.push_back(nullptr);
    const pid_t parent = getpid();
    process_ = check(fork());
    if (process_ == 0) become(arguments.data(), parent);
    member.state = MemberState::running;
  }
  Process(Process&& other) noexcept
      : member_(other.member_),
        process_(std::exchange(other.process_, 0)),
        messages_(std::exchange(other.messages_, -1)) {}
  Process& operator=(Process&& other) noexcept {
    std::swap(member_, other.member_);
    std::swap(process_, other.process_);
    std::swap(messages_, other.messages_);
    return *this;
  }
  ~Process() {
    if (messages_ >= 0) close(messages_);
  }

  Member& member() const { return *member_; }
  void interrupt() const { kill(process_, SIGTERM); }
  /// Whether it is over; then the member's state says how it went.
  bool over() {
    int status = 0;
    if (waitpid(process_, &status, WNOHANG) != process_) return false;
    if (WIFEXITED(status) && WEXITSTATUS(status) == 0) {
      member_->state = MemberState::finished;
    } else if (WIFSIGNALED(status) && WTERMSIG(status) == SIGTERM) {
      member_->state = MemberState::stopped;
    } else {
      member_->state = MemberState::failed;
      member_->sentence = last_sentence();
      if (member_->sentence.empty())
        member_->sentence = WIFSIGNALED(status) ? fmt::format("ended by the signal {}", strsignal(WTERMSIG(status)))
                                                : fmt::format("ended with status {}", WEXITSTATUS(status));
    }
    return true;
  }

 private:
  static int check(int result) {
    if (result < 0) throw Failure(fmt::format("no process can be started ({})", std::strerror(errno)));
    return result;
  }

  [[noreturn]] void become(char** arguments, pid_t parent) const {
    for (const int signal : {SIGINT, SIGTERM}) ::signal(signal, SIG_DFL);
    setpgid(0, 0);
    prctl(PR_SET_PDEATHSIG, SIGTERM);
    if (getppid() != parent) _exit(1);  // it died before we could ask
    const int nothing = open("/dev/null", O_RDWR);
    for (const int stream : {STDIN_FILENO, STDOUT_FILENO}) dup2(nothing, stream);
    dup2(messages_, STDERR_FILENO);
    execv("/proc/self/exe", arguments);  // the very same program, even if another was built meanwhile
    _exit(127);
  }

  /// What the program said last.
  std::string last_sentence() const {
    std::string text(static_cast<std::size_t>(std::max<off_t>(lseek(messages_, 0, SEEK_END), 0)), '\0');
    text.resize(static_cast<std::size_t>(std::max<ssize_t>(pread(messages_, text.data(), text.size(), 0), 0)));
    const std::string mark = "lichtenberg: ";
    const std::size_t start = text.rfind(mark);
    if (start == std::string::npos) return {};
    const std::string sentence = text.substr(start + mark.size());
    return sentence.substr(0, sentence.find('\n'));
  }

  Member* member_;
  pid_t process_ = 0;
  int messages_ = -1;
};

/// "12 of 48 done, 2 running, 1 failed, about 3 min 20 s left"
class Progress {
 public:
  Progress(const std::vector<Member>& members, bool quiet)
      : members_(members), quiet_(quiet), terminal_(isatty(STDERR_FILENO)), cost_at_start_(cost_left()) {}
  ~Progress() { end_line(); }
  Progress(const Progress&) = delete;

  void show() {
    const Clock::time_point now = Clock::now();
    if (quiet_ || now - shown_ < (terminal_ ? std::chrono::milliseconds(200) : std::chrono::seconds(30))) return;
    shown_ = now;
    fmt::print(stderr, "{}{}{}", terminal_ ? "\r" : "", line(),
               terminal_ ? "\033[K" : "\n");  // \033[K: clears the rest of a longer line
    unfinished_line_ = terminal_;
  }
  /// Before anything else is printed: it would run into the line.
  void end_line() {
    if (std::exchange(unfinished_line_, false)) fmt::print(stderr, "\n");
  }

 private:
  int count(MemberState state) const { return static_cast<int>(std::ranges::count(members_, state, &Member::state)); }
  /// A running member counts as half done.
  double cost_left() const {
    double cost = 0;
    for (const Member& member : members_)
      cost += member.state == MemberState::waiting   ? member.cost
              : member.state == MemberState::running ? member.cost / 2
                                                     : 0;
    return cost;
  }
  std::string line() const {
    std::string text = fmt::format("{} of {} done, {} running", count(MemberState::finished), members_.size(),
                                   count(MemberState::running));
    if (const int failed = count(MemberState::failed); failed > 0) text += fmt::format(", {} failed", failed);
    const double left = cost_left(), done = cost_at_start_ - left;
    const double elapsed = std::chrono::duration<double>(Clock::now() - began_).count();
    if (done > 0.02 * cost_at_start_) text += fmt::format(", about {} left", duration(elapsed * left / done));
    return text;
  }

  const std::vector<Member>& members_;
  bool quiet_, terminal_, unfinished_line_ = false;
  double cost_at_start_;
  Clock::time_point began_ = Clock::now(), shown_ = Clock::now();
};

void report_failure(const Member& member) {
  fmt::print(stderr, "lichtenberg: {} failed: {}\n", printable(member.name), printable(member.sentence));
}

/// Takes those that are over out of `running`.
void collect(std::vector<Process>& running, const std::string& folder, Progress& progress) {
  for (Process& process : running) {
    if (!process.over()) continue;
    Member& member = process.member();
    if (member.state == MemberState::finished) inspect(folder, member);
    if (member.state == MemberState::failed) {
      progress.end_line();
      report_failure(member);
    }
  }
  std::erase_if(running, [](const Process& process) { return process.member().state != MemberState::running; });
}

}  // namespace

void run_members(const std::string& folder, std::vector<Member>& members, int jobs, const std::string& device,
                 bool quiet) {
  std::deque<Member*> waiting;
  for (Member& member : members)
    if (member.state == MemberState::waiting) waiting.push_back(&member);
  std::ranges::stable_sort(waiting, std::ranges::greater(), [](const Member* member) { return member->cost; });

  Progress progress(members, quiet);
  std::vector<Process> running;
  const Interruption interruption;
  bool told = false;
  while (!waiting.empty() || !running.empty()) {
    if (Interruption::requested()) {
      if (!std::exchange(told, true))
        for (const Process& process : running) process.interrupt();
      for (Member* member : waiting) member->state = MemberState::stopped;
      waiting.clear();
    }
    while (!waiting.empty() && static_cast<int>(running.size()) < jobs) {
      Member& member = *waiting.front();
      waiting.pop_front();
      if (write_scene(folder, member))
        running.emplace_back(folder, member, device);
      else
        report_failure(member);
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
    collect(running, folder, progress);
    progress.show();
  }
}

}  // namespace lichtenberg::ensemble
