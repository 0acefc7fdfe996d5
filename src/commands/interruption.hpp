#pragma once

namespace lichtenberg {

/// Handler of the signals SIGINT, SIGTERM and SIGHUP. While an object exists, the first signal is recorded instead of
/// ending the program. A second signal, also of another kind, ends it at once. The first one also ends it if
/// requested() is not called within 20 s, because a step may never end. If the parent (nohup) had SIGHUP ignored, it
/// stays ignored.
class Interruption {
 public:
  /// Kind of work that a signal interrupts, for the message. `run`: ends after a step or at a checkpoint; `preparing`:
  /// work before it.
  enum class Work { preparing, run };

  /// Installs the handler of the three signals.
  explicit Interruption(Work work = Work::run);
  ~Interruption();
  Interruption(const Interruption&) = delete;

  /// Marks the change from `preparing` to `run`.
  void begin();
  /// Returns true if a signal was recorded, and then restarts the period of 20 s within which it must be called again.
  static bool requested();
  /// Returns true if the last recorded signal is SIGTERM or SIGHUP, whose senders (a scheduler, a closing terminal) do
  /// not wait long. Also restarts the period of 20 s, as requested() does.
  static bool urgent();
  /// Disables the limit of 20 s after a signal while a file is written. Until the next requested(), only a repeated
  /// signal ends the program. Without an Interruption object it has no effect.
  static void suspend_time_limit();
  /// Ends the program by the recorded signal, so that the parent process sees it.
  [[noreturn]] static void end_by_signal();
};

}  // namespace lichtenberg
