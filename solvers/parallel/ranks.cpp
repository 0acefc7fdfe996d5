#include "solvers/parallel/ranks.hpp"

#include <algorithm>
#include <cstring>
#include <exception>
#include <thread>

#include "solvers/error.hpp"

namespace lichtenberg::parallel {
namespace {

/// Link of ranks whose device memory is that of the process.
class HostLink final : public Link {
 public:
  using Link::Link;

  void sum(void* numbers, std::size_t n, Number type, void*) const override {
    if (type == Number::int32)
      sum_of(static_cast<std::int32_t*>(numbers), n);
    else if (type == Number::int64)
      sum_of(static_cast<std::int64_t*>(numbers), n);
    else
      sum_of(static_cast<double*>(numbers), n);
  }
  void broadcast(void* data, std::size_t bytes, void*) const override {
    const auto all = barrier().publish(rank(), data);
    if (rank() > 0) std::memcpy(data, all[0], bytes);
    barrier().wait();
  }
  void gather(void* all, std::size_t bytes, void*) const override {
    const auto of = barrier().publish(rank(), all);
    for (int r = 0; r < ranks(); ++r) {
      const std::size_t at = r * bytes;
      if (r != rank()) std::memcpy(static_cast<char*>(all) + at, static_cast<const char*>(of[r]) + at, bytes);
    }
    barrier().wait();
  }
  void exchange(std::span<const Transfer> transfers, void*) const override {
    const auto all = barrier().publish(rank(), &transfers);
    std::vector<std::size_t> taken(ranks(), 0);
    for (const Transfer& to : transfers) {
      if (to.sends) continue;
      const auto& theirs = *static_cast<const std::span<const Transfer>*>(all[to.peer]);
      std::size_t& k = taken[to.peer];
      while (k < theirs.size() && !(theirs[k].sends && theirs[k].peer == rank())) ++k;
      if (k == theirs.size() || theirs[k].bytes != to.bytes) throw Failure("ranks exchange different numbers of bytes");
      std::memcpy(to.data, theirs[k++].data, to.bytes);
    }
    barrier().wait();
  }

 private:
  template <class T>
  void sum_of(T* numbers, std::size_t n) const {
    const auto all = barrier().publish(rank(), numbers);
    std::vector<T> sums(n);
    for (const void* each : all)
      for (std::size_t k = 0; k < n; ++k) sums[k] += static_cast<const T*>(each)[k];
    barrier().wait();
    std::ranges::copy(sums, numbers);
  }
};

}  // namespace

void HostBarrier::wait() {
  const int round = round_;
  if (++arrived_ == ranks_) {
    arrived_ = 0;
    ++round_;
    return;
  }
  for (int polls = 0; round_ == round; ++polls) {
    if (failed_) throw Failure("another device of the run has failed");
    if (polls > 1000) std::this_thread::yield();
  }
}

std::span<const void* const> HostBarrier::publish(int rank, const void* mine) {
  slots_[rank] = mine;
  wait();
  return slots_;
}

void RankThreads::on_all(const std::function<void(int)>& f) const {
  std::exception_ptr failure;
  std::atomic<bool> failed = false;
  {
    std::vector<std::jthread> threads;
    for (int r = 0; r < ranks(); ++r)
      threads.emplace_back([&, r] {
        try {
          enter_(r);
          f(r);
        } catch (...) {
          if (!failed.exchange(true)) failure = std::current_exception();
          links_[r]->abort();
        }
      });
  }
  if (failure) std::rethrow_exception(failure);
}
void RankThreads::on_each(const std::function<void(int)>& f) const {
  for (int r = 0; r < ranks(); ++r)
    std::jthread([&] {
      enter_(r);
      f(r);
    });
}

std::vector<std::unique_ptr<Link>> host_links(int ranks) {
  const auto barrier = std::make_shared<HostBarrier>(ranks);
  std::vector<std::unique_ptr<Link>> links;
  for (int r = 0; r < ranks; ++r) links.push_back(std::make_unique<HostLink>(r, barrier));
  return links;
}

#ifndef LICHTENBERG_WITH_NCCL
std::vector<std::unique_ptr<Link>> cuda_links(const std::vector<int>&) {
  throw InputError(
      "several CUDA devices: this program was built without NCCL; configure it with -DLICHTENBERG_CUDA=ON where CMake "
      "finds nccl.h and libnccl");
}
#endif

}  // namespace lichtenberg::parallel
