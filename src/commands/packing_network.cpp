#include "src/commands/packing_network.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <thread>

#include "solvers/disjoint_sets.hpp"
#include "solvers/error.hpp"
#include "solvers/network/resistor.hpp"
#include "src/effects/read_scene.hpp"
#include "src/effects/soft_repulsion.hpp"
#include "src/record/hdf5.hpp"
#include "src/scene/effect_kind.hpp"
#include "src/scene/loads.hpp"

namespace lichtenberg {
namespace {

constexpr const char* positions = "particles/conductors/position/value";

std::vector<network::Point> points(const std::vector<double>& numbers) {
  std::vector<network::Point> result(numbers.size() / 3);
  for (std::size_t i = 0; i < result.size(); ++i)
    std::copy_n(numbers.begin() + static_cast<std::ptrdiff_t>(3 * i), 3, result[i].begin());
  return result;
}

/// Returns the walls of the file, or the sides of its domain.
std::vector<network::PackingWall> read_walls(const hdf5::Handle& file) {
  if (!hdf5::exists(file, "scene/walls")) {
    const std::vector<double> size = hdf5::get<double>(file, "scene/domain/size");
    if (size.size() < 2) throw hdf5::Error("scene/domain/size must have two lengths");
    std::vector<network::PackingWall> sides = {{"left", {}, {1, 0, 0}},
                                               {"right", {size[0], 0, 0}, {-1, 0, 0}},
                                               {"bottom", {}, {0, 1, 0}},
                                               {"top", {0, size[1], 0}, {0, -1, 0}}};
    if (!hdf5::exists(file, "scene/domain/height")) return sides;
    const double height = hdf5::single(hdf5::get<double>(file, "scene/domain/height"), "scene/domain/height");
    sides.push_back({"front", {}, {0, 0, 1}});
    sides.push_back({"back", {0, 0, height}, {0, 0, -1}});
    return sides;
  }
  const hdf5::Handle group = hdf5::open_group(file, "scene/walls");
  const std::vector<std::string> names = hdf5::text_attribute(group, "names");
  const auto point = points(hdf5::get<double>(group, "point")), normal = points(hdf5::get<double>(group, "normal"));
  if (point.size() != names.size() || normal.size() != names.size())
    throw hdf5::Error("scene/walls must have one point and one normal for each name");
  std::vector<network::PackingWall> walls;
  for (std::size_t k = 0; k < names.size(); ++k) walls.push_back({names[k], point[k], normal[k]});
  return walls;
}

/// Returns as many threads as the machine has processors, for frames that are worth it.
std::unique_ptr<parallel::Team> team_for(const network::ParticlePacking& packing) {
  constexpr int few = 5000;
  return std::make_unique<parallel::Team>(
      packing.size() < few ? 1 : std::max(1, static_cast<int>(std::thread::hardware_concurrency())));
}

network::ParticlePacking read_frame(const ResultFile& result, int frame) {
  network::ParticlePacking packing;
  packing.position = points(result.rows<double>(positions, frame, 1));
  packing.radius = radii_in(result.file());
  packing.walls = read_walls(result.file());
  return packing;
}

constexpr const char* size_of_load = "observables/size_x/value";

/// Returns the size (m) of the domain in a frame of a packing with loads.
Vec3 size_in(const ResultFile& result, int frame) {
  Vec3 size;
  for (int k = 0; k < 3; ++k)
    if (const std::string axis = fmt::format("observables/size_{}/value", "xyz"[k]); result.has(axis))
      size[k] = hdf5::single(result.rows<double>(axis, frame, 1), axis);
  return size;
}

/// Replaces walls by those at their present positions in a packing, and adds its periodic axes and its forces of
/// contacts.
void complete_packing(PackingFrame& frame) {
  frame.packing.walls.clear();
  for (const Wall& wall : frame.scene.walls)
    frame.packing.walls.push_back(
        {wall.name, {wall.point.x, wall.point.y, wall.point.z}, {wall.normal.x, wall.normal.y, wall.normal.z}});
  frame.packing.box = frame.scene.domain.box();
  const effects::SoftRepulsion potential(frame.scene);
  frame.packing.force = [potential](double distance, double reach) {
    return -potential.stiffness() * potential.contact(distance / reach).slope / reach;
  };
}

/// Calls `read` (network::read_electrodes or read_electrode) on the text of --between. Throws InputError.
template <class Read>
auto electrodes_by(const Read& read, const PackingFrame& frame, const std::string& between) {
  std::vector<std::string> walls;
  for (const network::PackingWall& wall : frame.packing.walls) walls.push_back(wall.name);
  try {
    return read(between, walls, frame.packing.size());
  } catch (const InputError& error) {
    throw InputError(fmt::format("--terminals is not valid: {}", error.what()));
  }
}

std::vector<network::PackingElectrode> electrodes_of(const PackingFrame& frame, const std::string& between) {
  return electrodes_by(network::read_electrodes, frame, between);
}

/// Sets a resistance of 1 Ohm if neither a resistor nor a resistance is given. Returns true if it did.
bool assume_resistance(NetworkOptions& options) {
  if (options.resistor || options.parameters.resistance) return false;
  options.parameters.resistance = 1;
  return true;
}

/// Returns the resistor model of the options. Throws InputError as network::check.
const network::ResistorModel& checked_resistor(const NetworkOptions& options) {
  const network::ResistorModel& resistor = network::resistor_model(options.resistor.value_or("constant"));
  network::check(resistor, options.parameters);
  return resistor;
}

network::PackingNetwork build(const PackingFrame& frame, NetworkModel model, const NetworkOptions& options,
                              const std::vector<network::PackingElectrode>& electrodes) {
  const network::ResistorModel& resistor = checked_resistor(options);
  return model == NetworkModel::particle
             ? particle_network(frame.packing, frame.contacts, resistor, options.parameters, electrodes,
                                *team_for(frame.packing))
             : contact_network(frame.packing, frame.contacts, resistor, options.parameters, electrodes);
}

/// Solves the contact-centred network, with one network per particle as second electrode.
std::vector<double> resistances_between_contacts(const PackingFrame& frame, const NetworkOptions& options,
                                                 const network::PackingElectrode& from,
                                                 const std::function<void(int)>& count) {
  constexpr int most = 20'000;  // takes about an hour
  if (frame.packing.size() > most)
    throw InputError(
        fmt::format("--terminals {},all needs one elimination per particle in the contact-centred network, for {} "
                    "particles, and at most {} are allowed: --model particle needs a single one",
                    options.between, frame.packing.size(), most));
  std::vector<double> resistance;
  for (int i = 0; i < frame.packing.size(); ++i) {
    if (count) count(i);
    const std::vector<network::PackingElectrode> ends{from, {.wall = false, .index = i}};
    if (ends[0] == ends[1]) {
      resistance.push_back(0);
    } else if (!network::contact_network_obstacle(frame.packing, frame.contacts, ends).empty()) {
      resistance.push_back(NAN);
    } else {
      const network::PackingNetwork built = build(frame, NetworkModel::contact, options, ends);
      resistance.push_back(1 / network::conductance_between(built.network, built.electrode[0], built.electrode[1]));
    }
  }
  return resistance;
}

/// Returns for each particle whether a path of contacts joins it to one of the electrodes.
std::vector<char> joined(const PackingFrame& frame, const std::vector<network::PackingElectrode>& electrodes) {
  const int particles = frame.packing.size();
  DisjointSets sets(particles + static_cast<int>(frame.packing.walls.size()));
  for (const auto [i, j] : frame.contacts.pairs) sets.unite(i, j);
  std::vector<int> ends;
  for (const network::PackingElectrode& electrode : electrodes) {
    ends.push_back(electrode.wall ? particles + electrode.index : electrode.index);
    for (const auto [i, wall] : frame.contacts.walls)
      if (electrode.wall && wall == electrode.index) sets.unite(i, ends.back());
  }
  std::vector<char> result(particles);
  for (int i = 0; i < particles; ++i)
    result[i] = std::ranges::any_of(ends, [&](int end) { return sets.find(end) == sets.find(i); });
  return result;
}

void sort_particles(const PackingFrame& frame, const std::vector<network::PackingElectrode>& electrodes,
                    SolvedNetwork& solved) {
  std::vector<char> carries(frame.packing.size(), 0);
  for (std::size_t k = 0; k < solved.network.network.links.size(); ++k) {
    if (!solved.conduction.backbone[k]) continue;
    carries[solved.network.first_particle[k]] = 1;
    if (const int second = solved.network.second_particle[k]; second >= 0) carries[second] = 1;
  }
  // An electrode particle has no links in the contact-centred network, because its contacts form one node.
  for (const network::PackingElectrode& electrode : electrodes)
    if (!electrode.wall && solved.conduction.connected) carries[electrode.index] = 1;
  const std::vector<char> has_path = joined(frame, electrodes);
  for (int i = 0; i < frame.packing.size(); ++i)
    (carries[i] ? solved.backbone : has_path[i] ? solved.dead_ends : solved.isolated).push_back(i);
}

void put_network(const hdf5::Handle& file, const PackingFrame& frame, const SolvedNetwork& solved) {
  const std::string path = "network/" + name_of(solved.model);
  if (hdf5::exists(file, path)) hdf5::check(H5Ldelete(file, path.c_str(), H5P_DEFAULT));
  const hdf5::Handle group = hdf5::open_group(file, path);
  const auto& [network, electrode, first, second] = solved.network;
  std::vector<double> position, conductance;
  std::vector<std::int32_t> ends, particles,
      backbone(solved.conduction.backbone.begin(), solved.conduction.backbone.end());
  for (const network::Point& p : network.position) position.insert(position.end(), p.begin(), p.end());
  for (const network::Link& link : network.links) {
    ends.insert(ends.end(), {link.a, link.b});
    conductance.push_back(link.conductance);
  }
  for (std::size_t k = 0; k < first.size(); ++k) particles.insert(particles.end(), {first[k], second[k]});
  const std::size_t links = network.links.size(), nodes = network.nodes;
  hdf5::put_attribute(group, "resistor", solved.options.resistor.value_or("constant"));
  hdf5::put_attribute(group, "between", solved.options.between);
  hdf5::put_attribute(group, "assumed", solved.assumed ? 1 : 0);
  hdf5::put_attribute(group, "frame", frame.frame);
  for (const network::ParameterEntry& entry : network::parameter_entries())
    if (const auto& value = solved.options.parameters.*entry.value) hdf5::put(group, entry.name, *value, entry.unit);
  hdf5::put<double>(group, "position", position, {nodes, 3}, "m");
  hdf5::put<double>(group, "potential", solved.conduction.potential, {nodes}, "V");
  hdf5::put<std::int32_t>(group, "electrode", electrode, {electrode.size()}, "1");
  hdf5::put<std::int32_t>(group, "links", ends, {links, 2}, "1");
  hdf5::put<std::int32_t>(group, "link_particles", particles, {links, 2}, "1");
  hdf5::put<std::int32_t>(group, "link_in_backbone", backbone, {links}, "1");
  hdf5::put<double>(group, "conductance", conductance, {links}, "S");
  hdf5::put<double>(group, "current", solved.conduction.link_current, {links}, "A");
  hdf5::put(group, "effective_resistance", solved.conduction.resistance, "Ohm");
  hdf5::put(group, "total_current", solved.conduction.current, "A");
  hdf5::put(group, "power", solved.conduction.power, "W");
  for (const auto& [name, list] : {std::pair{"backbone", &solved.backbone}, std::pair{"dead_ends", &solved.dead_ends},
                                   std::pair{"isolated", &solved.isolated}})
    hdf5::put<std::int32_t>(group, name, *list, {list->size()}, "1");
}

/// Returns the warnings of the run. For an earlier frame of a packing, the warning states that this frame is not at
/// rest.
std::vector<std::string> warnings_of(const PackingFrame& frame) {
  const bool is_packing = frame.scene.effects.has(&EffectKind::packing);
  const bool is_last = frame.frame == frame.file->frames() - 1, is_over = hdf5::exists(frame.file->file(), "summary");
  if (frame.scene.compression.loads() > 0 && frame.frame > 0)
    return is_over ? frame.file->warnings() : std::vector<std::string>{};
  if (!is_packing || (is_last && is_over)) return frame.file->warnings();
  return {fmt::format("not at rest: {}, so that forces do not balance yet and contacts change",
                      is_last ? "the run has not come to its end" : "the frame is not the run's last")};
}

}  // namespace

PackingFrame read_packing(const std::string& path, std::optional<int> frame) {
  try {
    const auto file = std::make_shared<const ResultFile>(path, "measured");
    if (!file->has(positions) || file->frames() == 0)
      throw InputError(fmt::format("the result file {} holds no frames: nothing can be measured", path));
    const int frames = static_cast<int>(file->frames());
    if (frame && (*frame < 0 || *frame >= frames))
      throw InputError(
          fmt::format("frame {} is not in the result file {}: it has frames 0 to {}", *frame, path, frames - 1));
    PackingFrame result{.file = file, .frame = frame.value_or(frames - 1)};
    result.scene = parse_scene(hdf5::get_text(file->file(), "scene/text"), path);
    const bool is_packing = result.scene.effects.has(&EffectKind::packing);
    if (!is_packing && result.scene.domain.box().any_periodic())
      throw InputError(fmt::format(
          "the result file {} has a periodic side, and contacts across it are not searched: only a packing, "
          "or a scene without one, can be measured",
          path));
    if (file->has(size_of_load)) result.scene = resized(std::move(result.scene), size_in(*file, result.frame));
    result.packing = read_frame(*file, result.frame);
    if (is_packing) complete_packing(result);
    if (std::ranges::any_of(result.scene.conductors, [](const Conductor& c) { return c.relative_resistivity != 1; }))
      for (const Conductor& conductor : result.scene.conductors)
        result.packing.resistivity.push_back(conductor.relative_resistivity);
    result.scene.conductors = {};
    network::check(result.packing);
    result.contacts = network::find_contacts(result.packing, *team_for(result.packing));
    result.warnings = warnings_of(result);
    return result;
  } catch (const hdf5::Error& error) {
    throw InputError(fmt::format("the result file {} is damaged and cannot be measured ({})", path, error.what()));
  }
}

std::vector<Load> read_loads(const std::string& path) {
  try {
    const ResultFile file(path, "measured");
    if (!file.has(size_of_load) || file.frames() < 2)
      throw InputError(fmt::format(
          "--loads is not allowed for {}: it has no loads; only a run with the table [compression] has", path));
    const auto fraction = file.rows<double>("observables/packing_fraction/value"),
               pressure = file.rows<double>("observables/pressure/value");
    if (fraction.size() != pressure.size()) throw hdf5::Error("each load must have one packing fraction and pressure");
    std::vector<Load> loads;
    for (std::size_t k = 1; k < fraction.size(); ++k) loads.push_back({static_cast<int>(k), fraction[k], pressure[k]});
    return loads;
  } catch (const hdf5::Error& error) {
    throw InputError(fmt::format("the result file {} is damaged and cannot be measured ({})", path, error.what()));
  }
}

SolvedNetwork solve_network(const PackingFrame& frame, NetworkModel model, const NetworkOptions& requested,
                            double voltage) {
  SolvedNetwork solved{.model = model, .options = requested};
  solved.assumed = assume_resistance(solved.options);
  checked_resistor(solved.options);
  const auto electrodes = electrodes_of(frame, requested.between);
  solved.network = build(frame, model, solved.options, electrodes);
  solved.conduction = network::conduct(solved.network.network, solved.network.electrode[0], solved.network.electrode[1],
                                       {.voltage = voltage, .team = team_for(frame.packing).get()});
  sort_particles(frame, electrodes, solved);
  return solved;
}

std::string contact_network_obstacle(const PackingFrame& frame, const NetworkOptions& options) {
  return network::contact_network_obstacle(frame.packing, frame.contacts, electrodes_of(frame, options.between));
}

ResistancesToAll resistances_to_all(const PackingFrame& frame, NetworkModel model, const NetworkOptions& requested,
                                    const std::function<void(int)>& count) {
  ResistancesToAll result{.model = model, .options = requested};
  result.assumed = assume_resistance(result.options);
  checked_resistor(result.options);
  const network::PackingElectrode from = electrodes_by(network::read_electrode, frame, requested.between);
  if (model == NetworkModel::contact) {
    result.resistance = resistances_between_contacts(frame, result.options, from, count);
    return result;
  }
  const network::PackingNetwork built = build(frame, model, result.options, {from});
  result.resistance = network::resistances_from(built.network, built.electrode[0]);
  result.resistance.resize(static_cast<std::size_t>(frame.packing.size()));  // drops the wall if the electrode is one
  return result;
}

void save_networks(const std::string& path, const PackingFrame& frame, const std::vector<SolvedNetwork>& networks,
                   bool no_contact_network) {
  try {
    store(*frame.file, [&](const hdf5::Handle& file) {
      const std::string contact = "network/" + name_of(NetworkModel::contact);
      if (no_contact_network && hdf5::exists(file, contact)) hdf5::check(H5Ldelete(file, contact.c_str(), H5P_DEFAULT));
      for (const SolvedNetwork& solved : networks) put_network(file, frame, solved);
    });
  } catch (const hdf5::Error& error) {
    throw Failure(fmt::format("{} cannot be written ({}); it was left alone", path, error.what()));
  } catch (const Failure& failure) {
    throw Failure(fmt::format("{}; it was left alone", failure.what()));
  }
}

}  // namespace lichtenberg
