#pragma once

#include <cstdint>
#include <functional>
#include <initializer_list>
#include <limits>
#include <string>
#include <string_view>
#include <type_traits>
#include <variant>
#include <vector>

#include "src/scene/choice.hpp"
#include "src/scene/draft.hpp"

namespace lichtenberg {

/// Where the value of a key goes. In a repeated table that is the last element, the one being read.
template <class T>
using At = T* (*)(Draft&);

/// Where the value of an enumeration goes that has names (choice.hpp), or of one that may have no value yet.
struct AtChoice {
  std::vector<std::string> names;
  std::function<std::string(Draft&)> name;                   ///< of the value; empty if there is none
  std::function<void(Draft&, const std::string& name)> set;  ///< does nothing for what is no name

  AtChoice() = default;
  /// Of a function from Draft& to E* or std::optional<E>*.
  template <class F, class Value = std::remove_pointer_t<std::invoke_result_t<F, Draft&>>>
  requires Enumeration<Value> || Enumeration<typename Value::value_type> AtChoice(F at) {
    constexpr bool always = Enumeration<Value>;
    using E = typename std::conditional_t<always, std::type_identity<Value>, Content<Value>>::type;
    names = names_of<E>();
    name = [at](Draft& draft) {
      const std::optional<E> value = *at(draft);
      return value ? name_of(*value) : std::string();
    };
    set = [at](Draft& draft, const std::string& text) {
      if (const std::optional<E> value = value_of<E>(text)) *at(draft) = *value;
    };
  }

 private:
  template <class Optional>
  struct Content {
    using type = typename Optional::value_type;
  };
};

using Place = std::variant<At<bool>, At<int>, At<std::int64_t>, At<double>, At<std::string>, At<Vec2>, At<Coordinates>,
                           At<std::vector<double>>, At<DomainSide>, At<std::optional<int>>, At<std::optional<double>>,
                           At<std::optional<std::string>>, At<std::optional<Interval>>, At<std::optional<Region>>,
                           At<std::optional<Coordinates>>, AtChoice>;

/// Functions of one name for std::visit.
template <class... Functions>
struct Overloaded : Functions... {
  using Functions::operator()...;
};
template <class... Functions>
Overloaded(Functions...) -> Overloaded<Functions...>;

/// The sizes that a number of a scene may have beside 0, in the unit of its key: products of a few of them, such as a
/// mass or an energy, neither overflow nor vanish.
inline constexpr double smallest_size = 1e-50, largest_size = 1e50;

/// The finite numbers from low to high.
struct Range {
  double low = -std::numeric_limits<double>::infinity();
  double high = std::numeric_limits<double>::infinity();
  bool low_itself = true, high_itself = true;  ///< false: that end itself is not allowed

  bool contains(double value) const;
  /// Whether the size of a number is 0 or from smallest_size to largest_size; an end that the range itself has beyond
  /// them counts in their place.
  bool allows_size_of(double value) const;
  /// As in "a number, greater than 0"; empty if every finite number is allowed.
  std::string text() const;
};

namespace ranges {
inline constexpr Range positive{.low = 0, .low_itself = false};
inline constexpr Range not_negative{.low = 0};
inline constexpr Range accuracy{.low = 0, .high = 1, .low_itself = false, .high_itself = false};
}  // namespace ranges

/// One key of the scene file. The reader, the checks, the help and the messages all follow from this entry; its default
/// is what an untouched Draft holds.
struct Key {
  std::string name;
  Place place;
  std::string unit{};                ///< of the key's numbers; empty: a pure number or none
  Range range{};                     ///< of each of the key's numbers
  std::vector<std::string> texts{};  ///< that a text may be; empty: any. (An enumeration has its names)
  bool required = false;
  std::vector<std::string> shapes{};  ///< the shapes of electrode that need the key, others refuse it; empty: any shape
  std::string computed_default{};     ///< says in words what an optional place is filled with
  std::string help{};

  /// The texts that may be written: an enumeration's names, or a text's; empty if there are others.
  std::vector<std::string> choices() const;
  /// What may be written, as in "a number in m, greater than 0".
  std::string allowed() const;
  /// "required", or the default, which an `untouched` draft (Schema::blank_draft) holds.
  std::string fallback(Draft& untouched) const;
};

/// The keys of several lists, in order.
std::vector<Key> joined(std::initializer_list<std::vector<Key>> lists);

struct Table {
  enum class Kind { optional, required, repeated };

  std::string path{};  ///< "" is the top of the file
  Kind kind = Kind::optional;
  std::string help{};
  std::function<void(Draft&, int line)> open = [](Draft&, int) {};  ///< what it means that the table stands in the file
  std::vector<Key> keys{};

  /// As written in a scene file: [field], [[conductor]]
  std::string header() const;
};

/// Everything a scene file may hold.
class Schema {
 public:
  /// With the tables of these effects. Throws InputError if two have one name.
  explicit Schema(const EffectKinds& kinds);

  const std::vector<Table>& tables() const { return tables_; }  ///< the top of the file first
  const Table* find_table(std::string_view path) const;         ///< null if there is none
  std::vector<std::string> known_paths() const;                 ///< of all tables and keys
  Draft blank_draft() const;                                    ///< with one untouched element of each repeated table

 private:
  std::vector<Table> tables_;
};

/// The tables that every scene may have: what there is, how it is computed and what that leaves.
std::vector<Table> tables_of_the_world();
std::vector<Table> tables_of_grains();
std::vector<Table> tables_of_the_computation();

/// Null if there is none.
const Key* find_key(const Table& table, std::string_view name);
/// Path of a key or table inside `table`.
std::string path_in(const Table& table, std::string_view name);

}  // namespace lichtenberg
