#pragma once

namespace lichtenberg {

/// While one of these lives, SIGINT and SIGTERM are noted instead of ending the program; a second one does end it.
class Interruption {
 public:
  Interruption();
  ~Interruption();
  Interruption(const Interruption&) = delete;

  static bool requested();
  /// Ends the program by the signal that was noted, so that whoever started it sees that.
  [[noreturn]] static void obey();
};

}  // namespace lichtenberg
