#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace lichtenberg {

/// Insertions, deletions and replacements of single characters that turn a into b (Levenshtein's distance).
int edit_distance(std::string_view a, std::string_view b);

/// The word with the smallest edit distance to `word`; the first of equals. `words` must not be empty.
std::string nearest(std::string_view word, const std::vector<std::string>& words);

/// The one of `words` that the writer of `word` may have meant: one that begins with it, if no other does, or the
/// nearest, if it is two edits or a third of the word away. Empty if all are farther. `words` may be empty.
std::optional<std::string> likely(std::string_view word, const std::vector<std::string>& words);

/// The known path (as in "field.cells") that the writer of `path` most likely meant: the nearest by edit distance,
/// where a key of exactly the same name in another table counts as three edits away.
std::string nearest_path(std::string_view path, const std::vector<std::string>& known);

}  // namespace lichtenberg
