#pragma once

#include <functional>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "src/commands/gas_parameters.hpp"
#include "src/record/hdf5.hpp"
#include "src/theory/kinetic.hpp"
#include "src/theory/stability.hpp"

namespace lichtenberg {

/// Column of a table of a theory: values of one quantity.
struct TheoryColumn {
  std::string name, unit;  ///< unit 1 for pure numbers
  std::string label;       ///< label in a picture
  std::vector<double> values;
};

/// Values of a run (x, y) that are compared with one column of a theory's table.
struct FoundSeries {
  std::string of;  ///< name of that column
  std::string label;
  std::vector<double> x, y;
};

/// Table of a theory's results as functions of its first column, with panels for a picture.
struct TheoryTable {
  std::string name, title;
  std::vector<TheoryColumn> columns;
  /// Columns that one panel of a picture shows; a table without panels is not drawn.
  struct Panel {
    std::string label;
    bool logarithmic = true;
    std::vector<std::string> columns;
  };
  std::vector<Panel> panels;
  bool logarithmic = true;  ///< axis of the first column
  std::vector<FoundSeries> found{};
};

/// Applies `value` (a function or a pointer to member) to each element and returns the results.
template <class All, class Value>
std::vector<double> values_of(const All& all, Value value) {
  std::vector<double> values;
  for (const auto& each : all) values.push_back(std::invoke(value, each));
  return values;
}

/// Adds a column to a table and to one of its panels.
inline void add(TheoryTable& table, int panel, TheoryColumn column) {
  table.panels[panel].columns.push_back(column.name);
  table.columns.push_back(std::move(column));
}

/// A single number of a theory with its unit and meaning.
struct TheoryFigure {
  std::string name, unit;
  double value = 0;
  std::string meaning;
};

/// Fields on a square at one instant, drawn as adjacent pictures.
struct TheoryMaps {
  std::string title;
  int cells = 0;      ///< per edge
  double length = 0;  ///< of an edge, l_0
  struct Map {
    std::string name, label;
    bool logarithmic = false;
    std::vector<double> values;  ///< row by row from below
  };
  std::vector<Map> fields;
};

/// Results of a theory: numbers, tables and fields.
struct TheoryAnswer {
  std::string name, title;
  std::vector<TheoryFigure> figures;
  std::vector<TheoryTable> tables;
  std::vector<TheoryMaps> maps{};
};

/// Time series of a run of grains: those that the run recorded, and with the prefix `analysis/` those stored by
/// `analyse`.
class GasTimeSeries {
 public:
  /// Values at times counted from the end of the warm-up (equilibration); earlier values are omitted. Each shell of a
  /// structure factor is a series of its own, with the suffix /1, /2, ...
  struct Series {
    std::vector<double> time, value;
  };

  /// Reads the time series of a result file. `warm_up`: end of the equilibration (t0). Throws InputError if there are
  /// none: the file is damaged, is not of a gas, or ends with the warm-up.
  GasTimeSeries(const std::string& path, double warm_up);

  /// Returns the series of this name; null if there is none. Throws InputError if it does not have one number per
  /// instant.
  const Series* find(const std::string& name) const;
  const std::map<std::string, Series>& all() const { return series_; }
  /// Adds the series `name`, times `factor`, to the table for comparison with one of its columns, if the series exists.
  void show(TheoryTable& table, const std::string& column, const std::string& name, const std::string& label,
            double factor = 1) const;

 private:
  void read(const hdf5::Handle& file, const std::string& group, double warm_up);

  std::string path_;
  std::map<std::string, Series> series_;
  std::set<std::string> malformed_names_;
};

/// Returns the density, temperature, pair correlation at contact and collision frequency of a gas, which most theories
/// print first.
std::vector<TheoryFigure> common_figures(const GasParameters& gas);
/// Computes the constant restitution coefficient with the same mean energy loss as the contact law of the gas at its
/// initial temperature.
double mean_restitution(const GasParameters& gas);
/// Makes times (t0) in geometric progression from the smaller of 0.01 and end / 100 to `end`, at least twenty per
/// decade.
std::vector<double> times_until(double end);
/// Computes the states of a coalescing gas at these times by kinetic theory with finite contact durations. Throws
/// InputError for a gas without charge exchange or without Coulomb forces.
std::vector<theory::KineticState> merging_states(const GasParameters& gas, const std::vector<double>& times);

/// Growth of aggregates by Smoluchowski's equation in the time of kinetic theory: number of aggregates per initial
/// grain, and mean size S.
struct PacedGrowth {
  std::vector<double> number, size;
  double error = 0, ratio = 0;  ///< as in theory::CoagulationSeries
};
/// Computes the growth of aggregates by Smoluchowski's equation with theory::flight_kernel(beta), at the pace of
/// kinetic theory. Each of the `states` (result of merging_states()) is mapped to the theory::flight_time() of its mean
/// size. Values are NaN where the solution of the equation has ended.
PacedGrowth paced_growth(double beta, const GasParameters& gas, const std::vector<theory::KineticState>& states);

/// Adds the critical wave numbers of linear stability to the figures. Below the first one shear modes grow; at the
/// others heat or sound modes begin or cease to grow. `charge_number`: dimensionless charge number R.
void add_critical(std::vector<TheoryFigure>& figures, const theory::TransportCoefficients& c, double charge_number);

/// Makes `count` >= 2 values in geometric progression from `first` to `last`.
std::vector<double> logarithmic_range(double first, double last, int count);

}  // namespace lichtenberg
