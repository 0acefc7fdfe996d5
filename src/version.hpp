#pragma once

namespace lichtenberg {

/// What built this program: results carry it as provenance.
struct Version {
  const char* number;    ///< release, "0.1.0"
  const char* commit;    ///< git commit, 12 digits, "-dirty" after it if files were changed; "unknown" outside git
  const char* compiler;  ///< "GNU 12.2.0"
  const char* flags;     ///< of the compiler
};

Version lichtenberg_version();

}  // namespace lichtenberg
