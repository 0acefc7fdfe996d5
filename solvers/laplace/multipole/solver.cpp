#include "solvers/laplace/multipole/solver.hpp"

#include <chrono>

#include "solvers/error.hpp"
#include "solvers/laplace/multipole/krylov.hpp"
#include "solvers/laplace/multipole/results.hpp"
#include "solvers/laplace/multipole/system.hpp"

namespace lichtenberg::laplace {

namespace {

/// Errors of potentials and forces are up to this many times GMRES's residual (measured; gaps down to 1e-4 R).
constexpr double krylov_error = 10;

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

void check(const LaplaceProblem& problem, const MultipoleOptions& options) {
  problem.check();
  for (const Side& side : problem.sides) {
    if (side.profile) throw InputError("the multipole method needs sides of constant potential, not a profile");
    if (options.unbounded && side.kind == Side::Kind::electrode)
      throw InputError("an unbounded problem has no electrode sides: all sides must be insulating");
  }
}

std::array<double, 4> side_potentials(const LaplaceProblem& problem) {
  std::array<double, 4> potential;
  for (int s = 0; s < 4; ++s) potential[s] = problem.sides[s].potential;
  return potential;
}

}  // namespace

struct MultipoleSolver::Implementation {
  explicit Implementation(MultipoleOptions o) : options(o) {}

  /// Everything that belongs to the last problem.
  struct State {
    State(const LaplaceProblem& p, const MultipoleOptions& options)
        : problem(p),
          mirrors(options.unbounded ? Mirrors() : Mirrors(problem)),
          lattice(mirrors),
          wall(mirrors, lattice, side_potentials(problem)),
          arrangement(problem, mirrors, options.tolerance),
          layout(arrangement.sources) {}
    State(const State&) = delete;
    State& operator=(const State&) = delete;

    LaplaceProblem problem;
    Mirrors mirrors;
    LatticeSum lattice;
    WallField wall;
    Arrangement arrangement;
    Layout layout;
    std::unique_ptr<FarField> far;
    std::vector<Complex> coefficients;
    Eigen::VectorXd extra;  ///< unknowns other than multipoles
    std::vector<double> group_potential;
    double level = 0;
  };

  MultipoleOptions options;
  std::unique_ptr<State> state;

