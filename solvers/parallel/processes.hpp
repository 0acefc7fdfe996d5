#pragma once

#include <cstddef>
#include <cstring>
#include <functional>
#include <type_traits>
#include <vector>

namespace lichtenberg::parallel {

// Program under mpirun: the first process runs it; the others execute their part of collective operations on its
// messages. They read no scene, print nothing, write no file, and make no decisions.

/// Message from the first process to the others: a sequence of plain structs and arrays of them.
class Message {
 public:
  Message() = default;
  explicit Message(std::vector<char> bytes) : bytes_(std::move(bytes)) {}

  template <class T>
  void put(const T& value) {
    static_assert(std::is_trivially_copyable_v<T>);
    bytes_.resize(bytes_.size() + sizeof(T));
    std::memcpy(bytes_.data() + bytes_.size() - sizeof(T), &value, sizeof(T));
  }
  template <class T>
  void put(const std::vector<T>& values) {
    put(values.size());
    for (const T& value : values) put(value);
  }
  template <class T>
  T get() {
    T value;
    std::memcpy(&value, bytes_.data() + at_, sizeof(T));
    at_ += sizeof(T);
    return value;
  }
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

/// To be called at the start of a program. In a single process (according to the launcher's environment, without MPI
/// calls) it has no effect and returns true. Otherwise it starts PETSc and returns true in the first process. In the
/// others it passes each message to `handle_message`, and returns false once the first process dismisses them; they
/// must exit then. An exception of `handle_message` may occur in the first process too, which then only ends the
/// program; after a second exception all processes end. Throws InputError if PETSc was built without MPI.
bool join_processes(const std::function<void(Message&)>& handle_message);

/// Dismisses the other processes; after an error, in any state. No effect in a single process.
void dismiss_processes(bool after_error);

/// Returns true in the first process of several, until it has dismissed the others.
bool is_leading_process();

/// Sends a message to the other processes; only valid if is_leading_process().
void broadcast(const Message& message);

}  // namespace lichtenberg::parallel
