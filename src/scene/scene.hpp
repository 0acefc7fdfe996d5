#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <memory>
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
#include "src/scene/grain_material.hpp"
#include "src/scene/mechanics_options.hpp"
#include "src/scene/signal.hpp"

namespace lichtenberg {

/// One side of the domain: insulating, an electrode, or periodic. In a circuit, an electrode side has the potential of
/// the circuit's node.
struct DomainSide {
  bool electrode = false;
  Signal potential = 0;  ///< V, without a circuit
  bool periodic = false;
  int circuit = -1;  ///< index into Scene::circuits; -1: none
  /// Resistance (ohm) before the voltage source, and charge (C), of a circuit of this side alone
  std::optional<double> series_resistance{}, charge{};
};

/// The simulated rectangle or cuboid, from the origin to `size`, and its sides.
struct Domain {
  Vec3 size;  ///< m; z = 0: two dimensions
  /// Sides in the order of side_names; a plane domain has the first four
  std::array<DomainSide, 6> sides;
  bool walled = true;  ///< packings: the sides are walls
  bool open = false;   ///< no sides: free space, where the potential tends to 0 at infinity
  /// External uniform field E (V/m) of free space, with the potential -E.r, which is 0 at the origin
  Vec3 uniform_field{};

  int dimension() const { return size.z > 0 ? 3 : 2; }

  /// Returns the lengths and boundary conditions of the domain, for the motion of bodies. In two dimensions the length
  /// along z is 0.
  Box<3> box() const {
    Box<3> box{.lengths = size};
    for (std::size_t s = 0; s < sides.size(); ++s)
      box.sides[s] = sides[s].periodic ? Boundary::periodic : sides[s].electrode ? Boundary::electrode : Boundary::wall;
    return box;
  }
};

/// A fixed conducting body at a given potential. Behind a resistor its own potential floats, and `potential` is that of
/// the voltage source. In a circuit it has the potential of the circuit's node.
struct Electrode {
  std::string name;
  Shape shape;
  Signal potential = 0;          ///< V
  double series_resistance = 0;  ///< ohm, between the voltage source and the body; 0: none
  double height = 0;             ///< m, z of a sphere's centre; the shape is the sphere's outline in the xy plane
  int circuit = -1;              ///< index into Scene::circuits; -1: none
  /// Surface of a closed curve, to which the shape points; null for other shapes
  std::shared_ptr<const ClosedCurve> curve{};

  Vec3 centre() const {  ///< centre of a sphere (m)
    const Vec2 c = std::get<Disk>(shape).centre;
    return {c.x, c.y, height};
  }
};

/// Properties of the fluid.
struct Medium {
  /// F/m, absolute: dielectric constant of the fluid times the vacuum permittivity
  double permittivity = 0;
  double viscosity = 0;  ///< Pa s
  double depth = 0;      ///< m: charge in C = depth * charge per metre of the two-dimensional field
  /// Temperature (K; 22 degrees Celsius, D 4.1), which relates dissipated power to entropy production
  double temperature = 295.15;
};

/// A fixed flat wall of a packing. Particles are on the side to which its normal points. Two-dimensional scenes leave z
/// at 0.
struct Wall {
  std::string name;
  Vec3 point{};   ///< m
  Vec3 normal{};  ///< unit vector
};

/// A body that moves unless it is fixed: a disk for the two-dimensional field, a sphere for the three-dimensional field
/// and for mechanics. Two-dimensional scenes leave z at 0. In a scene of grains all values are in reduced units.
struct Conductor {
  Vec3 position{};                  ///< m
  Vec3 velocity{};                  ///< m/s
  double radius = 0;                ///< m
  double charge = 0;                ///< C
  int group = -1;                   ///< index into Scene::groups, -1: no prescribed group
  double relative_resistivity = 1;  ///< resistivity of its material, in units of NetworkOptions::parameters
  bool fixed = false;               ///< true: fixed at its position
  Vec3 angular_velocity{};          ///< 1/t0, of a grain with friction; along z in two dimensions
  GrainMaterial material{};         ///< of a grain
  double permittivity = 0;          ///< relative, of a dielectric grain; 0: effects.induced_dipoles.polarizability
};

/// Returns the distance (m) of the conductor's centre from the wall; negative beyond the wall.
inline double distance(const Wall& wall, const Conductor& conductor) {
  return dot(conductor.position - wall.point, wall.normal);
}

/// Conductors that the scene connects by a wire ([[group]]). They have one potential, whether they touch or not. Either
/// the charge of the whole group or its potential is given, or it belongs to a circuit.
struct PrescribedGroup {
  std::string name;
  double charge = 0;                ///< C
  std::optional<Signal> potential;  ///< V
  int circuit = -1;                 ///< index into Scene::circuits; -1: none
};

/// A circuit ([[circuit]]): one node, which joins electrodes, sides and groups to one potential. The node has a charge
/// of its own. A voltage source behind a resistor or a current source feeds it, or none: then it floats.
struct Circuit {
  std::string name;
  double resistance = 0;            ///< ohm, between the voltage source and the node; 0: no voltage source
  Signal potential = 0;             ///< V, of the voltage source
  std::optional<Signal> current{};  ///< A, of the current source, from 0 V into the node
  double capacitance = 0;           ///< F, between the node and 0 V
  double charge = 0;                ///< C, of the node at the start
};

/// Material of the conductors.
struct Material {
  double density = 8050;  ///< kg/m^3 (steel, D 5.5.2)
};

/// Table [field] of a scene: options of the field solver, or a requested accuracy for which they are still to be
/// chosen.
using FieldTable = std::variant<FieldOptions, FieldRequest>;

/// Reduced units of a scene of grains (G table 5.3) in SI: the factors of the unit conversion. Numbers of such a scene
/// are in these units: lengths in d0, masses in m0, velocities in v0, charges in q0. Times are in t0 = d0 / v0,
/// energies and temperatures in m0 v0^2. Only the keys of [units] and keys with Key::Scale::si are in SI.
struct Reference {
  double length = 4.78e-3;  ///< d0, m: diameter of a grain
  double mass = 1.52e-4;    ///< m0, kg: mass of a grain
  double velocity = 1;      ///< v0, m/s
  double charge = 2e-8;     ///< q0, C

