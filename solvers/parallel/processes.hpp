#pragma once

#include <cstddef>
#include <cstring>
#include <functional>
#include <type_traits>
#include <vector>

namespace lichtenberg::parallel {

// A program under mpirun: the first process runs it; the others do what it tells them to, their part of what takes all
// processes. They read no scene, print nothing, write no file, and decide nothing.

/// What the first process tells the others: plain structs and arrays of them, one after the other.
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

/// To be called at the start of a program. Started alone (told from the launcher's environment, without touching MPI)
/// it does nothing and returns true. Otherwise it starts PETSc and returns true in the first process, and in the others
/// only when the first has dismissed them: false, and nothing is left to do but to exit. Until then they hand each
/// message to `take_part`. What that throws may be the first process's trouble as well, which then says no more but to
/// end things; if it throws again, all processes end. Throws InputError if PETSc was built without MPI.
bool join_processes(const std::function<void(Message&)>& take_part);

/// Ends the others' part; after an error, whatever state it has left them in. Of no effect in a program that runs
/// alone.
void dismiss_processes(bool after_error);

/// True in the first process of several, until it has dismissed the others.
bool leads_processes();

/// Sends a message to the others; to be called where leads_processes().
void tell_others(const Message& message);

}  // namespace lichtenberg::parallel
