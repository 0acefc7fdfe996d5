#include "src/record/result.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "solvers/error.hpp"
#include "src/effects/read_scene.hpp"
#include "src/record/layout.hpp"
#include "src/version.hpp"

namespace lichtenberg {
namespace {

constexpr const char* conductors = "/particles/conductors/";

void put_column(hid_t group, const Column& column, std::size_t frames) {
  hdf5::Shape shape{frames};
  if (column.width > 0) shape.push_back(column.width);
  std::visit(
      [&]<class Number>(const std::vector<Number>& values) {
        hdf5::put<Number>(group, column.name, values, shape, column.unit);
      },
      column.values);
}

void remove_others(hid_t group, const std::vector<Column>& columns) {
  for (const std::string& name : hdf5::names(group))
    if (std::ranges::find(columns, name, &Column::name) == columns.end())
      hdf5::check(H5Ldelete(group, name.c_str(), H5P_DEFAULT));
}

}  // namespace

hdf5::Handle load_result(const std::string& path, const std::string& used) {
  if (!std::filesystem::exists(path)) throw InputError(fmt::format("{} does not exist", path));
  if (!hdf5::is_hdf5(path))
    throw InputError(fmt::format("{} is no HDF5 file: only a result file of `lichtenberg run` can be {}", path, used));
  hdf5::Handle file = hdf5::load(path);
  const std::optional<int> format = hdf5::integer_attribute(file, "lichtenberg_result");
  if (!format)
    throw InputError(
        fmt::format("{} was not written by `lichtenberg run`: only its result files can be {}", path, used));
  if (*format != result_format)
    throw InputError(
        fmt::format("{} has result format {}, but with this version of lichtenberg only format {} can be {}", path,
                    *format, result_format, used));
  return file;
}

/// Whatever HDF5 has against the file is the file's fault.
template <class Reading>
auto Result::guarded(Reading reading) const {
  try {
    return reading();
  } catch (const hdf5::Error& error) {
    throw InputError(fmt::format("{} is damaged and cannot be analysed ({})", path_, error.what()));
  }
}

Result::Result(const std::string& path) : path_(path) {
  guarded([&] {
    identity_ = identity_of(path);
    file_ = load_result(path, "analysed");
    if (!hdf5::exists(*file_, std::string(conductors) + "position/time"))
      throw InputError(fmt::format("{} holds no frames: there is nothing to analyse", path));
    times_ = hdf5::get<double>(*file_, std::string(conductors) + "position/time");
    if (times_.empty()) throw InputError(fmt::format("{} holds no frames: there is nothing to analyse", path));
    conductors_ = radius().size();
  });
}

Scene Result::scene() const {
  const std::string text = guarded([&] { return hdf5::get_text(*file_, "scene/text"); });
  return parse_scene(text, fmt::format("{}:/scene/text", path_));
}

std::vector<double> Result::radius() const {
  return guarded([&] { return hdf5::get<double>(*file_, std::string(conductors) + "radius"); });
}

std::vector<double> Result::mass() const {
  return guarded([&] {
    std::vector<double> mass = hdf5::get<double>(*file_, std::string(conductors) + "mass");
    if (mass.size() != conductors_)
      throw hdf5::Error(fmt::format("there are {} masses of {} conductors", mass.size(), conductors_));
    return mass;
  });
}

std::vector<double> Result::reals(const std::string& name, int index, std::size_t count) const {
  if (!hdf5::exists(*file_, name)) throw hdf5::Error(name + " is missing");
  std::vector<double> row = hdf5::get_rows<double>(*file_, name + "/value", index, 1);
  if (row.size() != count)
    throw hdf5::Error(fmt::format("{} has {} numbers a frame where there should be {}", name, row.size(), count));
  return row;
}

Frame Result::frame(int index) const {
  return guarded([&] {
    Frame frame{.time = times_.at(index)};
    const auto read = [&](const std::string& parent, Column::Of of) {
      if (!hdf5::exists(*file_, parent)) return;
      const hdf5::Handle group(H5Gopen2(*file_, parent.c_str(), H5P_DEFAULT));
      for (const std::string& name : hdf5::names(group)) {
        const std::string value = parent + "/" + name + "/value";
        if (hdf5::exists(*file_, value)) frame.columns.push_back(column(value, name, of, index));
      }
    };
    read("particles/conductors", Column::Of::particles);
    read("observables", Column::Of::system);
    return frame;
  });
}

Column Result::column(const std::string& path, const std::string& name, Column::Of of, int index) const {
  const hdf5::Shape shape = hdf5::shape(*file_, path);
  const std::size_t row = of == Column::Of::particles ? 2 : 1;  // the dimension that counts a row's numbers
  if (shape.size() < row || (of == Column::Of::particles && shape[1] != conductors_))
    throw hdf5::Error(fmt::format("{} has not one row for each of {} conductors", name, conductors_));
  return {.name = name,
          .unit = "",
          .of = of,
          .width = shape.size() > row ? shape[row] : 0,
          .values = hdf5::get_rows<double>(*file_, path, index, 1)};
}

std::vector<double> Result::observable(const std::string& name, int index) const {
  return guarded([&] {
    const std::string element = "observables/" + name;
    return hdf5::exists(*file_, element) ? hdf5::get_rows<double>(*file_, element + "/value", index, 1)
                                         : std::vector<double>{};
  });
}

bool Result::has_network() const {
  return guarded([&] { return hdf5::exists(*file_, std::string(conductors) + "successor"); });
}

std::vector<int> Result::successor(int index) const {
  return guarded([&] {
    std::vector<int> result;
    for (const double next : reals(std::string(conductors) + "successor", index, conductors_)) {
      result.push_back(static_cast<int>(next));
      if (next < analysis::unconnected || next >= static_cast<double>(conductors_))
        throw hdf5::Error(fmt::format("successor {} is no conductor", next));
    }
    return result;
  });
}

std::optional<std::vector<analysis::Contact>> Result::contacts(int index) const {
  return guarded([&]() -> std::optional<std::vector<analysis::Contact>> {
    const std::vector<std::int64_t> ends = contact_ends(*file_);
    if (ends.size() != times_.size()) return {};
    const std::int64_t first = index > 0 ? ends[index - 1] : 0;
    const std::vector<analysis::Contact> contacts = contacts_between(*file_, first, ends[index]);
    for (const auto& [i, j] : contacts)
      if (i < 0 || std::max(i, j) >= static_cast<int>(conductors_) || j < analysis::to_ground)
        throw hdf5::Error(fmt::format("contact {} - {} is not one of conductors", i, j));
    return contacts;
  });
}

void Result::put_analysis(const std::vector<Column>& columns) const {
  try {
    const hdf5::Handle group = hdf5::open_group(*file_, "analysis");
    hdf5::put_attribute(group, "version", lichtenberg_version().number);
    hdf5::put_attribute(group, "commit", lichtenberg_version().commit);
    remove_others(group, columns);
    for (const Column& column : columns) put_column(group, column, times_.size());
    replace_if_same(path_, identity_, hdf5::image(*file_));
  } catch (const std::exception& error) {
    throw Failure(fmt::format("the analysis is not in {} ({}); the file was left alone", path_, error.what()));
  }
}

}  // namespace lichtenberg
