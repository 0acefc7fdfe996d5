#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "src/analysis/gas_state.hpp"
#include "src/granular/device/device.hpp"
#include "src/granular/gas.hpp"
#include "src/granular/homogeneous_gas.hpp"
#include "src/model/column.hpp"

namespace lichtenberg::granular {

/// Observables of a gas at one instant, which may lie between frames.
struct Note {
  /// Predictions for a homogeneous gas.
  struct Expected {
    double temperature = 0, collisions = 0;
    std::optional<double> charge_square;
  };
  double time = 0;
  GasEnergy energy;
  analysis::GasState gas;
  std::int64_t contacts = 0, collisions = 0;
  std::optional<Expected> expected;

  /// Temperature (m0 v0^2) relative to the local flow; the total one where the gas is too thin for a local flow.
  double temperature() const;
};

std::vector<Pair> pairs_in_contact(const Gas& gas);

/// Computes the observables of the gas at its present instant, and advances `theory`, if there is one. `potential`: the
/// potential energy, if it is known.
Note take_note(Gas& gas, std::optional<HomogeneousGas>& theory, double& analysis_seconds,
               std::optional<double> potential = {});
/// Returns the observables of a gas on a device, without predictions. `like` has its masses, radii and box. `before`
/// has the entries of the energy budget that devices do not change.
Note note_of(const device::Snapshot& snapshot, const Bodies& like, const GrainContactLaw& law, const GasEnergy& before);
/// Adds the predictions of `theory` for the instant of `note`, in the present stage of the gas.
void expect(Note& note, const Gas& gas, HomogeneousGas& theory);

/// Returns the observables as columns of the group "gas", one row per instant (Note). Without `theory` there are no
/// columns of predictions.
ColumnGroup columns_of(std::span<const Note> notes, const std::optional<HomogeneousGas>& theory);

}  // namespace lichtenberg::granular
