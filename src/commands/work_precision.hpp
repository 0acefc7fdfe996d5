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

/// What a candidate's run has shown.
struct Point {
  std::vector<double> errors;  ///< by quantity
  double seconds = 0;          ///< of a run, median; by Diagram::clock
  double cores = 0;            ///< processor time over wall time
  std::int64_t work = 0;
  double evaluations = 0;           ///< of an operator, in residual evaluations on the whole grid; 0: not counted
  std::optional<double> mebibytes;  ///< memory that it took at its peak; empty if the system does not say
};

/// What errors are taken of, and against what.
struct Diagram {
  std::string title;                     ///< what is computed
  std::vector<std::string> quantities;   ///< whose errors are taken
  std::string measure;                   ///< which error that is, in words
  std::string work;                      ///< what Point::work counts
  std::string clock = "wall time";       ///< what Point::seconds are
  std::string reference;                 ///< how it was found, in words
  std::vector<double> reference_errors;  ///< the reference's own, estimated, by quantity
  /// For methods of others (python/lichtenberg/methods): what is solved, and the errors, by quantity, of their answer.
  std::function<nlohmann::ordered_json()> subject;
  std::function<std::vector<double>(const nlohmann::ordered_json& answer)> errors;
};

/// What to sweep.
struct Request {
  std::vector<std::string> methods;     ///< names; empty: all
  std::vector<std::string> others;      ///< names of methods of others that can join
  std::vector<int> sizes;               ///< S, of the methods with a grid
  std::function<void()> begin = [] {};  ///< called before the reference is sought
  /// Called with what is compared and the methods that were asked for, which last as long as this call.
  std::function<void(const Diagram&, const std::vector<Method>&)> serve;
};

/// The field of the scene's first instant, by every method that can solve it. Quantities: potentials, charges, forces.
/// Throws InputError for a scene without a field, unknown methods and sizes that do not give square cells.
void sweep_field(const Scene& scene, const Request& request);
/// The same of a scene of spheres in three dimensions, by accuracy and by degree, beside finite elements where they are
/// installed.
void sweep_spheres(const Scene& scene, const Request& request);
/// The scene's motion until stop.time, by every integrator. Quantity: positions. Throws InputError for unknown methods.
void sweep_time(const Scene& scene, const Request& request);

/// The forces of charges on grains at the places of the first instant, by every way to sum them, LAMMPS' among them;
/// with induced dipoles, from no start, where the scene's grains polarize. Gaussian charges where they have none yet.
/// Quantities: rms force, largest force. Throws InputError for a scene without charges and for unknown methods.
void sweep_charges(const Scene& scene, const Request& request);

/// The motion of a scene of grains over half a unit of time, stages left out, by every integrator, and by every variant
/// of dipoles where its grains polarize. Quantities: places, energy book. Throws InputError for unknown methods.
void sweep_grains(const Scene& scene, const Request& request);

/// Those of `all` that were asked for. Throws InputError for names that are none of theirs and none of others.
std::vector<Method> choose(std::vector<Method> all, const Request& request);
/// The time is the median of up to five runs after a first one that does not count; of fewer if they take long. Throws
/// InputError if the method cannot do it, Failure if it does not succeed.
Point measure(const Candidate& candidate);

/// Of the processor, that this thread has taken.
double seconds_of_thread();

}  // namespace lichtenberg::work_precision
