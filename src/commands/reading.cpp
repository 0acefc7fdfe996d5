#include "src/commands/reading.hpp"
#include "src/commands/streams.hpp"
#include "src/record/hdf5.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <memory>

#include "solvers/error.hpp"
#include "solvers/parallel/petsc.hpp"
#include "src/record/result_file.hpp"

namespace lichtenberg {
namespace {

volatile pid_t reader = 0;

/// Signal handler: passes the signal to the child. The terminal's signals are skipped, because the child receives them
/// as well.
void forward_signal(int signal, siginfo_t* about, void*) {
  if (about->si_code != SI_KERNEL) kill(reader, signal);
}

void forward_signals() {
  struct sigaction action {};
  action.sa_sigaction = forward_signal;
  action.sa_flags = SA_RESTART | SA_SIGINFO;
  for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGQUIT}) {
    struct sigaction before {};
    if (sigaction(signal, nullptr, &before) == 0 && before.sa_handler != SIG_IGN) sigaction(signal, &action, nullptr);
  }
}

/// Forks. Returns 0 in the child; -1 if the system allows no further process.
pid_t fork_reader() {
  std::fflush(nullptr);  // otherwise the child would write buffered output again
  const pid_t parent = getpid(), child = fork();
  if (child != 0) return child;
  prctl(PR_SET_PDEATHSIG, SIGTERM);
  if (getppid() != parent) _exit(1);
  return 0;
}

int status_of(pid_t child) {
  int status = 0;
  while (waitpid(child, &status, 0) < 0)
    if (errno != EINTR) throw Failure(fmt::format("lost the process that reads ({})", std::strerror(errno)));
  return status;
}

bool is_crash(int status) {
  if (!WIFSIGNALED(status)) return false;
  const int signal = WTERMSIG(status);
  return signal == SIGSEGV || signal == SIGBUS || signal == SIGABRT || signal == SIGFPE || signal == SIGILL;
}

std::string crash_in_words(const std::string& file, int status) {
  return fmt::format("{} is damaged and cannot be read (reading it ended with the signal {}, {})", file,
                     WTERMSIG(status), strsignal(WTERMSIG(status)));
}

/// Reads the values of a dataset (H5D) or an attribute (H5A) of any type, to test whether HDF5 crashes.
template <class Space, class Type, class Read>
void read_values(hid_t object, Space space_of, Type type_of, Read read) {
  const hdf5::Handle space(space_of(object)), stored(type_of(object));
  const hdf5::Handle type(H5Tget_native_type(stored, H5T_DIR_ASCEND));
  constexpr double most = 1e9;  // B; a damaged length may have any value
  const hssize_t values = hdf5::check(H5Sget_simple_extent_npoints(space));
  if (static_cast<double>(values) * static_cast<double>(H5Tget_size(type)) > most) return;
  std::vector<std::byte> bytes(static_cast<std::size_t>(values) * H5Tget_size(type));
  hdf5::check(read(object, type, bytes.data()));
}

void read_attributes(hid_t object) {
  for (int k = 0, count = H5Aget_num_attrs(object); k < count; ++k) {
    const hdf5::Handle attribute(
        H5Aopen_by_idx(object, ".", H5_INDEX_NAME, H5_ITER_INC, static_cast<hsize_t>(k), H5P_DEFAULT, H5P_DEFAULT));
    read_values(attribute, H5Aget_space, H5Aget_type, H5Aread);
  }
}

/// Reads all objects of a group and its subgroups. Skips objects that HDF5 refuses.
void read_group(hid_t group, int depth = 0) {
  constexpr int deepest = 32;  // links may form a cycle
  read_attributes(group);
  for (const std::string& name : hdf5::names(group)) try {
      const hdf5::Handle object(H5Oopen(group, name.c_str(), H5P_DEFAULT));
      if (H5Iget_type(object) == H5I_GROUP && depth < deepest) read_group(object, depth + 1);
      if (H5Iget_type(object) != H5I_DATASET) continue;
      read_attributes(object);
      read_values(object, H5Dget_space, H5Dget_type, [](hid_t data, hid_t type, void* bytes) {
        return H5Dread(data, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, bytes);
      });
    } catch (const std::exception&) {
    }
}

/// Reports a crashed child and returns the exit status. The message blames a file only if merely reading it crashes as
/// well.
int report_crash(const std::vector<std::string>& files, int status) {
  try {
    for (const std::string& file : files)
      try_reading(file, [&] { read_group(hdf5::open(std::make_shared<const OpenFile>(file))); });
  } catch (const InputError& damaged) {
    fmt::print(stderr, "lichtenberg: {}\n", printable(damaged.what()));
    return 2;
  }
  fmt::print(
      stderr,
      "lichtenberg: the program crashed (signal {}, {}), though {} can be read: this is an error of the program, "
      "please report it with the command and the file\n",
      WTERMSIG(status), strsignal(WTERMSIG(status)), printable(fmt::format("{}", fmt::join(files, ", "))));
  return 1;
}

}  // namespace

void read_in_child(const std::vector<std::string>& files) {
  if (parallel::process_count() > 1) return;
  reader = fork_reader();
  if (reader <= 0) return;
  forward_signals();
  const int status = status_of(reader);
  if (is_crash(status)) _exit(report_crash(files, status));
  if (WIFEXITED(status)) _exit(WEXITSTATUS(status));
  signal(WTERMSIG(status), SIG_DFL);
  raise(WTERMSIG(status));
  _exit(128 + WTERMSIG(status));
}

void try_reading(const std::string& file, const std::function<void()>& read) {
  if (parallel::process_count() > 1) return;
  const pid_t child = fork_reader();
  if (child < 0) return;
  if (child == 0) {
    const int nothing = open("/dev/null", O_WRONLY);
    for (const int stream : {STDOUT_FILENO, STDERR_FILENO}) dup2(nothing, stream);
    try {
      read();
    } catch (...) {  // the parent encounters the same exception
    }
    _exit(0);
  }
  if (const int status = status_of(child); is_crash(status)) throw InputError(crash_in_words(file, status));
}

void check_bytes(const std::string& path, const std::string& done) {
  try {
    warn_if_changed(ResultFile(path, done));
  } catch (const hdf5::Error& error) {
    throw InputError(fmt::format("the result file {} is damaged and cannot be {} ({})", path, done, error.what()));
  }
}

void warn_if_changed(const ResultFile& result) {
  constexpr int without_checksums = 1;
  if (result.is_sealed() || result.format() == without_checksums) return;
  fmt::print(stderr, "lichtenberg: {} was changed by another program after its run and has no valid checksum\n",
             printable(result.path()));
}

}  // namespace lichtenberg
