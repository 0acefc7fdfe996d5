#include "src/record/result_file.hpp"

#include <fmt/format.h>
#include <sys/resource.h>

#include <algorithm>
#include <filesystem>
#include <system_error>
#include <utility>

#include "solvers/error.hpp"
#include "src/record/layout.hpp"
#include "src/record/writer_lock.hpp"

namespace lichtenberg {
namespace {

/// Raises the limit of open files, because segments stay open and may exceed the initial limit.
void allow_many_files() {
  rlimit limit{};
  if (getrlimit(RLIMIT_NOFILE, &limit) != 0) return;
  limit.rlim_cur = limit.rlim_max;
  setrlimit(RLIMIT_NOFILE, &limit);
}

std::shared_ptr<const OpenFile> open_file(const std::string& path) {
  std::error_code unknown;
  if (std::filesystem::is_directory(path, unknown))
    throw InputError(fmt::format("the path {} is a folder: name a result file", path));
  if (std::filesystem::exists(path, unknown) && !std::filesystem::is_regular_file(path, unknown))
    throw InputError(
        fmt::format("the path {} is no file: name a result file", path));  // a pipe without a writer would block
  try {
    return std::make_shared<const OpenFile>(path);
  } catch (const std::system_error& error) {
    if (error.code() == std::errc::no_such_file_or_directory)
      throw InputError(fmt::format("the file {} does not exist", path));
    throw InputError(fmt::format("the file {} cannot be read ({})", path, error.code().message()));
  }
}

/// Exception: another file has taken the name, and its segments differ.
struct FileReplaced {};

bool is_dataset_of_frames(const std::vector<Series>& series, const std::string& path) {
  return std::ranges::any_of(
      series, [&](const Series& each) { return each.dataset == path || each.dataset.starts_with(path + "/"); });
}

/// Copies the object at a path with its attributes. If frames are stored below it, only the rest of its members is
/// copied.
void copy_path(const hdf5::Handle& from, const hdf5::Handle& to, const std::string& path,
               const std::vector<Series>& series) {
  if (!is_dataset_of_frames(series, path)) {
    const hdf5::Handle creation(H5Pcreate(H5P_LINK_CREATE));
    hdf5::check(H5Pset_create_intermediate_group(creation, 1));
    hdf5::check(H5Ocopy(from, path.c_str(), to, path.c_str(), H5P_DEFAULT, creation));
  } else if (hdf5::is_group(from, path) && !hdf5::exists(from, path + "/value")) {
    const hdf5::Handle group = hdf5::open_group(from, path);
    if (H5Aget_num_attrs(group) > 0) hdf5::copy_attributes(group, hdf5::open_group(to, path));
    for (const std::string& name : hdf5::names(group)) copy_path(from, to, path + "/" + name, series);
  }
}

/// Throws Failure if the file at the path is no longer the opened one.
void refuse_another(const ResultFile& opened) {
  if (identity_of(opened.path()) != opened.identity())
    throw Failure(fmt::format("{} has changed since it was read: try again once its run is over", opened.path()));
}

/// Writes a file with large frames, which are copied in blocks of a few megabytes.
void store_beside_frames(const ResultFile& opened, const std::function<void(const hdf5::Handle&)>& put) {
  const auto pages = std::make_shared<hdf5::Pages>();
  {
    const hdf5::Handle file = hdf5::create_in_memory(pages);
    copy_all_but_frames(opened.file(), file, hdf5::names(opened.file()));
    put(file);
  }
  const std::vector<Series> series = series_in(opened.file());
  const StoredFrames frames{rows_in(opened.file(), series), [&] { return opened.opened(); }};
  write_with_frames(opened.path(), std::move(*pages), series, {&frames, 1}, {}, [&] { refuse_another(opened); });
}

void store_in_memory(const ResultFile& opened, const std::function<void(const hdf5::Handle&)>& put) {
  const auto pages = std::make_shared<hdf5::Pages>(hdf5::pages_of(*opened.opened()));
  put(hdf5::open_in_memory(pages));
  const auto check = [&] { refuse_another(opened); };
  if (opened.is_sealed()) return write_sealed(opened.path(), *pages, check);
  NewFile file(opened.path());  // a file that another program has changed gets no seal
  pages->for_each([&](std::uint64_t offset, std::span<const std::byte> bytes) { file.write(offset, bytes); });
  file.publish(check);
}

}  // namespace

ResultFile::ResultFile(const std::string& path, const std::string& used) : path_(path), index_(open_file(path)) {
  constexpr int attempts = 100;  // the run would have to save this often while one index is read
  for (int attempt = 1;; ++attempt) try {
      open_index(used);
      open_segments();
      find_ranges();
      return;
    } catch (const FileReplaced&) {
      if (attempt == attempts) throw hdf5::Error("its run replaces it faster than it can be read");
      index_ = open_file(path);
    }
}

void ResultFile::open_index(const std::string& used) {
  if (!hdf5::is_hdf5(*index_))
    throw InputError(
        fmt::format("the file {} is no HDF5 file: only a result file of `lichtenberg run` can be {}", path_, used));
  sealed_ = checked_seal(*index_).has_value();
  file_ = std::make_shared<hdf5::Handle>(hdf5::open(index_));
  const std::optional<int> format = hdf5::integer_attribute(*file_, "lichtenberg_result");
  if (!format)
    throw InputError(
        fmt::format("the file {} was not written by `lichtenberg run`: only its result files can be {}", path_, used));
  format_ = *format;
  if (format_ != result_format && format_ != 1)
    throw InputError(
        fmt::format("the file {} has result format {}, but this version of lichtenberg reads only formats 1 and {}",
                    path_, format_, result_format));
}

void ResultFile::open_segments() {
  segments_ = get_segments(*file_);
  files_.clear();
  if (segments_.size() > 200) allow_many_files();
  for (const Segment& segment : segments_) try {
      files_.push_back(std::make_shared<const OpenFile>(open_segment(path_, segment)));
    } catch (const std::system_error& error) {
      if (identity_of(path_) != identity()) throw FileReplaced();
      throw hdf5::Error(fmt::format("{}, which holds frames of it, cannot be read: {}",
                                    segment_name(path_, segment.number), error.code().message()));
    }
}

void ResultFile::find_ranges() {
  ranges_.clear();
  frames_ = 0;
  for (std::size_t k = 0; k < segments_.size(); ++k) {
    ranges_.push_back({frames_, segments_[k].frames, static_cast<int>(k)});
    frames_ += segments_[k].frames;
  }
  const std::string prefix = segments_.empty() ? "" : "tail";
  if (!prefix.empty() && !hdf5::exists(*file_, prefix)) return;
  const hdf5::Handle own = prefix.empty() ? hdf5::open_group(*file_, "/") : hdf5::open_group(*file_, prefix);
  const std::string home = element_with_time(own);
  if (home.empty()) return;
  const auto count = static_cast<std::int64_t>(hdf5::row_count(own, home + "/time"));
  ranges_.push_back({frames_, count, -1});
  frames_ += count;
}

const ResultFile::FrameRange& ResultFile::range_with(std::int64_t frame) const {
  for (const FrameRange& range : ranges_)
    if (frame >= range.first && frame < range.first + range.frames) return range;
  throw hdf5::Error(fmt::format("there is no frame {}", frame));
}

template <class Reading>
auto ResultFile::in(const FrameRange& range, Reading reading) const {
  if (range.segment >= 0) return reading(hdf5::open(files_[static_cast<std::size_t>(range.segment)]), std::string());
  return reading(*file_, std::string(segments_.empty() ? "" : "tail/"));
}

std::vector<std::string> ResultFile::warnings() const {
  if (!hdf5::exists(*file_, "summary")) return {};
  return hdf5::text_attribute(hdf5::open_group(*file_, "summary"), "warnings");
}

bool ResultFile::has(const std::string& dataset) const { return hdf5::exists(*file_, dataset); }

template <class Number>
std::vector<Number> ResultFile::rows(const std::string& dataset, std::int64_t first, std::int64_t count) const {
  std::vector<Number> all;
  while (count > 0) {
    const FrameRange& range = range_with(first);
    const std::int64_t here = std::min(count, range.first + range.frames - first);
    const std::vector<Number> rows = in(range, [&](const hdf5::Handle& file, const std::string& prefix) {
      return hdf5::get_rows<Number>(file, prefix + dataset, static_cast<hsize_t>(first - range.first),
                                    static_cast<hsize_t>(here));
    });
    all.insert(all.end(), rows.begin(), rows.end());
    first += here;
    count -= here;
  }
  return all;
}

template <class Number>
std::vector<Number> ResultFile::list(const std::string& name, const std::vector<std::int64_t>& ends, std::int64_t frame,
                                     std::int64_t count) const {
  if (static_cast<std::int64_t>(ends.size()) < frame + count) throw hdf5::Error(name + " has no end in a frame");
  const FrameRange& range = range_with(frame);
  const auto end_before = [&](std::int64_t k) { return k > 0 ? ends.at(static_cast<std::size_t>(k - 1)) : 0; };
  const std::int64_t before = end_before(range.first), first = end_before(frame), end = end_before(frame + count);
  if (first < before || end < first) throw hdf5::Error(fmt::format("the {} of a frame end before they begin", name));
  return in(range, [&](const hdf5::Handle& file, const std::string& prefix) {
    return hdf5::get_rows<Number>(file, fmt::format("{}network/{}_of_all_frames", prefix, name),
                                  static_cast<hsize_t>(first - before), static_cast<hsize_t>(end - first));
  });
}

#define FOR_NUMBER(Number)                                                                                          \
  template std::vector<Number> ResultFile::rows(const std::string&, std::int64_t, std::int64_t) const;              \
  template std::vector<Number> ResultFile::list(const std::string&, const std::vector<std::int64_t>&, std::int64_t, \
                                                std::int64_t) const;
FOR_NUMBER(double)
FOR_NUMBER(std::int32_t)
FOR_NUMBER(std::int64_t)
#undef FOR_NUMBER

void copy_all_but_frames(const hdf5::Handle& from, const hdf5::Handle& to, const std::vector<std::string>& groups) {
  if (const std::optional<int> format = hdf5::integer_attribute(from, "lichtenberg_result"))
    hdf5::put_attribute(to, "lichtenberg_result", *format);
  const std::vector<Series> series = element_with_time(from).empty() ? std::vector<Series>{} : series_in(from);
  for (const std::string& group : groups)
    if (hdf5::exists(from, group)) copy_path(from, to, group, series);
}

void store(const ResultFile& opened, const std::function<void(const hdf5::Handle&)>& put, std::uint64_t in_memory) {
  const std::optional<WriterLock> lock = WriterLock::if_free(opened.path());
  if (!lock) throw Failure(fmt::format("{} is being written: try again once its run is over", opened.path()));
  try {
    const bool large = opened.is_sealed() && opened.segments().empty() && opened.opened()->size() > in_memory;
    large ? store_beside_frames(opened, put) : store_in_memory(opened, put);
  } catch (const std::system_error& error) {
    throw Failure(fmt::format("{} cannot be read ({})", opened.path(), error.code().message()));
  }
}

std::vector<double> radii_in(const hdf5::Handle& file) {
  std::vector<double> radii = hdf5::get<double>(file, "particles/conductors/radius");
  for (const double radius : radii)
    if (!(radius > 0)) throw hdf5::Error(fmt::format("a radius in it is {:g}", radius));
  return radii;
}

}  // namespace lichtenberg
