#pragma once

// Induced dipoles in checkpoints, in the format of effects::Coulomb.

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "solvers/error.hpp"
#include "src/granular/device/lists.hpp"

namespace lichtenberg::granular::device {

/// Loads the history of induced dipoles and the counter of their solver from a checkpoint. n: number of grains.
template <class Executor>
void load_dipoles(const Checkpoint& checkpoint, int n, periodic::device::InducedDipolesOn<Executor>& dipoles) {
  std::vector<std::vector<double>> history;
  for (int k = 0; k < periodic::device::dipole_history; ++k)
    if (const auto kept = checkpoint.reals.find("effects.coulomb.dipole_" + std::to_string(k));
        kept != checkpoint.reals.end() && kept->second.size() == 3 * static_cast<std::size_t>(n))
      history.push_back(kept->second);
  dipoles.load(n, history, integers(checkpoint, "effects.coulomb.counters").at(1));
}

/// Writes values of sorted grains to a checkpoint in the order of the grains in the scene. `number`: index in the scene
/// of each sorted grain.
class ByNumber {
 public:
  ByNumber(Checkpoint& checkpoint, std::vector<int> number) : checkpoint_(&checkpoint), number_(std::move(number)) {}

  /// Writes the array "effects.coulomb.NAME" with one value for each grain; `name`: NAME; of(s): value of the grain
  /// with the sorted index s.
  template <class Of>
  void reals(const std::string& name, const Of& of) {
    std::vector<double>& to = checkpoint_->reals["effects.coulomb." + name];
    to.resize(number_.size());
    for (std::size_t s = 0; s < number_.size(); ++s) to[number_[s]] = of(s);
  }
  /// Writes the array "effects.coulomb.NAME" with one vector for each grain; `name`: NAME; of(s): vector of the grain
  /// with the sorted index s.
  template <class Of>
  void vectors(const std::string& name, const Of& of) {
    std::vector<double>& to = checkpoint_->reals["effects.coulomb." + name];
    to.resize(3 * number_.size());
    for (std::size_t s = 0; s < number_.size(); ++s)
      for (int k = 0; k < 3; ++k) to[3 * static_cast<std::size_t>(number_[s]) + k] = Vec3(of(s))[k];
  }

 private:
  Checkpoint* checkpoint_;
  std::vector<int> number_;
};

/// Copies induced dipoles, fields and forces from a device to the host. Returns a function that writes them to a
/// checkpoint, from which the CPU can continue.
template <class Executor>
std::function<void(Checkpoint&)> dipole_writer(const GasState<Executor>& gas, const ChargeSums<Executor>& sums,
                                               const periodic::device::InducedDipolesOn<Executor>& dipoles) {
  return [budget = gas.field_energy.download().front(), totals = sums.download_totals(),
          field_at_source = sums.download_fields(), force = sums.download_force(), number = gas.numbers(),
          dipole = dipoles.dipoles(), history = dipoles.history(), applications = dipoles.download().applications,
          background = sums.background()](Checkpoint& checkpoint) {
    const double back = 1 / budget.scale, share = totals.square > 0 ? 1 / totals.square : 0;
    const double own = background * totals.charge;
    ByNumber to(checkpoint, number);
    to.reals("potential", [&](std::size_t s) { return back * (field_at_source[s].potential + own); });
    to.vectors("field", [&](std::size_t s) {
      return back * Vec3{field_at_source[s].x, field_at_source[s].y, field_at_source[s].z};
    });
    to.vectors("force", [&](std::size_t s) {
      const FieldSample f = force[s];
      return back * back * (Vec3{f.x, f.y, f.z} - f.potential * share * Vec3{totals.x, totals.y, totals.z});
    });
    checkpoint.reals["effects.coulomb.energy"] = {back * back * (totals.energy + 0.5 * own * totals.charge)};
    checkpoint.reals["effects.coulomb.position"] = checkpoint.reals.at("position");
    checkpoint.reals["effects.coulomb.charge"] = checkpoint.reals.at("charge");
    to.vectors("dipole", [&](std::size_t s) { return dipole[s]; });
    for (std::size_t k = 0; k < history.size(); ++k)
      to.vectors("dipole_" + std::to_string(k), [&](std::size_t s) { return history[k][s]; });
    checkpoint.integers["effects.coulomb.counters"].at(1) = applications;
  };
}

/// Throws Failure if the mutual polarization of the induced dipoles diverges, or if their solver has not converged.
inline void check_dipoles(const periodic::device::DipoleSolve& solve, const GasOptions& options) {
  const std::string which =
      options.path + ": effects.induced_dipoles: at a polarizability of " + std::to_string(options.polarizability);
  if (solve.unstable)
    throw Failure(which +
                  " the mutual polarization of the dipoles at these positions diverges; a lower temperature or a "
                  "stiffer contact reduces the overlaps");
  if (solve.unsolved)
    throw Failure(which + " single precision keeps the residual field above " +
                  std::to_string(options.dipole_tolerance) +
                  " of the field: a larger tolerance, or \"cpu\", is needed");
}

}  // namespace lichtenberg::granular::device