  bool operator==(const Reference&) const = default;
};

/// Names of the units of length, mass and time of a scene.
struct UnitNames {
  std::string length = "m", mass = "kg", time = "s";
};

/// A stage of equilibration of a run of grains, with modified settings. The stages follow each other from the start of
/// the run. After the last stage, the scene's own parameters apply.
struct Stage {
  double duration = 0;   ///< t0
  bool elastic = true;   ///< contacts dissipate no energy and move no charge, and no Effect::drive acts
  double stiffness = 1;  ///< factor of contact stiffness; the restitution stays the same
  /// Temperature (m0 v0^2) at the end of the stage, set by scaling all velocities
  std::optional<double> temperature{};
};

enum class MinimizeMethod { lbfgs_newton, lbfgs, newton_cg, fire, gradient_descent };
template <>
inline constexpr Named<MinimizeMethod> values_named<MinimizeMethod>[] = {
    {MinimizeMethod::lbfgs_newton, "lbfgs-newton"},
    {MinimizeMethod::lbfgs, "lbfgs"},
    {MinimizeMethod::newton_cg, "newton-cg"},
    {MinimizeMethod::fire, "fire"},
    {MinimizeMethod::gradient_descent, "gradient-descent"}};

/// Options of the energy minimization of a packing. Forces are in units of stiffness / R, where R is the mean diameter.
struct MinimizeOptions {
  MinimizeMethod method = MinimizeMethod::lbfgs_newton;
  double force_tolerance = 1e-8;  ///< largest net force on a particle
  std::int64_t max_iterations = 10'000'000;
  double step = 2.5e-3;           ///< gradient-descent: step in units of R^2 / stiffness
  std::int64_t record_every = 0;  ///< iterations between two frames; 0: increasing intervals
  int threads = 0;                ///< 0: one for each core, fewer for few particles
};

/// Options of [compression]: loads of a packing, one frame each. The domain's size changes in small steps, each
/// followed by a minimization. At most one of the three lists has elements.
struct CompressionOptions {
  std::vector<double> pressure;  ///< pressure of each load (N/m, in space Pa)
  std::vector<double> filling;   ///< packing fraction of each load
  /// Packing fraction of each load above that at jamming. The first load is the jammed packing itself.
  std::vector<double> excess;
  std::string plate{};      ///< upper side that alone moves: right, top or back; empty: all sides move
  double step = 1e-3;       ///< largest change of the packing fraction between two minimizations
  double tolerance = 1e-3;  ///< relative error of a given pressure

