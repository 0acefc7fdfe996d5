#pragma once

namespace lichtenberg {

/// Version and build of this program, which results store as provenance.
struct Version {
  const char* number;  ///< release, "1.0.0"
  /// Commit in git, 12 digits, followed by "-dirty" if files were changed; "unknown" outside git
  const char* commit;
  const char* compiler;  ///< "GNU 12.2.0"
  const char* flags;     ///< flags of the compiler
};

/// Returns the version and build of this program.
Version lichtenberg_version();

}  // namespace lichtenberg
