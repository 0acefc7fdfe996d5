#pragma once

#include <cstddef>
#include <cstring>
#include <functional>
#include <type_traits>
#include <vector>

namespace lichtenberg::parallel {

// Program under mpirun: the first process runs it; the others execute their part of collective operations on its
// messages. They read no scene, print nothing, write no file, and make no decisions.

/// Message from the first MPI process to the others: a byte sequence of trivially copyable values and vectors. The
/// receiver must read them with the same types and in the same order as the sender wrote them.
class Message {
 public:
  Message() = default;
  explicit Message(std::vector<char> bytes) : bytes_(std::move(bytes)) {}

  /// Appends a value to the message.
  template <class T>
  void put(const T& value) {
    static_assert(std::is_trivially_copyable_v<T>);
    bytes_.resize(bytes_.size() + sizeof(T));
    std::memcpy(bytes_.data() + bytes_.size() - sizeof(T), &value, sizeof(T));
  }
  /// Appends the number of values and the values.
  template <class T>
  void put(const std::vector<T>& values) {
    put(values.size());
    for (const T& value : values) put(value);
  }
  /// Returns the next value of the message, which must be of the type T that the sender appended.
  template <class T>
  T get() {
    T value;
    std::memcpy(&value, bytes_.data() + at_, sizeof(T));
    at_ += sizeof(T);
    return value;
  }
  /// Returns the next vector of the message, whose elements must be of the type T that the sender appended.
  template <class T>
  std::vector<T> get_all() {
    std::vector<T> values(get<std::size_t>());
    for (T& value : values) value = get<T>();
    return values;
  }
  const std::vector<char>& bytes() const { return bytes_; }

 private:
  std::vector<char> bytes_;
  std::size_t at_ = 0;
};

/// Divides a program under mpirun into a first process (MPI rank 0), which leads, and others, which serve it. To be
/// called at the start of a program.
/// Returns true in the first process, which continues the program. In the other processes it passes each message of
/// broadcast() to `handle_message`. It returns false there once the first process dismisses them; they must exit then.
/// In a single process it has no effect and returns true. The launcher's environment variables give the number of
/// processes; with several, the function starts PETSc.
/// Errors: after an exception of `handle_message` a process waits 2 s for a message of the first process. Without a
/// message, or after a second exception, it prints the error and aborts all processes. Throws InputError if several
/// processes use a PETSc without MPI.
bool join_processes(const std::function<void(Message&)>& handle_message);

/// Ends the work of the other MPI processes: join_processes() returns false there. `after_error`: true if the first
/// process ends by an exception; if another process then does not answer within 2 s, all are aborted. No effect unless
/// is_leading_process().
void dismiss_processes(bool after_error);

/// Returns true in the first of several MPI processes (rank 0) until it has dismissed the others; false in a single
/// process.
bool is_leading_process();

/// Sends a message from the first MPI process to all others, whose join_processes() handles it. Only valid if
/// is_leading_process().
void broadcast(const Message& message);

}  // namespace lichtenberg::parallel
