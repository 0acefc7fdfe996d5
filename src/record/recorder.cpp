#include "src/record/recorder.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sys/statvfs.h>

#include <algorithm>
#include <filesystem>
#include <system_error>
#include <utility>

#include "solvers/error.hpp"
#include "src/field_methods/field_method.hpp"
#include "src/record/atomic_file.hpp"
#include "src/record/layout.hpp"
#include "src/record/provenance.hpp"
#include "src/record/scene_change.hpp"
#include "src/record/vtkhdf.hpp"
#include "src/scene/effect_kind.hpp"
#include "src/version.hpp"

namespace lichtenberg {
namespace {

std::vector<Quantity> get_summary(const hdf5::Handle& file) {
  std::vector<Quantity> summary;
  if (!hdf5::exists(file, "summary")) return summary;
  const hdf5::Handle group = hdf5::open_group(file, "summary");
  for (const std::string& name : hdf5::names(group))
    summary.push_back({name, hdf5::get<double>(group, name).at(0), ""});
  return summary;
}

/// How many frames there were at the checkpoint; those after it are made anew when the run goes on.
constexpr const char* frames_up_to_it = "frames";

std::int64_t frames_of_checkpoint(const ResultFile& result) {
  const std::optional<int> frames =
      hdf5::integer_attribute(hdf5::open_group(result.file(), "checkpoint"), frames_up_to_it);
  return frames ? std::min<std::int64_t>(*frames, result.frames()) : result.frames();
}

/// Marks a group that grows from save to save.
constexpr const char* is_history = "history";

void check_scene(const hdf5::Handle& file, const std::string& path, const Scene& scene) {
  const std::string change = first_change(hdf5::get_text(file, "scene/text"), scene.text);
  if (!change.empty())
    throw InputError(
        fmt::format("{}: key `{}` is not what it was when {} was started; to resume a run, only [stop], "
                    "[output], [network] and minimize.max_iterations, force_tolerance and threads may change",
                    scene.path, change, path));
}

/// What was fed and what had been there from the start are told apart by where the run began.
void check_start(const hdf5::Handle& file, const std::string& path, const Scene& scene) {
  const std::string start = hdf5::text(hdf5::open_group(file, "scene"), "started_from");
  if (start != scene.started_from)
    throw InputError(fmt::format("{} was started {}: resume it {}", path,
                                 start.empty() ? "where its scene says" : "from " + start,
                                 start.empty() ? "without --from" : "with the same --from and --frame"));
}

std::string session_group(int session) { return fmt::format("provenance/session-{}", session); }

int sessions(const hdf5::Handle& file) {
  int count = 0;
  while (hdf5::exists(file, session_group(count))) ++count;
  return count;
}

/// Empty if the last session was of this build.
std::string warning_of_another_build(const hdf5::Handle& file, const std::string& path) {
  const hdf5::Handle last = hdf5::open_group(file, session_group(sessions(file) - 1));
  const std::string number = hdf5::text(last, "version"), commit = hdf5::text(last, "commit");
  const Version here = lichtenberg_version();
  if (number == here.number && commit == here.commit) return "";
  return fmt::format(
      "{} was last carried on by lichtenberg {} ({}), not {} ({}): what the scene leaves open may have another default "
      "here, so the run may go on in another way than it would have there",
      path, number, commit, here.number, here.commit);
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

/// What the scene left open may have been chosen by the program, or on the command line.
void put_field_options(const hdf5::Handle& group, const FieldOptions& field) {
  hdf5::put_attribute(group, "method", field.method->name);
  hdf5::put_attribute(group, "cells", field.cells);
  hdf5::put_attribute(group, "tolerance", field.moving_tolerance);
  hdf5::put_attribute(group, "device", name_of(field.device));
  if (!field.chosen_for) return;
  hdf5::put_attribute(group, "accuracy", field.chosen_for->asked);
  hdf5::put_attribute(group, "estimated_error", field.chosen_for->estimate);
}

void put_session(const hdf5::Handle& file, int session, const Provenance& provenance, const Scene& scene) {
  put_program(hdf5::open_group(file, session_group(session)), provenance);
  if (scene.effects.has(&EffectKind::field))
    put_field_options(hdf5::open_group(file, session_group(session) + "/field"), scene.field());
}

std::optional<ColumnGroup> history_in(const hdf5::Handle& file) {
  for (const std::string& name : hdf5::names(file)) {
    if (!hdf5::is_group(file, name)) continue;
    const hdf5::Handle group = hdf5::open_group(file, name);
    if (hdf5::integer_attribute(group, is_history)) return ColumnGroup{name, get_columns(group)};
  }
  return {};
}

void lengthen(Column& column, const std::vector<Column>& added) {
  const auto more = std::ranges::find(added, column.name, &Column::name);
  if (more == added.end() || more->unit != column.unit || more->values.index() != column.values.index())
    throw InputError(fmt::format("column `{}` of a history is not what it was before", column.name));
  std::visit(
      [&]<class Number>(std::vector<Number>& numbers) {
        const auto& rows = std::get<std::vector<Number>>(more->values);
        numbers.insert(numbers.end(), rows.begin(), rows.end());
      },
      column.values);
}

std::vector<Column> lists_of(const Rows& rows, const std::vector<Series>& series) {
  std::vector<Column> lists;
  for (std::size_t k = 0; k < series.size(); ++k)
    if (series[k].of == Column::Of::list)
      lists.push_back({.name = series[k].name,
                       .unit = series[k].unit,
                       .of = Column::Of::list,
                       .width = series[k].row.empty() ? 0 : static_cast<std::size_t>(series[k].row[0]),
                       .values = rows[k]});
  return lists;
}

/// What is free on the disk of a path; all there is if it does not say.
std::uint64_t free_bytes(const std::string& path) {
  struct statvfs disk {};
  if (statvfs(folder_of(path).c_str(), &disk) != 0) return UINT64_MAX;
  return static_cast<std::uint64_t>(disk.f_bavail) * disk.f_frsize;
}

std::uint64_t bytes_in(const hdf5::Handle& file, const std::string& prefix, const std::vector<Series>& all) {
  std::uint64_t bytes = 0;
  for (const Series& series : all) bytes += hdf5::shape(file, prefix + series.dataset).at(0) * series.row_bytes();
  return bytes;
}

/// Rows `first` to `first + count` of values that hold many.
Values part_of(const Values& values, const Series& series, std::int64_t first, std::int64_t count) {
  return std::visit(
      [&]<class Number>(const std::vector<Number>& numbers) -> Values {
        const auto width = static_cast<std::int64_t>(series.row_bytes() / sizeof(Number));
        return std::vector<Number>(numbers.begin() + first * width, numbers.begin() + (first + count) * width);
      },
      values);
}

}  // namespace

Recorder::Recorder(const std::string& path, std::uint64_t tail_bytes)
    : path_(path), lock_((check_writable(path), check_segments_folder(path), path)), tail_limit_(tail_bytes) {}

Recorder Recorder::start(const std::string& path, const Scene& scene, std::span<const double> mass, bool overwrite,
                         std::uint64_t tail_bytes) {
  Recorder recorder(path, tail_bytes);
  if (std::filesystem::exists(path) && !overwrite)
    throw InputError(
        fmt::format("{} exists: go on from it with --resume, replace it with --overwrite, or name another "
                    "file with --out",
                    path));
  remove_partial_files(path);
  recorder.particles_ = mass.size();
  recorder.length_unit_ = scene.units().length;
  recorder.box_edges_ = box_edges(scene);
  recorder.stored_field_ = scene.output.field;
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
    throw InputError(
        fmt::format("{} does not exist: there is nothing to resume, run the scene without --resume", path));
  Recorder recorder(path, tail_bytes);
  try {
    const ResultFile result(path, "resumed");
    if (result.format() != result_format)
      throw InputError(
          fmt::format("{} has result format {}, but with this version of lichtenberg only format {} can be resumed",
                      path, result.format(), result_format));
    if (!result.is_sealed())
      throw InputError(
          fmt::format("{} was changed by another program, which left it without its checksum: it can be read, but not "
                      "resumed",
                      path));
    check_scene(result.file(), path, scene);
    check_start(result.file(), path, scene);
    recorder.is_resumed_ = true;
    recorder.warning_ = warning_of_another_build(result.file(), path);
    recorder.take_over(result);
    if (recorder.particles_ != scene.conductors.size())
      throw hdf5::Error(
          fmt::format("it has {} particles, and its scene {}", recorder.particles_, scene.conductors.size()));
    recorder.box_edges_ = box_edges(scene);
    recorder.stored_field_ = scene.output.field;
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

void Recorder::take_over(const ResultFile& result) {
  put_constants([&](const hdf5::Handle& file) {
    copy_all_but_frames(result.file(), file, {"h5md", "scene", "reference", "parameters", "particles", "provenance"});
  });
  particles_ = hdf5::shape(result.file(), "particles/conductors/radius").at(0);
  checkpoint_ = get_checkpoint(result.file());
  summary_ = get_summary(result.file());
  history_ = history_in(result.file());
  series_ = series_in(result.file());
  frames_ = saved_frames_ = frames_of_checkpoint(result);
  last_time_ = result.rows<double>(series_[1].dataset, frames_ - 1, 1).at(0);
  saved_time_ = last_time_;
  const std::int64_t before = take_over_segments(result);
  take_over_last_lists(result, before == frames_);
  if (before == frames_) return;
  // The rest of them stands before those that are made anew, or in the file itself.
  if (outdated_segments_) return take_over_tail(hdf5::open(result.segment(segments_.size())), "", frames_ - before);
  whole_file_ = segments_.empty() && bytes_in(result.file(), "", series_) > tail_limit_;
  if (!whole_file_) take_over_tail(result.file(), segments_.empty() ? "" : "tail/", frames_ - before);
}

/// Those that hold no frame after the checkpoint; how many frames they hold. The index names the others until it is
/// written anew.
std::int64_t Recorder::take_over_segments(const ResultFile& result) {
  std::int64_t frames = 0;
  for (const Segment& segment : result.segments()) {
    outdated_segments_ = frames + segment.frames > frames_;
    if (outdated_segments_) break;
    frames += segment.frames;
    segments_.push_back(segment);
    segments_.back().rows = rows_in(hdf5::open(result.segment(segments_.size() - 1)), series_);
  }
  return frames;
}

/// Of the last frame up to the checkpoint, which may be the last of a segment; else they stand in the file by
/// themselves, unless there are later frames: then they are taken from those that wait again.
void Recorder::take_over_last_lists(const ResultFile& result, bool ends_segment) {
  for (std::size_t k = 0; k < series_.size(); ++k) {
    const Series& series = series_[k];
    if (series.of != Column::Of::list) continue;
    const std::string ends = fmt::format("network/{}_end", series.name), last = "network/" + series.name;
    const auto end_of = [&](std::int64_t frame) {
      return frame < 0 ? 0 : result.rows<std::int64_t>(ends, frame, 1).at(0);
    };
    const std::int64_t end = end_of(frames_ - 1);
    const hsize_t rows = ends_segment ? segments_.back().rows[k] : hdf5::shape(result.file(), last).at(0);
    const hsize_t count = ends_segment ? static_cast<hsize_t>(end - end_of(frames_ - 2)) : rows;
    if (count > rows) throw hdf5::Error(series.name + " of a frame end before they begin");
    ends_[series.name] = end;
    last_lists_.push_back({.name = series.name,
                           .unit = series.unit,
                           .of = Column::Of::list,
                           .width = series.row.empty() ? 0 : static_cast<std::size_t>(series.row[0]),
                           .values = ends_segment ? read_rows(hdf5::open(result.segment(segments_.size() - 1)),
                                                              series.dataset, series, rows - count, count)
                                                  : read_rows(result.file(), last, series, 0, rows)});
  }
}

/// The first frames of a file, which wait here again.
void Recorder::take_over_tail(const hdf5::Handle& file, const std::string& prefix, std::int64_t frames) {
  tail_.assign(static_cast<std::size_t>(frames), Rows(series_.size()));
  for (std::size_t k = 0; k < series_.size(); ++k) {
    const Series& series = series_[k];
    const bool is_list = series.of == Column::Of::list;
    const std::string dataset = prefix + series.dataset;
    const Values all = read_rows(file, dataset, series, 0, hdf5::shape(file, dataset).at(0));
    const auto ends = is_list ? hdf5::get<std::int64_t>(file, fmt::format("{}network/{}_end", prefix, series.name))
                              : std::vector<std::int64_t>{};
    const std::int64_t rows = is_list ? static_cast<std::int64_t>(rows_in(all, series)) : 0;
    std::int64_t first = 0;
    for (std::size_t f = 0; f < tail_.size(); ++f) {
      const std::int64_t end = is_list ? ends.at(f) - (ends.back() - rows) : static_cast<std::int64_t>(f + 1);
      if (end < first || (is_list && end > rows)) throw hdf5::Error(series.name + " of a frame end before they begin");
      tail_[f][k] = part_of(all, series, first, end - first);
      first = end;
    }
  }
  for (const Rows& rows : tail_) tail_bytes_ += bytes_of(rows);
  last_lists_ = lists_of(tail_.back(), series_);
}

std::string Recorder::warning_of_columns() const {
  if (left_out_.empty()) return "";
  return fmt::format("{} was begun without {}, which it therefore does not record: a new run does", path_,
                     fmt::join(left_out_, ", "));
}

void Recorder::save_frames_alone() {
  if (!saved_time_ || frames_ == saved_frames_) return;
  try {
    const auto pages = std::make_shared<hdf5::Pages>();
    {
      const ResultFile saved(path_, "lengthened");
      const hdf5::Handle file = hdf5::create_in_memory(pages);
      std::vector<std::string> kept = hdf5::names(saved.file());
      std::erase_if(kept, [](const std::string& name) { return name == "segments" || name == "tail"; });
      copy_all_but_frames(saved.file(), file, kept);
      if (!last_lists_.empty()) put_columns(hdf5::open_group(file, "network"), last_lists_);
      put_frames_into(file, false);
    }
    write_sealed(path_, *pages);
  } catch (const std::exception& error) {
    throw Failure(fmt::format("{} cannot be written ({}); {}", path_, error.what(), what_stands()));
  }
}

/// Removes columns that the frames of a resumed file do not have: an effect or a newer program has added them since.
void Recorder::leave_out_new_columns(Frame& frame) {
  std::erase_if(frame.columns, [&](const Column& column) {
    const bool is_new = std::ranges::find(series_, column.name, &Series::name) == series_.end();
    if (is_new) left_out_.insert(column.name);
    return is_new;
  });
}

void Recorder::add(Frame frame) {
  if (is_resumed_) leave_out_new_columns(frame);
  std::vector<Series> series = series_;
  if (series.empty()) {
    series = series_of(frame, particles_);
    if (!box_edges_.empty()) series.push_back(series_of_box_edges(length_unit_));
  }
  const double time = frame.time;
  std::map<std::string, std::int64_t> ends = ends_;
  Rows rows = rows_of(std::move(frame), particles_, series, frames_, ends, box_edges_);
  series_ = series;
  try {
    keep(std::move(rows));
  } catch (const Failure& failure) {
    throw Failure(fmt::format("{}; {}", failure.what(), what_stands()));
  } catch (const std::exception& error) {
    throw Failure(fmt::format("{} cannot be written ({}); {}", path_, error.what(), what_stands()));
  }
  ends_ = std::move(ends);
  last_time_ = time;
  ++frames_;
}

/// Until the next save; frames that are many, or large, in a segment.
void Recorder::keep(Rows rows) {
  if (whole_file_) whole_file_becomes_segment();
  const std::uint64_t bytes = bytes_of(rows);
  if (!tail_.empty() && tail_bytes_ + bytes > tail_limit_) {
    write_segment(tail_);
    tail_.clear();
    tail_bytes_ = 0;
  }
  if (bytes > tail_limit_) write_segment({&rows, 1});
  last_lists_ = lists_of(rows, series_);
  if (bytes > tail_limit_) return;
  tail_.push_back(std::move(rows));
  tail_bytes_ += bytes;
}

void Recorder::write_segment(std::span<const Rows> frames) {
  check_segments_folder(path_);
  std::error_code error;
  std::filesystem::create_directory(segments_folder(path_), error);
  if (error) throw Failure(fmt::format("{} cannot be made ({})", segments_folder(path_), error.message()));
  Segment segment{.number = next_segment(path_), .frames = static_cast<std::int64_t>(frames.size()), .seal = {}};
  segment.rows.assign(series_.size(), 0);
  for (const Rows& rows : frames)
    for (std::size_t k = 0; k < rows.size(); ++k) segment.rows[k] += lichtenberg::rows_in(rows[k], series_[k]);
  segment.seal = write_with_frames(segment_file(path_, segment.number), {}, series_, {}, frames);
  segments_.push_back(std::move(segment));
}

/// Under another name, beside its own, that the next save gives to an index; nothing is copied where the disk has hard
/// links.
void Recorder::whole_file_becomes_segment() {
  namespace fs = std::filesystem;
  Segment segment{.number = next_segment(path_), .frames = frames_, .seal = {}};
  check_segments_folder(path_);
  std::error_code error;
  fs::create_directory(segments_folder(path_), error);
  const std::string name = segment_file(path_, segment.number);
  fs::create_hard_link(path_, name, error);
  if (error) fs::copy_file(path_, name, error);
  if (error) throw Failure(fmt::format("{} cannot be written ({})", name, error.message()));
  const auto file = std::make_shared<const OpenFile>(name);
  segment.seal = checked_seal(*file).value();
  segment.rows = lichtenberg::rows_in(hdf5::open(file), series_);
  segments_.push_back(std::move(segment));
  whole_file_ = false;
}

std::string Recorder::save(const Milestone& milestone) {
  const bool others_remain = !saved_time_ || outdated_segments_;
  try {
    if (whole_file_) whole_file_becomes_segment();
    lengthen_history(milestone.history);
    // Once, and not with every save.
    if (milestone.field) put_constants([&](const hdf5::Handle& file) { put_vtkhdf_grid(file, *milestone.field); });
    write_index(milestone);
  } catch (const Failure& failure) {
    throw Failure(fmt::format("{}; {}", failure.what(), what_stands()));
  } catch (const InputError&) {
    throw;
  } catch (const std::exception& error) {
    throw Failure(fmt::format("{} cannot be written ({}); {}", path_, error.what(), what_stands()));
  }
  saved_time_ = last_time_;
  saved_frames_ = frames_;
  if (others_remain) remove_other_segments(path_, segments_);  // of a run that was overwritten, or of frames made anew
  outdated_segments_ = false;
  return milestone.summary.empty() || segments_.empty() ? "" : put_together(milestone);
}

void Recorder::lengthen_history(const ColumnGroup& added) {
  if (added.columns.empty()) return;
  if (!history_) {
    history_ = added;
    return;
  }
  std::vector<Column> columns = history_->columns;
  for (Column& column : columns) lengthen(column, added.columns);
  history_->columns = std::move(columns);
}

hdf5::Pages Recorder::all_but_frames(const Milestone& milestone) const {
  const auto pages = std::make_shared<hdf5::Pages>(constants_);
  {
    const hdf5::Handle file = hdf5::open_in_memory(pages);
    put_checkpoint(file, milestone.checkpoint);
    hdf5::put_attribute(hdf5::open_group(file, "checkpoint"), frames_up_to_it, frames_);
    if (milestone.field) put_vtkhdf(file, *milestone.field, stored_field_);
    if (!last_lists_.empty()) put_columns(hdf5::open_group(file, "network"), last_lists_);
    for (const ColumnGroup& found : milestone.findings) put_columns(hdf5::open_group(file, found.name), found.columns);
    if (history_) {
      const hdf5::Handle group = hdf5::open_group(file, history_->name);
      hdf5::put_attribute(group, is_history, 1);
      put_columns(group, history_->columns);
    }
    const hdf5::Handle seconds = hdf5::open_group(file, session_group(session_) + "/seconds");
    for (const auto& [activity, value] : milestone.seconds) hdf5::put(seconds, activity, value, "s");
    for (const auto& [name, value, unit] : milestone.summary)
      hdf5::put(hdf5::open_group(file, "summary"), name, value, unit);
    if (!milestone.warnings.empty())
      hdf5::put_attribute(hdf5::open_group(file, "summary"), "warnings", milestone.warnings);
  }
  return std::move(*pages);
}

void Recorder::write_index(const Milestone& milestone) const {
  const auto pages = std::make_shared<hdf5::Pages>(all_but_frames(milestone));
  const bool over = !milestone.summary.empty();  // what lies in segments is put together then
  if (!series_.empty()) put_frames_into(hdf5::open_in_memory(pages), over && segments_.empty());
  write_sealed(path_, *pages);
}

/// All there are; of those in segments, where they stand. Compressed once the run is over: before, each save would
/// compress them all again.
void Recorder::put_frames_into(const hdf5::Handle& file, bool compressed) const {
  if (segments_.empty()) return put_frames(file, "", series_, tail_, compressed);
  std::vector<Elsewhere> parts;
  for (const Segment& segment : segments_) parts.push_back({segment_name(path_, segment.number), "", segment.rows});
  if (!tail_.empty()) {
    put_frames(file, "tail/", series_, tail_, compressed);
    parts.push_back({".", "tail/", lichtenberg::rows_in(hdf5::open_group(file, "tail"), series_)});
  }
  put_virtual(file, series_, parts);
  put_segments(file, segments_);
}

/// One file in place of index and segments, which stay if that cannot be done: then why.
std::string Recorder::put_together(const Milestone& milestone) {
  try {
    hdf5::Pages rest = all_but_frames(milestone);
    constexpr std::uint64_t spare = 16u << 20;
    std::uint64_t needed = rest.size() + tail_bytes_ + spare;
    std::vector<StoredFrames> before;
    for (const Segment& segment : segments_) needed += segment.seal.bytes;
    if (free_bytes(path_) < needed)
      throw Failure(fmt::format("that takes {:.3g} GB on the disk", 1e-9 * static_cast<double>(needed)));
    for (const Segment& segment : segments_)
      before.push_back({segment.rows, [&] { return std::make_shared<const OpenFile>(open_segment(path_, segment)); }});
    write_with_frames(path_, std::move(rest), series_, before, tail_);
    remove_other_segments(path_, {});
    segments_.clear();
    tail_.clear();
    tail_bytes_ = 0;
    whole_file_ = true;
    return "";
  } catch (const std::exception& error) {
    return fmt::format("{} stays beside {} and belongs to it: they were not put together ({})", segments_folder(path_),
                       path_, error.what());
  }
}

std::string Recorder::what_stands() const {
  if (saved_time_) {
    const std::string saved =
        "what was saved up to " + instant_in_words(*saved_time_, series_.empty() ? Frame{}.time_unit : series_[1].unit);
    std::error_code error;
    return std::filesystem::exists(path_, error) ? saved + " stands, and --resume goes on from there"
                                                 : saved + " is gone with the file, which was removed during the run";
  }
  return std::filesystem::exists(path_) ? "the file that was to be overwritten stands" : "nothing was saved";
}

}  // namespace lichtenberg
