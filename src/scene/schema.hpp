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

/// Function that returns the address of a key's value in a draft (scene as read). For a repeated table the address is
/// in the last element, which is being read.
template <class T>
using At = T* (*)(Draft&);

/// Access to a key's value in a draft if the value is an enumeration with names (choice.hpp), or an optional
/// enumeration.
struct AtChoice {
  std::vector<std::string> names;
  std::function<std::string(Draft&)> name;                   ///< name of the value; empty if there is none
  std::function<void(Draft&, const std::string& name)> set;  ///< ignores unknown names

  AtChoice() = default;
  /// Makes the access from a function that converts Draft& to E* or std::optional<E>*.
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

using KeyTarget =
    std::variant<At<bool>, At<int>, At<std::int64_t>, At<double>, At<std::string>, At<Vec2>, At<Coordinates>,
                 At<std::vector<double>>, At<std::vector<Vec2>>, At<std::vector<std::string>>, At<DomainSide>,
                 At<std::optional<Signal>>, At<std::optional<int>>, At<std::optional<double>>,
                 At<std::optional<std::string>>, At<std::optional<Interval>>, At<std::optional<Region>>,
                 At<std::optional<Coordinates>>, AtChoice>;

/// Function object with the overloads of all `Functions`, for std::visit.
template <class... Functions>
struct Overloaded : Functions... {
  using Functions::operator()...;
};
template <class... Functions>
Overloaded(Functions...) -> Overloaded<Functions...>;

/// Smallest and largest magnitude of a non-zero number in a scene, in the unit of its key. Products of a few such
/// numbers, such as a mass or an energy, neither overflow nor vanish.
inline constexpr double smallest_size = 1e-50, largest_size = 1e50;

/// Interval of the finite numbers from low to high that a key allows.
struct Range {
  double low = -std::numeric_limits<double>::infinity();
  double high = std::numeric_limits<double>::infinity();
  bool low_itself = true, high_itself = true;  ///< false: the interval is open at that end

  /// Returns true if the value is finite and in the interval.
  bool contains(double value) const;
  /// Returns true if the value is 0 or its magnitude is from smallest_size to largest_size. An end of the range beyond
  /// these limits replaces them.
  bool allows_size_of(double value) const;
  /// Describes the range in words, as in "at least 0 and less than 1"; empty if every finite number is allowed.
  std::string text() const;
};

namespace ranges {
inline constexpr Range positive{.low = 0, .low_itself = false};
inline constexpr Range not_negative{.low = 0};
inline constexpr Range accuracy{.low = 0, .high = 1, .low_itself = false, .high_itself = false};
}  // namespace ranges

/// Declaration of one key of the scene file. The reader, the check of its type and range, and the help follow from it.
/// Its default is the value in an untouched Draft, or depends on other keys (`computed_default`).
struct Key {
  std::string name;
  KeyTarget target;
  std::string unit{};                ///< unit of the key's numbers; empty: a pure number or no number
  Range range{};                     ///< range of each of the key's numbers
  std::vector<std::string> texts{};  ///< allowed texts; empty: any. Enumerations use their names instead.
  bool required = false;
  std::vector<std::string> shapes{};  ///< shapes of electrode that need the key, others refuse it; empty: any shape
  std::vector<std::string> optional_shapes{};  ///< shapes of electrode that may have the key, others refuse it
  std::string computed_default{};              ///< describes the default of an optional value
  std::string help{};
  std::string old_name{};  ///< former name, which is read with a warning
  /// Meaning of the key's numbers in a scene of grains
  enum class Scale {
    own,     ///< in `unit`, in SI or in reduced units as the scene
    si,      ///< in SI in every scene
    reduced  ///< dimensionless by the scales of [units]; a scene in SI refuses the key
  };
  Scale scale = Scale::own;

  /// Returns the allowed texts: the names of an enumeration, or `texts`. Empty if other values are allowed.
  std::vector<std::string> choices() const;
  /// Describes the allowed values, as in "a number in m, greater than 0".
  std::string allowed() const;
  /// Describes the default for the help, or states that the key is required. The default is read from an `untouched`
  /// draft (Schema::blank_draft).
  std::string fallback(Draft& untouched) const;
};

/// Concatenates lists of keys.
std::vector<Key> joined(std::initializer_list<std::vector<Key>> lists);

/// Declaration of one table of the scene file with its keys.
struct Table {
  enum class Kind { optional, required, repeated };

  std::string path{};  ///< "" is the top of the file
  Kind kind = Kind::optional;
  std::string help{};
  /// Records in the draft that the file has the table.
  std::function<void(Draft&, int line)> open = [](Draft&, int) {};
  std::vector<Key> keys{};
  std::string old_path{};  ///< former path, which is read with a warning

  /// Returns the header of the table in a scene file, such as [field] or [[conductor]].
  std::string header() const;
};

/// Declarations of all tables and keys that a scene file may have.
class Schema {
 public:
  /// Makes the schema with the tables of these effects. Throws InputError if two effects have the same name.
  explicit Schema(const EffectKinds& kinds);

  const std::vector<Table>& tables() const { return tables_; }  ///< top of the file first
  const Table* find_table(std::string_view path) const;         ///< null if there is none
  std::vector<std::string> known_paths() const;                 ///< paths of all tables and keys
  Draft blank_draft() const;                                    ///< with one untouched element of each repeated table

 private:
  std::vector<Table> tables_;
};

/// Returns the top of the file, and the tables of domain, fluid, material, electrodes, circuits and walls.
std::vector<Table> tables_of_the_world();
/// Returns the tables of conductors and grains: single ones, groups and populations.
std::vector<Table> tables_of_bodies();
/// Returns the tables that only scenes of grains have: units and equilibration.
std::vector<Table> tables_of_grains();
/// Returns the tables of the computation and the output: field, mechanics, minimization, stop, output, network.
std::vector<Table> tables_of_the_computation();

/// Returns the key of a table with this name; null if there is none.
const Key* find_key(const Table& table, std::string_view name);
/// Returns the dotted path of a key or table inside `table`.
std::string path_in(const Table& table, std::string_view name);

}  // namespace lichtenberg
