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

/// Settings of a method by name, such as {{"S", 512}, {"tolerance", 1e-6}}.
using Settings = std::vector<std::pair<std::string, double>>;

/// Interface of a repeatable computation with a measurable error. Each run starts from the same state.
class Trial {
 public:
  virtual ~Trial() = default;
  /// Runs the computation once, from its initial state. Throws InputError if the method is not applicable, Failure if
  /// the computation fails.
  virtual void run() = 0;
  /// Returns the error of each quantity of the last run against the reference (Diagram::measure).
  virtual std::vector<double> errors() const = 0;
  /// Returns the work of the last run: iterations or field solves (Diagram::work).
  virtual std::int64_t work() const = 0;
  /// Returns the machine-independent work of the last run, in residual evaluations on the whole grid; 0: not counted.
  virtual double evaluations() const { return 0; }
  /// Returns the time (s) of the last run if wall time is not appropriate: processor time of one thread, or time of
  /// another program or device without start and transfers. No value: wall time counts.
  virtual std::optional<double> measured_seconds() const { return {}; }
  /// Returns true if another program or a device does the work, whose memory is not that of this process.
  virtual bool uses_other_memory() const { return false; }
};

/// One setting of a method that can be measured.
struct Candidate {
  Settings settings;
  double cost = 1;  ///< expected time in arbitrary units
  std::function<std::unique_ptr<Trial>()> make;
};

/// A numerical method with the settings at which it is compared.
struct Method {
  std::string name, description;
  std::vector<Candidate> candidates;  ///< approximately in ascending order of cost
};

/// Measured error and cost of a candidate: one point of a work-precision diagram.
struct Point {
  std::vector<double> errors;  ///< per quantity
  double seconds = 0;          ///< median time of a run; see Diagram::clock
  double cores = 0;            ///< processor time over wall time
  std::int64_t work = 0;
  double evaluations = 0;           ///< operator evaluations, in residual evaluations on the whole grid; 0: not counted
  std::optional<double> mebibytes;  ///< peak memory; empty if the system does not report it
};

/// Subject, reference and units of a work-precision diagram.
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

/// Request for a work-precision comparison: methods and sizes.
struct Request {
  std::vector<std::string> methods;     ///< names; empty: all
  std::vector<std::string> others;      ///< names of other programs' methods that can join
  std::vector<int> sizes;               ///< grid sizes S of the methods with a grid
  std::function<void()> begin = [] {};  ///< called before the reference is computed
  /// Callback that receives the subject and the requested methods, which stay valid during the call.
  std::function<void(const Diagram&, const std::vector<Method>&)> serve;
};

/// Compares the requested methods for the plane field of the scene at its start. Quantities: potentials, charges,
/// forces. Throws InputError for a scene without a field, unknown methods and sizes that are not allowed.
void sweep_field(const Scene& scene, const Request& request);
/// Compares the requested methods for the field of spheres in three dimensions, by accuracy and by degree, together
/// with finite elements if installed. Throws InputError for a scene without a field, unknown methods and any sizes.
void sweep_spheres(const Scene& scene, const Request& request);
/// Compares the requested integrators for the plane motion of the scene's conductors until stop.time. Quantity:
/// positions. Throws InputError for three dimensions, a periodic side and unknown methods.
void sweep_time(const Scene& scene, const Request& request);

/// Compares the requested summation methods for the forces of charges on grains at their initial positions, including
/// LAMMPS. If the grains are polarizable, induced dipoles are included, from a zero initial guess. Uncharged grains get
/// Gaussian charges. Quantities: rms force, largest force. Throws InputError for a scene without [effects.coulomb] or
/// with fewer than two grains, unknown methods and any sizes.
void sweep_charges(const Scene& scene, const Request& request);

/// Compares the requested integrators for the motion of grains over at most half a unit of time, without equilibration
/// stages. For polarizable grains the methods include all variants of the dipole sum. Quantities: positions, energy
/// balance. Throws InputError for unknown methods.
void sweep_grains(const Scene& scene, const Request& request);

/// Returns the methods of `all` that the request names; all if it names none. Throws InputError for names that are
/// neither of `all` nor of request.others.
std::vector<Method> choose(std::vector<Method> all, const Request& request);
/// Measures the error, time and memory of a candidate. The time is the median of up to five runs after a warm-up run,
/// or that of a single run of 2 s or more. Throws InputError if the method is not applicable, Failure if a run fails.
Point measure(const Candidate& candidate);

/// Returns the processor time (s) of this thread.
double seconds_of_thread();

}  // namespace lichtenberg::work_precision
