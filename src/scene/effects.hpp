#pragma once

#include <any>
#include <string_view>
#include <utility>
#include <vector>

namespace lichtenberg {

struct EffectKind;

/// Kinds of effects that a scene may have, in the order in which their shares are added up. They outlive all scenes.
using EffectKinds = std::vector<const EffectKind*>;

/// What stands in a scene's tables of effects: which effects it has, and their options. Options are a struct of the
/// effect's own (HertzContactOptions, say) with a static function `kind()`, which says what effect they are of.
class Effects {
 public:
  struct Entry {
    const EffectKind* kind;
    std::any options;
  };

  /// The options of type O; null if the effect is not in the scene.
  template <class O>
  const O* find() const {
    for (const Entry& entry : entries_)
      if (const O* options = std::any_cast<O>(&entry.options)) return options;
    return nullptr;
  }
  template <class O>
  O* find() {
    return const_cast<O*>(std::as_const(*this).find<O>());
  }
  bool has(std::string_view name) const;  ///< by the name of its table
  /// Whether one is of a kind for which that is true: has(&EffectKind::field).
  bool has(bool EffectKind::*flag) const;
  template <class O>
  bool has() const {
    return find<O>() != nullptr;
  }

  /// Puts an effect into the scene, or gives it other options if it is there.
  template <class O>
  O& add(O options = {}) {
    return *std::any_cast<O>(&add(O::kind(), std::any(std::move(options))));
  }
  /// Puts an effect of that kind into the scene, or gives it other options; they are of the type that `kind` has.
  /// Throws InputError if the scene has another kind of the same name.
  std::any& add(const EffectKind& kind, std::any options);
  void remove(std::string_view name);
  template <class O>
  void remove() {
    std::erase_if(entries_, [](const Entry& entry) { return std::any_cast<O>(&entry.options) != nullptr; });
  }

  /// Puts those of `kinds` into their order, and what is none of them behind.
  void sort(const EffectKinds& kinds);

  auto begin() const { return entries_.begin(); }
  auto end() const { return entries_.end(); }
  std::size_t size() const { return entries_.size(); }

 private:
  std::vector<Entry> entries_;
};

}  // namespace lichtenberg
