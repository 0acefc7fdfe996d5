#include "solvers/laplace/cutcell/processes.hpp"

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <map>
#include <string>
#include <thread>
#include <type_traits>
#include <vector>

#include "solvers/error.hpp"
#include "solvers/laplace/cutcell/petsc.hpp"

namespace lichtenberg::laplace {

namespace {

enum class Word : int { solve, forget, end, dismissed };
constexpr int tag = 1;

/// How long a process waits for another's word after something went wrong. An error that all have is found by all at
/// about the same time; one that has it alone must not leave the others waiting for it forever.
constexpr std::chrono::seconds patience{2};

bool leading = false;

/// A message: plain structs and arrays of them, one after the other.
struct Message {
  std::vector<char> bytes;
  std::size_t at = 0;

  template <class T>
  void put(const T& value) {
    static_assert(std::is_trivially_copyable_v<T>);
    bytes.resize(bytes.size() + sizeof(T));
    std::memcpy(bytes.data() + bytes.size() - sizeof(T), &value, sizeof(T));
  }
  template <class T>
  void put(const std::vector<T>& values) {
    put(values.size());
    for (const T& value : values) put(value);
  }
  template <class T>
  T get() {
    T value;
    std::memcpy(&value, bytes.data() + at, sizeof(T));
    at += sizeof(T);
    return value;
  }
  template <class T>
  std::vector<T> get_all() {
    std::vector<T> values(get<std::size_t>());
    for (T& value : values) value = get<T>();
    return values;
  }
};

void put(Message& message, const LaplaceProblem& problem) {
  message.put(problem.size);
  for (const Side& side : problem.sides) {
    if (side.profile) throw Failure("field solver: a potential that varies along a side stays within one process");
    message.put(side.kind);
    message.put(side.potential);
  }
  message.put(problem.permittivity);
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

void send_to_others(const Message& message) {
  for (int rank = 1; rank < process_count(); ++rank)
    MPI_Send(message.bytes.data(), static_cast<int>(message.bytes.size()), MPI_BYTE, rank, tag, PETSC_COMM_WORLD);
}

Message receive(int from) {
  MPI_Status status;
  MPI_Probe(from, tag, PETSC_COMM_WORLD, &status);
  int size = 0;
  MPI_Get_count(&status, MPI_BYTE, &size);
  Message message{std::vector<char>(size)};
  MPI_Recv(message.bytes.data(), size, MPI_BYTE, from, tag, PETSC_COMM_WORLD, MPI_STATUS_IGNORE);
  return message;
}

/// False if nothing has come when patience ends.
bool hears_from(int rank) {
  const auto end = std::chrono::steady_clock::now() + patience;
  while (std::chrono::steady_clock::now() < end) {
    int there = 0;
    MPI_Iprobe(rank, tag, PETSC_COMM_WORLD, &there, MPI_STATUS_IGNORE);
    if (there) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return false;
}

[[noreturn]] void abort_all(const std::string& trouble) {
  std::fprintf(stderr, "lichtenberg, process %d: %s\n", process_rank(), trouble.c_str());
  MPI_Abort(PETSC_COMM_WORLD, 1);
  std::abort();
}

using Solvers = std::map<int, CutCellSolver>;

/// Returns what went wrong, nothing if nothing did or if it is the problem's fault: then the first process knows too.
std::string take_part_in_solve(Solvers& solvers, int number, Message& message) {
  try {
    const auto options = message.get<CutCellOptions>();
    CutCellSolver& solver = solvers.try_emplace(number, options).first->second;
    solver.set_tolerance(options.tolerance);
    solver.solve(get_problem(message));
  } catch (const InputError&) {
  } catch (const std::exception& error) {
    return error.what();
  }
  return {};
}

/// Until the first process has no more need of this one.
void take_part() {
  Solvers solvers;
  std::string trouble;
  for (;;) {
    if (!trouble.empty() && !hears_from(0)) abort_all(trouble);
    Message message = receive(0);
    const auto word = message.get<Word>();
    if (word == Word::dismissed) {
      MPI_Send(nullptr, 0, MPI_BYTE, 0, tag, PETSC_COMM_WORLD);
      return;
    }
    const int number = message.get<int>();
    if (word == Word::end) solvers.erase(number);
    if (const auto solver = solvers.find(number); word == Word::forget && solver != solvers.end())
      solver->second.forget();
    if (word == Word::solve) {
      if (!trouble.empty()) abort_all(trouble);  // the first process goes on as if nothing had happened
      trouble = take_part_in_solve(solvers, number, message);
    }
  }
}

Message say(Word word, int number = 0) {
  Message message;
  message.put(word);
  message.put(number);
  return message;
}

bool launched_with_others() {
  for (const char* name : {"OMPI_COMM_WORLD_SIZE", "PMI_SIZE", "SLURM_STEP_NUM_TASKS"})
    if (const char* size = std::getenv(name); size && std::atoi(size) > 1) return true;
  return false;
}

}  // namespace

bool join_processes() {
  if (!launched_with_others()) return true;
#ifdef PETSC_HAVE_MPIUNI
  throw InputError("this program stands on a PETSc without MPI and runs on one process: start it without mpirun");
#endif
  start_petsc();
  if (process_rank() > 0) {
    take_part();
    return false;
  }
  leading = process_count() > 1;
  return true;
}

void dismiss_processes(bool after_error) {
  if (!leading) return;
  leading = false;
  send_to_others(say(Word::dismissed));
  for (int rank = 1; rank < process_count(); ++rank) {
    // It may wait for what the error has kept this one from.
    if (after_error && !hears_from(rank)) MPI_Abort(PETSC_COMM_WORLD, 1);
    receive(rank);
  }
}

void announce_solve(int solver, const CutCellOptions& options, const LaplaceProblem& problem) {
  if (!leading) return;
  Message message = say(Word::solve, solver);
  message.put(options);
  put(message, problem);
  send_to_others(message);
}

void announce_forgetting(int solver) {
  if (leading) send_to_others(say(Word::forget, solver));
}

void announce_end(int solver) {
  if (leading) send_to_others(say(Word::end, solver));
}

}  // namespace lichtenberg::laplace
