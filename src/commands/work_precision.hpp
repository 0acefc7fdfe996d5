#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "src/scene/scene.hpp"

namespace lichtenberg::work_precision {

/// What a method was asked for, by name: {{"S", 512}, {"tolerance", 1e-6}}.
using Settings = std::vector<std::pair<std::string, double>>;
/// "S = 512, tolerance = 1e-06"
std::string to_string(const Settings& settings);

/// A piece of work that can be done again and again from nothing, and how wrong its result is.
class Trial {
 public:
  virtual ~Trial() = default;
  /// Throws InputError if the method cannot do it, Failure if it does not succeed.
  virtual void run() = 0;
  /// Of the last run, against the reference: largest error of each of the sweep's quantities, relative.
  virtual std::vector<double> errors() const = 0;
  /// Iterations or field solves of the last run.
  virtual std::int64_t work() const = 0;
  /// Work of the last run by what a machine cannot change: operator evaluations, in residual evaluations on the whole
  /// grid; 0: not counted.
  virtual double evaluations() const { return 0; }
  /// Seconds of the last run where the wall's clock does not tell them: of the processor, of one thread that others
  /// must not slow down; of another program or a device, whose start and transfers do not count.
  virtual std::optional<double> own_seconds() const { return {}; }
  /// Another program or a device does it, whose memory is not this one's.
  virtual bool is_elsewhere() const { return false; }
};

/// One setting of a method.
struct Candidate {
  Settings settings;
  double cost = 1;  ///< time that it is expected to take, in a unit of the method's own
  std::function<std::unique_ptr<Trial>()> make;
};

struct Method {
  std::string name, description;
  std::vector<Candidate> candidates;  ///< in ascending order of cost, roughly
};

/// A candidate that was measured.
struct Point {
  std::string method;
  Settings settings;
  std::vector<double> errors;  ///< by quantity
  double seconds = 0;          ///< of a run, median; by Diagram::clock
  double cores = 0;            ///< processor time over wall time
  std::int64_t work = 0;
  double evaluations = 0;           ///< of an operator, in residual evaluations on the whole grid; 0: not counted
  std::optional<double> mebibytes;  ///< memory that it took at its peak; empty if the system does not say
};

/// A candidate that was not, or a method without any (no settings).
struct LeftOut {
  std::string method;
  Settings settings;
  std::string reason;
};

/// Error against time, for several methods.
struct Diagram {
  std::string title;                                         ///< what was computed
  std::vector<std::string> quantities;                       ///< whose errors are taken
  std::string measure;                                       ///< which error that is, in words
  std::string work;                                          ///< what Point::work counts
  std::string clock = "wall time";                           ///< what Point::seconds are
  std::string reference;                                     ///< how it was found, in words
  std::vector<double> reference_errors;                      ///< the reference's own, estimated, by quantity
  std::vector<std::pair<std::string, std::string>> methods;  ///< name and description of those that were asked for
  std::vector<Point> points;
  std::vector<LeftOut> left_out;
};

/// What to sweep.
struct Request {
  std::vector<std::string> methods;  ///< names; empty: all
  std::vector<int> sizes;            ///< S, of the methods with a grid
  double seconds = 10;               ///< candidates that are expected to take longer are left out
  /// Called before each candidate is measured, with its place in the order, from 1; with place 0 before the reference.
  std::function<void(int place, int all, const std::string& method, const Settings& settings)> progress;
};

/// The field of the scene's first instant, by every method that can solve it. Quantities: potentials, charges, forces.
/// Throws InputError for a scene without a field, unknown methods and sizes that do not give square cells.
Diagram sweep_field(const Scene& scene, const Request& request);
/// The same of a scene of spheres in three dimensions, by accuracy and by degree, beside finite elements where they are
/// installed.
Diagram sweep_spheres(const Scene& scene, const Request& request);
/// The scene's motion until stop.time, by every integrator. Quantity: positions. Throws InputError for unknown methods.
Diagram sweep_time(const Scene& scene, const Request& request);

/// The forces of charges on grains at the places of the first instant, by every way to sum them, LAMMPS' among them;
/// with induced dipoles, from no start, where the scene's grains polarize. Gaussian charges where they have none yet.
/// Quantities: rms force, largest force. Throws InputError for a scene without charges and for unknown methods.
Diagram sweep_charges(const Scene& scene, const Request& request);

/// The motion of a scene of grains over half a unit of time, stages left out, by every integrator, and by every variant
/// of dipoles where its grains polarize. Quantities: places, energy book. Throws InputError for unknown methods.
Diagram sweep_grains(const Scene& scene, const Request& request);

/// Those of `all` that were asked for. Throws InputError for names that are none of theirs.
std::vector<Method> choose(std::vector<Method> all, const std::vector<std::string>& names);
/// Measures the methods' candidates into diagram.points and diagram.left_out.
///
/// A run's time is the median of up to five after a first one that does not count; of fewer if they take long. What a
/// candidate will take is expected from the last one of its method and the ratio of their costs.
void measure(const std::vector<Method>& methods, const Request& request, Diagram& diagram);

/// The cheapest point whose error is at most `error`.
struct Price {
  double error = 0;
  const Point* point = nullptr;  ///< of the diagram; null: none is that good
};
/// For errors of 1e-1, 1e-2, ... in the quantity of that index, to the first that no point reaches. An error counts as
/// no smaller than the reference's own.
std::vector<Price> price_list(const Diagram& diagram, std::size_t quantity);

/// Of the processor, that this thread has taken.
double seconds_of_thread();

/// Where a diagram was measured, and by what.
struct Circumstances {
  std::string scene, processor;
  int cores = 0;         ///< that the program may use
  double load = 0;       ///< processes that ran or wanted to in the minute before (the system's load average)
  std::string versions;  ///< lichtenberg with its commit, PETSc, SUNDIALS, compiler
};
Circumstances circumstances(const Scene& scene);

void print(const Diagram& diagram, const Circumstances& circumstances);
nlohmann::ordered_json to_json(const Diagram& diagram, const Circumstances& circumstances);

}  // namespace lichtenberg::work_precision
