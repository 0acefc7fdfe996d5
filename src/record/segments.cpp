#include "src/record/segments.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <optional>
#include <set>
#include <utility>

#include "solvers/error.hpp"

namespace lichtenberg {
namespace {

namespace fs = std::filesystem;

constexpr const char* segments_group = "segments";
constexpr const char* segment_prefix = "segment-";
constexpr const char* segment_suffix = ".h5";
constexpr std::uint64_t block_bytes = 4u << 20;

std::string name_of(std::int64_t number) { return fmt::format("{}{:06}{}", segment_prefix, number, segment_suffix); }

std::optional<std::int64_t> number_of(const std::string& name) {
  std::int64_t number = 0;
  const std::string digits = name.substr(std::min(name.size(), std::string(segment_prefix).size()));
  std::from_chars(digits.data(), digits.data() + digits.size(), number);
  return name == name_of(number) ? std::optional(number) : std::nullopt;
}

/// Returns true if segments may be written and removed in the folder. A link to another folder is refused.
bool is_own_folder(const std::string& folder) {
  std::error_code missing;
  return fs::symlink_status(folder, missing).type() == fs::file_type::directory;
}

/// Returns true if the name is that of a segment or of a partial segment of a killed process.
bool is_segment_name(const std::string& name) {
  if (number_of(name)) return true;
  const std::string segment = name.substr(0, name.rfind(".partial-"));
  return number_of(segment) && is_partial_name(name, segment);
}

std::vector<fs::path> files_in(const std::string& folder) {
  std::vector<fs::path> files;
  std::error_code missing;
  for (const auto& entry : fs::directory_iterator(folder, missing)) files.push_back(entry.path());
  return files;
}

void copy_bytes(const OpenFile& from, std::uint64_t offset, std::uint64_t bytes, NewFile& to, std::uint64_t target) {
  std::vector<std::byte> block(std::min<std::uint64_t>(bytes, block_bytes));
  for (std::uint64_t done = 0; done < bytes; done += block.size()) {
    block.resize(std::min<std::uint64_t>(block.size(), bytes - done));
    from.read(offset + done, block);
    to.write(target + done, block);
  }
}

/// Copies compressed rows, which are not contiguous, through HDF5.
void copy_chunks(const hdf5::Handle& from, const Series& series, hsize_t rows, NewFile& to, std::uint64_t target) {
  const hsize_t together = std::max<hsize_t>(block_bytes / series.row_bytes(), 1);
  for (hsize_t first = 0; first < rows; first += together) {
    const Values block = read_rows(from, series.dataset, series, first, std::min(together, rows - first));
    to.write(target + first * series.row_bytes(), bytes_of(block));
  }
}

/// Copies the rows of all series of a file to `target`, one offset for each series, and advances the offsets.
void copy_rows(const StoredFrames& stored, const std::vector<Series>& series, NewFile& to,
               std::vector<std::uint64_t>& target) {
  const std::shared_ptr<const OpenFile> from = stored.open();
  const hdf5::Handle file = hdf5::open(from);
  for (std::size_t k = 0; k < series.size(); ++k) {
    const std::uint64_t bytes = stored.rows[k] * series[k].row_bytes();
    if (bytes == 0) continue;
    const hdf5::Handle dataset(H5Dopen2(file, series[k].dataset.c_str(), H5P_DEFAULT));
    const haddr_t offset = H5Dget_offset(dataset);
    if (offset == HADDR_UNDEF)
      copy_chunks(file, series[k], stored.rows[k], to, target[k]);
    else
      copy_bytes(*from, offset, bytes, to, target[k]);
    target[k] += bytes;
  }
}

std::vector<hsize_t> rows_of_all(const std::vector<Series>& series, std::span<const StoredFrames> before,
                                 std::span<const Rows> frames) {
  std::vector<hsize_t> rows(series.size(), 0);
  for (const StoredFrames& stored : before)
    for (std::size_t k = 0; k < rows.size(); ++k) rows[k] += stored.rows[k];
  for (const Rows& frame : frames)
    for (std::size_t k = 0; k < rows.size(); ++k) rows[k] += rows_in(frame[k], series[k]);
  return rows;
}

}  // namespace

std::string segments_folder(const std::string& path) { return path + ".frames"; }

std::string segment_file(const std::string& path, std::int64_t number) {
  return segments_folder(path) + "/" + name_of(number);
}

std::string segment_name(const std::string& path, std::int64_t number) {
  return segment_file(fs::path(path).filename().string(), number);
}

void put_segments(const hdf5::Handle& index, const std::vector<Segment>& segments) {
  std::vector<std::int64_t> number, frames, bytes, crc;
  for (const Segment& segment : segments) {
    number.push_back(segment.number);
    frames.push_back(segment.frames);
    bytes.push_back(static_cast<std::int64_t>(segment.seal.bytes));
    crc.push_back(segment.seal.crc);
  }
  const hdf5::Handle group = hdf5::open_group(index, segments_group);
  for (const auto& [name, numbers] :
       {std::pair{"number", &number}, std::pair{"frames", &frames}, std::pair{"bytes", &bytes}, std::pair{"crc", &crc}})
    hdf5::put<std::int64_t>(group, name, *numbers, {numbers->size()}, "1");
}

std::vector<Segment> get_segments(const hdf5::Handle& index) {
  if (!hdf5::exists(index, segments_group)) return {};
  const hdf5::Handle group = hdf5::open_group(index, segments_group);
  const auto number = hdf5::get<std::int64_t>(group, "number"), frames = hdf5::get<std::int64_t>(group, "frames"),
             bytes = hdf5::get<std::int64_t>(group, "bytes"), crc = hdf5::get<std::int64_t>(group, "crc");
  if (frames.size() != number.size() || bytes.size() != number.size() || crc.size() != number.size())
    throw hdf5::Error("its list of segments has gaps");
  constexpr std::int64_t most_frames = std::int64_t{1} << 40;  // sums of all do not overflow
  if (!std::ranges::all_of(frames, [](std::int64_t count) { return count >= 0 && count <= most_frames; }))
    throw hdf5::Error("its list of segments has wrong numbers of frames");
  std::vector<Segment> segments;
  for (std::size_t k = 0; k < number.size(); ++k)
    segments.push_back(
        {number[k], frames[k], {static_cast<std::uint64_t>(bytes[k]), static_cast<std::uint32_t>(crc[k])}, {}});
  return segments;
}

OpenFile open_segment(const std::string& path, const Segment& segment) {
  OpenFile file(segment_file(path, segment.number));
  if (checked_seal(file) != segment.seal)
    throw hdf5::Error(fmt::format("{} is not the one that it was written with", segment_name(path, segment.number)));
  return file;
}

void check_segments_folder(const std::string& path) {
  const std::string folder = segments_folder(path);
  std::error_code missing;
  if (fs::symlink_status(folder, missing).type() == fs::file_type::not_found || is_own_folder(folder)) return;
  throw InputError(
      fmt::format("the file {} exists and is not replaced: frames of the result file {} are written to a folder of "
                  "that name, which must not be a link",
                  folder, path));
}

void make_segments_folder(const std::string& path) {
  const std::string folder = segments_folder(path);
  std::error_code error;
  fs::create_directory(folder, error);
  if (!is_own_folder(folder))
    throw Failure(
        fmt::format("{} cannot be made ({})", folder, error ? error.message() : "it is a symbolic link; remove it"));
}

std::int64_t next_segment(const std::string& path) {
  std::int64_t next = 0;
  for (const fs::path& file : files_in(segments_folder(path)))
    if (const auto number = number_of(file.filename().string())) next = std::max(next, *number + 1);
  return next;
}

void remove_other_segments(const std::string& path, const std::vector<Segment>& segments) {
  if (!is_own_folder(segments_folder(path))) return;
  std::set<std::string> kept;
  for (const Segment& segment : segments) kept.insert(name_of(segment.number));
  std::error_code ignored;  // files that cannot be removed do no harm
  for (const fs::path& file : files_in(segments_folder(path)))
    if (const std::string name = file.filename().string(); !kept.contains(name) && is_segment_name(name))
      ::unlink(file.c_str());  // unlink never removes a folder
  if (segments.empty()) fs::remove(segments_folder(path), ignored);
}

std::vector<hsize_t> rows_in(const hdf5::Handle& file, const std::vector<Series>& series) {
  std::vector<hsize_t> rows;
  for (const Series& each : series) {
    const hdf5::Shape shape = hdf5::shape(file, each.dataset);
    if (shape.empty() || !std::equal(shape.begin() + 1, shape.end(), each.row.begin(), each.row.end()))
      throw hdf5::Error(each.dataset + " has rows of another shape");
    rows.push_back(shape[0]);
  }
  return rows;
}

Seal write_with_frames(const std::string& path, hdf5::Pages rest, const std::vector<Series>& series,
                       std::span<const StoredFrames> before, std::span<const Rows> frames,
                       const std::function<void()>& check) {
  const auto pages = std::make_shared<hdf5::Pages>(std::move(rest));
  std::vector<std::uint64_t> target = [&] {
    const hdf5::Handle file = pages->size() > 0 ? hdf5::open_in_memory(pages) : hdf5::create_in_memory(pages);
    return allocate_rows(file, series, rows_of_all(series, before, frames));
  }();
  NewFile file(path);
  pages->for_each([&](std::uint64_t offset, std::span<const std::byte> bytes) { file.write(offset, bytes); });
  for (const StoredFrames& stored : before) copy_rows(stored, series, file, target);
  for (const Rows& rows : frames)
    for (std::size_t k = 0; k < series.size(); ++k) {
      const std::span<const std::byte> bytes = bytes_of(rows[k]);
      if (bytes.empty()) continue;
      file.write(target[k], bytes);
      target[k] += bytes.size();
    }
  const Seal written = seal(file, pages->size());
  file.publish(check);
  return written;
}

}  // namespace lichtenberg
