#pragma once

namespace lichtenberg {

/// While one of these lives, SIGINT, SIGTERM and SIGHUP are noted instead of ending the program. A second one does end
/// it, and so does the first where nobody asks for it within 20 s: a step that has no end is not waited for. A SIGHUP
/// that whoever started the program (nohup) has it ignore stays ignored.
class Interruption {
 public:
  /// Of what a signal comes to: `run`, which ends after a step or at a checkpoint, or what is done before it.
  enum class Work { preparing, run };

  explicit Interruption(Work work = Work::run);
  ~Interruption();
  Interruption(const Interruption&) = delete;

  /// What was prepared begins to run.
  void begin();
  static bool requested();
  /// By SIGTERM or SIGHUP: who sends these (a scheduler, a terminal that goes) does not wait long.
  static bool urgent();
  /// Waits for a file that is being written, however long that takes: until requested() is called again no signal ends
  /// the program but a second one.
  static void take_time();
  /// Ends the program by the signal that was noted, so that whoever started it sees that.
  [[noreturn]] static void obey();
};

}  // namespace lichtenberg
