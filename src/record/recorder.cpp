#include "src/record/recorder.hpp"

#include <fmt/format.h>

#include <filesystem>
#include <utility>

#include "solvers/error.hpp"
#include "src/effects/floating_conductors.hpp"
#include "src/record/atomic_file.hpp"
#include "src/record/layout.hpp"
#include "src/record/result.hpp"
#include "src/record/scene_change.hpp"
#include "src/record/vtkhdf.hpp"
#include "src/version.hpp"

namespace lichtenberg {
namespace {

void check_scene(const hdf5::Handle& file, const std::string& path, const Scene& scene) {
  const std::string change = first_change(hdf5::get_text(file, "scene/text"), scene.text);
  if (!change.empty())
    throw InputError(
        fmt::format("{}: key `{}` is not what it was when {} was started; to resume a run, only [stop], "
                    "[output], [network] and minimize.max_iterations, force_tolerance and threads may change",
                    scene.path, change, path));
}

std::string session_group(int session) { return fmt::format("provenance/session-{}", session); }

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

/// What the scene left open may have been chosen by the program, or on the command line.
void put_field_options(const hdf5::Handle& group, const FieldOptions& field) {
  hdf5::put_attribute(group, "method", field.method);
  hdf5::put_attribute(group, "cells", field.cells);
  hdf5::put_attribute(group, "tolerance", field.moving_tolerance);
  hdf5::put_attribute(group, "device", field.device);
  if (field.accuracy) hdf5::put_attribute(group, "accuracy", *field.accuracy);
  if (field.estimate) hdf5::put_attribute(group, "estimated_error", *field.estimate);
}

/// What was found of fewer frames is not true of these.
void remove_analysis(const hdf5::Handle& file) {
  for (const char* found : {"analysis", "packing", "network/particle", "network/contact"})
    if (hdf5::exists(file, found)) hdf5::check(H5Ldelete(file, found, H5P_DEFAULT));
}

std::vector<Quantity> get_summary(const hdf5::Handle& file) {
  const hdf5::Handle group(H5Gopen2(file, "summary", H5P_DEFAULT));
  std::vector<Quantity> summary;
  for (const std::string& name : hdf5::names(group))
    summary.push_back({name, hdf5::get<double>(group, name).at(0), ""});
  return summary;
}

/// Only a run that is over has one: that of a run which was resumed with a later stop goes.
void put_summary(const hdf5::Handle& file, const std::vector<Quantity>& summary) {
  if (hdf5::exists(file, "summary")) hdf5::check(H5Ldelete(file, "summary", H5P_DEFAULT));
  for (const auto& [name, value, unit] : summary) hdf5::put(hdf5::open_group(file, "summary"), name, value, unit);
}

}  // namespace

Recorder::Recorder(std::string path, const Scene& scene, std::vector<double> mass)
    : path_(std::move(path)), scene_(scene), mass_(std::move(mass)) {}

Recorder Recorder::start(const std::string& path, const Scene& scene, std::span<const double> mass, bool overwrite) {
  check_writable(path);
  if (std::filesystem::exists(path) && !overwrite)
    throw InputError(
        fmt::format("{} exists: go on from it with --resume, replace it with --overwrite, or name another "
                    "file with --out",
                    path));
  return Recorder(path, scene, {mass.begin(), mass.end()});
}

Recorder Recorder::resume(const std::string& path, const Scene& scene) {
  if (!std::filesystem::exists(path))
    throw InputError(
        fmt::format("{} does not exist: there is nothing to resume, run the scene without --resume", path));
  check_writable(path);
  try {
    const hdf5::Handle file = load_result(path, "resumed");
    check_scene(file, path, scene);
    Recorder recorder(path, scene, {});
    recorder.checkpoint_ = get_checkpoint(file);
    const std::vector<double> times = frame_times(file);
    recorder.saved_time_ = times.back();
    if (hdf5::exists(file, "summary")) recorder.summary_ = get_summary(file);
    recorder.saved_frames_ = static_cast<std::int64_t>(times.size());
    while (hdf5::exists(file, session_group(recorder.session_))) ++recorder.session_;
    return recorder;
  } catch (const hdf5::Error& error) {
    throw Failure(fmt::format("{} is damaged and cannot be resumed ({})", path, error.what()));
  }
}

void Recorder::add(Frame frame) { waiting_.push_back(std::move(frame)); }

void Recorder::save(const Milestone& milestone) {
  try {
    const hdf5::Handle file = saved_frames_ > 0 ? hdf5::load(path_) : new_file();
    put_frames(file);
    remove_analysis(file);
    put_checkpoint(file, milestone.checkpoint);
    if (milestone.field) put_vtkhdf(file, *milestone.field);
    if (!milestone.history.columns.empty()) append_history(file, milestone.history);
    for (const ColumnGroup& group : milestone.findings) put_group(file, group);
    put_session(file, milestone.seconds);
    put_summary(file, milestone.summary);
    write_atomically(path_, hdf5::image(file));
  } catch (const hdf5::Error& error) {
    throw Failure(fmt::format("{} cannot be written ({}); {}", path_, error.what(), what_stands()));
  } catch (const Failure& failure) {
    throw Failure(fmt::format("{}; {}", failure.what(), what_stands()));
  }
  saved_frames_ = frames();
  if (!waiting_.empty()) saved_time_ = waiting_.back().time;
  waiting_.clear();
}

hdf5::Handle Recorder::new_file() const {
  hdf5::Handle file = hdf5::create_in_memory();
  put_header(file, provenance_);
  put_scene(file, scene_);
  put_conductors(file, scene_, mass_);
  return file;
}

void Recorder::put_frames(const hdf5::Handle& file) const {
  for (const Frame& frame : waiting_) append_frame(file, frame);
}

void Recorder::put_session(const hdf5::Handle& file, const std::map<std::string, double>& seconds) const {
  const std::string path = session_group(session_);
  if (!hdf5::exists(file, path)) {
    put_program(hdf5::open_group(file, path), provenance_);
    if (scene_.effects.has<effects::FloatingConductorsOptions>())
      put_field_options(hdf5::open_group(file, path + "/field"), scene_.field);
  }
  const hdf5::Handle group = hdf5::open_group(file, path + "/seconds");
  for (const auto& [activity, value] : seconds) hdf5::put(group, activity, value, "s");
}

std::string Recorder::what_stands() const {
  if (saved_time_)
    return fmt::format("what was saved up to t = {:.6g} s stands, and --resume goes on from there", *saved_time_);
  return std::filesystem::exists(path_) ? "the file that was to be overwritten stands" : "nothing was saved";
}

}  // namespace lichtenberg
