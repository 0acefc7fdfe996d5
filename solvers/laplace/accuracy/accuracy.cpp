#include "solvers/laplace/accuracy/accuracy.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <numbers>

#include "solvers/error.hpp"
#include "solvers/geometry/closed_curve.hpp"
#include "solvers/laplace/accuracy/cost_model.hpp"
#include "solvers/laplace/accuracy/gaps.hpp"
#include "solvers/laplace/accuracy/grids.hpp"
#include "solvers/laplace/measure.hpp"
#include "solvers/laplace/multipole/solver.hpp"

namespace lichtenberg::laplace {
namespace {

// Factors without a derivation are empirical (docs/measurements/accuracy.json).

/// CG's error in the energy norm, in units of the accuracy. Errors in potentials and forces can be much larger.
constexpr double linear_share = 1e-4;
constexpr double finest_tolerance = 1e-13, coarsest_accuracy = 0.1;

constexpr double estimate_over_error = 2.5;  // Typical ratio for the cut-cell method

/// Safety factor on the prediction of the worst of five coarser grids. It is larger if the narrowest gap has only a
/// cell or two, because errors do not decrease regularly yet.
constexpr double regular_from = 2;  // Cells
double safety(double cells_in_gap) { return cells_in_gap < 1 ? 7 : cells_in_gap < regular_from ? 3 : 2; }

bool reaches_a_side(const Ring& ring, Vec2 size) {
  const Vec2 c = ring.centre;
  return ring.radius >= std::min({c.x, size.x - c.x, c.y, size.y - c.y});
}

bool reaches_a_side(const ClosedCurve& curve, Vec2 size) {
  return std::min(curve.low().x, curve.low().y) <= 0 || curve.high().x >= size.x || curve.high().y >= size.y;
}

/// Returns the order of the error for a corner of this exterior angle. With w = pi + angle of fluid around the corner
/// the potential varies like r^(pi/w), and fluxes through cells of size h are wrong by h^(2 pi/w).
double order_at_corner(double angle) { return 2 * std::numbers::pi / (std::numbers::pi + angle); }

/// Returns the order of the error, h^order, on grids of cells down from this size (m). A bar has corners of pi / 2. A
/// closed curve has a corner where the direction of its surface rotates much within a cell. If a rim or a curve reaches
/// a side of the box, cells with faces on the covered part treat these as insulating: first order.
double order_of(const LaplaceProblem& problem, double cell) {
  constexpr double little = 0.5;  // A circle of two cells' radius: errors decrease regularly
  double order = 2;
  for (const Body& body : problem.bodies) {
    if (std::holds_alternative<Bar>(body.shape)) order = std::min(order, 4.0 / 3);
    if (const auto* freeform = std::get_if<Freeform>(&body.shape)) {
      if (const double rotation = freeform->curve->largest_rotation(cell); rotation > little)
        order = std::min(order, order_at_corner(rotation));
      if (reaches_a_side(*freeform->curve, problem.size)) order = 1;
    }
    const Ring* ring = std::get_if<Ring>(&body.shape);
    if (ring && reaches_a_side(*ring, problem.size)) order = 1;
  }
  return order;
}

double cut_cell_tolerance(double accuracy) { return std::max(linear_share * accuracy, finest_tolerance); }

double refusal_margin(double estimate) { return 1.5 * estimate; }

[[noreturn]] void refuse(const AccuracyRequest& request, const std::string& why, double possible,
                         const std::string& instead = "") {
  const double stated_accuracy = request.reserve * refusal_margin(possible);
  const std::string can =
      stated_accuracy <= coarsest_accuracy ? fmt::format("about {:.1e}", stated_accuracy) : "not even 0.1";
  throw InputError(fmt::format("field.accuracy = {:g} cannot be met: {} {} would be possible{}",
                               request.reserve * request.accuracy, why, can, instead));
}

/// Solutions of one problem on grids of different cell size, each computed once.
class GridSolutions {
 public:
  GridSolutions(const LaplaceProblem& problem, CutCellOptions options) : problem_(problem), options_(options) {}

  const LaplaceSolution& on(int cells) {
    if (const auto known = solutions_.find(cells); known != solutions_.end()) return known->second;
    options_.cells = cells;
    auto solver = std::make_unique<CutCellSolver>(options_);
    LaplaceSolution& solution = solutions_[cells] = solver->solve(problem_);
    if (cells > finest_) {
      finest_ = cells;
      solver_ = std::move(solver);
    }
    return solution;
  }

