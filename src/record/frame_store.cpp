#include "src/record/frame_store.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sys/statvfs.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <system_error>
#include <utility>

#include "solvers/error.hpp"
#include "src/record/atomic_file.hpp"
#include "src/record/layout.hpp"

namespace lichtenberg {
namespace {

Column list_column(const Series& series, Values values) {
  return {.name = series.name,
          .unit = series.unit,
          .of = Column::Of::list,
          .width = series.row.empty() ? 0 : static_cast<std::size_t>(series.row[0]),
          .values = std::move(values)};
}

std::vector<Column> lists_of(const Rows& rows, const std::vector<Series>& series) {
  std::vector<Column> lists;
  for (std::size_t k = 0; k < series.size(); ++k)
    if (series[k].of == Column::Of::list) lists.push_back(list_column(series[k], rows[k]));
  return lists;
}

/// Returns the free bytes on the disk of a path; the largest number if they are unknown.
std::uint64_t free_bytes(const std::string& path) {
  struct statvfs disk {};
  if (statvfs(folder_of(path).c_str(), &disk) != 0) return UINT64_MAX;
  return static_cast<std::uint64_t>(disk.f_bavail) * disk.f_frsize;
}

std::uint64_t bytes_in(const hdf5::Handle& file, const std::vector<Series>& all) {
  std::uint64_t bytes = 0;
  for (const Series& series : all) bytes += hdf5::row_count(file, series.dataset) * series.row_bytes();
  return bytes;
}

/// Returns rows `first` to `first + count` of values. Throws hdf5::Error if there are fewer.
Values part_of(const Values& values, const Series& series, std::int64_t first, std::int64_t count) {
  return std::visit(
      [&]<class Number>(const std::vector<Number>& numbers) -> Values {
        const auto width = static_cast<std::int64_t>(series.row_bytes() / sizeof(Number));
        if (first < 0 || count < 0 || (first + count) * width > static_cast<std::int64_t>(numbers.size()))
          throw hdf5::Error(fmt::format("rows of {} are missing", series.name));
        return std::vector<Number>(numbers.begin() + first * width, numbers.begin() + (first + count) * width);
      },
      values);
}

/// Reads the rows of `count` frames from frame `first`, all in one file. `ends`: index after each frame's last row of a
/// list.
Values values_in(const ResultFile& result, const Series& series, const std::vector<std::int64_t>& ends,
                 std::int64_t first, std::int64_t count) {
  return std::visit(
      [&]<class Number>(const std::vector<Number>&) -> Values {
        return series.of == Column::Of::list ? result.list<Number>(series.name, ends, first, count)
                                             : result.rows<Number>(series.dataset, first, count);
      },
      series.kind);
}

}  // namespace

FrameStore::FrameStore(std::string path, const Scene& scene, std::size_t particles, std::uint64_t tail_limit)
    : path_(std::move(path)),
      tail_limit_(tail_limit),
      particles_(particles),
      box_edges_(box_edges(scene)),
      length_unit_(scene.units().length) {}

void FrameStore::resume_from(const ResultFile& result, std::int64_t frames) {
  is_resumed_ = true;
  series_ = series_in(result.file());
  frames_ = frames;
  last_time_ = hdf5::single(result.rows<double>(series_[1].dataset, frames_ - 1, 1), series_[1].dataset);
  const std::int64_t first = resume_segments(result);
  is_whole_file_ = segments_.empty() && !stale_segments_remain_ && bytes_in(result.file(), series_) > tail_limit_;
  if (!is_whole_file_) tail_.assign(static_cast<std::size_t>(frames_ - first), Rows(series_.size()));
  for (std::size_t k = 0; k < series_.size(); ++k)
    resume_rows(result, k, first < frames_ ? first : first - segments_.back().frames);
  for (const Rows& rows : tail_) tail_bytes_ += bytes_of(rows);
}

/// Adopts the segments of a result that have no frame after the checkpoint. Returns their number of frames.
std::int64_t FrameStore::resume_segments(const ResultFile& result) {
  std::int64_t frames = 0;
  stale_segments_remain_ = false;
  for (const Segment& segment : result.segments()) {
    stale_segments_remain_ = frames + segment.frames > frames_;
    if (stale_segments_remain_) break;
    frames += segment.frames;
    segments_.push_back(segment);
    segments_.back().rows = rows_in(hdf5::open(result.segment(segments_.size() - 1)), series_);
  }
  return frames;
}

/// Reads the rows of the tail and, for a list, those of the last frame. `begin`: first frame of the file that contains
/// the last frame.
void FrameStore::resume_rows(const ResultFile& result, std::size_t k, std::int64_t begin) {
  const Series& series = series_[k];
  const bool is_list = series.of == Column::Of::list;
  const auto length = static_cast<std::int64_t>(tail_.size()), first = frames_ - length;
  std::vector<std::int64_t> ends(static_cast<std::size_t>(is_list ? frames_ : 0));  // unknown before begin - 1
  if (is_list) {
    const std::int64_t known = std::max<std::int64_t>(begin - 1, 0);
    const auto stored = result.rows<std::int64_t>(fmt::format("network/{}_end", series.name), known, frames_ - known);
    if (static_cast<std::int64_t>(stored.size()) != frames_ - known)
      throw hdf5::Error(fmt::format("{} has not one end for each frame", series.name));
    std::ranges::copy(stored, ends.begin() + known);
    ends_[series.name] = ends.back();
    last_lists_.push_back(list_column(series, values_in(result, series, ends, frames_ - 1, 1)));
  }
  if (tail_.empty()) return;
  const Values all = values_in(result, series, ends, first, length);
  const auto end_of = [&](std::int64_t frame) {
    return !is_list ? frame + 1 : frame < 0 ? 0 : ends[static_cast<std::size_t>(frame)];
  };
  for (std::int64_t f = 0; f < length; ++f) {
    const std::int64_t before = end_of(first + f - 1), rows = end_of(first + f) - before;
    if (rows < 0) throw hdf5::Error(series.name + " of a frame end before they begin");
    tail_[static_cast<std::size_t>(f)][k] = part_of(all, series, before - end_of(first - 1), rows);
  }
}

std::string FrameStore::warning_of_columns() const {
  if (omitted_.empty()) return "";
  return fmt::format("{} was begun without {}, which it therefore does not record: a new run does", path_,
                     fmt::join(omitted_, ", "));
}

/// Removes columns that the frames of a resumed file lack, because an effect or a newer program has added them.
void FrameStore::omit_new_columns(Frame& frame) {
  std::erase_if(frame.columns, [&](const Column& column) {
    const bool is_new = std::ranges::find(series_, column.name, &Series::name) == series_.end();
    if (is_new) omitted_.insert(column.name);
    return is_new;
  });
}

void FrameStore::add(Frame frame) {
  if (is_resumed_) omit_new_columns(frame);
  std::vector<Series> series = series_;
  if (series.empty()) {
    series = series_of(frame, particles_);
    if (!box_edges_.empty()) series.push_back(series_of_box_edges(length_unit_));
  }
  const double time = frame.time;
  std::map<std::string, std::int64_t> ends = ends_;
  std::vector<double> edges = box_edges_;
  for (int k = 0; k < 3 && !edges.empty(); ++k)  // a packing with loads changes its box
    if (const auto size = frame.number(fmt::format("size_{}", "xyz"[k]))) edges[4 * k] = *size;
  Rows rows = rows_of(std::move(frame), particles_, series, frames_, ends, edges);
  series_ = series;
  keep(std::move(rows));
  ends_ = std::move(ends);
  last_time_ = time;
  ++frames_;
}

/// Adds a frame to the tail, or to the segments if the tail is full or the frame is large.
void FrameStore::keep(Rows rows) {
  link_as_first_segment();
  const std::uint64_t bytes = bytes_of(rows);
  if (!tail_.empty() && tail_bytes_ + bytes > tail_limit_) {
    write_segment(tail_);
    clear_tail();
  }
  if (bytes > tail_limit_) write_segment({&rows, 1});
  last_lists_ = lists_of(rows, series_);
  if (bytes > tail_limit_) return;
  tail_.push_back(std::move(rows));
  tail_bytes_ += bytes;
}

void FrameStore::clear_tail() {
  tail_.clear();
  tail_bytes_ = 0;
}

/// Returns the next segment, without a file, and creates its folder.
Segment FrameStore::new_segment(std::int64_t frames) const {
  make_segments_folder(path_);
  return {.number = next_segment(path_), .frames = frames, .seal = {}};
}

void FrameStore::write_segment(std::span<const Rows> frames) {
  Segment segment = new_segment(static_cast<std::int64_t>(frames.size()));
  segment.rows.assign(series_.size(), 0);
  for (const Rows& rows : frames)
    for (std::size_t k = 0; k < rows.size(); ++k) segment.rows[k] += rows_in(rows[k], series_[k]);
  segment.seal = write_with_frames(segment_file(path_, segment.number), {}, series_, {}, frames);
  segments_.push_back(std::move(segment));
}

void FrameStore::link_as_first_segment() {
  if (!is_whole_file_) return;
  Segment segment = new_segment(frames_);
  const std::string name = segment_file(path_, segment.number);
  std::error_code error;
  std::filesystem::create_hard_link(path_, name, error);
  if (error) std::filesystem::copy_file(path_, name, error);
  if (error) throw Failure(fmt::format("{} cannot be written ({})", name, error.message()));
  const auto file = std::make_shared<const OpenFile>(name);
  segment.seal = checked_seal(*file).value();
  segment.rows = rows_in(hdf5::open(file), series_);
  segments_.push_back(std::move(segment));
  is_whole_file_ = false;
}

void FrameStore::put_last_lists(const hdf5::Handle& file) const {
  if (!last_lists_.empty()) put_columns(hdf5::open_group(file, "network"), last_lists_);
}

void FrameStore::write_to(const hdf5::Handle& file, bool is_over) const {
  if (series_.empty()) return;
  if (segments_.empty()) return put_frames(file, "", series_, tail_, is_over);
  std::vector<RowSource> parts;
  for (const Segment& segment : segments_) parts.push_back({segment_name(path_, segment.number), "", segment.rows});
  if (!tail_.empty()) {
    put_frames(file, "tail/", series_, tail_, false);
    parts.push_back({".", "tail/", rows_in(hdf5::open_group(file, "tail"), series_)});
  }
  put_virtual(file, series_, parts);
  put_segments(file, segments_);
}

void FrameStore::remove_stale_segments() {
  if (stale_segments_remain_) remove_other_segments(path_, segments_);
  stale_segments_remain_ = false;
}

void FrameStore::merge_into_one_file(hdf5::Pages rest) {
  constexpr std::uint64_t spare = 16u << 20;
  std::uint64_t needed = rest.size() + tail_bytes_ + spare;
  for (const Segment& segment : segments_) needed += segment.seal.bytes;
  if (free_bytes(path_) < needed)
    throw Failure(fmt::format("that takes {:.3g} GB on the disk", 1e-9 * static_cast<double>(needed)));
  std::vector<StoredFrames> before;
  for (const Segment& segment : segments_)
    before.push_back({segment.rows, [&] { return std::make_shared<const OpenFile>(open_segment(path_, segment)); }});
  write_with_frames(path_, std::move(rest), series_, before, tail_);
  remove_other_segments(path_, {});
  segments_.clear();
  clear_tail();
  is_whole_file_ = true;
}

}  // namespace lichtenberg
