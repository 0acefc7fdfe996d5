#include "src/scene/nearest.hpp"

#include <algorithm>
#include <numeric>

namespace lichtenberg {
namespace {

std::string_view last_name(std::string_view path) {
  return path.substr(path.find_last_of('.') + 1);  // npos + 1 = 0: the whole path
}

template <class Distance>
std::string closest(const std::vector<std::string>& words, Distance distance) {
  return *std::min_element(words.begin(), words.end(),
                           [&](const std::string& a, const std::string& b) { return distance(a) < distance(b); });
}

}  // namespace

int edit_distance(std::string_view a, std::string_view b) {
  std::vector<int> row(b.size() + 1);  // row[j]: distance between a's first i characters and b's first j
  std::iota(row.begin(), row.end(), 0);
  for (std::size_t i = 1; i <= a.size(); ++i) {
    int diagonal = row[0];
    row[0] = static_cast<int>(i);
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const int replaced = diagonal + (a[i - 1] != b[j - 1]);
      diagonal = row[j];
      row[j] = std::min({row[j] + 1, row[j - 1] + 1, replaced});
    }
  }
  return row[b.size()];
}

std::string nearest(std::string_view word, const std::vector<std::string>& words) {
  return closest(words, [&](const std::string& known) { return edit_distance(word, known); });
}

std::optional<std::string> likely(std::string_view word, const std::vector<std::string>& words) {
  if (words.empty()) return {};
  const auto begins_with_it = [&](const std::string& known) { return word.size() >= 3 && known.starts_with(word); };
  if (std::ranges::count_if(words, begins_with_it) == 1) return *std::ranges::find_if(words, begins_with_it);
  const std::string found = nearest(word, words);
  const int size = static_cast<int>(word.size()), distance = edit_distance(word, found);
  return distance <= std::max(2, size / 3) && distance < size ? std::optional(found) : std::nullopt;
}

std::string nearest_path(std::string_view path, const std::vector<std::string>& known) {
  constexpr int in_another_table = 3;
  // A path directly in [effects] is meant to name an effect, not a key of an effect.
  const bool is_effect = path.starts_with("effects.") && std::ranges::count(path, '.') == 1;
  return closest(known, [&](const std::string& candidate) {
    const int distance = edit_distance(path, candidate);
    return !is_effect && last_name(path) == last_name(candidate) ? std::min(distance, in_another_table) : distance;
  });
}

}  // namespace lichtenberg
