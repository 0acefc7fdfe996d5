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

/// Interval [smallest, largest] from which a population draws the radius of each of its conductors.
struct Interval {
  double smallest = 0, largest = 0;
};

/// A point or a vector of two or three components (`count`); a missing component is 0.
struct Coordinates {
  Vec3 value{};
  int count = 2;
};

/// A rectangle or a cuboid between two corners with the same number of components. In three dimensions, a rectangle
/// extends over the whole domain along z (from front to back).
struct Region {
  Coordinates lower{}, upper{};

  int axes() const { return lower.count; }  ///< number of axes along which the region is bounded
};

/// An [[electrode]] of a scene file as written, with the keys of every shape. The reader has checked that the keys
/// belong to its shape.
struct ElectrodeDraft {
  int line = 0;
  std::string shape{};
  std::optional<std::string> name{};
  std::optional<Signal> potential{};
  std::optional<double> series_resistance{}, charge{};
  Vec2 centre{}, from{}, to{};
  Coordinates position{};  ///< centre of a sphere
  std::string side{};
  double at = 0, radius = 0, width = 0, wire_radius = 0;
  int circuit = -1;            ///< index into Scene::circuits, set by connect_circuits()
  std::vector<Vec2> points{};  ///< of a polygon or curve
  Vec2 semi_axes{};
  double angle = 0;  ///< degrees
  double corner_radius = 0;
  bool hollow = false;
};

/// A [[conductor]] of a scene file as written: a body with a given position.
struct ConductorDraft {
  int line = 0;
  Conductor conductor{};
  Coordinates position{};
  std::optional<Coordinates> velocity{};
  std::optional<double> charge{};
  std::optional<std::string> group{};
  std::optional<double> young{}, poisson{};  ///< Young's modulus (Pa) and Poisson's ratio of the material
  std::optional<Coordinates> angular_velocity{};
};

/// A [[group]] of a scene file as written: conductors connected by a wire.
struct GroupDraft {
  int line = 0;
  std::string name{};
  std::optional<double> charge{};
  std::optional<Signal> potential{};
  int circuit = -1;  ///< index into Scene::circuits, set by connect_circuits()
};

/// A [[circuit]] of a scene file as written: electrodes, sides and groups at one potential, and their sources.
struct CircuitDraft {
  int line = 0;
  std::optional<std::string> name{};
  std::vector<std::string> electrodes{};  ///< names of electrodes, sides and groups
  std::optional<double> resistance{}, capacitance{}, charge{};
  std::optional<Signal> potential{}, current{};
};

/// A [[wall]] of a scene file as written: a flat wall of a packing.
struct WallDraft {
  int line = 0;
  std::optional<std::string> name{};
  Coordinates point{}, normal{};
};

/// Distribution of radii, truncated to their interval.
enum class RadiusDistribution { uniform, normal, lognormal };
template <>
inline constexpr Named<RadiusDistribution> values_named<RadiusDistribution>[] = {
    {RadiusDistribution::uniform, "uniform"},
    {RadiusDistribution::normal, "normal"},
    {RadiusDistribution::lognormal, "lognormal"}};

/// Distribution of charges in a population: equal, or random about 0 (charge_distribution.hpp).
enum class ChargeDistribution { equal, gaussian, exponential_power };
template <>
inline constexpr Named<ChargeDistribution> values_named<ChargeDistribution>[] = {
    {ChargeDistribution::equal, "equal"},
    {ChargeDistribution::gaussian, "gaussian"},
    {ChargeDistribution::exponential_power, "exponential-power"}};

