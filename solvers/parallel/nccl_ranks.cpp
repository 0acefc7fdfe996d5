// Links of several CUDA devices of one host, by NCCL.

#include "solvers/parallel/ranks.hpp"

#ifdef LICHTENBERG_WITH_NCCL
#include <cuda_runtime.h>
#include <nccl.h>

#include <mutex>

#include "solvers/parallel/cuda_device.hpp"

namespace lichtenberg::parallel {
namespace {

void check_nccl(ncclResult_t code) {
  if (code != ncclSuccess) throw Failure(std::string("NCCL: ") + ncclGetErrorString(code));
}

/// Communicators of all ranks; a failure of one rank ends all.
struct NcclRing {
  std::vector<ncclComm_t> ranks;
  std::mutex mutex;
  bool aborted = false;

  ~NcclRing() {
    if (!aborted)
      for (ncclComm_t each : ranks) ncclCommDestroy(each);
  }
  void abort() {
    const std::scoped_lock lock(mutex);
    if (std::exchange(aborted, true)) return;
    for (ncclComm_t each : ranks) ncclCommAbort(each);
  }
};

class NcclLink final : public Link {
 public:
  NcclLink(int rank, const std::shared_ptr<HostBarrier>& barrier, std::shared_ptr<NcclRing> ring)
      : Link(rank, barrier), ring_(std::move(ring)), mine_(ring_->ranks[rank]) {}

  void sum(void* numbers, std::size_t n, Number type, void* stream) const override {
    const ncclDataType_t of = type == Number::int32 ? ncclInt32 : type == Number::int64 ? ncclInt64 : ncclFloat64;
    check_nccl(ncclAllReduce(numbers, numbers, n, of, ncclSum, mine_, static_cast<cudaStream_t>(stream)));
  }
  void broadcast(void* data, std::size_t bytes, void* stream) const override {
    check_nccl(ncclBroadcast(data, data, bytes, ncclInt8, 0, mine_, static_cast<cudaStream_t>(stream)));
  }
  void gather(void* all, std::size_t bytes, void* stream) const override {
    const void* mine = static_cast<const char*>(all) + rank() * bytes;
    check_nccl(ncclAllGather(mine, all, bytes, ncclInt8, mine_, static_cast<cudaStream_t>(stream)));
  }
  void exchange(std::span<const Transfer> transfers, void* stream) const override {
    check_nccl(ncclGroupStart());
    for (const Transfer& one : transfers)
      check_nccl(one.sends
                     ? ncclSend(one.data, one.bytes, ncclInt8, one.peer, mine_, static_cast<cudaStream_t>(stream))
                     : ncclRecv(one.data, one.bytes, ncclInt8, one.peer, mine_, static_cast<cudaStream_t>(stream)));
    check_nccl(ncclGroupEnd());
  }
  void abort() override {
    Link::abort();
    ring_->abort();
  }

 private:
  std::shared_ptr<NcclRing> ring_;
  ncclComm_t mine_;
};

}  // namespace

std::vector<std::unique_ptr<Link>> cuda_links(const std::vector<int>& devices) {
  const int ranks = static_cast<int>(devices.size());
  const auto ring = std::make_shared<NcclRing>();
  ring->ranks.resize(devices.size());
  check_nccl(ncclCommInitAll(ring->ranks.data(), ranks, devices.data()));
  const auto barrier = std::make_shared<HostBarrier>(ranks);
  std::vector<std::unique_ptr<Link>> links;
  for (int r = 0; r < ranks; ++r) links.push_back(std::make_unique<NcclLink>(r, barrier, ring));
  return links;
}

}  // namespace lichtenberg::parallel
#endif
