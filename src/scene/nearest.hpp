#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace lichtenberg {

/// Returns the number of insertions, deletions and replacements of single characters that convert a to b (Levenshtein
/// distance).
int edit_distance(std::string_view a, std::string_view b);

/// Returns the word with the smallest edit distance to `word`, the first of equals. `words` must not be empty.
std::string nearest(std::string_view word, const std::vector<std::string>& words);

/// Returns the most likely intended word for a misspelt `word`. This is the only one of `words` that begins with it, if
/// it has three characters or more. Otherwise it is the nearest word, if its distance is less than the length and at
/// most two edits or a third of the length. Empty if all are farther. `words` may be empty.
std::optional<std::string> likely(std::string_view word, const std::vector<std::string>& words);

/// Returns the known path (as in "field.cells") that is most likely meant by `path`. This is the nearest by edit
/// distance. A key of the same name in another table counts as at most three edits away.
std::string nearest_path(std::string_view path, const std::vector<std::string>& known);

}  // namespace lichtenberg
