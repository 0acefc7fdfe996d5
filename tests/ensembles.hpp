#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "src/record/hdf5.hpp"
#include "tests/program.hpp"

/// Scenes with runs of milliseconds, and queries of their ensembles.
namespace lichtenberg::ensembles {

/// Scene of three conductors that fall through the fluid without a field.
inline const std::string neutral_scene = R"(
seed = 3
[domain]
size = [20e-3, 20e-3]
[medium]
viscosity = 0.7
[[conductor]]
position = [5e-3, 1e-3]
velocity = [0.0, 0.0]
radius = 0.775e-3
[[population]]
count = 2
radius = 0.775e-3
region = [[0, 5e-3], [20e-3, 20e-3]]
[effects.stokes_drag]
[output]
every = 0.01
checkpoint_every = 1
[stop]
time = 0.1
)";

/// Scene of conductors charged by a current source, and one electrode: 20 frames with a checkpoint at every fourth.
inline const std::string charged_scene = R"(
seed = 3
[domain]
size = [8e-3, 8e-3]
[medium]
relative_permittivity = 4.7
viscosity = 0.7
[[electrode]]
shape = "half-disk"
side = "bottom"
at = 4e-3
radius = 1e-3
potential = 0.0
[[population]]
count = 6
radius = 0.6e-3
min_gap = 0.1e-3
[effects.floating_conductors]
[effects.current_injection]
current = 0.2e-9
[effects.stokes_drag]
[effects.hertz_contact]
[effects.wall_contact]
[effects.contact_discharge]
[field]
cells = 32
[output]
every = 0.01
checkpoint_every = 4
[stop]
time = 0.2
stationary = false
)";

/// Folder with both scenes.
struct ScenesFolder : Folder {
  ScenesFolder() {
    write("neutral.toml", neutral_scene);
    write("charged.toml", charged_scene);
  }
};

inline Ended ensemble(const Folder& folder, const std::string& arguments) {
  return run_program(folder, "ensemble " + arguments);
}

inline nlohmann::json summary(const Folder& folder, const std::string& name) {
  return nlohmann::json::parse(text_of(folder / name / "ensemble.json"));
}

inline std::vector<std::string> states(const nlohmann::json& summary) {
  std::vector<std::string> all;
  for (const nlohmann::json& member : summary["members"]) all.push_back(member["state"]);
  return all;
}

/// Time (s) of the last frame in a result file.
inline double last_time(const std::filesystem::path& result) {
  return hdf5::get<double>(hdf5::load(result.string()), "particles/conductors/position/time").back();
}

/// Number of times that a run was started or resumed.
inline int sessions(const std::filesystem::path& result) {
  const hdf5::Handle file = hdf5::load(result.string());
  return static_cast<int>(hdf5::names(hdf5::open_group(file, "provenance")).size());
}

}  // namespace lichtenberg::ensembles
