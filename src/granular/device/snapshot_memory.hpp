#pragma once

// Host memory of snapshots. Memory to which a device copies at full speed is expensive to allocate, so it is reused
// after the release of a snapshot.

#include <atomic>
#include <cstddef>
#include <memory>
#include <vector>

#include "src/granular/device/lists.hpp"
#include "src/granular/device/snapshot.hpp"

namespace lichtenberg::granular::device {

/// Makes snapshots of a gas on an executor (CPU or CUDA device), in host memory that is reused after their release.
template <class Executor>
class SnapshotMemories {
 public:
  explicit SnapshotMemories(const Executor& run) : run_(&run), records_(run) {}

  /// Copies grains and contacts of a gas to host memory. Other members of the snapshot are left to the caller. The
  /// snapshot must be released before the executor is destroyed.
  Snapshot take(const GasState<Executor>& gas, const GasLists<Executor>& lists) {
    records_.resize(gas.n);
    gas.list_records(records_.data());
    const auto& contacts = lists.contacts();
    const std::size_t grains = records_.size() * sizeof(GrainRecord), open = contacts.size() * sizeof(OpenContact);
    const std::shared_ptr<Memory> memory = free_memory(grains + open);
    run_->to_host(memory->bytes, records_.data(), grains);
    if (open > 0) run_->to_host(memory->bytes + grains, contacts.data(), open);
    Snapshot taken;
    taken.memory = memory;
    taken.grains = {reinterpret_cast<const GrainRecord*>(memory->bytes), records_.size()};
    taken.contacts = {reinterpret_cast<const OpenContact*>(memory->bytes + grains), contacts.size()};
    return taken;
  }

 private:
  struct Memory {
    Memory(const Executor& executor, std::size_t wanted)
        : run(&executor), bytes(static_cast<std::byte*>(executor.allocate_on_host(wanted))), size(wanted) {}
    Memory(const Memory&) = delete;
    Memory& operator=(const Memory&) = delete;
    ~Memory() { run->release_on_host(bytes); }

    const Executor* run;
    std::byte* bytes;
    std::size_t size;
  };

  /// Returns host memory of at least `size` bytes that no snapshot uses.
  std::shared_ptr<Memory> free_memory(std::size_t size) {
    for (std::shared_ptr<Memory>& memory : all_)
      if (memory.use_count() == 1) {
        std::atomic_thread_fence(std::memory_order_acquire);  // the last owner has finished reading
        if (memory->size < size) memory = std::make_shared<Memory>(*run_, size + size / 4);
        return memory;
      }
    return all_.emplace_back(std::make_shared<Memory>(*run_, size + size / 4));
  }

  const Executor* run_;
  parallel::Array<GrainRecord, Executor> records_;
  std::vector<std::shared_ptr<Memory>> all_;
};

}  // namespace lichtenberg::granular::device