  LaplaceSolution solve(const LaplaceProblem& problem);
  double tail(const State& s) const;
  double potential(Complex z, int& body) const;
};

LaplaceSolution MultipoleSolver::Implementation::solve(const LaplaceProblem& problem) {
  const auto start = std::chrono::steady_clock::now();
  auto next = std::make_unique<State>(problem, options);
  State& s = *next;
  const Cells& cells = s.arrangement.cells;
  const int far_order = static_cast<int>(std::ceil(std::log(0.1 * options.tolerance) / std::log(cells.separation))) + 1;
  if (state && state->far && state->far->fits(s.mirrors, cells, far_order))
    s.far = std::move(state->far);
  else
    s.far = std::make_unique<FarField>(s.mirrors, s.lattice, cells, far_order);
  const System system(s.problem, s.arrangement, s.lattice, s.wall, *s.far, s.mirrors, 0.1 * options.tolerance);
  LaplaceSolution solution;
  solution.unknowns = system.size();
  solution.seconds.setup = seconds_since(start);

  const auto solve_start = std::chrono::steady_clock::now();
  Eigen::VectorXd x = state ? system.first_guess(state->layout, state->coefficients, state->extra)
                            : Eigen::VectorXd(Eigen::VectorXd::Zero(system.size()));
  state.reset();
  const KrylovResult krylov = solve_krylov(system, system.right_hand_side(), 0.01 * options.tolerance, x);
  solution.iterations = krylov.iterations;
  solution.seconds.solve = seconds_since(solve_start);

  const auto results_start = std::chrono::steady_clock::now();
  s.coefficients = system.coefficients(x);
  s.extra = system.extra(x);
  System::Potentials potentials = system.potentials(x, s.coefficients);
  s.level = potentials.level;
  s.group_potential = solution.group_potential = std::move(potentials.group);
  solution.residual = std::max(krylov_error * krylov.residual, tail(s));
  evaluate(s.problem, s.mirrors, s.lattice, s.wall, s.arrangement, s.coefficients, solution);
  solution.seconds.forces = seconds_since(results_start);
  state = std::move(next);
  return solution;
}

/// Estimates what the multipoles beyond the order of some disk add up to, over the largest coefficient of all: a
/// geometric series from the last ones, with the ratio at which they fell off in the second half.
double MultipoleSolver::Implementation::tail(const State& s) const {
  constexpr double largest_ratio = 0.999;
  double worst = 0, largest = 0;
  for (const Complex& a : s.coefficients) largest = std::max(largest, std::abs(a));
  for (int i = 0; i < s.arrangement.disks; ++i) {
    const Complex* a = &s.coefficients[s.layout.start[i]];
    const int order = s.layout.order(i), half = order / 2;
    if (half < 2) continue;
    // By symmetry every other one may vanish.
    const double last = std::max(std::abs(a[order]), std::abs(a[order - 1]));
    const double middle = std::max(std::abs(a[half]), std::abs(a[half - 1]));
    if (last == 0) continue;
    const double ratio =
        middle > last ? std::min(largest_ratio, std::pow(last / middle, 1.0 / (order - half))) : largest_ratio;
    worst = std::max(worst, last * ratio / (1 - ratio));
  }
  return largest > 0 ? worst / largest : 0.0;
}

/// Far cells by the local series of the point's cell, near disks one by one. Sets `body` to the disk that covers z.
double MultipoleSolver::Implementation::potential(Complex z, int& body) const {
  if (!state) throw Failure("the multipole method has no field yet: nothing has been solved");
  const State& s = *state;
  body = -1;
  const double negligible = 1e-4 * options.tolerance * options.tolerance;  // of the power's square
  double sum = s.level + (s.mirrors.bounded ? s.wall.potential(z) : 0.0);
  const auto add = [&](int i, const Image& image, Complex shift) {
    const Source& disk = s.arrangement.sources[i];
    const Complex d = z - image.centre(disk.centre) - shift;
    if (std::abs(d) < disk.radius) body = i;
    const Complex* a = &s.coefficients[s.layout.start[i]];
    const Complex ratio = disk.radius / d;
    Complex power = 1;
    sum -= image.sign * a[0].real() * std::log(std::abs(d));
    for (int k = 1; k <= disk.order && std::norm(power) > negligible; ++k) {
      power = multiply(power, ratio);
      sum += multiply(image.coefficient(k, a[k]), power).real();
    }
  };
  const Cells& cells = s.arrangement.cells;
  if (s.mirrors.bounded || cells.contains(z)) {
    cells.for_each_near(z, add);
    const int cell = cells.cell_of(z);
    const Complex t = (z - cells.centre(cell % cells.nx, cell / cells.nx)) / s.far->scale();
    Complex power = 1;
    for (int m = 0; m <= s.far->order(); ++m) {
      sum += multiply(s.far->local(cell)[m], power).real();
      power = multiply(power, t) / (m + 1.0);
    }
  } else {
    for (std::size_t i = 0; i < s.arrangement.sources.size(); ++i) add(static_cast<int>(i), Image{}, 0);
  }
  return body < 0 ? sum : s.group_potential[s.problem.bodies[body].group];
}

MultipoleSolver::MultipoleSolver(MultipoleOptions options)
    : implementation_(std::make_unique<Implementation>(options)) {}
MultipoleSolver::~MultipoleSolver() = default;

LaplaceSolution MultipoleSolver::solve(const LaplaceProblem& problem) {
  check(problem, implementation_->options);
  return implementation_->solve(problem);
}

double MultipoleSolver::potential(Vec2 p) const {
  int body = -1;
  return implementation_->potential(to_complex(p), body);
}

Field MultipoleSolver::field() const {
  if (!implementation_->state) throw Failure("the multipole method has no field yet: nothing has been solved");
  const Vec2 size = implementation_->state->problem.size;
  Field field;
  field.h = std::max(size.x, size.y) / implementation_->options.cells;
  field.nx = static_cast<int>(std::lround(size.x / field.h));
  field.ny = static_cast<int>(std::lround(size.y / field.h));
  field.value.resize(static_cast<std::size_t>(field.nx) * field.ny);
  field.body.resize(field.value.size());
  for (int j = 0; j < field.ny; ++j)
    for (int i = 0; i < field.nx; ++i) {
      const std::size_t at = static_cast<std::size_t>(j) * field.nx + i;
      field.value[at] = implementation_->potential({(i + 0.5) * field.h, (j + 0.5) * field.h}, field.body[at]);
    }
  return field;
}

void MultipoleSolver::forget() { implementation_->state.reset(); }

}  // namespace lichtenberg::laplace
