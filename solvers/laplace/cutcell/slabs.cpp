#include "solvers/laplace/cutcell/slabs.hpp"

#include <petscsys.h>

#include <utility>

#include "solvers/error.hpp"
#include "solvers/parallel/petsc.hpp"

namespace lichtenberg::laplace {

namespace {

/// Throws Failure if an MPI call returned an error. Open MPI aborts all processes by default before it returns one.
void check_mpi(int code) {
  if (code != MPI_SUCCESS) throw Failure("field solver: the processes cannot exchange data (MPI error)");
}

template <class Real>
MPI_Datatype mpi_type() {
  return sizeof(Real) == sizeof(double) ? MPI_DOUBLE : MPI_FLOAT;
}

template <class Real>
void add_values(const Layout& at, Real* values, std::ptrdiff_t n) {
  if (!at.is_divided() || n == 0) return;
  check_mpi(MPI_Allreduce(MPI_IN_PLACE, values, static_cast<int>(n), mpi_type<Real>(), MPI_SUM, PETSC_COMM_WORLD));
}

/// Rows of one colour are contiguous, padding included, so that no copies are necessary.
template <class Real>
void exchange(const Layout& at, Real* v, int rows) {
  if (!at.is_divided()) return;
  const int before = at.own.begin > 0 ? parallel::process_rank() - 1 : MPI_PROC_NULL;
  const int after = at.own.end < at.ny ? parallel::process_rank() + 1 : MPI_PROC_NULL;
  const int count = static_cast<int>(rows * at.stride);
  MPI_Request requests[8];
  MPI_Request* next = requests;
  const auto receive = [&](int colour, int row, int from) {
    check_mpi(MPI_Irecv(v + at.row(colour, row), count, mpi_type<Real>(), from, colour, PETSC_COMM_WORLD, next++));
  };
  const auto send = [&](int colour, int row, int to) {
    check_mpi(MPI_Isend(v + at.row(colour, row), count, mpi_type<Real>(), to, colour, PETSC_COMM_WORLD, next++));
  };
  for (int colour = 0; colour < 2; ++colour) {
    receive(colour, at.own.begin - rows, before);
    receive(colour, at.own.end, after);
    send(colour, at.own.begin, before);
    send(colour, at.own.end - rows, after);
  }
  check_mpi(MPI_Waitall(8, requests, MPI_STATUSES_IGNORE));
}

/// Positions of the processes' parts in a concatenation.
struct Concatenation {
  std::vector<int> count, start;

  explicit Concatenation(int own) : count(parallel::process_count()), start(count.size(), 0) {
    check_mpi(MPI_Allgather(&own, 1, MPI_INT, count.data(), 1, MPI_INT, PETSC_COMM_WORLD));
    for (std::size_t k = 1; k < start.size(); ++k) start[k] = start[k - 1] + count[k - 1];
  }
};

/// The unit of the transfer is a row, because counts of MPI are integers of 32 bits.
template <class Value>
std::vector<Value> gather_values(const Layout& at, std::vector<Value> own, bool everywhere) {
  if (!at.is_divided()) return own;
  const Concatenation parts(at.own.count());
  const bool receives = everywhere || at.is_first();
  std::vector<Value> all(receives ? static_cast<std::size_t>(at.nx) * at.ny : 0);
  MPI_Datatype row = MPI_DATATYPE_NULL;
  check_mpi(MPI_Type_contiguous(static_cast<int>(at.nx * sizeof(Value)), MPI_BYTE, &row));
  check_mpi(MPI_Type_commit(&row));
  if (everywhere)
    check_mpi(MPI_Allgatherv(own.data(), at.own.count(), row, all.data(), parts.count.data(), parts.start.data(), row,
                             PETSC_COMM_WORLD));
  else
    check_mpi(MPI_Gatherv(own.data(), at.own.count(), row, all.data(), parts.count.data(), parts.start.data(), row, 0,
                          PETSC_COMM_WORLD));
  check_mpi(MPI_Type_free(&row));
  return receives ? all : own;
}

}  // namespace

void add_over_slabs(const Layout& at, double* values, std::ptrdiff_t n) { add_values(at, values, n); }
void add_over_slabs(const Layout& at, float* values, std::ptrdiff_t n) { add_values(at, values, n); }

double sum_over_slabs(const Layout& at, double value) {
  add_values(at, &value, 1);
  return value;
}

double largest_of_slabs(const Layout& at, double value) {
  if (at.is_divided()) check_mpi(MPI_Allreduce(MPI_IN_PLACE, &value, 1, MPI_DOUBLE, MPI_MAX, PETSC_COMM_WORLD));
  return value;
}

void exchange_ghosts(const Layout& at, double* v, int rows) { exchange(at, v, rows); }
void exchange_ghosts(const Layout& at, float* v, int rows) { exchange(at, v, rows); }

void gather_rows(const Layout& at, Rows own, float* v) {
  if (own.count() == at.ny) return;
  const Concatenation parts(static_cast<int>(own.count() * at.stride));
  for (int colour = 0; colour < 2; ++colour)
    check_mpi(MPI_Allgatherv(MPI_IN_PLACE, 0, MPI_DATATYPE_NULL, v + at.row(colour, 0), parts.count.data(),
                             parts.start.data(), MPI_FLOAT, PETSC_COMM_WORLD));
}

std::vector<double> gather_field(const Layout& at, std::vector<double> own, bool everywhere) {
  return gather_values(at, std::move(own), everywhere);
}
std::vector<int> gather_field(const Layout& at, std::vector<int> own, bool everywhere) {
  return gather_values(at, std::move(own), everywhere);
}

std::vector<char> gather_bytes(const std::vector<char>& bytes) {
  const Concatenation parts(static_cast<int>(bytes.size()));
  std::vector<char> all(parts.start.back() + parts.count.back());
  check_mpi(MPI_Allgatherv(bytes.data(), static_cast<int>(bytes.size()), MPI_BYTE, all.data(), parts.count.data(),
                           parts.start.data(), MPI_BYTE, PETSC_COMM_WORLD));
  return all;
}

}  // namespace lichtenberg::laplace
