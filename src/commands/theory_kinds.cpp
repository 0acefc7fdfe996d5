#include "src/commands/theory_kind.hpp"

namespace lichtenberg {

const std::vector<TheoryKind>& theory_kinds() {
  static const std::vector<TheoryKind> kinds{haff_kind(),          monopolar_kind(), restitution_kind(),
                                             smoluchowski_kind(),  kinetic_kind(),   stability_kind(),
                                             hydrodynamics_kind(), all_kind()};
  return kinds;
}

}  // namespace lichtenberg
