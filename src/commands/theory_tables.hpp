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

struct TheoryColumn {
  std::string name, unit;  ///< 1 for pure numbers
  std::string label;       ///< in a picture
  std::vector<double> values;
};

/// What a run has found of one of the columns.
struct FoundSeries {
  std::string of;  ///< that column's name
  std::string label;
  std::vector<double> x, y;
};

/// Curves over the first column.
struct TheoryTable {
  std::string name, title;
  std::vector<TheoryColumn> columns;
  /// What a picture shows together; a table without any is not drawn.
  struct Panel {
    std::string label;
    bool logarithmic = true;
    std::vector<std::string> columns;
  };
  std::vector<Panel> panels;
  bool logarithmic = true;  ///< the first column
  std::vector<FoundSeries> found{};
};

/// What `value`, a function or a member, has for each of these.
template <class All, class Value>
std::vector<double> values_of(const All& all, Value value) {
  std::vector<double> values;
  for (const auto& each : all) values.push_back(std::invoke(value, each));
  return values;
}

/// Adds a column to the table and to one of its panels.
inline void add(TheoryTable& table, int panel, TheoryColumn column) {
  table.panels[panel].columns.push_back(column.name);
  table.columns.push_back(std::move(column));
}

/// A number with its unit, and what it is.
struct TheoryFigure {
  std::string name, unit;
  double value = 0;
  std::string meaning;
};

/// Fields of a square at an instant, as pictures beside each other.
struct TheoryMaps {
  std::string title;
  int cells = 0;      ///< along an edge
  double length = 0;  ///< of it, l_0
  struct Map {
    std::string name, label;
    bool logarithmic = false;
    std::vector<double> values;  ///< row after row from below
  };
  std::vector<Map> fields;
};

struct TheoryAnswer {
  std::string name, title;
  std::vector<TheoryFigure> figures;
  std::vector<TheoryTable> tables;
  std::vector<TheoryMaps> maps{};
};

/// The course of a run: what it noted itself, and with `analysis/` before its name what `analyse` has stored.
class GasCourse {
 public:
  /// Times are counted from the end of the warm-up; what was before is left out. Of structure factors each shell is one
  /// of them, with /1, /2, ... after its name.
  struct Series {
    std::vector<double> time, value;
  };

  /// Throws InputError if the file holds none: it is damaged, no gas's, or ends with the warm-up.
  GasCourse(const std::string& path, double warm_up);

  /// By name; null if it is not there. Throws InputError if it has not one number for each instant.
  const Series* find(const std::string& name) const;
  const std::map<std::string, Series>& all() const { return series_; }
  /// Adds it, times `factor`, to the table, if it is there.
  void show(TheoryTable& table, const std::string& column, const std::string& name, const std::string& label,
            double factor = 1) const;

 private:
  void read(const hdf5::Handle& file, const std::string& group, double warm_up);

  std::string path_;
  std::map<std::string, Series> series_;
  std::set<std::string> of_other_shapes_;
};

/// Numbers of a gas that most theories say first.
std::vector<TheoryFigure> common_figures(const GasParameters& gas);
/// The constant restitution that loses as much as the gas's own at its temperature.
double mean_restitution(const GasParameters& gas);
/// From a hundredth of a unit on, twenty to a power of ten.
std::vector<double> times_until(double end);
/// By kinetic theory, with contacts that last. Throws InputError for grains that do not charge each other and attract.
std::vector<theory::KineticState> merging_course(const GasParameters& gas, const std::vector<double>& times);

/// Coagulation in flight while a gas merges as kinetic theory has it: number of aggregates by initial grain, and S.
struct PacedGrowth {
  std::vector<double> number, size;
  double error = 0, ratio = 0;  ///< of theory::CoagulationCourse
};
/// `course`: of `merging_course`.
PacedGrowth paced_growth(double beta, const GasParameters& gas, const std::vector<theory::KineticState>& course);

/// Adds wave numbers below which modes grow: of shear, then of the heat and sound modes at this charge number R.
void add_critical(std::vector<TheoryFigure>& figures, const theory::TransportCoefficients& c, double charge_number);

/// Equal factors from `first` to `last`.
std::vector<double> logarithmic_range(double first, double last, int count);

}  // namespace lichtenberg
