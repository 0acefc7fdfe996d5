#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "src/scene/scene.hpp"
#include "src/scene/stopping.hpp"

namespace lichtenberg {

/// A number that a population draws uniformly from [smallest, largest] for each of its conductors.
struct Interval {
  double smallest = 0, largest = 0;
};

/// A point or a vector of two components or three; what is not given is 0.
struct Coordinates {
  Vec3 value{};
  int count = 2;
};

/// A rectangle or a cuboid between two corners of as many components; a rectangle in three dimensions goes from front
/// to back.
struct Region {
  Coordinates lower{}, upper{};

  int axes() const { return lower.count; }  ///< that it bounds
};

/// An [[electrode]] as written: the keys of every shape, of which the reader has seen to it that the right ones are
/// there.
struct ElectrodeDraft {
  int line = 0;
  std::string shape{};
  std::optional<std::string> name{};
  double potential = 0;
  std::optional<double> series_resistance{};
  Vec2 centre{}, from{}, to{};
  Coordinates position{};  ///< of a sphere
  std::string side{};
  double at = 0, radius = 0, width = 0;
};

struct ConductorDraft {
  int line = 0;
  Conductor conductor{};
  Coordinates position{};
  std::optional<Coordinates> velocity{};
  std::optional<double> charge{};
  std::optional<std::string> group{};
  std::optional<double> young{}, poisson{};  ///< of its material, Pa and 1
};

struct GroupDraft {
  int line = 0;
  std::string name{};
  std::optional<double> charge{}, potential{};
};

struct WallDraft {
  int line = 0;
  std::optional<std::string> name{};
  Coordinates point{}, normal{};
};

/// Of the radii in their interval, which truncates it.
enum class RadiusDistribution { uniform, normal, lognormal };
template <>
inline constexpr Named<RadiusDistribution> values_named<RadiusDistribution>[] = {
    {RadiusDistribution::uniform, "uniform"},
    {RadiusDistribution::normal, "normal"},
    {RadiusDistribution::lognormal, "lognormal"}};

/// How the grains of a population share out charge: all the same, or at random about 0 (charge_distribution.hpp).
enum class ChargeDistribution { equal, gaussian, exponential_power };
template <>
inline constexpr Named<ChargeDistribution> values_named<ChargeDistribution>[] = {
    {ChargeDistribution::equal, "equal"},
    {ChargeDistribution::gaussian, "gaussian"},
    {ChargeDistribution::exponential_power, "exponential-power"}};

/// `count` conductors at random places of `region`, wholly inside it.
struct PopulationDraft {
  int line = 0;
  int count = 0;
  std::optional<Interval> radius{};
  std::vector<double> radii{};  ///< m, taken in turn, in place of `radius`
  RadiusDistribution distribution = RadiusDistribution::uniform;
  std::optional<double> mean{}, deviation{};
  bool overlapping = false;
  double charge = 0;  ///< of each, or what those drawn are in units of
  ChargeDistribution charge_distribution = ChargeDistribution::equal;
  std::optional<double> charge_exponent{};
  double relative_resistivity = 1;
  std::optional<double> young{}, poisson{};  ///< of its material, Pa and 1
  std::optional<double> temperature{};       ///< of grains, m0 v0^2
  double min_gap = 0;                        ///< m, to every other conductor, electrode and side of the domain
  std::optional<Region> region{};
};

/// [field] as written.
struct FieldDraft {
  std::optional<double> accuracy{};
  const FieldMethodKind* method = nullptr;  ///< null: not given
  std::optional<double> tolerance{}, moving_tolerance{}, relaxation_eta{};
  FieldOptions options{};  ///< takes what needs no second thought
};

/// A scene file as written: each value has its type and its range, but defaults that depend on other keys are still
/// open, and nothing has been compared with anything else.
struct Draft {
  Scene scene;  ///< takes what needs no second thought
  std::int64_t seed = static_cast<std::int64_t>(Scene{}.seed);
  Coordinates domain_size;
  std::optional<double> relative_permittivity, permittivity, viscosity, depth;
  std::optional<double> position_tolerance, largest_step;
  FieldDraft field;
  std::optional<std::string> output_file;
  std::vector<ElectrodeDraft> electrodes;
  std::vector<WallDraft> walls;
  std::vector<ConductorDraft> conductors;
  std::vector<GroupDraft> groups;
  std::vector<PopulationDraft> populations;
  std::map<std::string, int> lines;  ///< where a table or key stands, by path; of repeated tables the last

  std::set<std::string> known;  ///< paths of all tables and keys of the schema; empty: any path may be asked for

  /// The line of a table or key, 0 if the file does not have it. Throws std::logic_error for a path that no table or
  /// key of the schema has, unless it belongs to an effect that the schema does not have.
  int line(const std::string& path) const;
};

/// "path:line: "; line 0 is left out.
std::string place_in(const std::string& path, int line);

/// Throws the InputError "path:line: sentence"; line 0 is left out.
[[noreturn]] void refuse(const std::string& path, int line, const std::string& sentence);
/// Refuses a table or key that the file has: "[table] PREDICATE" or "table.key PREDICATE".
void refuse_if_given(const Draft& draft, const std::string& key, const std::string& predicate);

/// Puts places and velocities into the scene's two or three dimensions, which are those of the domain. Throws
/// InputError for one that has others, for an axis that is periodic on one side only, and for what knows nothing of
/// three dimensions or of periodic sides where the scene has them.
void settle_dimension(Draft& draft);

/// Draft -> Scene: compares keys with each other, fills in the defaults that depend on others and draws populations.
/// `bodies`: as in stopping.hpp. Throws InputError; Stopped where `stop` says so.
Scene complete(const Draft& draft, const StopRequest& stop, const std::vector<Conductor>& bodies);

}  // namespace lichtenberg
