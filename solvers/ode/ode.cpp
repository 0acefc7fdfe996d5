#include "solvers/ode/ode.hpp"

#include <fmt/format.h>
#include <nvector/nvector_serial.h>
#include <sunlinsol/sunlinsol_dense.h>
#include <sunlinsol/sunlinsol_spgmr.h>
#include <sunmatrix/sunmatrix_dense.h>
#include <sunnonlinsol/sunnonlinsol_fixedpoint.h>

#include <algorithm>
#include <cmath>
#include <exception>
#include <string>

#include "solvers/error.hpp"
#include "solvers/ode/sundials.hpp"

namespace lichtenberg {
namespace {

/// State for CVODE's callbacks, and the objects to release.
struct Integration {
  explicit Integration(const Ode& o) : ode(o) {}
  ~Integration();
  Integration(const Integration&) = delete;
  Integration& operator=(const Integration&) = delete;

  const Ode& ode;
  std::exception_ptr thrown;  ///< Exception of the last callback: exceptions cannot pass through C code
  std::string message;        ///< Last message of CVODE
  SUNContext context = nullptr;
  N_Vector y = nullptr, absolute = nullptr;
  SUNNonlinearSolver solver = nullptr;      ///< Null if stiff: CVODE provides Newton's method
  SUNLinearSolver linear_solver = nullptr;  ///< Only for stiff equations
  SUNMatrix matrix = nullptr;               ///< Only for a given Jacobian
  void* memory = nullptr;
};

Integration::~Integration() {
  CVodeFree(&memory);
  if (solver) SUNNonlinSolFree(solver);
  if (linear_solver) SUNLinSolFree(linear_solver);
  if (matrix) SUNMatDestroy(matrix);
  N_VDestroy(y);
  N_VDestroy(absolute);
  SUNContext_Free(&context);
}

std::span<double> values(N_Vector v) { return {N_VGetArrayPointer(v), static_cast<std::size_t>(N_VGetLength(v))}; }

template <class Body>
int guarded(void* data, const Body& body) {
  auto& self = *static_cast<Integration*>(data);
  try {
    body(self.ode);
    return 0;
  } catch (...) {
    self.thrown = std::current_exception();
    return -1;
  }
}

constexpr int try_shorter = 1;  // CVODE's code for a recoverable error, after which it tries a shorter step

int rates(double time, N_Vector y, N_Vector rate, void* data) {
  const int flag = guarded(data, [&](const Ode& ode) { ode.rates(time, values(y), values(rate)); });
  const Ode& ode = static_cast<Integration*>(data)->ode;
  if (flag != 0 || !ode.stiff) return flag;
  return std::ranges::all_of(values(rate), [](double r) { return std::isfinite(r); }) ? 0 : try_shorter;
}

int jacobian(double time, N_Vector y, N_Vector, SUNMatrix matrix, void* data, N_Vector, N_Vector, N_Vector) {
  return guarded(data, [&](const Ode& ode) {
    const std::size_t size = values(y).size();
    ode.jacobian(time, values(y), std::span(SUNDenseMatrix_Data(matrix), size * size));
  });
}

int events(double time, N_Vector y, double* value, void* data) {
  return guarded(data, [&](const Ode& ode) {
    for (const Ode::Value& falls : ode.falls) *value++ = falls(time, values(y));
  });
}

void check(const Integration& self, int flag) {
  if (flag >= 0) return;
  if (self.thrown) std::rethrow_exception(self.thrown);
  if (flag == CV_TOO_MUCH_ACC)
    throw Failure(
        fmt::format("the accuracy {:g} of a differential equation is below the rounding error of such large values",
                    self.ode.relative));
  throw Failure(fmt::format("CVODE failed: {}", self.message));
}

void set_solver(Integration& self) {
  if (self.ode.stiff && self.ode.jacobian) {
    const sunindextype size = N_VGetLength(self.y);
    self.matrix = SUNDenseMatrix(size, size, self.context);
    self.linear_solver = SUNLinSol_Dense(self.y, self.matrix, self.context);
    check(self, CVodeSetLinearSolver(self.memory, self.linear_solver, self.matrix));
    check(self, CVodeSetJacFn(self.memory, jacobian));
  } else if (self.ode.stiff) {
    constexpr int directions = 20;  // Krylov directions of GMRES
    self.linear_solver = SUNLinSol_SPGMR(self.y, SUN_PREC_NONE, directions, self.context);
    check(self, CVodeSetLinearSolver(self.memory, self.linear_solver, nullptr));
  } else {
    self.solver = SUNNonlinSol_FixedPoint(self.y, 0, self.context);
    check(self, CVodeSetNonlinearSolver(self.memory, self.solver));
  }
}

void set_up(Integration& self, double start, double end, std::span<const double> y) {
  const auto size = static_cast<sunindextype>(y.size());
  self.context = sundials::make_context();
  self.y = N_VNew_Serial(size, self.context);
  self.absolute = N_VClone(self.y);
  std::ranges::copy(y, values(self.y).begin());
  std::ranges::copy(self.ode.absolute, values(self.absolute).begin());
  self.memory = CVodeCreate(self.ode.stiff ? CV_BDF : CV_ADAMS, self.context);
  check(self, sundials::keep_messages(self.context, self.memory, self.message));
  check(self, CVodeInit(self.memory, rates, start, self.y));
  check(self, CVodeSetUserData(self.memory, &self));
  check(self, CVodeSVtolerances(self.memory, self.ode.relative, self.absolute));
  set_solver(self);
  check(self, CVodeSetMaxNumSteps(self.memory, 10'000'000));
  check(self, CVodeSetStopTime(self.memory, end));
}

void set_events(Integration& self) {
  const auto count = static_cast<int>(self.ode.falls.size());
  std::vector<int> falling(count, -1);
  check(self, CVodeRootInit(self.memory, count, events));
  if (count > 0) check(self, CVodeSetRootDirection(self.memory, falling.data()));
  check(self, CVodeSetNoInactiveRootWarn(self.memory));
}

/// Returns the first of the events that CVODE has found.
int found(const Integration& self) {
  std::vector<int> which(self.ode.falls.size());
  CVodeGetRootInfo(self.memory, which.data());
  return static_cast<int>(std::ranges::find_if(which, [](int w) { return w != 0; }) - which.begin());
}

}  // namespace

OdeEnd integrate(const Ode& ode, double start, double end, std::vector<double>& y) {
  Integration self(ode);
  set_up(self, start, end, y);
  set_events(self);
  double time = start;
  const int flag = CVode(self.memory, end, self.y, &time, CV_NORMAL);
  check(self, flag);
  std::ranges::copy(values(self.y), y.begin());
  return {time, flag == CV_ROOT_RETURN ? found(self) : -1};
}

std::vector<std::vector<double>> integrate(const Ode& ode, double start, const std::vector<double>& y,
                                           std::span<const double> times) {
  std::vector<std::vector<double>> found;
  while (found.size() < times.size() && times[found.size()] <= start) found.push_back(y);
  if (found.size() == times.size()) return found;
  Integration self(ode);
  set_up(self, start, times.back(), y);
  set_events(self);
  for (const double wanted : times.subspan(found.size())) {
    double time = start;
    const int flag = CVode(self.memory, wanted, self.y, &time, CV_NORMAL);
    check(self, flag);
    if (flag == CV_ROOT_RETURN) break;
    found.emplace_back(values(self.y).begin(), values(self.y).end());
  }
  return found;
}

}  // namespace lichtenberg
