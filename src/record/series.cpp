#include "src/record/series.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <functional>
#include <limits>
#include <numeric>
#include <set>
#include <utility>

#include "solvers/error.hpp"

namespace lichtenberg {
namespace {

constexpr const char* particles_group = "particles/conductors";
constexpr const char* system_group = "observables";
constexpr const char* list_group = "network";
constexpr const char* box_edges_name = "box/edges";  // contains a slash, which no column's name has
constexpr const char* all_frames_suffix = "_of_all_frames";
constexpr const char* end_of_list = "_end";
constexpr const char* labels_name = "terminals";
constexpr const char* step_name = "step";
constexpr const char* time_name = "time";
constexpr const char* pure_number = "1";
constexpr std::uint64_t chunk_bytes = 1u << 18, compressed_row_bytes = 1u << 20;
constexpr unsigned compression = 4;  // deflate level, 0 ... 9

bool is_clock(const Series& series) { return series.name == step_name || series.name == time_name; }

bool is_box_edges(const Series& series) { return series.name == box_edges_name; }

bool is_element(const Series& series) { return series.dataset.ends_with("/value"); }

std::string element_of(const Series& series) { return series.dataset.substr(0, series.dataset.rfind('/')); }

[[noreturn]] void refuse(const std::string& column, const std::string& why) {
  throw InputError(fmt::format("column `{}` of a frame cannot be recorded: {}", column, why));
}

Values same_kind(const Values& values) {
  return std::visit([](const auto& numbers) -> Values { return std::decay_t<decltype(numbers)>{}; }, values);
}

void check_shape(const Column& column, std::size_t particles) {
  const std::size_t width = std::max<std::size_t>(column.width, 1), size = column.size();
  const std::size_t rows = column.of == Column::Of::particles ? particles : 1;
  if (column.of == Column::Of::list ? size % width != 0 : size != rows * width)
    refuse(column.name, column.of == Column::Of::list
                            ? fmt::format("it has {} numbers, which are no rows of {}", size, width)
                            : fmt::format("it has {} numbers where there should be {} times {}", size, rows, width));
  if (!column.labels.empty() && column.labels.size() != width)
    refuse(column.name, fmt::format("it has {} labels for rows of {} numbers", column.labels.size(), width));
}

/// Throws InputError if a column of particles or a list has the name of another object of its group.
void check_free(const Column& column) {
  constexpr std::array constants{"mass", "radius", "species", "box"};
  constexpr std::array networks{"particle", "contact"};
  if (column.of == Column::Of::particles && std::ranges::count(constants, column.name) > 0)
    refuse(column.name, "the name is that of a constant quantity of the particles");
  if (column.of == Column::Of::list && (std::ranges::count(networks, column.name) > 0 ||
                                        column.name.ends_with(end_of_list) || column.name.ends_with(all_frames_suffix)))
    refuse(column.name, fmt::format("a list's name must not be `particle` or `contact` nor end in `{}` or `{}`",
                                    end_of_list, all_frames_suffix));
}

void check(const Column& column, std::size_t particles) {
  if (column.name.empty() || column.name.find_first_of("/.") != std::string::npos)
    refuse(column.name, "a name must not be empty and not contain `/` or `.`");
  if (column.name == step_name || column.name == time_name)
    refuse(column.name, "the name is that of the step or time of frames");
  check_free(column);
  if (column.unit.empty()) refuse(column.name, "it has no unit; that of a pure number is \"1\"");
  check_shape(column, particles);
}

Series series_of(const Column& column) {
  Series series{.of = column.of, .name = column.name, .unit = column.unit, .kind = same_kind(column.values)};
  series.labels = column.labels;
  if (column.of == Column::Of::particles) series.row.push_back(column.rows());
  if (column.width > 0) series.row.push_back(column.width);
  const std::string group = column.of == Column::Of::particles ? particles_group : system_group;
  series.dataset = column.of == Column::Of::list ? fmt::format("{}/{}{}", list_group, column.name, all_frames_suffix)
                                                 : fmt::format("{}/{}/value", group, column.name);
  return series;
}

Series ends_of(const std::string& list) {
  return {.name = list + end_of_list,
          .dataset = fmt::format("{}/{}{}", list_group, list, end_of_list),
          .unit = "1",
          .kind = std::vector<std::int64_t>{}};
}

/// Returns the series of step and time, which are stored in one of the elements.
std::vector<Series> clock(const std::string& element, const std::string& time_unit) {
  return {{.name = step_name, .dataset = element + "/step", .kind = std::vector<std::int64_t>{}},
          {.name = time_name, .dataset = element + "/time", .unit = time_unit, .kind = std::vector<double>{}}};
}

/// Returns true if the unit is written. A time that counts iterations gets no unit, because MDAnalysis refuses unknown
/// units of time.
bool has_unit(const Series& series) {
  return !series.unit.empty() && !(series.name == time_name && series.unit == pure_number);
}

Values kind_of(hid_t dataset) {
  const hdf5::Handle type(H5Dget_type(dataset));
  if (H5Tget_class(type) == H5T_FLOAT) return std::vector<double>{};
  if (H5Tget_class(type) != H5T_INTEGER) throw hdf5::Error("the values are not numbers");
  if (H5Tget_size(type) == sizeof(std::int32_t)) return std::vector<std::int32_t>{};
  return std::vector<std::int64_t>{};
}

Series series_at(const hdf5::Handle& file, Column::Of of, const std::string& name, const std::string& path) {
  const hdf5::Handle dataset(H5Dopen2(file, path.c_str(), H5P_DEFAULT));
  Series series{.of = of, .name = name, .dataset = path, .kind = kind_of(dataset)};
  series.unit = hdf5::text(dataset, "unit");
  series.row = hdf5::shape(file, path);
  if (series.row.empty()) throw hdf5::Error(path + " has no rows");
  series.row.erase(series.row.begin());
  const std::string labelled = of == Column::Of::list ? path : path.substr(0, path.rfind('/'));
  const hdf5::Handle object(H5Oopen(file, labelled.c_str(), H5P_DEFAULT));
  series.labels = hdf5::text_attribute(object, labels_name);
  return series;
}

void add_elements(const hdf5::Handle& file, Column::Of of, const std::string& group, std::vector<Series>& all) {
  if (!hdf5::exists(file, group)) return;
  for (const std::string& name : hdf5::names(hdf5::open_group(file, group)))
    if (const std::string element = group + "/" + name;
        hdf5::is_group(file, element) && hdf5::exists(file, element + "/value"))
      all.push_back(series_at(file, of, name, element + "/value"));
}

void add_lists(const hdf5::Handle& file, std::vector<Series>& all) {
  if (!hdf5::exists(file, list_group)) return;
  const std::string suffix = all_frames_suffix;
  for (const std::string& found : hdf5::names(hdf5::open_group(file, list_group))) {
    if (!found.ends_with(suffix)) continue;
    const std::string name = found.substr(0, found.size() - suffix.size());
    all.push_back(series_at(file, Column::Of::list, name, fmt::format("{}/{}", list_group, found)));
    all.push_back(ends_of(name));
  }
}

/// Makes all datasets by `make(parent group, its name, series, index)`. Step and time are stored once and linked from
/// the other elements.
void put_all(const hdf5::Handle& file, const std::string& prefix, const std::vector<Series>& all,
             const std::function<hdf5::Handle(hid_t, const std::string&, const Series&, std::size_t)>& make) {
  for (std::size_t k = 0; k < all.size(); ++k) {
    const std::size_t slash = all[k].dataset.rfind('/');
    const hdf5::Handle group = hdf5::open_group(file, prefix + all[k].dataset.substr(0, slash));
    const hdf5::Handle dataset = make(group, all[k].dataset.substr(slash + 1), all[k], k);
    if (has_unit(all[k])) hdf5::put_attribute(dataset, "unit", all[k].unit);
    if (!all[k].labels.empty()) hdf5::put_attribute(is_element(all[k]) ? group : dataset, labels_name, all[k].labels);
  }
  for (const Series& clock : all)
    for (const Series& series : all)
      if (is_clock(clock) && is_element(series) && element_of(series) != element_of(clock))
        hdf5::check(H5Lcreate_hard(file, (prefix + clock.dataset).c_str(), file,
                                   (prefix + element_of(series) + "/" + clock.name).c_str(), H5P_DEFAULT, H5P_DEFAULT));
}

hid_t native(const Values& kind) {
  return std::visit(
      [](const auto& numbers) { return hdf5::native<typename std::decay_t<decltype(numbers)>::value_type>(); }, kind);
}

hdf5::Shape rows_of_shape(hsize_t rows, const hdf5::Shape& row) {
  hdf5::Shape shape{rows};
  shape.insert(shape.end(), row.begin(), row.end());
  return shape;
}

/// Returns the creation properties of a dataset: chunks of whole rows, if compression is useful.
hdf5::Handle storage(const Series& series, hsize_t rows) {
  hdf5::Handle creation(H5Pcreate(H5P_DATASET_CREATE));
  const std::uint64_t bytes = series.row_bytes();
  if (series.row.empty() || rows == 0 || bytes == 0 || bytes > compressed_row_bytes) return creation;
  const hsize_t together = std::clamp<hsize_t>(chunk_bytes / bytes, 1, rows);
  const hdf5::Shape chunk = rows_of_shape(together, series.row);
  hdf5::check(H5Pset_chunk(creation, static_cast<int>(chunk.size()), chunk.data()));
  hdf5::check(H5Pset_shuffle(creation));
  hdf5::check(H5Pset_deflate(creation, compression));
  return creation;
}

/// Sets the value that is read if a referenced file is missing.
void set_missing(const hdf5::Handle& creation, const Series& series) {
  std::visit(
      [&]<class Number>(const std::vector<Number>&) {
        Number missing = std::numeric_limits<Number>::min();
        if constexpr (std::is_same_v<Number, double>) missing = std::numeric_limits<double>::quiet_NaN();
        hdf5::check(H5Pset_fill_value(creation, native(series.kind), &missing));
      },
      series.kind);
}

/// Selects `count` rows of the shape from row `first`.
void select(const hdf5::Handle& space, const hdf5::Shape& shape, hsize_t first, hsize_t count) {
  hdf5::Shape start(shape.size(), 0), block = shape;
  start[0] = first;
  block[0] = count;
  hdf5::check(H5Sselect_hyperslab(space, H5S_SELECT_SET, start.data(), nullptr, block.data(), nullptr));
}

std::size_t find(const std::vector<Series>& series, const std::string& dataset) {
  return static_cast<std::size_t>(std::ranges::find(series, dataset, &Series::dataset) - series.begin());
}

/// Throws InputError if a column does not match the series of its name.
void check_same(const Column& column, const Series& now, const Series& before) {
  const auto change = [&](const std::string& what) {
    refuse(column.name, fmt::format("{} is not that of the frames before", what));
  };
  if (now.of != before.of) change("the owner of its rows");
  if (now.unit != before.unit) change(fmt::format("its unit `{}`", now.unit));
  if (now.kind.index() != before.kind.index()) change("the type of its numbers");
  if (now.row != before.row) change("its width");
  if (now.labels != before.labels) change("the list of its labels");
}

/// Returns the index of each column's series. Throws InputError for columns that earlier frames lack, and for missing
/// ones.
std::vector<std::size_t> series_indices(const std::vector<Series>& now, const std::vector<Series>& series,
                                        const Frame& frame) {
  std::vector<std::size_t> indices;
  for (const Column& column : frame.columns) {
    const auto by_name = [&](const Series& s) { return s.name == column.name && !s.dataset.ends_with(end_of_list); };
    const auto before = std::ranges::find_if(series, by_name);
    if (before == series.end()) refuse(column.name, "the frames before have no column of this name");
    check_same(column, *std::ranges::find_if(now, by_name), *before);
    indices.push_back(static_cast<std::size_t>(before - series.begin()));
  }
  for (const Series& before : series)
    if (!is_clock(before) && !is_box_edges(before) && find(now, before.dataset) == now.size())
      refuse(before.name, "the frames before have it, and this one does not");
  if (series[1].unit != frame.time_unit) refuse(time_name, "its unit is not that of the frames before");
  return indices;
}

}  // namespace

std::uint64_t Series::row_bytes() const {
  const hsize_t numbers = std::accumulate(row.begin(), row.end(), hsize_t{1}, std::multiplies<>());
  return numbers * (std::holds_alternative<std::vector<std::int32_t>>(kind) ? 4 : 8);
}

std::vector<Series> series_of(const Frame& frame, std::size_t particles) {
  std::set<std::string> names;
  std::vector<Series> columns;
  for (const Column& column : frame.columns) {
    check(column, particles);
    if (!names.insert(column.name).second) refuse(column.name, "there are two of this name");
    columns.push_back(series_of(column));
  }
  const auto home = std::ranges::find_if(columns, is_element);
  if (home == columns.end())
    throw InputError("a frame without a column of particles or of the system cannot be recorded");
  std::vector<Series> all = clock(element_of(*home), frame.time_unit);
  for (Series& series : columns) {
    all.push_back(series);
    if (series.of == Column::Of::list) all.push_back(ends_of(series.name));
  }
  return all;
}

Series series_of_box_edges(const std::string& unit) {
  return {.of = Column::Of::system,
          .name = box_edges_name,
          .dataset = fmt::format("{}/{}/value", particles_group, box_edges_name),
          .unit = unit,
          .kind = std::vector<double>{},
          .row = {3, 3}};
}

std::string element_with_time(const hdf5::Handle& file) {
  if (const std::string usual = std::string(particles_group) + "/position"; hdf5::exists(file, usual + "/time"))
    return usual;
  for (const std::string group : {particles_group, system_group}) {
    if (!hdf5::exists(file, group)) continue;
    for (const std::string& name : hdf5::names(hdf5::open_group(file, group)))
      if (const std::string element = group + "/" + name; hdf5::exists(file, element + "/time")) return element;
  }
  return "";
}

std::vector<Series> series_in(const hdf5::Handle& file) {
  const std::string home = element_with_time(file);
  if (home.empty()) throw hdf5::Error("no frames");
  const hdf5::Handle time(H5Dopen2(file, (home + "/time").c_str(), H5P_DEFAULT));
  const std::string unit = hdf5::text(time, "unit");
  std::vector<Series> all = clock(home, unit.empty() ? pure_number : unit);
  add_elements(file, Column::Of::particles, particles_group, all);
  add_elements(file, Column::Of::system, system_group, all);
  add_lists(file, all);
  // Files of older versions have one row of three edges for all frames.
  const Series edges = series_of_box_edges("");
  if (const std::string element = element_of(edges); hdf5::exists(file, element) && hdf5::is_group(file, element))
    all.push_back(series_at(file, edges.of, edges.name, edges.dataset));
  return all;
}

Rows rows_of(Frame frame, std::size_t particles, const std::vector<Series>& series, std::int64_t step,
             std::map<std::string, std::int64_t>& ends, const std::vector<double>& box_edges) {
  const std::vector<std::size_t> indices = series_indices(series_of(frame, particles), series, frame);
  Rows rows(series.size());
  rows[0] = std::vector<std::int64_t>{step};
  rows[1] = std::vector<double>{frame.time};
  for (std::size_t k = 0; k < indices.size(); ++k) {
    Column& column = frame.columns[k];
    if (column.of == Column::Of::list) {
      ends[column.name] += static_cast<std::int64_t>(column.rows());
      const std::size_t end = find(series, ends_of(column.name).dataset);
      rows[end] = std::vector<std::int64_t>{ends[column.name]};
    }
    rows[indices[k]] = std::move(column.values);
  }
  const auto edges = std::ranges::find_if(series, is_box_edges);
  if (edges != series.end()) rows[static_cast<std::size_t>(edges - series.begin())] = box_edges;
  return rows;
}

std::span<const std::byte> bytes_of(const Values& values) {
  return std::visit([](const auto& numbers) { return std::as_bytes(std::span(numbers)); }, values);
}

std::uint64_t bytes_of(const Rows& rows) {
  std::uint64_t bytes = 0;
  for (const Values& values : rows) bytes += bytes_of(values).size();
  return bytes;
}

hsize_t rows_in(const Values& values, const Series& series) {
  return series.of == Column::Of::list ? bytes_of(values).size() / series.row_bytes() : 1;
}

Values read_rows(hid_t file, const std::string& dataset, const Series& series, hsize_t first, hsize_t count) {
  return std::visit(
      [&]<class Number>(const std::vector<Number>&) -> Values {
        return hdf5::get_rows<Number>(file, dataset, first, count);
      },
      series.kind);
}

void put_frames(const hdf5::Handle& file, const std::string& prefix, const std::vector<Series>& series,
                std::span<const Rows> frames, bool compressed) {
  put_all(file, prefix, series, [&](hid_t group, const std::string& name, const Series& each, std::size_t k) {
    std::vector<std::byte> bytes;
    for (const Rows& rows : frames) {
      const auto added = bytes_of(rows[k]);
      bytes.insert(bytes.end(), added.begin(), added.end());
    }
    const hsize_t rows = each.row_bytes() > 0 ? bytes.size() / each.row_bytes() : frames.size();
    const hdf5::Handle space = hdf5::dataspace(rows_of_shape(rows, each.row));
    const hdf5::Handle creation = compressed ? storage(each, rows) : hdf5::Handle(H5Pcreate(H5P_DATASET_CREATE));
    const hid_t type = native(each.kind);
    hdf5::Handle dataset(H5Dcreate2(group, name.c_str(), type, space, H5P_DEFAULT, creation, H5P_DEFAULT));
    if (!bytes.empty()) hdf5::check(H5Dwrite(dataset, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, bytes.data()));
    return dataset;
  });
}

std::vector<std::uint64_t> allocate_rows(const hdf5::Handle& file, const std::vector<Series>& series,
                                         std::span<const hsize_t> rows) {
  const hdf5::Handle creation(H5Pcreate(H5P_DATASET_CREATE));
  hdf5::check(H5Pset_alloc_time(creation, H5D_ALLOC_TIME_EARLY));
  hdf5::check(H5Pset_fill_time(creation, H5D_FILL_TIME_NEVER));
  std::vector<std::uint64_t> offsets;
  put_all(file, "", series, [&](hid_t group, const std::string& name, const Series& each, std::size_t k) {
    const hdf5::Handle space = hdf5::dataspace(rows_of_shape(rows[k], each.row));
    hdf5::Handle dataset(H5Dcreate2(group, name.c_str(), native(each.kind), space, H5P_DEFAULT, creation, H5P_DEFAULT));
    offsets.push_back(H5Dget_offset(dataset));
    return dataset;
  });
  return offsets;
}

void put_virtual(const hdf5::Handle& file, const std::vector<Series>& series, std::span<const RowSource> parts) {
  put_all(file, "", series, [&](hid_t group, const std::string& name, const Series& each, std::size_t k) {
    hsize_t all = 0;
    for (const RowSource& part : parts) all += part.rows[k];
    const hdf5::Shape shape = rows_of_shape(all, each.row);
    const hdf5::Handle space = hdf5::dataspace(shape);
    const hdf5::Handle creation(H5Pcreate(H5P_DATASET_CREATE));
    set_missing(creation, each);
    hsize_t first = 0;
    for (const RowSource& part : parts) {
      if (part.rows[k] == 0 || each.row_bytes() == 0) continue;
      select(space, shape, first, part.rows[k]);
      const hdf5::Handle source = hdf5::dataspace(rows_of_shape(part.rows[k], each.row));
      hdf5::check(
          H5Pset_virtual(creation, space, part.file.c_str(), ("/" + part.prefix + each.dataset).c_str(), source));
      first += part.rows[k];
    }
    hdf5::check(H5Sselect_all(space));
    return hdf5::Handle(H5Dcreate2(group, name.c_str(), native(each.kind), space, H5P_DEFAULT, creation, H5P_DEFAULT));
  });
}

void put_columns(hid_t group, const std::vector<Column>& columns) {
  for (const Column& column : columns) {
    hdf5::Shape shape;
    if (column.of != Column::Of::system) shape.push_back(column.rows());
    if (column.width > 0) shape.push_back(column.width);
    std::visit(
        [&]<class Number>(const std::vector<Number>& values) {
          hdf5::put<Number>(group, column.name, values, shape, column.unit);
        },
        column.values);
  }
}

std::vector<Column> get_columns(hid_t group) {
  std::vector<Column> columns;
  for (const std::string& name : hdf5::names(group)) {
    const hdf5::Handle dataset(H5Dopen2(group, name.c_str(), H5P_DEFAULT));
    const hdf5::Shape shape = hdf5::shape(group, name);
    if (shape.empty() || shape.size() > 2) throw hdf5::Error(name + " is no list");
    const Series series{.kind = kind_of(dataset)};
    columns.push_back({.name = name,
                       .unit = hdf5::text(dataset, "unit"),
                       .of = Column::Of::list,
                       .width = shape.size() > 1 ? shape[1] : 0,
                       .values = read_rows(group, name, series, 0, shape[0])});
  }
  return columns;
}

}  // namespace lichtenberg
