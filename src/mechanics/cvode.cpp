#include "src/mechanics/cvode.hpp"

#include <fmt/format.h>
#include <nvector/nvector_serial.h>
#include <sunlinsol/sunlinsol_klu.h>
#include <sunmatrix/sunmatrix_sparse.h>

#include <Eigen/SparseCore>
#include <algorithm>
#include <cmath>
#include <exception>
#include <limits>
#include <numeric>
#include <string>

#include "solvers/error.hpp"
#include "solvers/ode/sundials.hpp"
#include "src/mechanics/step_control.hpp"

namespace lichtenberg::mechanics {

/// State that all integrations of one Cvode object share.
struct Cvode::Shared {
  Shared(Cvode& o, Model& m, Accuracy a)
      : owner(o), model(m), accuracy(std::move(a)), largest_move(m.largest_move()), force(m.bodies.position.size()) {}

  Cvode& owner;
  Model& model;
  Accuracy accuracy;
  double largest_move;
  std::vector<double> force;                    ///< N, on all bodies; only the last requested values are valid
  std::unique_ptr<Implementation> full_system;  ///< null before its first use
  std::int64_t steps = 0, rejected = 0;
};

// The integrator's vector is [positions, momenta], each with (number of moved bodies) * dimension numbers.
struct Cvode::Implementation {
  /// `which`: the bodies that move; empty: all.
  Implementation(Shared& shared, std::vector<int> which);
  ~Implementation();
  Implementation(const Implementation&) = delete;
  Implementation& operator=(const Implementation&) = delete;

  void store(N_Vector y) const;
  bool load(N_Vector y);
  void start(double time, int order);
  void count();
  int moved_index(int component) const;
  double advance(double start, double end);
  double longest_step(double time);
  void set_passive_bodies(double time) const;
  bool forces_depend_on_position(double time);
  void assemble();
  void copy_to(SUNMatrix matrix);
  [[noreturn]] void fail(double time, int flag) const;

  Shared& shared;
  Cvode& owner;
  Model& model;
  const Accuracy& accuracy;
  RequestedBodies requested;
  std::vector<int> moving;             ///< bodies
  std::vector<std::size_t> component;  ///< moved components, among those of all bodies
  std::size_t n;                       ///< size of `component`
  std::vector<double>& force;          ///< N, on moved bodies, and on others as set by others->forces
  ForceJacobian force_jacobian;
  std::vector<Eigen::Triplet<double>> triplets;
  Eigen::SparseMatrix<double, Eigen::ColMajor, sunindextype> jacobian;
  const Events* events = nullptr;
  const PassiveBodies* passive = nullptr;
  std::exception_ptr thrown;  ///< exception of the last callback, because exceptions cannot cross C code
  int failed_trials = 0;      ///< states of this integration at which forces threw
  std::string message;        ///< last message of CVODE

