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

/// Settings of a method by name: {{"S", 512}, {"tolerance", 1e-6}}.
using Settings = std::vector<std::pair<std::string, double>>;

/// Repeatable computation with a measurable error. Each run starts from the same state.
class Trial {
 public:
  virtual ~Trial() = default;
  /// Runs the computation once, from its initial state. Throws InputError if the method is not applicable, Failure if
  /// the computation fails.
  virtual void run() = 0;
  /// Returns the largest relative error of each quantity of the last run against the reference.
  virtual std::vector<double> errors() const = 0;
  /// Returns iterations or field solves of the last run.
  virtual std::int64_t work() const = 0;
  /// Returns the machine-independent work of the last run, in residual evaluations on the whole grid; 0: not counted.
  virtual double evaluations() const { return 0; }
  /// Returns the seconds of the last run if wall time is not appropriate: processor time of one thread, or time of
  /// another program or device without start and transfers.
  virtual std::optional<double> measured_seconds() const { return {}; }
  /// Returns true if another program or a device does the work, whose memory is not that of this process.
  virtual bool uses_other_memory() const { return false; }
};

/// One setting of a method.
struct Candidate {
  Settings settings;
  double cost = 1;  ///< expected time in arbitrary units
  std::function<std::unique_ptr<Trial>()> make;
};

struct Method {
  std::string name, description;
  std::vector<Candidate> candidates;  ///< approximately in ascending order of cost
};

/// Measurement of a candidate.
struct Point {
  std::vector<double> errors;  ///< per quantity
  double seconds = 0;          ///< median time of a run; see Diagram::clock
  double cores = 0;            ///< processor time over wall time
  std::int64_t work = 0;
  double evaluations = 0;           ///< operator evaluations, in residual evaluations on the whole grid; 0: not counted
  std::optional<double> mebibytes;  ///< peak memory; empty if the system does not report it
};

/// Subject and reference of a comparison.
struct Diagram {
  std::string title;                     ///< computed problem
  std::vector<std::string> quantities;   ///< quantities with errors
  std::string measure;                   ///< description of the error measure
  std::string work;                      ///< unit of Point::work
  std::string clock = "wall time";       ///< clock of Point::seconds
  std::string reference;                 ///< description of the reference
  std::vector<double> reference_errors;  ///< estimated errors of the reference, per quantity
  /// Returns the description of the problem for other programs' methods (python/lichtenberg/methods).
  std::function<nlohmann::ordered_json()> subject;
  /// Returns the errors of another program's answer, per quantity.
  std::function<std::vector<double>(const nlohmann::ordered_json& answer)> errors;
};

/// Requested sweep.
struct Request {
  std::vector<std::string> methods;     ///< names; empty: all
  std::vector<std::string> others;      ///< names of other programs' methods that can join
  std::vector<int> sizes;               ///< grid sizes S of the methods with a grid
  std::function<void()> begin = [] {};  ///< called before the reference is computed
  /// Called with the subject and the requested methods, which stay valid during the call.
  std::function<void(const Diagram&, const std::vector<Method>&)> serve;
};

/// Sweeps the field of the scene's start over all methods that can solve it. Quantities: potentials, charges, forces.
/// Throws InputError for a scene without a field, unknown methods and sizes without square cells.
void sweep_field(const Scene& scene, const Request& request);
/// Sweeps the field of spheres in three dimensions by accuracy and by degree, together with finite elements if
/// installed.
void sweep_spheres(const Scene& scene, const Request& request);
/// Sweeps the scene's motion until stop.time over all integrators. Quantity: positions. Throws InputError for unknown
/// methods.
void sweep_time(const Scene& scene, const Request& request);

/// Sweeps the forces of charges on grains at their initial positions over all summation methods, including LAMMPS; with
/// induced dipoles, from a zero initial guess, if the grains are polarizable. Uncharged grains get Gaussian charges.
/// Quantities: rms force, largest force. Throws InputError for a scene without charges and for unknown methods.
void sweep_charges(const Scene& scene, const Request& request);

/// Sweeps the motion of grains over half a unit of time, without equilibration stages, over all integrators, and over
/// all dipole variants if grains are polarizable. Quantities: positions, energy balance. Throws InputError for unknown
/// methods.
void sweep_grains(const Scene& scene, const Request& request);

/// Returns the requested methods of `all`. Throws InputError for names that are neither of `all` nor of request.others.
std::vector<Method> choose(std::vector<Method> all, const Request& request);
/// Measures a candidate. The time is the median of up to five runs after a warm-up run; slow candidates run less often.
/// Throws InputError if the method is not applicable, Failure if a run fails.
Point measure(const Candidate& candidate);

/// Returns the processor time (s) of this thread.
double seconds_of_thread();

}  // namespace lichtenberg::work_precision
