#pragma once

// A gas on several devices of one host: one GasImpl for each, in a thread each.

#include <exception>
#include <functional>
#include <thread>

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
      : enter_(std::move(enter)), ranks_(links.size()) {
    for (auto& link : links) links_.push_back(std::move(link));
    on_all([&](int r) { ranks_[r] = std::make_unique<GasImpl<Executor>>(make(links_[r]), options); });
  }
  GasOnRanks(const GasOnRanks&) = delete;
  GasOnRanks& operator=(const GasOnRanks&) = delete;
  ~GasOnRanks() override {
    for (std::size_t r = 0; r < ranks_.size(); ++r)
      std::jthread([&] { enter_(static_cast<int>(r)), ranks_[r].reset(); });
  }

  void load(const Checkpoint& checkpoint, const GrainContactLaw& law, bool elastic, double stage_begin,
            const SurfaceLaw* surface) override {
    on_all([&](int r) { ranks_[r]->load(checkpoint, law, elastic, stage_begin, surface); });
  }
  Snapshot snapshot() const override {
    Snapshot now;
    on_all([&](int r) {
      Snapshot mine = ranks_[r]->snapshot();
      if (r == 0) now = std::move(mine);
    });
    return now;
  }
  double potential_energy() override {
    double energy = 0;
    on_all([&](int r) {
      const double mine = ranks_[r]->potential_energy();
      if (r == 0) energy = mine;
    });
    return energy;
  }
  double time() const override { return ranks_[0]->time(); }
  void step(double time, int most) override {
    on_all([&](int r) { ranks_[r]->step(time, most); });
  }
  StepCounts counts() const override { return ranks_[0]->counts(); }

 private:
  /// Calls f(r) for all ranks at the same time, in a thread each. If calls throw, the other ranks end too, and the
  /// first exception is thrown again.
  template <class F>
  void on_all(const F& f) const {
    std::exception_ptr failure;
    std::atomic<bool> failed = false;
    {
      std::vector<std::jthread> threads;
      for (int r = 0; r < static_cast<int>(ranks_.size()); ++r)
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

  std::function<void(int)> enter_;
  std::vector<std::shared_ptr<parallel::Link>> links_;
  std::vector<std::unique_ptr<GasImpl<Executor>>> ranks_;
};

}  // namespace lichtenberg::granular::device