  /// Returns the number of loads; 0 without the table.
  std::size_t loads() const { return pressure.size() + filling.size() + (excess.empty() ? 0 : 1 + excess.size()); }
};

/// Precision in which a result stores the last frame's potential.
enum class StoredField { single_precision, double_precision, none };
template <>
inline constexpr Named<StoredField> values_named<StoredField>[] = {
    {StoredField::single_precision, "single"}, {StoredField::double_precision, "double"}, {StoredField::none, "none"}};

/// Options of [output]: result file, frames and checkpoints.
struct OutputOptions {
  std::string file;           ///< result file; default: the scene's name with .h5
  double every = 0.1;         ///< s, between frames
  int checkpoint_every = 10;  ///< frames between checkpoints
  StoredField field = StoredField::single_precision;
  bool picture = true;
};

/// Kinds of resistor networks of a packing: nodes are particles, or contacts.
enum class NetworkModel { particle, contact };
template <>
inline constexpr Named<NetworkModel> values_named<NetworkModel>[] = {{NetworkModel::particle, "particle"},
                                                                     {NetworkModel::contact, "contact"}};

/// Options of [network] for `lichtenberg network`, which measures a packing's contacts as resistors; a run does not use
/// them. network::resistor_models() lists the parameters of each model.
struct NetworkOptions {
  std::optional<NetworkModel> model;  ///< empty: both, sequentially
  /// Name in network::resistor_models; empty: constant, of 1 Ohm by default
  std::optional<std::string> resistor;
  network::Parameters parameters;
  std::string between = "bottom,top";  ///< electrodes: names of walls or numbers of particles
};

/// Options of [stop]: when a run of conductors or grains ends.
struct StopOptions {
  double time = 120;       ///< s
  bool stationary = true;  ///< stop when all conductors are connected to ground and at rest (D 7.1)
  /// Largest force allowed in a stationary state, as a fraction of the largest force of the run
  double force = 1e-3;
};

/// A checked and complete scene: defaults are filled in, and populations are placed. Field options may still have to be
/// chosen for a requested accuracy (field_request). Units are SI or those of `reference`.
struct Scene {
  std::string path;                   ///< the file it was read from
  std::string text;                   ///< text of that file, with the settings of the command line (provenance)
  std::vector<std::string> warnings;  ///< former names of keys and tables in the file
  std::string title;
  /// random seed: selects the random positions, velocities, charges, charge transfers and gas velocities of a run
  std::uint64_t seed = 1;
  Domain domain;
  Medium medium;
  Material material;
  std::vector<Electrode> electrodes;
  /// Walls of a scene with a contact potential: the domain's sides first, if they are walls
  std::vector<Wall> walls;
  std::vector<Conductor> conductors;
  std::vector<PrescribedGroup> groups;
  std::vector<Circuit> circuits;
  /// Frame of a result from which the bodies start; empty: positions are those of the file
  std::string started_from;
  std::optional<Reference> reference;  ///< units of a scene of grains; other scenes are in SI
  /// Numbers of the CUDA devices of a gas or of a field, from `--device`; -1: all; none: the first
  std::vector<int> cuda_devices;
  bool in_si = false;  ///< scene of grains whose file is in SI; the program chose `reference`
  std::vector<Stage> stages;
  Effects effects;  ///< effects that have a table in the scene
  FieldTable field_table;
  MechanicsOptions mechanics;
  MinimizeOptions minimize;
  CompressionOptions compression;
  NetworkOptions network;
  OutputOptions output;
  StopOptions stop;

  /// Returns the names of the scene's units: reduced for grains, otherwise SI.
  UnitNames units() const { return reference ? UnitNames{"d0", "m0", "t0"} : UnitNames{}; }
  int dimension() const { return domain.dimension(); }
  /// Returns the smallest radius (m, or d0 of grains) of the conductors; infinite if there are none.
  double smallest_radius() const {
    double smallest = std::numeric_limits<double>::infinity();
    for (const Conductor& conductor : conductors) smallest = std::min(smallest, conductor.radius);
    return smallest;
  }
  /// Returns the options of the field solver. Throws InputError while only an accuracy is requested.
  const FieldOptions& field() const {
    if (field_request())
      throw InputError(
          "the field method for field.accuracy is not chosen yet: with_field_chosen(scene) must be called first");
    return std::get<FieldOptions>(field_table);
  }
  FieldOptions& field() { return const_cast<FieldOptions&>(std::as_const(*this).field()); }
  /// Returns the accuracy for which the options of the field solver were chosen. Null if the scene specifies the
  /// options, or if nothing is chosen yet.
  const FieldAccuracy* field_accuracy() const {
    const FieldOptions* options = std::get_if<FieldOptions>(&field_table);
    return options && options->chosen_for ? &*options->chosen_for : nullptr;
  }
  /// Returns the requested accuracy of the field; null once the options of the field solver are chosen.
  const FieldRequest* field_request() const { return std::get_if<FieldRequest>(&field_table); }
};

/// A key of a scene and its value, both as text of a scene file.
struct Setting {
  /// Dotted path; an element of a repeated table has an index from 0, as in electrode[1].radius
  std::string key;
  std::string value;
};

/// Reads and checks a scene file with effects of these kinds. `settings`: keys that are set as if they were in the
/// file; `Scene::text` then contains them. Throws InputError for an invalid scene; the message names the file and
/// describes the fault. src/effects/read_scene.hpp reads scenes with the effects of this program.
Scene read_scene(const std::string& path, const EffectKinds& kinds, const std::vector<Setting>& settings = {});

/// Reads and checks a scene from text in memory; `path` is used in messages.
Scene parse_scene(const std::string& text, const std::string& path, const EffectKinds& kinds,
                  const std::vector<Setting>& settings = {});

/// Returns the help of every key, as `lichtenberg help scene` prints it: type, unit, default, allowed values and
/// meaning. A non-empty `part` (the path of a table or key, or the name of an effect) restricts it to this part. Throws
/// InputError for an unknown part.
std::string scene_help(const EffectKinds& kinds, const std::string& part = "");

}  // namespace lichtenberg
