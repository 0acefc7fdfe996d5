#pragma once

namespace lichtenberg {

/// Handler of SIGINT, SIGTERM and SIGHUP. While an object exists, the first signal is recorded instead of ending the
/// program. A second signal ends it. The first one also ends it if requested() is not called within 20 s, because a
/// step may never end. If the parent (nohup) had SIGHUP ignored, it stays ignored.
class Interruption {
 public:
  /// Work that a signal interrupts: `run` ends after a step or at a checkpoint; `preparing` precedes it.
  enum class Work { preparing, run };

  explicit Interruption(Work work = Work::run);
  ~Interruption();
  Interruption(const Interruption&) = delete;

  /// Marks the start of the run.
  void begin();
  static bool requested();
  /// Returns true if SIGTERM or SIGHUP was recorded. Their senders (a scheduler, a closing terminal) do not wait long.
  static bool urgent();
  /// Disables the time limit while a file is written: until the next requested(), only a second signal ends the
  /// program.
  static void suspend_time_limit();
  /// Ends the program by the recorded signal, so that the parent process sees it.
  [[noreturn]] static void end_by_signal();
};

}  // namespace lichtenberg
