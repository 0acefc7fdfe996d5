#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "solvers/error.hpp"
#include "solvers/geometry/box.hpp"
#include "solvers/geometry/shape.hpp"
#include "solvers/geometry/vec.hpp"
#include "solvers/network/parameters.hpp"
#include "src/field_methods/field_options.hpp"
#include "src/scene/choice.hpp"
#include "src/scene/effects.hpp"
#include "src/scene/mechanics_options.hpp"

namespace lichtenberg {

/// One side of the domain: insulating, an electrode at a potential, or periodic.
struct DomainSide {
  bool electrode = false;
  double potential = 0;  ///< V
  bool periodic = false;
};

struct Domain {
  Vec3 size;                        ///< m; z = 0: it has two dimensions
  std::array<DomainSide, 6> sides;  ///< as in side_names; a plane domain has the first four
  bool walled = true;               ///< of a packing: the sides are walls
  bool open = false;                ///< there are no sides: free space, whose potential tends to 0 far away

  int dimension() const { return size.z > 0 ? 3 : 2; }

  /// The domain for who moves bodies in it; without a length along z in two dimensions.
  Box<3> box() const {
    Box<3> box{.lengths = size};
    for (std::size_t s = 0; s < sides.size(); ++s)
      box.sides[s] = sides[s].periodic ? Boundary::periodic : sides[s].electrode ? Boundary::electrode : Boundary::wall;
    return box;
  }
};

/// A fixed body at a given potential, or behind a resistor: its potential then floats, and `potential` is the supply's.
struct Electrode {
  std::string name;
  Shape shape;
  double potential = 0;          ///< V
  double series_resistance = 0;  ///< ohm, between the supply and the body; 0: none
  double height = 0;             ///< m, z of a sphere's centre, whose shape is the disk that one sees from the front

  Vec3 centre() const {  ///< of a sphere
    const Vec2 c = std::get<Disk>(shape).centre;
    return {c.x, c.y, height};
  }
};

struct Medium {
  double permittivity = 0;      ///< F/m, absolute
  double viscosity = 0;         ///< Pa s
  double depth = 0;             ///< m: charge in C = depth * charge per metre of the two-dimensional field
  double temperature = 295.15;  ///< K (22 degrees Celsius, D 4.1): turns dissipated power into entropy production
};

/// A flat wall that does not move: particles are where its normal points. Two-dimensional scenes leave z at 0.
struct Wall {
  std::string name;
  Vec3 point{};   ///< m
  Vec3 normal{};  ///< of length 1
};

/// A mobile disk (field) or sphere (mechanics). Two-dimensional scenes leave z at 0.
struct Conductor {
  Vec3 position{};                  ///< m
  Vec3 velocity{};                  ///< m/s
  double radius = 0;                ///< m
  double charge = 0;                ///< C
  int group = -1;                   ///< index into Scene::groups, -1: of its own
  double relative_resistivity = 1;  ///< of its material, in units of NetworkOptions::parameters
  bool held = false;                ///< at its place, whatever pulls
};

/// m, of the conductor's centre from the wall; negative beyond it.
inline double distance(const Wall& wall, const Conductor& conductor) {
  return dot(conductor.position - wall.point, wall.normal);
}

/// Conductors wired together by the scene: one potential, whether they touch or not. Either the charge of the whole
/// group or its potential is given.
struct PrescribedGroup {
  std::string name;
  double charge = 0;                ///< C
  std::optional<double> potential;  ///< V
};

struct Material {
  double density = 8050;  ///< kg/m^3 (steel, D 5.5.2)
};

/// [field] of a scene.
using FieldTable = std::variant<FieldOptions, FieldRequest>;

/// The scales of a scene of grains (G table 5.3), in SI. All its numbers are in units of them: lengths in d0, masses in
/// m0, velocities in v0, charges in q0, times in t0 = d0 / v0, energies and temperatures in m0 v0^2.
struct Reference {
  double length = 4.78e-3;  ///< d0, m: the diameter of a grain
  double mass = 1.52e-4;    ///< m0, kg: its mass
  double velocity = 1;      ///< v0, m/s
  double charge = 2e-8;     ///< q0, C
};

/// What units are called.
struct UnitNames {
  std::string length = "m", mass = "kg", time = "s";
};

/// A part of a run of grains, from the end of the one before. After the last all is as the scene says.
struct Stage {
  double duration = 0;                  ///< t0
  bool elastic = true;                  ///< contacts lose nothing and move no charge, and no gas acts
  double stiffness = 1;                 ///< by what contacts are stiffer, with the same restitution
  std::optional<double> temperature{};  ///< m0 v0^2, set at its end by one factor for all velocities
};

enum class MinimizeMethod { lbfgs_newton, lbfgs, newton_cg, fire, gradient_descent };
template <>
inline constexpr Named<MinimizeMethod> values_named<MinimizeMethod>[] = {
    {MinimizeMethod::lbfgs_newton, "lbfgs-newton"},
    {MinimizeMethod::lbfgs, "lbfgs"},
    {MinimizeMethod::newton_cg, "newton-cg"},
    {MinimizeMethod::fire, "fire"},
    {MinimizeMethod::gradient_descent, "gradient-descent"}};

/// How particles under a contact potential come to rest. Forces are in units of stiffness / R, R the mean diameter.
struct MinimizeOptions {
  MinimizeMethod method = MinimizeMethod::lbfgs_newton;
  double force_tolerance = 1e-8;  ///< the largest net force on a particle
  std::int64_t max_iterations = 10'000'000;
  double step = 2.5e-3;           ///< of gradient-descent, in units of R^2 / stiffness
  std::int64_t record_every = 0;  ///< iterations between two frames; 0: ever longer ones
  int threads = 0;                ///< 0: one a core, fewer for few particles
};

/// What a result keeps of the last frame's potential.
enum class StoredField { single_precision, double_precision, none };
template <>
inline constexpr Named<StoredField> values_named<StoredField>[] = {
    {StoredField::single_precision, "single"}, {StoredField::double_precision, "double"}, {StoredField::none, "none"}};

struct OutputOptions {
  std::string file;           ///< result file; default: the scene's name with .h5
  double every = 0.1;         ///< s, between frames
  int checkpoint_every = 10;  ///< frames between checkpoints
  StoredField field = StoredField::single_precision;
  bool picture = true;
};

/// What a node of the network is.
enum class NetworkModel { particle, contact };
template <>
inline constexpr Named<NetworkModel> values_named<NetworkModel>[] = {{NetworkModel::particle, "particle"},
                                                                     {NetworkModel::contact, "contact"}};

/// The resistors of `lichtenberg network`; a run does not read them. Which model needs which parameter:
/// solvers/network/resistor.hpp.
struct NetworkOptions {
  std::optional<NetworkModel> model;    ///< empty: both, one after the other
  std::optional<std::string> resistor;  ///< of network::resistor_models; empty: constant, of 1 Ohm if nothing is said
  network::Parameters parameters;
  std::string between = "bottom,top";  ///< electrodes: names of walls or numbers of particles
};

struct StopOptions {
  double time = 120;       ///< s
  bool stationary = true;  ///< stop when all are connected to ground and at rest (D 7.1)
  double force = 1e-3;     ///< stationary: largest force allowed, as a fraction of the largest of the run
};

/// A scene file, checked and complete: every default filled in, populations drawn. SI throughout.
struct Scene {
  std::string path;  ///< the file it was read from
  std::string text;  ///< that file, verbatim (provenance)
  std::string title;
  std::uint64_t seed = 1;
  Domain domain;
  Medium medium;
  Material material;
  std::vector<Electrode> electrodes;
  std::vector<Wall> walls;  ///< of a scene with a contact potential: the domain's sides first, if they are walls
  std::vector<Conductor> conductors;
  std::vector<PrescribedGroup> groups;
  std::string started_from;  ///< frame of a result that the bodies were put to; empty: places are those of the file
  std::optional<Reference> reference;  ///< of a scene of grains; others are in SI
  std::vector<Stage> stages;
  Effects effects;  ///< one is in a run only if its table stands in the scene
  FieldTable field_table;
  MechanicsOptions mechanics;
  MinimizeOptions minimize;
  NetworkOptions network;
  OutputOptions output;
  StopOptions stop;