/// A [[population]] of a scene file as written: `count` conductors at random positions entirely inside `region`.
/// Without a region they are in the domain, along periodic axes with their centres.
struct PopulationDraft {
  int line = 0;
  int count = 0;
  std::optional<Interval> radius{};
  std::vector<double> radii{};  ///< m, used in cyclic order instead of `radius`
  RadiusDistribution distribution = RadiusDistribution::uniform;
  std::optional<double> mean{}, deviation{};
  bool overlapping = false;
  double charge = 0;  ///< charge of each conductor, or the unit of random charges
  ChargeDistribution charge_distribution = ChargeDistribution::equal;
  std::optional<double> charge_exponent{};
  double relative_resistivity = 1;
  std::optional<double> young{}, poisson{};  ///< Young's modulus (Pa) and Poisson's ratio of the material
  std::optional<double> temperature{};       ///< m0 v0^2, granular temperature of the initial velocities
  double min_gap = 0;                        ///< m, to every other conductor, electrode and side of the domain
  std::optional<Region> region{};
  /// Disk or vertical cylinder [x, y, radius], or sphere [x, y, z, radius] (m) that also contains the conductors;
  /// empty: none
  std::vector<double> round_region{};
  std::optional<double> rotational_temperature{};  ///< m0 v0^2, of the initial angular velocities
  double permittivity = 0;                         ///< relative; 0: effects.induced_dipoles.polarizability
  std::optional<double> velocity_spread{};         ///< v0, rms of each velocity component, instead of `temperature`
  GrainMaterial material{};
};

/// The table [field] of a scene file as written.
struct FieldDraft {
  std::optional<double> accuracy{};
  const FieldMethodKind* method = nullptr;  ///< null: not given
  std::optional<double> tolerance{}, moving_tolerance{}, relaxation_eta{};
  FieldOptions options{};  ///< values that need no further processing
};

/// A scene file as written. Each value has its type and its range. Defaults that depend on other keys are still
/// missing. Keys have not been compared with each other, except those of an electrode with its shape.
struct Draft {
  Scene scene;  ///< values that need no further processing
  std::int64_t seed = static_cast<std::int64_t>(Scene{}.seed);
  Coordinates domain_size;
  std::optional<Coordinates> uniform_field;
  std::optional<double> relative_permittivity, permittivity, viscosity, depth;
  std::optional<double> position_tolerance, largest_step;
  FieldDraft field;
  std::optional<std::string> output_file;
  std::vector<ElectrodeDraft> electrodes;
  std::vector<WallDraft> walls;
  std::vector<ConductorDraft> conductors;
  std::vector<GroupDraft> groups;
  std::vector<CircuitDraft> circuits;
  std::vector<PopulationDraft> populations;
  std::map<std::string, int> lines;  ///< line of each table or key, by path; the last line for repeated tables

  std::set<std::string> known;  ///< paths of all tables and keys of the schema; empty: line() accepts any path

  /// Returns the line of a table or key in the file, 0 if the file does not have it. For a key set on the command line
  /// it is the largest int. If `known` is filled, throws std::logic_error for a path outside the schema, unless it
  /// belongs to an effect that the schema lacks.
  int line(const std::string& path) const;
};

/// Returns "path:line: " for an error message; without the line if it is 0 or marks the command line
/// (Draft::line).
std::string location_prefix(const std::string& path, int line);

/// Throws InputError with location_prefix(path, line), that is "path:line: " or "path: ", followed by `message`.
[[noreturn]] void refuse(const std::string& path, int line, const std::string& message);
/// Throws InputError if the file has this table or key: "[table] PREDICATE" or "table.key PREDICATE".
void refuse_if_given(const Draft& draft, const std::string& key, const std::string& predicate);

/// Checks that positions and velocities have the dimension of the domain, 2 or 3, and stores them in the scene. Throws
/// InputError for a vector of another dimension and for an axis that is periodic on one side only. Throws InputError
/// for effects and keys of the scene that do not support three dimensions, periodic sides or free space.
void set_dimension(Draft& draft);

/// Converts a Draft to a Scene: compares keys with each other, fills in dependent defaults and draws random positions
/// for populations. `bodies`: bodies of a result from which the scene starts instead (stopping.hpp). Throws InputError,
/// and Stopped if `stop` returns true.
Scene complete(const Draft& draft, const StopRequest& stop, const std::vector<Conductor>& bodies);

}  // namespace lichtenberg