  SUNContext context = nullptr;
  N_Vector y = nullptr, rate = nullptr;  ///< state, and its rate at the end of the last step, 0 before the first
  SUNMatrix matrix = nullptr;
  SUNLinearSolver linear_solver = nullptr;
  void* memory = nullptr;
};

namespace {

using Implementation = Cvode::Implementation;

std::span<double> values(N_Vector v) { return {N_VGetArrayPointer(v), static_cast<std::size_t>(N_VGetLength(v))}; }

/// Runs the body of a callback. Returns 0: success, 1: CVODE should try a smaller step, -1: stop because of an
/// exception.
template <class Body>
int guarded(Implementation& self, Body body) {
  try {
    const int result = body();
    self.thrown = nullptr;
    return result;
  } catch (...) {
    self.thrown = std::current_exception();
    return -1;
  }
}

/// Computes the right-hand side of the equations for CVODE. In a step with a collision Newton's iteration may try
/// positions at which forces do not exist; a smaller step avoids them. After many such failures the bodies do move
/// there, and the exception ends the integration.
int rates(double time, N_Vector y, N_Vector rate, void* data) {
  auto& self = *static_cast<Implementation*>(data);
  const int done = guarded(self, [&] {
    if (!self.load(y)) return 1;
    if (self.owner.before_forces) self.owner.before_forces(time);
    const std::span<double> out = values(rate);
    const Bodies& bodies = self.model.bodies;
    self.model.forces(time, self.requested, self.force);
    for (std::size_t k = 0; k < self.n; ++k) {
      const std::size_t c = self.component[k];
      out[k] = bodies.momentum[c] / bodies.mass[c / bodies.dimension];
      out[self.n + k] = self.force[c];
    }
    return 0;
  });
  constexpr int max_failed_trials = 1000;
  return done < 0 && ++self.failed_trials < max_failed_trials ? 1 : done;
}

int jacobian(double time, N_Vector y, N_Vector, SUNMatrix matrix, void* data, N_Vector, N_Vector, N_Vector) {
  auto& self = *static_cast<Implementation*>(data);
  return guarded(self, [&] {
    if (!self.load(y)) return 1;
    self.model.jacobian(time, self.requested, self.force_jacobian);
    self.assemble();
    self.copy_to(matrix);
    return 0;
  });
}

int error_weights(N_Vector y, N_Vector weight, void* data) {
  const auto& self = *static_cast<Implementation*>(data);
  const std::span<double> state = values(y), w = values(weight);
  for (std::size_t k = 0; k < self.n; ++k) {
    w[k] = 1 / self.accuracy.position;
    const double floor = self.accuracy.momentum[self.component[k] / self.model.bodies.dimension];
    w[self.n + k] = 1 / (self.accuracy.relative * std::abs(state[self.n + k]) + floor);
  }
  return 0;
}

int event_values(double time, N_Vector y, double* value, void* data) {
  auto& self = *static_cast<Implementation*>(data);
  return guarded(self, [&] {
    if (!self.load(y)) return 1;
    self.set_passive_bodies(time);
    self.events->values({value, self.events->direction.size()});
    return 0;
  });
}

/// Norm of CVODE's error tests: the largest component. In CVODE's own norm, the root mean square, the error of two
/// colliding bodies would be hidden by a thousand bodies at rest.
double largest(N_Vector v, N_Vector weight) {
  const std::span<const double> error = values(v), w = values(weight);
  double worst = 0;
  for (std::size_t k = 0; k < error.size(); ++k) {
    const double e = std::abs(error[k]) * w[k];
    if (e > worst || std::isnan(e)) worst = e;  // NaN stays NaN
  }
  return worst;
}

void check(int flag) {
  if (flag < 0) throw Failure(fmt::format("mechanics: CVODE refuses its set-up ({})", CVodeGetReturnFlagName(flag)));
}

std::vector<int> all_of(const Bodies& bodies) {
  std::vector<int> all(bodies.size());
  std::iota(all.begin(), all.end(), 0);
  return all;
}

}  // namespace

Cvode::Implementation::Implementation(Shared& s, std::vector<int> which)
    : shared(s),
      owner(s.owner),
      model(s.model),
      accuracy(s.accuracy),
      requested(which),
      moving(which.empty() ? all_of(model.bodies) : std::move(which)),
      n(moving.size() * model.bodies.dimension),
      force(s.force),
      force_jacobian(model.bodies.dimension) {
  for (const int i : moving)
    for (int k = 0; k < model.bodies.dimension; ++k)
      component.push_back(static_cast<std::size_t>(i) * model.bodies.dimension + k);
  const auto size = static_cast<sunindextype>(2 * n);
  jacobian.resize(size, size);
  context = sundials::make_context();
  y = N_VNew_Serial(size, context);
  y->ops->nvwrmsnorm = largest;
  rate = N_VClone(y);
  matrix = SUNSparseMatrix(size, size, 4 * size, CSC_MAT, context);
  linear_solver = SUNLinSol_KLU(y, matrix, context);
  memory = CVodeCreate(CV_BDF, context);
  check(sundials::keep_messages(context, memory, message));
  check(CVodeInit(memory, rates, 0.0, y));
  check(CVodeSetUserData(memory, this));
  check(CVodeWFtolerances(memory, error_weights));
  check(CVodeSetLinearSolver(memory, linear_solver, matrix));
  check(CVodeSetJacFn(memory, mechanics::jacobian));
  check(CVodeSetNoInactiveRootWarn(memory));
  // A Jacobian from a contact makes Newton's corrections too small after its end, the more the longer the steps. Their
  // convergence test accepts small corrections, so that bodies keep an acceleration without a force. Therefore each
  // factorization takes a new Jacobian, not one of up to 51 steps before. CVODE still uses a factorization for up to 20
  // steps of similar length.
  check(CVodeSetJacEvalFrequency(memory, 1));
}

Cvode::Implementation::~Implementation() {
  CVodeFree(&memory);
  SUNLinSolFree(linear_solver);
  SUNMatDestroy(matrix);
  N_VDestroy(y);
  N_VDestroy(rate);
  SUNContext_Free(&context);
}

void Cvode::Implementation::store(N_Vector v) const {
  const std::span<double> state = values(v);
  for (std::size_t k = 0; k < n; ++k) {
    state[k] = model.bodies.position[component[k]];
    state[n + k] = model.bodies.momentum[component[k]];
  }
}

/// Sets the bodies to a state. Returns false if it is not finite.
bool Cvode::Implementation::load(N_Vector v) {
  const std::span<double> state = values(v);
  if (!std::ranges::all_of(state, [](double s) { return std::isfinite(s); })) return false;
  for (std::size_t k = 0; k < n; ++k) {
    model.bodies.position[component[k]] = state[k];
    model.bodies.momentum[component[k]] = state[n + k];
  }
  return true;
}

/// Restarts at `time` from the state in y, with formulas up to `order`.
void Cvode::Implementation::start(double time, int order) {
  N_VConst(0, rate);
  check(CVodeSetMaxOrd(memory, order));
  check(CVodeReInit(memory, time, y));
}

/// Adds the counters of CVODE since its last restart.
void Cvode::Implementation::count() {
  long now = 0, failures = 0, stiff_failures = 0;
  CVodeGetNumSteps(memory, &now);
  CVodeGetNumErrTestFails(memory, &failures);
  CVodeGetNumNonlinSolvConvFails(memory, &stiff_failures);
  shared.steps += now;
  shared.rejected += failures + stiff_failures;
}

/// Converts the index of a component of all bodies to that among the moved ones; -1: the component is not moved.
int Cvode::Implementation::moved_index(int of) const {
  if (requested.bodies().empty()) return of;
  const auto found = std::ranges::lower_bound(component, static_cast<std::size_t>(of));
  return found != component.end() && *found == static_cast<std::size_t>(of)
             ? static_cast<int>(found - component.begin())
             : -1;
}

void Cvode::Implementation::set_passive_bodies(double time) const {
  if (passive) passive->set_state(time);
}

/// Returns a step (s) in which no body moves farther than the effects allow, and no event is missed.
double Cvode::Implementation::longest_step(double time) {
  const Bodies& bodies = model.bodies;
  if (passive) {
    const std::span<const double> force_on_passive = passive->forces(time);
    for (const int i : passive->watched)
      std::copy_n(force_on_passive.begin() + i * bodies.dimension, bodies.dimension,
                  force.begin() + i * bodies.dimension);
  }
  for (std::size_t k = 0; k < n; ++k) force[component[k]] = values(rate)[n + k];
  double longest = INFINITY;
  for (const int i : moving) {
    double speed = 0, acceleration = 0;
    const auto first = static_cast<std::size_t>(i) * bodies.dimension;
    for (std::size_t k = first; k < first + bodies.dimension; ++k) {
      speed = std::hypot(speed, bodies.momentum[k] / bodies.mass[i]);
      acceleration = std::hypot(acceleration, force[k] / bodies.mass[i]);
    }
    longest = std::min(longest, time_to_move(shared.largest_move, speed, acceleration));
  }
  return events->longest_step ? std::min(longest, events->longest_step(force)) : longest;
}

/// Returns true if forces depend on positions, as in elastic contacts.
bool Cvode::Implementation::forces_depend_on_position(double time) {
  model.jacobian(time, requested, force_jacobian);
  return !force_jacobian.by_position.empty();
}

/// Assembles the Jacobian of the system. The diagonal is always stored, so that CVODE's I - gamma J has this pattern.
void Cvode::Implementation::assemble() {
  const Bodies& bodies = model.bodies;
  triplets.clear();
  const auto add = [&](std::size_t row, std::size_t column, double value) {
    triplets.emplace_back(static_cast<int>(row), static_cast<int>(column), value);
  };
  for (std::size_t k = 0; k < n; ++k) {
    add(k, k, 0);
    add(n + k, n + k, 0);
    add(k, n + k, 1 / bodies.mass[component[k] / bodies.dimension]);
  }
  const auto add_force = [&](const ForceJacobian::Entry& entry, std::size_t first_column) {
    const int row = moved_index(entry.row), column = moved_index(entry.column);
    if (row >= 0 && column >= 0) add(n + row, first_column + column, entry.value);
  };
  for (const ForceJacobian::Entry& entry : force_jacobian.by_position) add_force(entry, 0);
  for (const ForceJacobian::Entry& entry : force_jacobian.by_momentum) add_force(entry, n);
  jacobian.setFromTriplets(triplets.begin(), triplets.end());
}

/// Copies the Jacobian to CVODE's matrix. KLU keeps the symbolic analysis of a sparsity pattern, so it is reset if the
/// pattern changes with the contacts.
void Cvode::Implementation::copy_to(SUNMatrix target) {
  const auto columns = static_cast<std::size_t>(jacobian.cols()) + 1;
  const auto entries = static_cast<std::size_t>(jacobian.nonZeros());
  if (SUNSparseMatrix_NNZ(target) < jacobian.nonZeros()) SUNSparseMatrix_Reallocate(target, jacobian.nonZeros());
  sunindextype* starts = SUNSparseMatrix_IndexPointers(target);
  sunindextype* rows = SUNSparseMatrix_IndexValues(target);
  const bool same_pattern = std::equal(starts, starts + columns, jacobian.outerIndexPtr()) &&
                            std::equal(rows, rows + entries, jacobian.innerIndexPtr());
  std::copy_n(jacobian.outerIndexPtr(), columns, starts);
  std::copy_n(jacobian.innerIndexPtr(), entries, rows);
  std::copy_n(jacobian.valuePtr(), entries, SUNSparseMatrix_Data(target));
  if (!same_pattern) SUNLinSol_KLUReInit(linear_solver, target, jacobian.nonZeros(), SUNKLU_REINIT_PARTIAL);
}

void Cvode::Implementation::fail(double time, int flag) const {
  if (thrown) std::rethrow_exception(thrown);
  if (flag == CV_TOO_MUCH_ACC)
    throw Failure(
        fmt::format("mechanics: at t = {:.9g} s mechanics.relative_tolerance = {:g} is below the rounding error of "
                    "such large positions and momenta: a larger one is needed",
                    time, accuracy.relative));
  throw Failure(fmt::format("mechanics: the integrator failed at t = {:.9g} s: {}", time, message));
}

Cvode::Cvode(Model& model, Accuracy accuracy) : shared_(std::make_unique<Shared>(*this, model, std::move(accuracy))) {}
Cvode::~Cvode() = default;

double Cvode::advance(double start, double end, const Events& events) {
  if (!shared_->full_system) shared_->full_system = std::make_unique<Implementation>(*shared_, std::vector<int>());
  shared_->full_system->events = &events;
  return shared_->full_system->advance(start, end);
}

double Cvode::advance(double start, double end, const Events& events, std::vector<int> moving,
                      const PassiveBodies& passive) {
  Implementation some(*shared_, std::move(moving));
  some.events = &events;
  some.passive = &passive;
  return some.advance(start, end);
}

double Cvode::Implementation::advance(double from, double end) {
  // CVODE refuses an interval of rounding length, which remains if an event is next to the end.
  const double rounding = 4 * std::numeric_limits<double>::epsilon() * std::max(std::abs(from), std::abs(end));
  if (end - from <= rounding) return end;
  store(y);
  // A step that underflows to 0 makes CVODE's Newton iteration endless, because it divides by the last step.
  check(CVodeSetMinStep(memory, std::pow(std::numeric_limits<double>::epsilon(), 2) * (end - from)));
  thrown = nullptr;
  failed_trials = 0;
  const int high = 5, low = 2, high_order_steps = 300;
  int order = forces_depend_on_position(from) ? low : high;
  start(from, order);
  check(CVodeRootInit(memory, static_cast<int>(events->direction.size()), event_values));
  if (!events->direction.empty()) check(CVodeSetRootDirection(memory, const_cast<int*>(events->direction.data())));

  double time = from;
  for (int flag = CV_SUCCESS, tried = 0; flag != CV_ROOT_RETURN && end - time > rounding; ++tried) {
    if (owner.between_steps) owner.between_steps();
    if (order == high && tried >= high_order_steps) {
      count();
      start(time, order = low);
    }
    // CVODE obeys a largest step only from the step after the next on, but a stop time at once. It ignores a stop time
    // closer than some hundred roundings.
    const double longest = std::max(longest_step(time), 1000 * rounding);
    check(CVodeSetMaxStep(memory, longest));
    check(CVodeSetStopTime(memory, std::min(end, time + longest)));
    const double before = time;
    const std::vector<double> position = owner.after_step ? model.bodies.position : std::vector<double>();
    const std::vector<double> momentum = owner.after_step ? model.bodies.momentum : std::vector<double>();
    flag = CVode(memory, end, y, &time, CV_ONE_STEP);
    if (flag < 0) fail(time, flag);
    CVodeGetDky(memory, time, 1, rate);
    load(y);
    if (owner.after_step) owner.after_step(time - before, position, momentum);
  }
  count();
  return end - time > rounding ? time : end;
}

std::int64_t Cvode::steps() const { return shared_->steps; }
std::int64_t Cvode::rejected() const { return shared_->rejected; }

}  // namespace lichtenberg::mechanics
