#include "src/record/provenance.hpp"

#include <fmt/chrono.h>
#include <pwd.h>
#include <sys/utsname.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <iterator>
#include <thread>

#include "src/field_methods/field_method.hpp"
#include "src/scene/effect_kind.hpp"
#include "src/version.hpp"

namespace lichtenberg {
namespace {

std::string user_name() {
  const passwd* entry = getpwuid(geteuid());
  return entry != nullptr ? entry->pw_name : "unknown";
}

/// Returns the words of the command line, separated by spaces.
std::string command_line() {
  std::ifstream file("/proc/self/cmdline", std::ios::binary);
  std::string words{std::istreambuf_iterator<char>(file), {}};
  if (!words.empty()) words.pop_back();  // the last word's terminating zero
  std::replace(words.begin(), words.end(), '\0', ' ');
  return words;
}

std::string machine() {
  utsname name{};
  if (uname(&name) != 0) return "unknown";
  return fmt::format("{}, {} {} {}", name.nodename, name.sysname, name.release, name.machine);
}

std::string processor() {
  std::ifstream file("/proc/cpuinfo");
  for (std::string line; std::getline(file, line);)
    if (line.starts_with("model name")) return line.substr(std::min(line.find(':') + 2, line.size()));
  return "unknown";
}

void put_program(const hdf5::Handle& group, const Provenance& provenance) {
  const Version version = lichtenberg_version();
  hdf5::put_attribute(group, "version", version.number);
  hdf5::put_attribute(group, "commit", version.commit);
  hdf5::put_attribute(group, "compiler", version.compiler);
  hdf5::put_attribute(group, "compiler_flags", version.flags);
  hdf5::put_attribute(group, "command_line", provenance.command_line);
  hdf5::put_attribute(group, "petsc_options", provenance.petsc_options);
  hdf5::put_attribute(group, "started", provenance.started);
  hdf5::put_attribute(group, "machine", provenance.machine);
  hdf5::put_attribute(group, "processor", provenance.processor);
  hdf5::put_attribute(group, "cores", provenance.cores);
}

/// Writes the field options, which the program or the command line may have chosen instead of the scene.
void put_field_options(const hdf5::Handle& group, const FieldOptions& field) {
  hdf5::put_attribute(group, "method", field.method->name);
  hdf5::put_attribute(group, "cells", field.cells);
  hdf5::put_attribute(group, "tolerance", field.moving_tolerance);
  hdf5::put_attribute(group, "device", name_of(field.device));
  if (!field.chosen_for) return;
  hdf5::put_attribute(group, "accuracy", field.chosen_for->requested);
  hdf5::put_attribute(group, "estimated_error", field.chosen_for->estimate);
}

}  // namespace

Provenance provenance() {
  Provenance here;
  here.user = user_name();
  here.command_line = command_line();
  if (const char* options = std::getenv("PETSC_OPTIONS")) here.petsc_options = options;
  here.started = fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(std::time(nullptr)));
  here.machine = machine();
  here.processor = processor();
  here.cores = static_cast<int>(std::thread::hardware_concurrency());
  return here;
}

std::string session_group(int session) { return fmt::format("provenance/session-{}", session); }

int sessions(const hdf5::Handle& file) {
  int count = 0;
  while (hdf5::exists(file, session_group(count))) ++count;
  return count;
}

void put_session(const hdf5::Handle& file, int session, const Provenance& provenance, const Scene& scene) {
  put_program(hdf5::open_group(file, session_group(session)), provenance);
  if (scene.effects.has(&EffectKind::field))
    put_field_options(hdf5::open_group(file, session_group(session) + "/field"), scene.field());
}

std::string warning_of_another_build(const hdf5::Handle& file, const std::string& path) {
  const hdf5::Handle last = hdf5::open_group(file, session_group(sessions(file) - 1));
  const std::string number = hdf5::text(last, "version"), commit = hdf5::text(last, "commit");
  const Version here = lichtenberg_version();
  if (number == here.number && commit == here.commit) return "";
  return fmt::format(
      "{} was last continued by lichtenberg {} ({}), not {} ({}): defaults of keys that the scene omits may differ, so "
      "that the run may continue differently",
      path, number, commit, here.number, here.commit);
}

}  // namespace lichtenberg
