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

/// Array in the memory of an executor's device. Its capacity grows and never shrinks, so that a moving scene allocates
/// nothing.
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

  /// Sets the size; values are undefined afterwards.
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
  void zero() { run_->fill(data_, 0, size_ * sizeof(T)); }
  void upload(const std::vector<T>& values) {
    resize(values.size());
    if (size_ > 0) run_->to_device(data_, values.data(), size_ * sizeof(T));
  }
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

/// Struct of pointers for kernels, `view`, together with the device memory of those pointers for which resize() was
/// called. Other members of the struct belong to the caller.
template <class View, class Executor>
class Arrays {
 public:
  explicit Arrays(const Executor& run) : run_(&run) {}
  View view{};

  /// Allocates n values for each pointer, a member of `view`; values are undefined afterwards.
  template <class... T>
  void resize(std::size_t n, T*&... pointer) {
    (resize_bytes(n * sizeof(T), pointer), ...);
  }
  /// Sets all bytes of these arrays to 0.
  template <class... T>
  void zero(T*&... pointer) {
    (memory(pointer).zero(), ...);
  }

 private:
  using Memory = Array<char, Executor>;
  /// Returns the memory of a pointer, identified by its offset within the view.
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

/// Arrays that are transferred together: one block of memory on the device and one on the host.
template <class Executor>
class PackedTransfer {
 public:
  explicit PackedTransfer(const Executor& run) : run_(&run), device_(run) {}
  PackedTransfer(const PackedTransfer&) = delete;
  PackedTransfer& operator=(const PackedTransfer&) = delete;
  ~PackedTransfer() { release(); }

  template <class T>
  struct MirroredArray {
    T *host = nullptr, *device = nullptr;
  };
  /// Allocates counts[k] values of the k-th T, in this order, and frees earlier memory. Device bytes are 0, host bytes
  /// undefined.
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
  void send() { run_->to_device(device_.data(), host_, size_); }
  /// Starts the transfer to the host, which is complete once the executor has waited.
  void begin_fetch() { run_->begin_to_host(host_, device_.data(), size_); }
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

/// Value with a copy on the host and one on the device. Transfers are executed in the order of kernels. The host's copy
/// changes only when the executor waits, and then has the value at the time of fetch().
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
  void send() { run_->begin_to_device(device_.data(), host_, sizeof(T)); }
  void fetch() { run_->begin_to_host(host_, device_.data(), sizeof(T)); }

 private:
  const Executor* run_;
  Array<T, Executor> device_;
  T* host_ = nullptr;
};

}  // namespace lichtenberg::parallel