  /// Returns an upper estimate of the error of the solution on `cells`. Each of five coarser grids predicts it from the
  /// difference to that solution, for regular convergence in h. Predictions vary with the positions of surfaces within
  /// their cells; the worst of five avoids accidental agreement.
  double error(int cells) {
    const LaplaceSolution& fine = on(cells);
    const Scales scales = scales_of(problem_, fine);
    const double cell = std::max(problem_.size.x, problem_.size.y) / cells, order = order_of(problem_, 4 * cell);
    double worst = 0;
    for (const int sixteenths : {8, 7, 6, 5, 4}) {
      const double falls = std::pow(sixteenths / 16.0, order);
      const double difference = largest_error(problem_, on(cells / 16 * sixteenths), fine, scales);
      worst = std::max(worst, difference * falls / (1 - falls));
    }
    return safety(narrowest(problem_).gap / cell) * worst;
  }

  std::unique_ptr<CutCellSolver> take_finest() { return std::move(solver_); }

 private:
  const LaplaceProblem& problem_;
  CutCellOptions options_;
  std::map<int, LaplaceSolution> solutions_;
  int finest_ = 0;
  std::unique_ptr<CutCellSolver> solver_;
};

MultipoleOptions multipole_options(const Choice& choice) {
  return {.tolerance = choice.tolerance, .results_only = true, .cells = choice.cells};
}

bool are_charges_given(const LaplaceProblem& problem) {
  std::vector<int> members(problem.groups.size());
  for (const Body& body : problem.bodies) ++members[body.group];
  return std::ranges::all_of(problem.bodies, [&](const Body& body) {
    return problem.groups[body.group].floating && members[body.group] == 1;
  });
}

/// Returns the largest force (N/m) on any disk, or the limit of small forces; the error of forces is proportional to
/// it.
double largest_force(const LaplaceProblem& problem, const Scales& scales, const LaplaceSolution& solution) {
  double largest = small_values(problem, scales).force;
  for (std::size_t b = 0; b < problem.bodies.size(); ++b)
    if (std::holds_alternative<Disk>(problem.bodies[b].shape))
      largest = std::max(largest, norm(solution.body_force[b]));
  return largest;
}

/// Returns the tolerance, or the solution's own estimate if it is larger, or more for small charges or forces.
double multipole_estimate(const LaplaceProblem& problem, const Choice& choice, const LaplaceSolution& solution) {
  const Scales scales = scales_of(problem, solution);
  const double small_charge = are_charges_given(problem) ? 0 : small_values(problem, scales).charge;
  const double largest = largest_force(problem, scales, solution);
  const double force_error = largest > scales.force ? scales.error_of_force(choice.tolerance * largest) : 0;
  return std::max(
      {choice.tolerance, solution.residual, scales.error_of_charge(choice.tolerance * small_charge), force_error});
}

/// Returns the number of unknowns of the multipole method if it supports the problem.
std::optional<long> multipoles_possible(const LaplaceProblem& problem, double tolerance) {
  try {
    return multipole_unknowns(problem, {.tolerance = tolerance, .results_only = true});
  } catch (const InputError&) {
    return std::nullopt;
  }
}

/// The coarser grids, with a quarter of the cells, must resolve the disks, within the limits of an inexpensive grid.
constexpr double least_radius = 3, least_for_radius = 512;  // Cells

/// Returns the factor by which the error grows when bodies of different potential reach the smallest gap of the
/// request.
double error_growth_to_least_gap(const LaplaceProblem& problem, double least_gap) {
  const NarrowGap now = narrowest(problem);
  return std::pow(now.gap / std::min(now.gap, least_gap), 1.5);
}

Choice predict_cut_cell(const LaplaceProblem& problem, const AccuracyRequest& request) {
  const Grids grids(problem.size);
  const int most = grids.at_most(request.most_cells);
  const double side = std::max(problem.size.x, problem.size.y);
  NarrowGap narrow_gap = narrowest(problem);
  narrow_gap.gap = std::min(narrow_gap.gap, request.least_gap);
  constexpr double expected = estimate_over_error * likely_error;
  const double needed = std::max(side / cell_for(narrow_gap, request.accuracy / expected),
                                 std::min(least_radius * side / narrow_gap.radius, least_for_radius));
  Choice choice{.method = Method::cut_cell, .tolerance = cut_cell_tolerance(request.accuracy)};
  choice.cells = needed < most ? std::min(grids.at_least(static_cast<int>(needed)), most) : most;
  choice.estimate = expected * difficulty(narrow_gap, side / choice.cells);
  return choice;
}

Choice predict_multipole(const LaplaceProblem& problem, const AccuracyRequest& request) {
  constexpr int usual_cells = 512;  // Cells of `field()`
  const Grids grids(problem.size);
  const int cells = std::min(grids.at_least(usual_cells), grids.at_most(request.most_cells));
  return {Method::multipole, cells, std::max(request.accuracy, finest_tolerance), request.accuracy};
}

/// Throws InputError if the accuracy is out of reach. The prediction is empirical, so the possible accuracy is stated
/// with a factor of five.
void check_attainable(const Choice& predicted, const AccuracyRequest& request) {
  constexpr double unattainable_factor = 30, uncertainty = 5;
  if (predicted.estimate > unattainable_factor * request.accuracy)
    refuse(request, fmt::format("with {} cells along the longer side, the most possible here,", predicted.cells),
           uncertainty * predicted.estimate);
}

/// Returns true if the multipole method is cheaper, including the coarser solutions of the cut-cell method.
bool multipole_is_cheaper(const LaplaceProblem& problem, long unknowns, const Choice& multipole,
                          const Choice& cut_cell) {
  constexpr double coarser_grids = 1.75;
  const double cells = cut_cell.cells * static_cast<double>(cut_cell.cells) * std::min(problem.size.x, problem.size.y) /
                       std::max(problem.size.x, problem.size.y);
  return multipole_cost.seconds(static_cast<double>(unknowns), multipole.tolerance) <
         coarser_grids * cut_cell_cost.seconds(cells, cut_cell.tolerance);
}

AccurateSolution solve_by_multipoles(const LaplaceProblem& problem, const AccuracyRequest& request, Choice choice) {
  constexpr double margin = 0.8, most_finer = 1e-2;
  for (double least = INFINITY, finer = 1;;) {
    choice.tolerance = std::max(finer * choice.tolerance, finest_tolerance);
    auto solver = std::make_unique<MultipoleSolver>(multipole_options(choice));
    LaplaceSolution solution = solver->solve(problem);
    choice.estimate = multipole_estimate(problem, choice, solution);
    if (choice.estimate <= request.accuracy) return {choice, std::move(solver), std::move(solution)};
    least = std::min(least, choice.estimate);
    if (choice.tolerance == finest_tolerance)
      refuse(request, "rounding ends the multipole method's digits here, and", least);
    finer = std::max(margin * request.accuracy / choice.estimate, most_finer);  // Errors scale with the tolerance
  }
}

/// Returns the next grid after one whose estimate was too large by a factor of `excess`, with limited growth. Returns 0
/// if no grid would suffice; `regular`: true if errors decrease regularly, which permits this conclusion for distant
/// grids.
int next_grid(const Grids& grids, int cells, int most, double excess, double order, bool regular) {
  constexpr double margin = 1.05, least_growth = 1.2, most_growth = 4, hope = 2;
  const double growth = margin * std::pow(excess, 1 / order), possible = static_cast<double>(most) / cells;
  if (cells == most || (regular && excess > hope * std::pow(possible, order))) return 0;
  return std::min(grids.at_least(static_cast<int>(cells * std::clamp(growth, least_growth, most_growth))), most);
}

/// Returns the factor that tightens CG's tolerance for small forces. CG stops at a share of the field's energy,
/// relative to which forces may be small.
double share_of_largest_force(const LaplaceProblem& problem, const LaplaceSolution& solution) {
  const Scales scales = scales_of(problem, solution);
  if (scales.potential == 0) return 1;
  constexpr double least = 1e-3;
  return std::clamp(scales.force / largest_force(problem, scales, solution), least, 1.0);
}

/// Returns the factor that tightens CG's tolerance for small potential differences. CG stops at a share of the
/// potentials, but only their differences matter; they are small if all potentials are far from 0 and close to each
/// other.
double differences_over_level(const LaplaceProblem& problem, const LaplaceSolution& solution) {
  double level = 0;
  for (const double potential : solution.group_potential) level = std::max(level, std::abs(potential));
  for (const Side& side : problem.sides)
    if (side.kind == Side::Kind::electrode) level = std::max(level, std::abs(side.potential));
  const double differences = scales_of(problem, solution).potential;
  return differences < level ? differences / level : 1;
}

/// Returns the part of an error message on small forces, and on a method that can resolve them.
std::string instead_of_grids(const LaplaceProblem& problem, double accuracy, const LaplaceSolution& solution) {
  std::string text;
  if (share_of_largest_force(problem, solution) < 1)
    text = "; the largest force on a conductor is a small remainder of much larger contributions";
  if (multipoles_possible(problem, accuracy)) text += "; field.method = \"multipole\" can do it";
  return text;
}

AccurateSolution solve_on_grids(const LaplaceProblem& problem, const AccuracyRequest& request, Choice choice) {
  const Grids grids(problem.size);
  const int most = grids.at_most(request.most_cells);
  CutCellOptions options = request.cut_cell;
  // An inexpensive grid first: its result predicts the required cells better than the empirical formula.
  constexpr int cheap = 1024;
  choice.cells = std::min({choice.cells, most, grids.at_least(cheap)});
  const LaplaceSolution rough = GridSolutions(problem, options).on(choice.cells / 16 * 4);
  const double finer = differences_over_level(problem, rough) * share_of_largest_force(problem, rough);
  choice.tolerance = std::max(choice.tolerance * finer, finest_tolerance);
  options.tolerance = choice.tolerance;
  GridSolutions solutions(problem, options);
  const double side = std::max(problem.size.x, problem.size.y);
  const double error_growth = error_growth_to_least_gap(problem, request.least_gap);
  const double gap = narrowest(problem).gap / std::max(problem.size.x, problem.size.y);
  while ((choice.estimate = error_growth * solutions.error(choice.cells)) > request.accuracy) {
    const double order = order_of(problem, 4 * side / choice.cells);
    const bool regular = gap * choice.cells > regular_from && order == order_of(problem, 4 * side / most);
    const int next = next_grid(grids, choice.cells, most, choice.estimate / request.accuracy, order, regular);
    if (next == 0) {
      const double possible = choice.estimate * std::pow(static_cast<double>(choice.cells) / most, order);
      refuse(request, fmt::format("with {} cells along the longer side, the most possible here,", most), possible,
             instead_of_grids(problem, request.accuracy, solutions.on(choice.cells)));
    }
    choice.cells = next;
  }
  const LaplaceSolution solution = solutions.on(choice.cells);
  return {choice, solutions.take_finest(), solution};
}

}  // namespace

Choice predict_choice(const LaplaceProblem& problem, const AccuracyRequest& request) {
  if (!(request.accuracy >= finest_accuracy && request.accuracy <= coarsest_accuracy))
    throw InputError(fmt::format("an accuracy of {:g} is not allowed: it must be between {:g} and {:g}",
                                 request.reserve * request.accuracy, request.reserve * finest_accuracy,
                                 coarsest_accuracy));
  if (request.method == Method::multipole) {
    const Choice choice = predict_multipole(problem, request);
    multipole_unknowns(problem, multipole_options(choice));
    return choice;
  }
  const Choice cut_cell = predict_cut_cell(problem, request);
  if (request.method) {
    check_attainable(cut_cell, request);
    return cut_cell;
  }
  const Choice multipole = predict_multipole(problem, request);
  const std::optional<long> unknowns = multipoles_possible(problem, multipole.tolerance);
  if (unknowns &&
      (cut_cell.estimate > request.accuracy || multipole_is_cheaper(problem, *unknowns, multipole, cut_cell)))
    return multipole;
  check_attainable(cut_cell, request);
  return cut_cell;
}

double estimated_error(const LaplaceProblem& problem, const Choice& choice, const CutCellOptions& cut_cell) {
  if (choice.method == Method::multipole)
    return multipole_estimate(problem, choice, MultipoleSolver(multipole_options(choice)).solve(problem));
  CutCellOptions options = cut_cell;
  options.tolerance = choice.tolerance;
  return GridSolutions(problem, options).error(choice.cells);
}

AccurateSolution solve_to_accuracy(const LaplaceProblem& problem, const AccuracyRequest& request) {
  const Choice choice = predict_choice(problem, request);
  if (choice.method == Method::multipole) return solve_by_multipoles(problem, request, choice);
  return solve_on_grids(problem, request, choice);
}

}  // namespace lichtenberg::laplace
