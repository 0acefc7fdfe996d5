#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "src/commands/analyse.hpp"
#include "src/commands/analyse_columns.hpp"
#include "src/commands/streams.hpp"

namespace lichtenberg {
namespace {

using Frames = std::vector<FrameAnalysis>;
using analysis::DegreeRelations;
using analysis::Distribution;
using analysis::PowerLaw;

using FrameColumns = Columns<FrameAnalysis>;

std::vector<double> in_order(const Distribution& d) {
  return {d.least, d.quarter, d.median, d.three_quarters, d.largest, d.mean, d.deviation};
}

std::vector<double> fractions(std::vector<int> number, int total) {
  std::vector<double> result;
  for (const int n : number) result.push_back(total > 0 ? static_cast<double>(n) / total : 0);
  return result;
}

void add_degrees(FrameColumns& columns, int conductors) {
  columns.integer("connected", [](auto& f) { return f.topology.network.degrees.connected; });
  columns.integer("grounded", [](auto& f) { return f.topology.network.degrees.grounded; });
  columns.integer("loops", [](auto& f) { return f.topology.network.degrees.loops; });
  columns.integer("endpoints", [](auto& f) { return f.topology.network.degrees.endpoints(); });
  columns.integer("branch_points", [](auto& f) { return f.topology.network.degrees.branch_points(); });
  columns.real("endpoint_fraction", "1", [](auto& f) { return f.topology.network.degrees.fraction(1); });
  columns.real("branch_fraction", "1", [](auto& f) { return f.topology.network.degrees.branching(); });
  columns.integers("degree_number", [](auto& f) { return f.topology.network.degrees.number; });
  columns.reals("degree_fraction", "1", [](auto& f) {
    return fractions(f.topology.network.degrees.number, f.topology.network.degrees.connected);
  });
  columns.integers("emst_degree_number", [](auto& f) { return f.topology.minimum.number; });
  columns.reals("emst_degree_fraction", "1", [=](auto& f) { return fractions(f.topology.minimum.number, conductors); });
}

struct Relation {
  const char *name, *in_words;
  double DegreeRelations::*residual;
};

constexpr Relation relations[] = {
    {"residual_7_6", "7.6   sum f_j = 1", &DegreeRelations::normalization},
    {"residual_7_7", "7.7   sum (j - 2) f_j = c", &DegreeRelations::branches},
    {"residual_7_7_printed", "      as printed, c = -1/N", &DegreeRelations::branches_printed},
    {"residual_7_8", "7.8   sum j f_j = 2 + c", &DegreeRelations::mean_degree},
    {"residual_7_8_printed", "      as printed, c = 0", &DegreeRelations::mean_degree_printed},
    {"residual_7_9_f3", "7.9   f_3 with c and degrees above 4", &DegreeRelations::f3},
    {"residual_7_9_f3_printed", "      as printed, 2 B - f_1", &DegreeRelations::f3_printed},
    {"residual_7_9_f4", "7.9   f_4 with c and degrees above 4", &DegreeRelations::f4},
    {"residual_7_9_f4_printed", "      as printed, f_1 - B", &DegreeRelations::f4_printed}};

void add_strahler(FrameColumns& columns) {
  columns.integers("strahler_number", [](auto& f) { return f.topology.orders.conductors; });
  columns.integers("strahler_streams", [](auto& f) { return f.topology.orders.streams; });
  columns.integers("emst_strahler_number", [](auto& f) { return f.topology.minimum.strahler.conductors; });
  columns.integers("emst_strahler_streams", [](auto& f) { return f.topology.minimum.strahler.streams; });
}

void add_lengths(FrameColumns& columns, double radius) {
  columns.reals("edge_length", "m", [](auto& f) { return in_order(f.topology.edge_length); });
  columns.reals("edge_length_in_radii", "1", [=](auto& f) {
    std::vector<double> lengths = in_order(f.topology.edge_length);
    for (double& length : lengths) length /= radius;
    return lengths;
  });
  columns.real("tree_length", "m", [](auto& f) { return f.topology.tree_length; });
  columns.real("emst_length", "m", [](auto& f) { return f.topology.minimum.length; });
  columns.integer("emst_shared_edges", [](auto& f) { return f.topology.minimum.shared; });
}

void add_dimension(FrameColumns& columns, const std::string& name, std::optional<PowerLaw> analysis::Topology::*law) {
  const auto law_of = [=](const FrameAnalysis& f) {
    return (f.topology.*law).value_or(PowerLaw{NAN, NAN, NAN, NAN, 0});
  };
  columns.real(name, "1", [=](auto& f) { return law_of(f).exponent; });
  columns.real(name + "_error", "1", [=](auto& f) { return law_of(f).standard_error; });
  columns.reals(name + "_range", "m", [=](auto& f) { return std::vector{law_of(f).from, law_of(f).to}; });
}

void add_power(FrameColumns& columns) {
  columns.real("power_source", "W", [](auto& f) { return f.power.source; });
  columns.real("power_drag", "W", [](auto& f) { return f.power.drag; });
  columns.real("power_field", "W", [](auto& f) { return f.power.field; });
  columns.real("power_dissipated", "W", [](auto& f) { return f.dissipated.value_or(NAN); });
  columns.real("kinetic_energy", "J", [](auto& f) { return f.power.kinetic; });
  columns.real("elastic_energy", "J", [](auto& f) { return f.power.elastic; });
}

/// Adds the recorded quantities of a run with a circuit. All frames have the same ones.
void add_recorded(FrameColumns& columns, const Frames& frames) {
  if (frames.empty()) return;
  for (std::size_t k = 0; k < frames.front().recorded.size(); ++k) {
    const RecordedQuantity& first = frames.front().recorded[k];
    if (first.by_terminal)
      columns.reals(first.name, first.unit, [=](auto& f) { return f.recorded[k].values; });
    else
      columns.real(first.name, first.unit, [=](auto& f) { return f.recorded[k].values.front(); });
  }
}

// Table.

void print_head() {
  fmt::print("{:>6} {:>10} {:>5} {:>5} {:>5}  {:^29} {:>5} {:>6} {:>6} {:>6} {:>6}  {:^23} {:>10}\n", "", "", "", "",
             "", "degrees of the tree", "", "", "edge", "D of", "D of", "degrees of the EMST", "dissipated");
  fmt::print(
      "{:>6} {:>10} {:>5} {:>5} {:>5}  {:>5} {:>5} {:>5} {:>5} {:>5} {:>5} {:>6} {:>6} {:>6} {:>6}  {:>5} {:>5} "
      "{:>5} {:>5} {:>10}\n",
      "frame", "t (s)", "M", "ends", "forks", "f1", "f2", "f3", "f4", "f>4", "loops", "orders", "/ R", "boxes",
      "masses", "f1", "f2", "f3", "f4", "(W)");
}

/// Prints the meaning of the columns below the table.
void print_legend() {
  fmt::print(
      "\nM: conductors in contact with the ground. ends, forks: those of degree 1, of 3 and more. f1 ... f>4: shares "
      "of M by\ndegree, the ground counting as one contact. loops: contacts beyond those of a tree. orders: the "
      "highest Strahler number.\nedge / R: mean length between centres over the mean radius. D of boxes, of masses: "
      "dimensions of the tree, - where it\nis too small. EMST: the Euclidean minimum spanning tree of all centres. "
      "dissipated: mean power since the previous frame.\n");
}

std::string dimension(const std::optional<PowerLaw>& law) { return law ? fmt::format("{:.2f}", law->exponent) : "-"; }

double fraction_above_4(const analysis::DegreeDistribution& degrees) {
  double sum = 0;
  for (int j = 5; j < static_cast<int>(degrees.number.size()); ++j) sum += degrees.fraction(j);
  return sum;
}

void print_line(const AnalysedRun& run, const FrameAnalysis& found) {
  const analysis::Topology& t = found.topology;
  const analysis::DegreeDistribution& d = t.network.degrees;
  fmt::print("{:>6} {:>10.6g} {:>5} {:>5} {:>5} ", found.frame, found.time, d.connected, d.endpoints(),
             d.branch_points());
  for (int j = 1; j <= 4; ++j) fmt::print(" {:>5.3f}", d.fraction(j));
  fmt::print(" {:>5.3f} {:>5} {:>6} {:>6.3f} {:>6} {:>6} ", fraction_above_4(d), d.loops, t.orders.highest(),
             t.edge_length.mean / run.radius, dimension(t.boxes), dimension(t.masses));
  const std::vector<double> emst = fractions(t.minimum.number, run.conductors);
  for (std::size_t j = 1; j <= 4; ++j) fmt::print(" {:>5.3f}", j < emst.size() ? emst[j] : 0);
  const double dissipated = found.dissipated.value_or(NAN);
  fmt::print(" {:>10}\n", std::isnan(dissipated) ? "-" : fmt::format("{:.3g}", dissipated));
}

void print_degrees(const AnalysedRun& run, const analysis::Topology& t) {
  fmt::print("\n{:<10}{:>10}{:>8}{:>12}{:>8}\n", "degree", "tree", "", "EMST", "");
  const std::vector<int>&tree = t.network.degrees.number, &emst = t.minimum.number;
  for (std::size_t j = 0; j < std::max(tree.size(), emst.size()); ++j) {
    const int in_tree = j < tree.size() ? tree[j] : 0, in_emst = j < emst.size() ? emst[j] : 0;
    if (in_tree + in_emst == 0) continue;
    fmt::print("{:<10}{:>10}{:>8.3f}{:>12}{:>8.3f}\n", j, in_tree, t.network.degrees.fraction(static_cast<int>(j)),
               in_emst, static_cast<double>(in_emst) / run.conductors);
  }
  const analysis::DegreeDistribution& d = t.network.degrees;
  fmt::print("\nrelations of D (c = (2 loops - grounded) / M = {:.4f}){:>22}\n",
             d.connected > 0 ? static_cast<double>(2 * d.loops - d.grounded) / d.connected : 0, "residual");
  for (const Relation& relation : relations)
    fmt::print("  {:<48}{:>14.1e}\n", relation.in_words, t.relations.*relation.residual);
}

std::string ratio(const analysis::StrahlerDistribution& orders, int j) {
  return j < orders.highest() ? fmt::format("{:.2f}", orders.bifurcation_ratio(j)) : "";
}

void print_orders(const char* tree, const analysis::StrahlerDistribution& orders, int nodes) {
  fmt::print("\n{:<10}{:>10}{:>8}{:>12}{:>14}{:>20}\n", tree, "sigma", "", "streams", "their length",
             "bifurcation ratio");
  for (int j = 1; j <= orders.highest(); ++j)
    fmt::print("{:<10}{:>10}{:>8.3f}{:>12}{:>14.2f}{:>20}\n", fmt::format("order {}", j), orders.conductors[j],
               static_cast<double>(orders.conductors[j]) / nodes, orders.streams[j], orders.stream_length(j),
               ratio(orders, j));
}

void print_dimension(const char* what, const std::optional<PowerLaw>& law) {
  if (!law) return fmt::print("{:<15}not defined: the tree is too small for a range of scales\n", what);
  fmt::print("{:<15}{:.3f} +- {:.3f} (from the scatter about the line only), from {:.3g} to {:.3g} mm, {} scales\n",
             what, law->exponent, law->standard_error, 1e3 * law->from, 1e3 * law->to, law->points);
}

void print_lengths(const AnalysedRun& run, const analysis::Topology& t) {
  const Distribution& e = t.edge_length;
  fmt::print("\nedges          {} between conductors, mean {:.4f} R, deviation {:.4f} R\n", e.count,
             e.mean / run.radius, e.deviation / run.radius);
  fmt::print("               quartiles {:.4f}, {:.4f}, {:.4f} R, from {:.4f} to {:.4f} R\n", e.quarter / run.radius,
             e.median / run.radius, e.three_quarters / run.radius, e.least / run.radius, e.largest / run.radius);
  fmt::print("length         tree {:.6g} m, EMST {:.6g} m with {} of its {} edges in the tree\n", t.tree_length,
             t.minimum.length, t.minimum.shared, t.minimum.edges.size());
  print_dimension("D of boxes", t.boxes);
  print_dimension("D of masses", t.masses);
}

/// Returns a recorded number; NaN is a current that ideal contacts leave undefined, or a ratio without a difference.
std::string recorded_number(double value) { return std::isnan(value) ? "not defined" : fmt::format("{:.4g}", value); }

void print_recorded(const RecordedQuantity& recorded) {
  std::vector<std::string> numbers;
  for (const double value : recorded.values) numbers.push_back(recorded_number(value));
  const bool defined = std::ranges::any_of(recorded.values, [](double value) { return !std::isnan(value); });
  fmt::print("recorded       {} {}{}\n", recorded.name, fmt::join(numbers, ", "), defined ? " " + recorded.unit : "");
}

void print_power(const FrameAnalysis& found) {
  fmt::print("power          source {:.4g} W, work of the field {:.4g} W, drag {:.4g} W\n", found.power.source,
             found.power.field, found.power.drag);
  if (found.dissipated)
    fmt::print("dissipated     {} W since the previous frame\n", recorded_number(*found.dissipated));
  for (const RecordedQuantity& recorded : found.recorded) print_recorded(recorded);
}

}  // namespace

std::vector<Column> columns_of(const AnalysedRun& run, const Frames& frames) {
  FrameColumns columns(frames);
  columns.real("time", "s", [](auto& f) { return f.time; });
  add_degrees(columns, run.conductors);
  for (const Relation& relation : relations)
    columns.real(relation.name, "1", [&](auto& f) { return f.topology.relations.*relation.residual; });
  add_strahler(columns);
  add_lengths(columns, run.radius);
  add_dimension(columns, "box_dimension", &analysis::Topology::boxes);
  add_dimension(columns, "mass_dimension", &analysis::Topology::masses);
  add_power(columns);
  add_recorded(columns, frames);
  columns.integers("strahler", [](auto& f) { return f.topology.strahler; });
  return columns.take();
}

void print_analysis(const AnalysedRun& run, const Frames& frames) {
  fmt::print("{}: {}, {} conductors, {} frames, contacts {}\n\n", printable(run.file), printable(run.title),
             run.conductors, run.frames, run.contacts_recorded ? "as recorded" : "by D 7.1 and the recorded tree");
  print_head();
  for (const FrameAnalysis& found : frames) print_line(run, found);
  print_legend();
  const FrameAnalysis& last = frames.back();
  fmt::print("\nframe {} at t = {:.6g} s\n", last.frame, last.time);
  print_degrees(run, last.topology);
  print_orders("tree", last.topology.orders, last.topology.network.degrees.connected);
  print_orders("EMST", last.topology.minimum.strahler, run.conductors);
  print_lengths(run, last.topology);
  print_power(last);
}

nlohmann::ordered_json analysis_json(const AnalysedRun& run, const Frames& frames) {
  nlohmann::ordered_json json{{"file", run.file},
                              {"title", run.title},
                              {"conductors", run.conductors},
                              {"radius", run.radius},
                              {"contacts_recorded", run.contacts_recorded},
                              {"warnings", run.warnings}};
  add_frames(json, columns_of(run, frames), frames);
  return json;
}

}  // namespace lichtenberg
