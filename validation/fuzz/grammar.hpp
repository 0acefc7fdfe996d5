#pragma once

#include <map>
#include <string>
#include <vector>

#include "validation/fuzz/fuzz.hpp"

/// Changes of scene texts: keys and values of TOML tables.
namespace lichtenberg::fuzz {

struct Line {
  std::string key, value;  ///< text of the value
};
struct Table {
  std::string header;  ///< with its brackets; empty for the keys before the first table
  std::vector<Line> lines;
};
using Document = std::vector<Table>;

/// Returns the scene with few bodies, a coarse grid and a short run, so that its work takes a few milliseconds.
Document small_scene(const std::string& text);
/// Keys by the headers of their tables.
using KnownKeys = std::map<std::string, std::vector<std::string>>;
/// Returns all keys of scenes, from the program's help.
KnownKeys known_keys();

/// Scenes and keys from which change() draws.
struct Grammar {
  std::vector<Document> scenes;
  KnownKeys known;
};
/// Changes a value, key or table, or adds a table of another scene.
void change(Document& document, const Grammar& grammar, Dice& dice);
/// Returns a value that can replace another.
std::string drawn_value(const std::string& before, Dice& dice);
/// Returns the text with some characters changed, removed or repeated.
std::string with_changed_characters(std::string text, Dice& dice);
std::string text_of(const Document& document);
/// Returns a scene of up to 80 grains in a periodic box. Most values are sensible; some are near the limits of a double
/// or of a wrong type.
std::string random_gas(Dice& dice);

}  // namespace lichtenberg::fuzz