  UnitNames units() const { return reference ? UnitNames{"d0", "m0", "t0"} : UnitNames{}; }
  int dimension() const { return domain.dimension(); }
  /// Of the conductors; infinite if there are none.
  double smallest_radius() const {
    double smallest = std::numeric_limits<double>::infinity();
    for (const Conductor& conductor : conductors) smallest = std::min(smallest, conductor.radius);
    return smallest;
  }
  /// Throws InputError while it is only asked for.
  const FieldOptions& field() const {
    if (field_request())
      throw InputError("nothing has been chosen for field.accuracy yet: with_field_chosen() comes first");
    return std::get<FieldOptions>(field_table);
  }
  FieldOptions& field() { return const_cast<FieldOptions&>(std::as_const(*this).field()); }
  /// What the field was chosen for; null if the scene says how it is computed, or nothing is chosen yet.
  const FieldAccuracy* field_accuracy() const {
    const FieldOptions* options = std::get_if<FieldOptions>(&field_table);
    return options && options->chosen_for ? &*options->chosen_for : nullptr;
  }
  /// Null once nothing is left to be chosen.
  const FieldRequest* field_request() const { return std::get_if<FieldRequest>(&field_table); }
};

/// A key of a scene and a value for it, both as text: the value as a scene file has it.
struct Setting {
  std::string key;  ///< dotted; an element of a repeated table by its index from 0, as in electrode[1].radius
  std::string value;
};

/// Reads and checks a scene, whose effects are of these kinds. Throws InputError (one sentence: file, line, key, value
/// found, what is allowed). src/effects/read_scene.hpp reads scenes with the effects of this program.
/// `settings`: keys that are set as if the file had them so; then `Scene::text` is the file's with them.
Scene read_scene(const std::string& path, const EffectKinds& kinds, const std::vector<Setting>& settings = {});

/// Reads and checks a scene from text already in memory; `path` is used in messages.
Scene parse_scene(const std::string& text, const std::string& path, const EffectKinds& kinds,
                  const std::vector<Setting>& settings = {});

/// Every key with its type, unit, default, what is allowed and what it means, as printed by `lichtenberg help scene`;
/// of a `part` that is not empty (a table's or a key's path, an effect's name) that alone. Throws InputError if there
/// is none of that name.
std::string scene_help(const EffectKinds& kinds, const std::string& part = "");

}  // namespace lichtenberg
