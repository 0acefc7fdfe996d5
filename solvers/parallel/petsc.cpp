#include "solvers/parallel/petsc.hpp"

#include <dlfcn.h>

#include <cctype>
#include <cstdlib>

#include "solvers/error.hpp"

namespace lichtenberg::parallel {

namespace {

std::vector<std::string>& options() {
  static std::vector<std::string> list;
  return list;
}

// PETSc prints errors to stderr by default. The first message of a traceback describes the cause, and becomes the text
// of the exception.
std::string& last_message() {
  static std::string message;
  return message;
}

PetscErrorCode keep_message(MPI_Comm, int, const char*, const char*, PetscErrorCode code, PetscErrorType type,
                            const char* message, void*) {
  if (type == PETSC_ERROR_INITIAL) last_message() = message ? message : "";
  return code;
}

/// Limits OpenBLAS, if it is the BLAS, to one thread. Several threads would make the rounding of scalar products depend
/// on the number of cores, and their synchronization costs more than vectors of some thousand unknowns.
void keep_blas_to_one_thread() {
  using Set = void (*)(int);
  if (const auto set = reinterpret_cast<Set>(dlsym(RTLD_DEFAULT, "openblas_set_num_threads"))) set(1);
}

/// Throws Failure if the BLAS chooses its code by the processor, in builds for repeatable results.
void require_repeatable_blas() {
#ifdef LICHTENBERG_REPEATABLE
  for (const char* function : {"openblas_get_config", "bli_info_get_version_str", "mkl_get_version"})
    if (dlsym(RTLD_DEFAULT, function))
      throw Failure(
          "this build is for repeatable results, but the BLAS chooses its code by the processor (it has the function " +
          std::string(function) +
          "): choose libblas3 with `update-alternatives --config libblas.so.3-x86_64-linux-gnu`");
#endif
}

}  // namespace

void set_petsc_options(std::vector<std::string> list) { options() = std::move(list); }

bool petsc_started() {
  PetscBool started = PETSC_FALSE;
  PetscInitialized(&started);
  return started == PETSC_TRUE;
}

int process_rank() {
  int rank = 0;
  if (petsc_started()) MPI_Comm_rank(PETSC_COMM_WORLD, &rank);
  return rank;
}

int process_count() {
  int count = 1;
  if (petsc_started()) MPI_Comm_size(PETSC_COMM_WORLD, &count);
  return count;
}

void finish_petsc() {
  PetscBool finished = PETSC_FALSE;
  PetscFinalized(&finished);
  if (petsc_started() && !finished) PetscFinalize();
}

void start_petsc() {
  if (petsc_started()) return;
  require_repeatable_blas();
  keep_blas_to_one_thread();
  std::vector<std::string> arguments = options();
  // Options come from the command line and from PETSC_OPTIONS, which results record, and not from files in the working
  // folder. PETSc's signal handler would hide crashes from debuggers and Ctrl-C from the program, and replace its
  // handlers.
  arguments.insert(arguments.begin(), {"lichtenberg", "-skip_petscrc", "-no_signal_handler"});
  std::vector<char*> pointers;
  for (std::string& argument : arguments) pointers.push_back(argument.data());
  pointers.push_back(nullptr);
  int count = static_cast<int>(arguments.size());
  char** values = pointers.data();
  // Without mpirun, Open MPI would start a daemon process to wait for others, and share folders in /tmp with unrelated
  // single processes. A process that ends deletes these folders while another starts.
  if (!std::getenv("OMPI_COMM_WORLD_SIZE")) {
    setenv("OMPI_MCA_ess_singleton_isolated", "1", 0);
    setenv("OMPI_MCA_orte_create_session_dirs", "0", 0);
  }
  if (PetscInitialize(&count, &values, nullptr, nullptr)) throw Failure("PETSc could not be started");
  check_petsc(PetscPushErrorHandler(keep_message, nullptr));
  std::atexit(finish_petsc);
}

std::vector<std::string> unused_petsc_options() {
  std::vector<std::string> unused;
  for (const std::string& word : options()) {
    if (word.size() < 2 || word[0] != '-' || !std::isalpha(static_cast<unsigned char>(word[1]))) continue;
    if (word.starts_with("-options_")) continue;  // PETSc reads these when it ends
    PetscBool used = PETSC_FALSE;
    if (petsc_started()) check_petsc(PetscOptionsUsed(nullptr, word.c_str() + 1, &used));
    if (!used) unused.push_back(word);
  }
  return unused;
}

void check_petsc(PetscErrorCode code) {
  if (code == 0) return;
  const char* text = nullptr;
  PetscErrorMessage(code, &text, nullptr);
  throw Failure("PETSc: " + (last_message().empty() ? std::string(text ? text : "unknown error") : last_message()));
}

}  // namespace lichtenberg::parallel
