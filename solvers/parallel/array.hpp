#pragma once

#include <cstddef>
#include <new>
#include <span>
#include <utility>
#include <vector>

namespace lichtenberg::parallel {

/// Memory of an executor's device. It grows and never shrinks, so that a moving scene allocates nothing.
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

  /// The values are undefined afterwards.
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

/// A value of which the host and the device each have a copy. Copies are made in the order of kernels: the host's is as
/// it was fetched once the executor has waited, and changes only then.
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
