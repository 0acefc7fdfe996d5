#include <fmt/format.h>
#include <fmt/ranges.h>
#include <petscsys.h>
#include <sched.h>
#include <sundials/sundials_version.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <nlohmann/json.hpp>

#include "src/commands/streams.hpp"
#include "src/commands/work_precision.hpp"
#include "src/record/provenance.hpp"
#include "src/version.hpp"

namespace lichtenberg::work_precision {
namespace {

std::string versions() {
  const Version own = lichtenberg_version();
  std::array<char, 32> sundials{};
  SUNDIALSGetVersion(sundials.data(), static_cast<int>(sundials.size()));
  return fmt::format("lichtenberg {} ({}), PETSc {}.{}.{}, SUNDIALS {}, {}", own.number, own.commit,
                     PETSC_VERSION_MAJOR, PETSC_VERSION_MINOR, PETSC_VERSION_SUBMINOR, sundials.data(), own.compiler);
}

double load_average() {
  double load = 0;
  return getloadavg(&load, 1) == 1 ? load : 0;
}

bool shows_evaluations(const Diagram& diagram) {
  return std::ranges::any_of(diagram.points, [](const Point& point) { return point.evaluations > 0; });
}

void print_heading(const Diagram& diagram, const Circumstances& here) {
  fmt::print("{}: {}\n", printable(here.scene), diagram.title);
  fmt::print("  errors      {}\n", diagram.measure);
  fmt::print("  reference   {}; its own error is about", diagram.reference);
  for (const double error : diagram.reference_errors) fmt::print(" {:.1e}", error);
  fmt::print("\n  time        {} of a run from nothing: the median of up to five after one that does not count\n",
             diagram.clock);
  if (shows_evaluations(diagram))
    fmt::print("  evaluations of an operator, in residual evaluations on the whole grid\n");
  const bool busy = here.load > 0.5;
  fmt::print("  machine     {}, {} core{}, load {:.1f} before the start{}\n", here.processor, here.cores,
             here.cores == 1 ? "" : "s", here.load, busy ? ": others were at work, and times may be too long" : "");
  fmt::print("  versions    {}\n\n", here.versions);
}

/// Of the error in the first quantity, by work: error ~ work^-order, from one point of a method to its next.
std::optional<double> order(const Point& before, const Point& point) {
  if (before.method != point.method || before.work == point.work) return {};
  const double steps = static_cast<double>(point.work) / static_cast<double>(before.work);
  return -std::log(point.errors.front() / before.errors.front()) / std::log(steps);
}

bool shows_order(const Diagram& diagram) { return diagram.quantities.size() == 1; }

/// Of a column under this heading.
std::size_t column_width(const std::string& heading, std::size_t least) { return std::max(least, heading.size() + 2); }

void print_points(const Diagram& diagram) {
  constexpr auto heading = "{:<26}{:<34}";
  fmt::print(heading, "method", "settings");
  for (const std::string& quantity : diagram.quantities) fmt::print("{:>{}}", quantity, column_width(quantity, 12));
  if (shows_order(diagram)) fmt::print("{:>8}", "order");
  fmt::print("{:>12}{:>7}{:>{}}", "ms", "cores", diagram.work, column_width(diagram.work, 14));
  if (shows_evaluations(diagram)) fmt::print("{:>13}", "evaluations");
  fmt::print("{:>9}\n", "MiB");
  const Point* before = nullptr;
  for (const Point& point : diagram.points) {
    fmt::print(heading, point.method, to_string(point.settings));
    for (std::size_t q = 0; q < point.errors.size(); ++q)
      fmt::print("{:>{}.1e}", point.errors[q], column_width(diagram.quantities[q], 12));
    if (shows_order(diagram)) {
      const std::optional<double> slope = before ? order(*before, point) : std::nullopt;
      fmt::print("{:>8}", slope ? fmt::format("{:.2f}", *slope) : "");
    }
    fmt::print("{:>12.4g}{:>7.2f}{:>{}}", 1e3 * point.seconds, point.cores, point.work, column_width(diagram.work, 14));
    if (shows_evaluations(diagram))
      fmt::print("{:>13}", point.evaluations > 0 ? fmt::format("{:.1f}", point.evaluations) : "");
    fmt::print("{:>9}\n", point.mebibytes ? fmt::format("{:.0f}", *point.mebibytes) : "");
    before = &point;
  }
}

/// One line a method and reason.
void print_left_out(const Diagram& diagram) {
  if (diagram.left_out.empty()) return;
  fmt::print("\nleft out\n");
  for (auto first = diagram.left_out.begin(); first != diagram.left_out.end();) {
    const auto last = std::find_if(first, diagram.left_out.end(), [&](const LeftOut& other) {
      return other.method != first->method || other.reason != first->reason;
    });
    std::vector<std::string> settings;
    for (auto entry = first; entry != last; ++entry) settings.push_back(to_string(entry->settings));
    const bool measured = std::ranges::find(diagram.points, first->method, &Point::method) != diagram.points.end();
    fmt::print("  {:<26}{}{}\n", first->method, measured ? fmt::format("{}: ", fmt::join(settings, "; ")) : "",
               first->reason);
    first = last;
  }
}

void print_prices(const Diagram& diagram) {
  fmt::print("\nprice list: the cheapest point with an error of at most\n");
  for (std::size_t q = 0; q < diagram.quantities.size(); ++q)
    for (const Price& price : price_list(diagram, q)) {
      fmt::print("  {:<16}1e{:<6.0f}", diagram.quantities[q], std::log10(price.error));
      if (price.point == nullptr)
        fmt::print("none is that good\n");
      else
        fmt::print("{:>10.4g} ms   {}, {}\n", 1e3 * price.point->seconds, price.point->method,
                   to_string(price.point->settings));
    }
}

nlohmann::ordered_json settings_json(const Settings& settings) {
  nlohmann::ordered_json json = nlohmann::ordered_json::object();
  for (const auto& [name, value] : settings) json[name] = value;
  return json;
}

nlohmann::ordered_json point_json(const Diagram& diagram, const Point& point) {
  nlohmann::ordered_json json{{"method", point.method}, {"settings", settings_json(point.settings)}};
  for (std::size_t q = 0; q < point.errors.size(); ++q) json["errors"][diagram.quantities[q]] = point.errors[q];
  json["seconds"] = point.seconds;
  json["cores"] = point.cores;
  json["work"] = point.work;
  if (point.evaluations > 0) json["evaluations"] = point.evaluations;
  if (point.mebibytes) json["mebibytes"] = *point.mebibytes;
  return json;
}

nlohmann::ordered_json prices_json(const Diagram& diagram, std::size_t quantity) {
  nlohmann::ordered_json rows = nlohmann::ordered_json::array();
  for (const Price& price : price_list(diagram, quantity))
    if (price.point != nullptr)
      rows.push_back({{"error", price.error},
                      {"method", price.point->method},
                      {"settings", settings_json(price.point->settings)},
                      {"seconds", price.point->seconds}});
  return rows;
}

}  // namespace

Circumstances circumstances(const Scene& scene) {
  const Provenance here = provenance();
  return {scene.path, here.processor, here.cores, load_average(), versions()};
}

void print(const Diagram& diagram, const Circumstances& here) {
  print_heading(diagram, here);
  print_points(diagram);
  print_left_out(diagram);
  print_prices(diagram);
}

nlohmann::ordered_json to_json(const Diagram& diagram, const Circumstances& here) {
  nlohmann::ordered_json json{{"scene", here.scene},         {"title", diagram.title},
                              {"processor", here.processor}, {"cores", here.cores},
                              {"load", here.load},           {"versions", here.versions},
                              {"errors", diagram.measure},   {"reference", diagram.reference},
                              {"work", diagram.work},        {"time", diagram.clock}};
  for (std::size_t q = 0; q < diagram.quantities.size(); ++q)
    json["reference_errors"][diagram.quantities[q]] = diagram.reference_errors[q];
  for (const auto& [name, description] : diagram.methods) json["methods"][name] = description;
  json["points"] = nlohmann::ordered_json::array();
  for (const Point& point : diagram.points) json["points"].push_back(point_json(diagram, point));
  json["left_out"] = nlohmann::ordered_json::array();
  for (const LeftOut& entry : diagram.left_out)
    json["left_out"].push_back(
        {{"method", entry.method}, {"settings", settings_json(entry.settings)}, {"reason", entry.reason}});
  for (std::size_t q = 0; q < diagram.quantities.size(); ++q)
    json["prices"][diagram.quantities[q]] = prices_json(diagram, q);
  return json;
}

}  // namespace lichtenberg::work_precision
