#pragma once

// A gas on several devices of one host: one GasImpl for each, in a thread each.

#include <functional>
#include <memory>
#include <vector>

#include "src/granular/device/gas.hpp"

namespace lichtenberg::granular::device {

/// Gas of grains on several ranks (CUDA devices, or threads of the CPU for tests). Each rank moves its share of the
/// grains. Results have the same bits for any number of ranks.
template <class Executor>
class GasOnRanks final : public DeviceGas {
 public:
  /// Makes the executor of a rank in the thread of the rank.
  using MakeExecutor = std::function<std::unique_ptr<Executor>(std::shared_ptr<parallel::Link>)>;

  /// `links`: one for each rank; `enter`: prepares a thread for the work of a rank.
  GasOnRanks(std::vector<std::unique_ptr<parallel::Link>> links, std::function<void(int)> enter,
             const MakeExecutor& make, const GasOptions& options)
      : threads_(std::move(links), std::move(enter)), ranks_(threads_.ranks()) {
    threads_.on_all([&](int r) { ranks_[r] = std::make_unique<GasImpl<Executor>>(make(threads_.link(r)), options); });
  }
  GasOnRanks(const GasOnRanks&) = delete;
  GasOnRanks& operator=(const GasOnRanks&) = delete;
  ~GasOnRanks() override {
    threads_.on_each([this](int r) { ranks_[r].reset(); });
  }

  void load(const Checkpoint& checkpoint, const GrainContactLaw& law, bool elastic, double stage_begin,
            const SurfaceLaw* surface) override {
    threads_.on_all([&](int r) { ranks_[r]->load(checkpoint, law, elastic, stage_begin, surface); });
  }
  Snapshot snapshot() const override {
    Snapshot now;
    threads_.on_all([&](int r) {
      Snapshot mine = ranks_[r]->snapshot();
      if (r == 0) now = std::move(mine);
    });
    return now;
  }
  double potential_energy() override {
    double energy = 0;
    threads_.on_all([&](int r) {
      const double mine = ranks_[r]->potential_energy();
      if (r == 0) energy = mine;
    });
    return energy;
  }
  double time() const override { return ranks_[0]->time(); }
  void step(double time, int most) override {
    threads_.on_all([&](int r) { ranks_[r]->step(time, most); });
  }
  StepCounts counts() const override { return ranks_[0]->counts(); }

 private:
  parallel::RankThreads threads_;
  std::vector<std::unique_ptr<GasImpl<Executor>>> ranks_;
};

}  // namespace lichtenberg::granular::device
