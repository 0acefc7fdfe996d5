#pragma once

// Communication between the devices of one computation. Each device has a rank and a host thread, and all threads run
// the same program: they make the same calls in the same order.

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <utility>
#include <vector>

namespace lichtenberg::parallel {

/// Barrier of the host threads of all ranks, and exchange of small values between them. If one of the threads fails,
/// the others do not wait for it forever: their calls throw Failure.
class HostBarrier {
 public:
  explicit HostBarrier(int ranks) : ranks_(ranks), slots_(ranks) {}
  int ranks() const { return ranks_; }
  /// Waits until all ranks have called. Throws Failure if a rank has failed.
  void wait();
  /// Lets all present and later calls of wait() throw.
  void fail() { failed_ = true; }
  bool failed() const { return failed_; }
  /// Publishes a pointer of this rank to all ranks, and returns after all have done so. The pointers are valid until
  /// the next call of wait().
  std::span<const void* const> publish(int rank, const void* mine);

 private:
  const int ranks_;
  std::vector<const void*> slots_;
  std::atomic<int> arrived_ = 0, round_ = 0;
  std::atomic<bool> failed_ = false;
};

/// A range of device memory that this rank sends to another rank or receives from it. The k-th range that a rank sends
/// to another one is the k-th that the other receives from it.
struct Transfer {
  void* data = nullptr;
  std::size_t bytes = 0;
  int peer = 0;        ///< rank of the other side
  bool sends = false;  ///< false: receives
};

/// Type of numbers that ranks sum.
enum class Number { int32, int64, real64 };
template <class T>
constexpr Number number_type = sizeof(T) == 4 ? Number::int32 : Number::int64;
template <>
inline constexpr Number number_type<double> = Number::real64;

/// Communication of one rank with the others, in sequence with the kernels of a stream. All ranks must make the same
/// calls. Functions throw Failure if a rank has failed. `stream`: a CUDA stream, null on the CPU.
class Link {
 public:
  Link(int rank, std::shared_ptr<HostBarrier> barrier) : rank_(rank), barrier_(std::move(barrier)) {}
  Link(const Link&) = delete;
  Link& operator=(const Link&) = delete;
  virtual ~Link() = default;

  int rank() const { return rank_; }
  int ranks() const { return barrier_->ranks(); }
  HostBarrier& barrier() const { return *barrier_; }

  /// Replaces n numbers in device memory by their sums over all ranks. The sums must be exact, so that they do not
  /// depend on the order.
  virtual void sum(void* numbers, std::size_t n, Number type, void* stream) const = 0;
  /// Copies device memory of rank 0 to all ranks.
  virtual void broadcast(void* data, std::size_t bytes, void* stream) const = 0;
  /// Sends `bytes` of device memory, `all` + rank * bytes, to all ranks. Afterwards `all` has those of each rank.
  virtual void gather(void* all, std::size_t bytes, void* stream) const = 0;
  /// Sends and receives ranges of device memory.
  virtual void exchange(std::span<const Transfer> transfers, void* stream) const = 0;
  /// Ends all communication after a failure, so that no device waits for another one.
  virtual void abort() { barrier_->fail(); }

 private:
  int rank_;
  std::shared_ptr<HostBarrier> barrier_;
};

/// Makes the links of several ranks on the CPU, for tests.
std::vector<std::unique_ptr<Link>> host_links(int ranks);
/// Makes the links of several CUDA devices, by NCCL: device[r] has rank r. Throws InputError if the program was built
/// without NCCL, and Failure if NCCL fails.
std::vector<std::unique_ptr<Link>> cuda_links(const std::vector<int>& devices);

/// Host threads of the ranks of one computation, and their links.
class RankThreads {
 public:
  /// `enter`: prepares a thread for the work of a rank.
  RankThreads(std::vector<std::unique_ptr<Link>> links, std::function<void(int)> enter) : enter_(std::move(enter)) {
    for (auto& link : links) links_.push_back(std::move(link));
  }
  int ranks() const { return static_cast<int>(links_.size()); }
  const std::shared_ptr<Link>& link(int rank) const { return links_[rank]; }
  /// Calls f(rank) for all ranks at the same time, in a thread each. If calls throw, the other ranks end too, and the
  /// first exception is thrown again.
  void on_all(const std::function<void(int)>& f) const;
  /// Calls f(rank) for one rank after the other, in a thread each. f must not throw.
  void on_each(const std::function<void(int)>& f) const;

 private:
  std::function<void(int)> enter_;
  std::vector<std::shared_ptr<Link>> links_;
};

/// Functions of an executor for the communication between ranks, in sequence with its kernels. With one rank they do
/// nothing. `Executor`: the class that inherits them; its function stream() returns a CUDA stream, or null on the CPU.
template <class Executor>
class Communicator {
 public:
  Communicator() = default;
  explicit Communicator(std::shared_ptr<Link> link) : link_(std::move(link)) {}

  int rank() const { return link_ ? link_->rank() : 0; }
  int ranks() const { return link_ ? link_->ranks() : 1; }
  Link* link() const { return link_.get(); }
  /// Returns the values that all ranks give, in host memory, by rank.
  template <class T>
  std::vector<T> from_all(const T& mine) const {
    if (!link_) return {mine};
    std::vector<T> all;
    for (const void* each : link_->barrier().publish(rank(), &mine)) all.push_back(*static_cast<const T*>(each));
    link_->barrier().wait();
    return all;
  }
  /// Replaces n numbers (int, std::int64_t, double) in device memory by their sums over all ranks, which must be exact.
  template <class T>
  void sum_over_ranks(T* numbers, long n) const {
    if (link_) link_->sum(numbers, static_cast<std::size_t>(n), number_type<T>, stream());
  }
  /// Copies n values in device memory of rank 0 to all ranks.
  template <class T>
  void broadcast(T* values, long n) const {
    if (link_) link_->broadcast(values, n * sizeof(T), stream());
  }
  /// Sends n values in device memory, all[rank * n] and the next ones, to all ranks. Afterwards `all` has those of each
  /// rank.
  template <class T>
  void gather(T* all, long n) const {
    if (link_) link_->gather(all, n * sizeof(T), stream());
  }
  /// Sends ranges of device memory to other ranks and receives others from them.
  void exchange(std::span<const Transfer> transfers) const {
    if (link_) link_->exchange(transfers, stream());
  }

 private:
  void* stream() const { return static_cast<const Executor*>(this)->stream(); }

  std::shared_ptr<Link> link_;
};

}  // namespace lichtenberg::parallel
