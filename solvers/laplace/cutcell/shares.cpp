#include "solvers/laplace/cutcell/shares.hpp"

#include "solvers/error.hpp"

namespace lichtenberg::laplace {

namespace {

using parallel::Message;

enum class Action : int { solve, forget, follow, gather, end };

void put(Message& message, const LaplaceProblem& problem) {
  message.put(problem.size);
  for (const Side& side : problem.sides) {
    if (side.profile) throw Failure("field solver: a potential that varies along a side stays within one process");
    message.put(side.kind);
    message.put(side.potential);
  }
  message.put(problem.permittivity);
  for (const Body& body : problem.bodies)
    if (body.link_model)
      throw InputError("a body with a link model (LinkModel) cannot be solved by several processes: use one process");
  for (const Body& body : problem.bodies)
    if (std::holds_alternative<Freeform>(body.shape))
      throw InputError(
          "electrodes of shape polygon, ellipse or curve cannot be solved by several processes: use one process");
  message.put(problem.bodies);
  message.put(problem.groups);
  message.put(problem.couplings);
}

LaplaceProblem get_problem(Message& message) {
  LaplaceProblem problem;
  problem.size = message.get<Vec2>();
  for (Side& side : problem.sides) {
    side.kind = message.get<Side::Kind>();
    side.potential = message.get<double>();
  }
  problem.permittivity = message.get<double>();
  problem.bodies = message.get_all<Body>();
  problem.groups = message.get_all<Group>();
  problem.couplings = message.get_all<Coupling>();
  return problem;
}

Message announcement_of(Action action, int number) {
  Message message;
  message.put(action);
  message.put(number);
  return message;
}

}  // namespace

void SolverShares::operator()(Message& announcement) {
  const auto action = announcement.get<Action>();
  const int number = announcement.get<int>();
  const auto solver = solvers_.find(number);
  if (action == Action::solve) solve(number, announcement);
  if (action == Action::follow) follow(number, announcement);
  if (solver == solvers_.end()) return;
  if (action == Action::end) solvers_.erase(solver);
  if (action == Action::forget) solver->second.forget();
  if (action == Action::gather) solver->second.field();
}

/// Makes the announced solvers if they have not solved a problem yet.
void SolverShares::follow(int number, Message& announcement) {
  CutCellSolver& solver = solvers_.try_emplace(number, announcement.get<CutCellOptions>()).first->second;
  const int coarser = announcement.get<int>();
  solver.follow(solvers_.try_emplace(coarser, announcement.get<CutCellOptions>()).first->second);
}

void SolverShares::solve(int number, Message& announcement) {
  if (failed_) throw Failure("field solver: a solve after one that has failed in this process");
  try {
    const auto options = announcement.get<CutCellOptions>();
    CutCellSolver& solver = solvers_.try_emplace(number, options).first->second;
    solver.set_tolerance(options.tolerance);
    solver.solve(get_problem(announcement));
  } catch (const InputError&) {
  } catch (...) {
    failed_ = true;
    throw;
  }
}

void announce_solve(int solver, const CutCellOptions& options, const LaplaceProblem& problem) {
  if (!parallel::is_leading_process()) return;
  Message message = announcement_of(Action::solve, solver);
  message.put(options);
  put(message, problem);
  parallel::broadcast(message);
}

void announce_forgetting(int solver) {
  if (parallel::is_leading_process()) parallel::broadcast(announcement_of(Action::forget, solver));
}

void announce_following(int solver, const CutCellOptions& options, int coarser, const CutCellOptions& coarser_options) {
  if (!parallel::is_leading_process()) return;
  Message message = announcement_of(Action::follow, solver);
  message.put(options);
  message.put(coarser);
  message.put(coarser_options);
  parallel::broadcast(message);
}

void announce_gathering(int solver) {
  if (parallel::is_leading_process()) parallel::broadcast(announcement_of(Action::gather, solver));
}

void announce_end(int solver) {
  if (parallel::is_leading_process()) parallel::broadcast(announcement_of(Action::end, solver));
}

}  // namespace lichtenberg::laplace
