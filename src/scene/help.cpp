#include <fmt/format.h>

#include "src/scene/schema.hpp"

namespace lichtenberg {

std::string scene_help(const EffectKinds& kinds) {
  const Schema schema(kinds);
  Draft untouched = schema.blank_draft();
  std::string text =
      "A scene is a TOML file. Every number is in the SI unit named here and written without it. A [[table]] may stand "
      "any "
      "number of times. D is the dissertation that the conductors' model comes from.\n";
  for (const Table& table : schema.tables()) {
    text += fmt::format("\n{}\n  {}\n", table.header(), table.help);
    for (const Key& key : table.keys)
      text += fmt::format("    {:<22} {}\n    {:<22} {}; {}\n", key.name, key.help, "", key.allowed(),
                          key.fallback(untouched));
  }
  return text;
}

}  // namespace lichtenberg
