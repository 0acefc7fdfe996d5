#pragma once

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "src/effects/contact_discharge.hpp"
#include "src/record/recorder.hpp"
#include "tests/folder.hpp"
#include "tests/frames.hpp"
#include "tests/message.hpp"

/// Result of a run of two conductors with given frames.
namespace lichtenberg::recorded_pair {

namespace fs = std::filesystem;

inline Scene two_conductors() {
  Scene scene;
  scene.path = "pair.toml";
  scene.title = "a pair";
  scene.text = "title = \"a pair\"\n[stop]\ntime = 1.0\n";
  scene.seed = 18446744073709551615u;  // The largest value.
  scene.domain.size = {0.05, 0.04};
  scene.domain.sides[2] = {true, -3.0};
  scene.medium = {4e-11, 0.7, 1.5e-3};
  scene.electrodes.push_back({"needle", Disk{{0.02, 0}, 0.001}, 5});
  scene.electrodes.push_back({"rod", Bar{{0, 0}, {0.01, 0}, 0.002}, 6});
  scene.electrodes.push_back({"dish", Ring{{0.025, 0.02}, 0.02}, 7});
  scene.conductors.push_back({.position = {0.01, 0.02}, .radius = 0.001});
  scene.conductors.push_back({.position = {0.03, 0.02}, .radius = 0.0005});
  scene.effects.add(effects::ContactDischargeOptions{0.00075, 0.01});
  return scene;
}

inline const std::vector<double> masses{3e-5, 4e-6};

inline ConductorFrame frame(double time) {
  ConductorFrame f;
  f.time = time;
  f.position = {{0.01 + time, 0.02}, {0.03, 0.02 - time}};
  f.velocity = {{1, 2}, {3, 4}};
  f.force = {{5e-6, 0}, {0, 6e-6}};
  f.charge = {1e-10, 2e-10};
  f.potential = {10 + time, 20};
  f.group = {0, 1};
  f.energy = 1e-6 * time;
  f.charge_held = 3e-10;
  f.charge_fed = 4e-10;
  f.charge_drained = 1e-10;
  f.field_solves = 7;
  f.iterations = 70;
  return f;
}

inline analysis::ContactNetwork network_of_two() {
  analysis::ContactNetwork net;
  net.contacts = {{0, analysis::to_ground}, {0, 1}};
  net.successor = {analysis::to_ground, 0};
  net.degrees.connected = 2;
  net.degrees.number = {0, 1, 1};
  return net;
}

inline Frame columns(const ConductorFrame& f) { return columns_of(f, network_of_two()); }

inline Milestone milestone(double mark) {
  Milestone m;
  m.checkpoint.reals["mark"] = {mark};
  m.seconds["field"] = 0.5;
  return m;
}

/// Run of frames 0, 1, ..., n - 1 (s), saved once.
inline Recorder saved_run(const std::string& path, int n) {
  Recorder recorder = Recorder::start(path, two_conductors(), masses, false);
  for (int k = 0; k < n; ++k) recorder.add(columns(frame(k)));
  recorder.save(milestone(n - 1));
  return recorder;
}

inline std::vector<char> bytes_of(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

inline void write_bytes(const std::string& path, const std::vector<char>& bytes) {
  std::ofstream(path, std::ios::binary).write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
}

}  // namespace lichtenberg::recorded_pair
