#include "src/record/result.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

#include "solvers/error.hpp"
#include "src/record/layout.hpp"
#include "src/version.hpp"

namespace lichtenberg {
namespace {

constexpr const char* conductors = "/particles/conductors/";
constexpr double largest_number = 1e70;  ///< in units of the file; sums of fourth powers are finite

/// Columns of particles whose numbers are finite.
constexpr std::array<std::string_view, 7> defined_columns{
    "position", "velocity", "angular_velocity", "force", "charge", "potential", "dipole"};

/// Throws hdf5::Error for a number of at least largest_number. `may_be_undefined`: infinity and NaN
/// are allowed.
void check_numbers(const std::string& name, int frame, const std::vector<double>& values, bool may_be_undefined) {
  for (const double value : values)
    if (!(std::abs(value) < largest_number) && !(may_be_undefined && !std::isfinite(value)))
      throw hdf5::Error(fmt::format("{} of frame {} holds the number {}, and only finite ones below {:g} are allowed",
                                    name, frame, value, largest_number));
}

/// Removes datasets of an earlier analysis that are not written again. The others are overwritten in place, so that the
/// file does not grow.
void remove_others(hid_t group, const std::vector<Column>& columns) {
  for (const std::string& name : hdf5::names(group))
    if (std::ranges::find(columns, name, &Column::name) == columns.end())
      hdf5::check(H5Ldelete(group, name.c_str(), H5P_DEFAULT));
}

}  // namespace

/// Calls `reading` and reports any HDF5 error as damage of the file.
template <class Reading>
auto Result::guarded(Reading reading) const {
  try {
    return reading();
  } catch (const hdf5::Error& error) {
    throw InputError(fmt::format("the result file {} is damaged and cannot be analysed ({})", path_, error.what()));
  }
}

Result::Result(const std::string& path) : path_(path) {
  guarded([&] {
    file_.emplace(path, "analysed");
    const std::string time = std::string(conductors) + "position/time", ends = "network/contacts_end";
    if (!file_->has(time) || file_->frames() == 0)
      throw InputError(fmt::format("the result file {} holds no frames: there is nothing to analyse", path));
    times_ = file_->rows<double>(time);
    if (static_cast<std::int64_t>(times_.size()) != file_->frames() ||
        !std::ranges::all_of(times_, [](double instant) { return std::isfinite(instant); }))
      throw hdf5::Error("the frames do not have one finite time each");
    if (file_->has(ends)) contact_ends_ = file_->rows<std::int64_t>(ends);
    conductors_ = radius().size();
  });
}

Scene Result::scene(const EffectKinds& kinds, const StopRequest& stop) const {
  const std::string text = guarded([&] { return hdf5::get_text(file_->file(), "scene/text"); });
  const bool elsewhere =
      guarded([&] { return !hdf5::text(hdf5::open_group(file_->file(), "scene"), "started_from").empty(); });
  return parse_scene(text, fmt::format("{}:/scene/text", path_), kinds, {}, stop,
                     elsewhere ? bodies(0) : std::vector<Conductor>{});
}

std::vector<Conductor> Result::bodies(int index) const {
  const std::vector<double> radii = radius(), position = frame(index).reals("position");
  if (position.size() != 3 * radii.size())
    throw InputError(
        fmt::format("the result file {} is damaged and cannot be analysed (it has {} positions for {} bodies)", path_,
                    position.size() / 3, radii.size()));
  std::vector<Conductor> bodies;
  for (std::size_t i = 0; i < radii.size(); ++i)
    bodies.push_back({.position = {position[3 * i], position[3 * i + 1], position[3 * i + 2]}, .radius = radii[i]});
  return bodies;
}

std::vector<double> Result::radius() const {
  return guarded([&] { return radii_in(file_->file()); });
}

std::vector<double> Result::mass() const {
  return guarded([&] {
    std::vector<double> mass = hdf5::get<double>(file_->file(), std::string(conductors) + "mass");
    if (mass.size() != conductors_)
      throw hdf5::Error(fmt::format("there are {} masses of {} conductors", mass.size(), conductors_));
    return mass;
  });
}

std::vector<double> Result::reals(const std::string& name, int index, std::size_t count) const {
  if (!file_->has(name)) throw hdf5::Error(name + " is missing");
  std::vector<double> row = file_->rows<double>(name + "/value", index, 1);
  if (row.size() != count)
    throw hdf5::Error(fmt::format("{} has {} numbers a frame where there should be {}", name, row.size(), count));
  return row;
}

Frame Result::frame(int index) const {
  return guarded([&] {
    Frame frame{.time = times_.at(index)};
    for (const std::string& name : names_in("particles/conductors")) {
      std::vector<double> values = file_->rows<double>(conductors + name + "/value", index, 1);
      if (conductors_ == 0 || values.size() % conductors_ != 0)
        throw hdf5::Error(fmt::format("{} has not one row for each of {} conductors", name, conductors_));
      check_numbers(name, index, values, std::ranges::find(defined_columns, name) == defined_columns.end());
      const std::size_t numbers = values.size() / conductors_;
      frame.add_particles(name, "", std::move(values), numbers == 1 ? 0 : numbers);
    }
    for (const std::string& name : names_in("observables")) {
      std::vector<double> values = file_->rows<double>("observables/" + name + "/value", index, 1);
      check_numbers(name, index, values, true);
      const hdf5::Handle element = hdf5::open_group(file_->file(), "observables/" + name);
      std::vector<std::string> labels = hdf5::text_attribute(element, "terminals");
      const std::size_t width = labels.empty() && values.size() == 1 ? 0 : values.size();
      frame.columns.push_back({name, "", Column::Of::system, width, std::move(values), std::move(labels)});
    }
    return frame;
  });
}

ConductorFrame Result::conductor_frame(int index) const {
  return guarded([&] {
    try {
      return lichtenberg::conductor_frame(frame(index));
    } catch (const InputError& error) {
      throw hdf5::Error(error.what());
    }
  });
}

/// Returns the names of the columns in this group.
std::vector<std::string> Result::names_in(const std::string& group) const {
  std::vector<std::string> names;
  if (!hdf5::exists(file_->file(), group)) return names;
  for (const std::string& name : hdf5::names(hdf5::open_group(file_->file(), group)))
    if (const std::string path = group + "/" + name; hdf5::is_group(file_->file(), path) && file_->has(path + "/value"))
      names.push_back(name);
  return names;
}

std::vector<double> Result::observable(const std::string& name, int index) const {
  return guarded([&] {
    const std::string element = "observables/" + name;
    return file_->has(element) ? file_->rows<double>(element + "/value", index, 1) : std::vector<double>{};
  });
}

bool Result::has_network() const {
  return guarded([&] { return file_->has(std::string(conductors) + "successor"); });
}

std::vector<std::string> Result::warnings() const {
  return guarded([&] { return file_->warnings(); });
}

std::vector<int> Result::successor(int index) const {
  return guarded([&] {
    std::vector<int> result;
    for (const double next : reals(std::string(conductors) + "successor", index, conductors_)) {
      if (!(next >= analysis::unconnected && next < static_cast<double>(conductors_)))
        throw hdf5::Error(fmt::format("successor {} is no conductor", next));
      result.push_back(static_cast<int>(next));
    }
    return result;
  });
}

std::optional<std::vector<analysis::Edge>> Result::contacts(int index) const {
  return guarded([&]() -> std::optional<std::vector<analysis::Edge>> {
    if (contact_ends_.empty()) return {};
    const std::vector<std::int32_t> pairs = file_->list<std::int32_t>("contacts", contact_ends_, index);
    std::vector<analysis::Edge> contacts;
    for (std::size_t k = 0; k + 1 < pairs.size(); k += 2) {
      const int i = pairs[k], j = pairs[k + 1];
      if (i < 0 || std::max(i, j) >= static_cast<int>(conductors_) || j < analysis::to_ground)
        throw hdf5::Error(fmt::format("contact {} - {} is not one of conductors", i, j));
      contacts.emplace_back(i, j);
    }
    return contacts;
  });
}

void Result::put_analysis(const std::vector<Column>& columns) const {
  try {
    store(*file_, [&](const hdf5::Handle& file) {
      const hdf5::Handle group = hdf5::open_group(file, "analysis");
      remove_others(group, columns);
      hdf5::put_attribute(group, "version", lichtenberg_version().number);
      hdf5::put_attribute(group, "commit", lichtenberg_version().commit);
      put_columns(group, columns);
    });
  } catch (const std::exception& error) {
    throw Failure(fmt::format("the analysis is not in {} ({}); the file was left alone", path_, error.what()));
  }
}

}  // namespace lichtenberg
