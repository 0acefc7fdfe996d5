#include "src/record/recorder.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <system_error>
#include <utility>

#include "src/record/atomic_file.hpp"
#include "src/record/layout.hpp"
#include "src/record/provenance.hpp"
#include "src/record/scene_change.hpp"
#include "src/record/vtkhdf.hpp"

namespace lichtenberg {
namespace {

std::vector<Quantity> get_summary(const hdf5::Handle& file) {
  std::vector<Quantity> summary;
  if (!hdf5::exists(file, "summary")) return summary;
  const hdf5::Handle group = hdf5::open_group(file, "summary");
  for (const std::string& name : hdf5::names(group))
    summary.push_back({name, hdf5::single(hdf5::get<double>(group, name), name), ""});
  return summary;
}

/// Attribute with the number of frames at the checkpoint. A resumed run computes later frames again.
constexpr const char* frames_up_to_it = "frames";

std::int64_t frames_of_checkpoint(const ResultFile& result) {
  const std::optional<int> frames =
      hdf5::integer_attribute(hdf5::open_group(result.file(), "checkpoint"), frames_up_to_it);
  return frames ? std::min<std::int64_t>(*frames, result.frames()) : result.frames();
}

void check_scene(const hdf5::Handle& file, const std::string& path, const Scene& scene) {
  const std::string change = first_change(hdf5::get_text(file, "scene/text"), scene.text, path + ":/scene/text");
  if (!change.empty())
    throw InputError(
        fmt::format("{}: key `{}` has changed since the result file {} was started; to resume a run, only [stop], "
                    "[output], [network] and minimize.max_iterations, force_tolerance and threads may change",
                    scene.path, change, path));
}

/// Throws InputError unless the run had the same effects that are not built in.
void check_added_effects(const hdf5::Handle& file, const std::string& path, const Scene& scene) {
  const std::string before = hdf5::text(hdf5::open_group(file, "scene"), "added_effects"), now = added_effects(scene);
  if (before == now) return;
  const auto words = [](const std::string& names) { return names.empty() ? "no added effects" : names; };
  throw InputError(
      fmt::format("the run of the result file {} had {}, and the scene has {}: only a program that adds the same "
                  "effects can resume it",
                  path, words(before), words(now)));
}

/// Throws InputError unless the run started from the same state as the scene: injected charge is counted apart from
/// initial charge.
void check_start(const hdf5::Handle& file, const std::string& path, const Scene& scene) {
  const std::string start = hdf5::text(hdf5::open_group(file, "scene"), "started_from");
  if (start == scene.started_from) return;
  if (start.empty())
    throw InputError(
        fmt::format("the run of the result file {} was started without --from: resume it without --from", path));
  throw InputError(fmt::format(
      "the run of the result file {} was started from {}: resume it with the same --from and --frame", path, start));
}

/// Attribute that marks the group of Milestone::history, to which each save appends.
constexpr const char* is_history = "history";

void lengthen(Column& column, const std::vector<Column>& added) {
  const auto more = std::ranges::find(added, column.name, &Column::name);
  if (more == added.end() || more->unit != column.unit || more->values.index() != column.values.index())
    throw InputError(fmt::format("the column `{}` of the recorded history has changed its type or unit", column.name));
  std::visit(
      [&]<class Number>(std::vector<Number>& numbers) {
        const auto& rows = std::get<std::vector<Number>>(more->values);
        numbers.insert(numbers.end(), rows.begin(), rows.end());
      },
      column.values);
}

std::optional<ColumnGroup> get_history(const hdf5::Handle& file) {
  for (const std::string& name : hdf5::names(file)) {
    if (!hdf5::is_group(file, name)) continue;
    const hdf5::Handle group = hdf5::open_group(file, name);
    if (hdf5::integer_attribute(group, is_history)) return ColumnGroup{name, get_columns(group)};
  }
  return {};
}

void put_history(const hdf5::Handle& file, const std::optional<ColumnGroup>& history) {
  if (!history) return;
  const hdf5::Handle group = hdf5::open_group(file, history->name);
  hdf5::put_attribute(group, is_history, 1);
  put_columns(group, history->columns);
}

void lengthen(std::optional<ColumnGroup>& history, const ColumnGroup& added) {
  if (added.columns.empty()) return;
  if (!history) {
    history = added;
    return;
  }
  std::vector<Column> columns = history->columns;
  for (Column& column : columns) lengthen(column, added.columns);
  history->columns = std::move(columns);
}

}  // namespace

Recorder::Recorder(const std::string& path, const Scene& scene, std::size_t particles, std::uint64_t tail_bytes)
    : path_(path),
      lock_((check_writable(path), check_segments_folder(path), path)),
      stored_field_(scene.output.field),
      frames_(path, scene, particles, tail_bytes) {}

Recorder Recorder::start(const std::string& path, const Scene& scene, std::span<const double> mass, bool overwrite,
                         std::uint64_t tail_bytes) {
  Recorder recorder(path, scene, mass.size(), tail_bytes);
  if (std::filesystem::exists(path) && !overwrite)
    throw InputError(
        fmt::format("the result file {} exists: go on from it with --resume, replace it with --overwrite, or name "
                    "another file with --out",
                    path));
  remove_partial_files(path);
  recorder.put_constants([&](const hdf5::Handle& file) {
    const Provenance here = provenance();
    put_header(file, scene, here);
    put_scene(file, scene);
    put_conductors(file, scene, mass);
    put_session(file, 0, here, scene);
  });
  return recorder;
}

Recorder Recorder::resume(const std::string& path, const Scene& scene, std::uint64_t tail_bytes) {
  if (!std::filesystem::exists(path))
    throw InputError(fmt::format(
        "the result file {} does not exist: there is nothing to resume, run the scene without --resume", path));
  Recorder recorder(path, scene, scene.conductors.size(), tail_bytes);
  try {
    const ResultFile result(path, "resumed");
    if (result.format() != result_format)
      throw InputError(fmt::format(
          "the file {} has result format {}, but with this version of lichtenberg only format {} can be resumed", path,
          result.format(), result_format));
    if (!result.is_sealed())
      throw InputError(
          fmt::format("the result file {} was changed by another program, which left it without its checksum: it can "
                      "be read, but not resumed",
                      path));
    check_scene(result.file(), path, scene);
    check_added_effects(result.file(), path, scene);
    check_start(result.file(), path, scene);
    recorder.warning_ = warning_of_another_build(result.file(), path);
    recorder.resume_from(result);
    if (const auto particles = hdf5::row_count(result.file(), "particles/conductors/radius");
        particles != scene.conductors.size())
      throw hdf5::Error(fmt::format("it has {} particles, and its scene {}", particles, scene.conductors.size()));
    recorder.put_constants([&](const hdf5::Handle& file) {
      recorder.session_ = sessions(file);
      put_session(file, recorder.session_, provenance(), scene);
    });
    remove_partial_files(path);
    remove_other_segments(path, result.segments());
    return recorder;
  } catch (const hdf5::Error& error) {
    throw Failure(fmt::format("{} is damaged and cannot be resumed ({})", path, error.what()));
  } catch (const std::system_error& error) {
    throw Failure(fmt::format("{} cannot be resumed ({})", path, error.code().message()));
  }
}

template <class Put>
void Recorder::put_constants(Put put) {
  const auto pages = std::make_shared<hdf5::Pages>(std::move(constants_));
  put(pages->size() > 0 ? hdf5::open_in_memory(pages) : hdf5::create_in_memory(pages));
  constants_ = std::move(*pages);
}

void Recorder::resume_from(const ResultFile& result) {
  put_constants([&](const hdf5::Handle& file) {
    copy_all_but_frames(result.file(), file, {"h5md", "scene", "reference", "parameters", "particles", "provenance"});
  });
  checkpoint_ = get_checkpoint(result.file());
  summary_ = get_summary(result.file());
  history_ = get_history(result.file());
  frames_.resume_from(result, frames_of_checkpoint(result));
  saved_frames_ = frames_.frames();
  saved_time_ = frames_.last_time();
}

void Recorder::add(Frame frame) {
  try {
    frames_.add(std::move(frame));
  } catch (const InputError&) {
    throw;
  } catch (const std::exception& error) {
    throw write_failure(error);
  }
}

std::string Recorder::save(const Milestone& milestone) {
  try {
    frames_.link_as_first_segment();
    lengthen(history_, milestone.history);
    // The grid of the field is the same in all saves.
    if (milestone.field) put_constants([&](const hdf5::Handle& file) { put_vtkhdf_grid(file, *milestone.field); });
    const auto pages = std::make_shared<hdf5::Pages>(all_but_frames(milestone));
    frames_.write_to(hdf5::open_in_memory(pages), !milestone.summary.empty());
    write_sealed(path_, *pages);
  } catch (const InputError&) {
    throw;
  } catch (const std::exception& error) {
    throw write_failure(error);
  }
  saved_time_ = frames_.last_time();
  saved_frames_ = frames_.frames();
  frames_.remove_stale_segments();
  if (milestone.summary.empty() || frames_.in_one_file()) return "";
  try {
    frames_.merge_into_one_file(all_but_frames(milestone));
    return "";
  } catch (const std::exception& error) {
    return fmt::format("{} belongs to {} and must stay with it: they could not be merged ({})", segments_folder(path_),
                       path_, error.what());
  }
}

void Recorder::save_frames_alone() {
  if (!saved_time_ || frames_.frames() == saved_frames_) return;
  try {
    const auto pages = std::make_shared<hdf5::Pages>();
    {
      const ResultFile saved(path_, "lengthened");
      const hdf5::Handle file = hdf5::create_in_memory(pages);
      std::vector<std::string> kept = hdf5::names(saved.file());
      std::erase_if(kept, [](const std::string& name) { return name == "segments" || name == "tail"; });
      copy_all_but_frames(saved.file(), file, kept);
      frames_.put_last_lists(file);
      frames_.write_to(file, false);
    }
    write_sealed(path_, *pages);
  } catch (const std::exception& error) {
    throw write_failure(error);
  }
}

hdf5::Pages Recorder::all_but_frames(const Milestone& milestone) const {
  const auto pages = std::make_shared<hdf5::Pages>(constants_);
  {
    const hdf5::Handle file = hdf5::open_in_memory(pages);
    put_checkpoint(file, milestone.checkpoint);
    hdf5::put_attribute(hdf5::open_group(file, "checkpoint"), frames_up_to_it, frames_.frames());
    if (milestone.field) put_vtkhdf(file, *milestone.field, stored_field_);
    frames_.put_last_lists(file);
    for (const ColumnGroup& found : milestone.findings) put_columns(hdf5::open_group(file, found.name), found.columns);
    put_history(file, history_);
    const hdf5::Handle seconds = hdf5::open_group(file, session_group(session_) + "/seconds");
    for (const auto& [activity, value] : milestone.seconds) hdf5::put(seconds, activity, value, "s");
    for (const auto& [name, value, unit] : milestone.summary)
      hdf5::put(hdf5::open_group(file, "summary"), name, value, unit);
    if (!milestone.warnings.empty())
      hdf5::put_attribute(hdf5::open_group(file, "summary"), "warnings", milestone.warnings);
  }
  return std::move(*pages);
}

/// Adds a description of the result that remains on the disk to an error.
Failure Recorder::write_failure(const std::exception& error) const {
  const std::string what = dynamic_cast<const Failure*>(&error)
                               ? error.what()
                               : fmt::format("{} cannot be written ({})", path_, error.what());
  return Failure(fmt::format("{}; {}", what, remaining_result()));
}

std::string Recorder::remaining_result() const {
  if (saved_time_) {
    const std::string saved = "the state saved up to " + instant_in_words(*saved_time_, frames_.time_unit());
    std::error_code error;
    return std::filesystem::exists(path_, error) ? saved + " is intact, and --resume continues from there"
                                                 : saved + " is lost, because the file was removed during the run";
  }
  return std::filesystem::exists(path_) ? "the file to be overwritten is unchanged" : "nothing was saved";
}

}  // namespace lichtenberg
