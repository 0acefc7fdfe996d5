#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace lichtenberg {

/// Computes the Levenshtein distance: the number of insertions, deletions and replacements of single characters that
/// convert a to b.
int edit_distance(std::string_view a, std::string_view b);

/// Returns the word with the smallest Levenshtein distance to `word`, the first of equals. `words` must not be empty.
std::string nearest(std::string_view word, const std::vector<std::string>& words);

/// Returns the most likely intended word for a misspelt `word`; empty if there are no `words` or all differ too much.
/// If `word` has three characters or more and only one of `words` begins with it, that one is returned. Otherwise the
/// nearest word is returned. Its distance must be less than the length of `word`, and at most the larger of two edits
/// and a third of the length.
std::optional<std::string> likely(std::string_view word, const std::vector<std::string>& words);

/// Returns the known path of a key (as in "field.cells") that is most likely meant by `path`: the nearest by
/// Levenshtein distance. A key of the same name in another table counts as at most three edits away, unless `path` is
/// that of an effect.
std::string nearest_path(std::string_view path, const std::vector<std::string>& known);

}  // namespace lichtenberg
