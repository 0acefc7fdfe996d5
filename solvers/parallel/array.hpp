#pragma once

#include <array>
#include <cstddef>
#include <map>
#include <new>
#include <span>
#include <tuple>
#include <utility>
#include <vector>

namespace lichtenberg::parallel {

/// Array in the memory of a device (GPU, or CPU for HostExecutor); resize() and transfers use the executor. The
/// capacity never shrinks, so that a size up to the capacity needs no allocation.
template <class T, class Executor>
class Array {
 public:
  explicit Array(const Executor& run) : run_(&run) {}
  Array(Array&& other) noexcept
      : run_(other.run_),
        data_(std::exchange(other.data_, nullptr)),
        size_(std::exchange(other.size_, 0)),
        capacity_(std::exchange(other.capacity_, 0)) {}
  Array& operator=(Array&& other) noexcept {
    std::swap(data_, other.data_);
    std::swap(size_, other.size_);
    std::swap(capacity_, other.capacity_);
    return *this;
  }
  ~Array() {
    if (data_) run_->release(data_);
  }

  /// Sets the number of values; all values are undefined afterwards.
  void resize(std::size_t size) {
    if (size > capacity_) {
      if (data_) run_->release(std::exchange(data_, nullptr));
      capacity_ = 0;
      const std::size_t wanted = size_ == 0 ? size : size + size / 4;
      data_ = static_cast<T*>(run_->allocate(wanted * sizeof(T)));
      capacity_ = wanted;
    }
    size_ = size;
  }
  /// Sets all bytes of the array to 0.
  void zero() { run_->fill(data_, 0, size_ * sizeof(T)); }
  /// Copies values from the host to the device, and sets the size of the array to their number.
  void upload(const std::vector<T>& values) {
    resize(values.size());
    if (size_ > 0) run_->to_device(data_, values.data(), size_ * sizeof(T));
  }
  /// Returns a copy of all values on the host, after all kernels started before have ended.
  std::vector<T> download() const {
    std::vector<T> values(size_);
    if (size_ > 0) run_->to_host(values.data(), data_, size_ * sizeof(T));
    return values;
  }
  T* data() const { return data_; }
  std::size_t size() const { return size_; }
  std::size_t capacity() const { return capacity_; }

 private:
  const Executor* run_;
  T* data_ = nullptr;
  std::size_t size_ = 0, capacity_ = 0;
};

/// Device memory for a struct of arrays. `view` is a struct of device pointers that kernels receive by value. resize()
/// allocates memory for some of these pointers; this object owns the memory. All other members of `view` are set by the
/// caller.
template <class View, class Executor>
class Arrays {
 public:
  explicit Arrays(const Executor& run) : run_(&run) {}
  View view{};

  /// Allocates n values for each of the given pointers, which are members of `view`. All values are undefined
  /// afterwards.
  template <class... T>
  void resize(std::size_t n, T*&... pointer) {
    (resize_bytes(n * sizeof(T), pointer), ...);
  }
  /// Sets all bytes of the given arrays (pointers in `view`) to 0.
  template <class... T>
  void zero(T*&... pointer) {
    (memory(pointer).zero(), ...);
  }

 private:
  using Memory = Array<char, Executor>;
  /// Returns the memory that belongs to a pointer of `view`, identified by the pointer's offset in the struct.
  template <class T>
  Memory& memory(T*& pointer) {
    const auto offset = reinterpret_cast<const char*>(&pointer) - reinterpret_cast<const char*>(&view);
    return memory_.try_emplace(offset, *run_).first->second;
  }
  template <class T>
  void resize_bytes(std::size_t bytes, T*& pointer) {
    Memory& own = memory(pointer);
    own.resize(bytes);
    pointer = reinterpret_cast<T*>(own.data());
  }

  const Executor* run_;
  std::map<std::ptrdiff_t, Memory> memory_;
};

/// Several arrays that are transferred together between host and device, because they share one block of memory on
/// each.
template <class Executor>
class PackedTransfer {
 public:
  explicit PackedTransfer(const Executor& run) : run_(&run), device_(run) {}
  PackedTransfer(const PackedTransfer&) = delete;
  PackedTransfer& operator=(const PackedTransfer&) = delete;
  ~PackedTransfer() { release(); }

  /// Pointers to one of the arrays on the host and on the device.
  template <class T>
  struct MirroredArray {
    T *host = nullptr, *device = nullptr;
  };
  /// Allocates one array for each type T, the k-th with counts[k] values. Arrays of an earlier call become invalid.
  /// Returns the pointers in the same order. Initially device bytes are 0, host bytes undefined.
  template <class... T>
  std::tuple<MirroredArray<T>...> divide(const std::array<std::size_t, sizeof...(T)>& counts) {
    release();
    size_ = 0;
    const std::size_t* count = counts.data();
    ((size_ += rounded(*count++ * sizeof(T))), ...);
    device_.resize(size_);
    device_.zero();  // begin_fetch() also copies the padding between the arrays
    host_ = static_cast<char*>(run_->allocate_on_host(size_));
    count = counts.data();
    std::size_t end = 0;
    return std::tuple<MirroredArray<T>...>{part<T>(end, count)...};
  }
  /// Starts the copy of all arrays from the host to the device, in sequence with the kernels. The arrays on the host
  /// must not change before the copy is complete, as after the executor's wait().
  void send() { run_->to_device(device_.data(), host_, size_); }
  /// Starts the copy of all arrays from the device to the host. It is complete once the executor's wait() has returned.
  void begin_fetch() { run_->begin_to_host(host_, device_.data(), size_); }
  /// Copies all arrays from the device to the host, and waits until the copy is complete.
  void fetch() {
    begin_fetch();
    run_->wait();
  }

 private:
  template <class T>
  MirroredArray<T> part(std::size_t& end, const std::size_t*& count) const {
    const std::size_t from = std::exchange(end, end + rounded(*count++ * sizeof(T)));
    return {reinterpret_cast<T*>(host_ + from), reinterpret_cast<T*>(device_.data() + from)};
  }
  static std::size_t rounded(std::size_t bytes) { return (bytes + 63) / 64 * 64; }
  void release() {
    if (host_) run_->release_on_host(std::exchange(host_, nullptr));
  }

  const Executor* run_;
  Array<char, Executor> device_;
  char* host_ = nullptr;
  std::size_t size_ = 0;
};

/// Value with a copy on the host and one on the device. Transfers start without waiting and are executed in sequence
/// with the kernels. After fetch() and the executor's wait(), the host's copy is the device's value at the time of
/// fetch().
template <class T, class Executor>
class Mirrored {
 public:
  static_assert(sizeof(T) % sizeof(int) == 0);
  explicit Mirrored(const Executor& run) : run_(&run), device_(run) {
    device_.resize(1);
    host_ = new (run.allocate_on_host(sizeof(T))) T{};
  }
  Mirrored(const Mirrored&) = delete;
  Mirrored& operator=(const Mirrored&) = delete;
  ~Mirrored() { run_->release_on_host(host_); }

  T& host() { return *host_; }
  T* device() const { return device_.data(); }
  /// Starts the copy from host to device. The host's copy must not change before it is complete.
  void send() { run_->begin_to_device(device_.data(), host_, sizeof(T)); }
  /// Starts the copy from device to host.
  void fetch() { run_->begin_to_host(host_, device_.data(), sizeof(T)); }

 private:
  const Executor* run_;
  Array<T, Executor> device_;
  T* host_ = nullptr;
};

}  // namespace lichtenberg::parallel
