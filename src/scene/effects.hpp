#pragma once

#include <any>
#include <string_view>
#include <utility>
#include <vector>

namespace lichtenberg {

struct EffectKind;

/// Kinds of effects that a scene may have, in the order in which their contributions are added. They outlive all
/// scenes.
using EffectKinds = std::vector<const EffectKind*>;

/// The effects of a scene and their options. The options of an effect are a struct of its own (HertzContactOptions, for
/// example), whose static function kind() returns the kind of effect.
class Effects {
 public:
  struct Entry {
    const EffectKind* kind;
    std::any options;
  };

  /// Returns the options of type O; null if the effect is not in the scene.
  template <class O>
  const O* find() const {
    for (const Entry& entry : entries_)
      if (const O* options = std::any_cast<O>(&entry.options)) return options;
    return nullptr;
  }
  /// Returns the options of type O for changes; null if the effect is not in the scene.
  template <class O>
  O* find() {
    return const_cast<O*>(std::as_const(*this).find<O>());
  }
  /// Returns true if the scene has an effect whose table has this name.
  bool has(std::string_view name) const;
  /// Returns true if a kind of effect in the scene has this flag, such as &EffectKind::field.
  bool has(bool EffectKind::*flag) const;
  /// Returns true if the scene has the effect with options of type O.
  template <class O>
  bool has() const {
    return find<O>() != nullptr;
  }

  /// Adds the effect with options of type O to the scene, or replaces its options if the scene has it. Throws
  /// InputError if the scene has another kind of the same name.
  template <class O>
  O& add(O options = {}) {
    return *std::any_cast<O>(&add(O::kind(), std::any(std::move(options))));
  }
  /// Adds an effect of this kind to the scene, or replaces its options, which have the type of `kind.options`. Throws
  /// InputError if the scene has another kind of the same name.
  std::any& add(const EffectKind& kind, std::any options);
  /// Removes the effect whose table has this name, if the scene has it.
  void remove(std::string_view name);
  template <class O>
  void remove() {
    std::erase_if(entries_, [](const Entry& entry) { return std::any_cast<O>(&entry.options) != nullptr; });
  }

  /// Sorts the effects of the scene into the order of `kinds`. Effects of other kinds come last.
  void sort(const EffectKinds& kinds);

  auto begin() const { return entries_.begin(); }
  auto end() const { return entries_.end(); }
  std::size_t size() const { return entries_.size(); }

 private:
  std::vector<Entry> entries_;
};

}  // namespace lichtenberg
