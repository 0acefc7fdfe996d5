#include "solvers/parallel/processes.hpp"

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <string>
#include <thread>

#include "solvers/error.hpp"
#include "solvers/parallel/petsc.hpp"

namespace lichtenberg::parallel {

namespace {

/// Tags of messages: one for `handle_message`, and the last one.
constexpr int work_tag = 1, dismissal_tag = 2;

/// Time limit for a message from another process after an error. An error common to all processes occurs in all at
/// about the same time. A process with an error of its own must not block the others forever.
constexpr std::chrono::seconds message_timeout{2};

bool leading = false;

void send_to_others(const Message& message, int tag) {
  const std::vector<char>& bytes = message.bytes();
  for (int rank = 1; rank < process_count(); ++rank)
    MPI_Send(bytes.data(), static_cast<int>(bytes.size()), MPI_BYTE, rank, tag, PETSC_COMM_WORLD);
}

/// Waits for a message from a process. MPI's own functions would keep the core busy while the first process works alone
/// on the motion. The waiting process polls, and sleeps between polls if no message has come for some time.
void wait_for_message(int rank) {
  constexpr std::chrono::microseconds polling_time{1000}, sleeping_time{50};
  const auto start = std::chrono::steady_clock::now();
  for (int there = 0;;) {
    MPI_Iprobe(rank, MPI_ANY_TAG, PETSC_COMM_WORLD, &there, MPI_STATUS_IGNORE);
    if (there) return;
    if (std::chrono::steady_clock::now() - start < polling_time)
      std::this_thread::yield();
    else
      std::this_thread::sleep_for(sleeping_time);
  }
}

Message receive(int from, int* tag) {
  wait_for_message(from);
  MPI_Status status;
  MPI_Probe(from, MPI_ANY_TAG, PETSC_COMM_WORLD, &status);
  *tag = status.MPI_TAG;
  int size = 0;
  MPI_Get_count(&status, MPI_BYTE, &size);
  std::vector<char> bytes(size);
  MPI_Recv(bytes.data(), size, MPI_BYTE, from, *tag, PETSC_COMM_WORLD, MPI_STATUS_IGNORE);
  return Message(std::move(bytes));
}

/// Returns false if no message arrives within `message_timeout`.
bool has_message_from(int rank) {
  const auto end = std::chrono::steady_clock::now() + message_timeout;
  while (std::chrono::steady_clock::now() < end) {
    int there = 0;
    MPI_Iprobe(rank, MPI_ANY_TAG, PETSC_COMM_WORLD, &there, MPI_STATUS_IGNORE);
    if (there) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return false;
}

[[noreturn]] void abort_all(const std::string& error_text) {
  std::fprintf(stderr, "lichtenberg, process %d: %s\n", process_rank(), error_text.c_str());
  MPI_Abort(PETSC_COMM_WORLD, 1);
  std::abort();
}

/// Handles messages until the first process dismisses this one.
void handle_messages(const std::function<void(Message&)>& handle_message) {
  std::string error_text;
  for (;;) {
    if (!error_text.empty() && !has_message_from(0)) abort_all(error_text);
    int tag = 0;
    Message message = receive(0, &tag);
    if (tag == dismissal_tag) {
      MPI_Send(nullptr, 0, MPI_BYTE, 0, dismissal_tag, PETSC_COMM_WORLD);
      return;
    }
    try {
      handle_message(message);
    } catch (const std::exception& error) {
      if (!error_text.empty()) abort_all(error_text);  // The first process continues, so the error is not common to all
      error_text = error.what();
    }
  }
}

bool launched_with_others() {
  for (const char* name : {"OMPI_COMM_WORLD_SIZE", "PMI_SIZE", "SLURM_STEP_NUM_TASKS"})
    if (const char* size = std::getenv(name); size && std::atoi(size) > 1) return true;
  return false;
}

}  // namespace

bool join_processes(const std::function<void(Message&)>& handle_message) {
  if (!launched_with_others()) return true;
#ifdef PETSC_HAVE_MPIUNI
  throw InputError("this program uses a PETSc without MPI and runs as one process: start it without mpirun");
#endif
  start_petsc();
  if (process_rank() > 0) {
    handle_messages(handle_message);
    return false;
  }
  leading = process_count() > 1;
  return true;
}

bool is_leading_process() { return leading; }

void dismiss_processes(bool after_error) {
  if (!leading) return;
  leading = false;
  send_to_others({}, dismissal_tag);
  for (int rank = 1; rank < process_count(); ++rank) {
    // Without a message in time, the process waits for data that this one cannot send after the error.
    if (after_error && !has_message_from(rank)) MPI_Abort(PETSC_COMM_WORLD, 1);
    int tag = 0;
    receive(rank, &tag);
  }
}

void broadcast(const Message& message) { send_to_others(message, work_tag); }

}  // namespace lichtenberg::parallel
