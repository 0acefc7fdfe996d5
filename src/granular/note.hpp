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

/// Row of the time series of a gas: energy, temperature, charges, clusters and counts at one instant, in reduced units.
/// The instant may lie between frames.
struct Note {
  /// Theoretical predictions for a homogeneous gas (HomogeneousGas).
  struct Expected {
    double temperature = 0, collisions = 0;
    std::optional<double> charge_square;
  };
  double time = 0;
  GasEnergy energy;
  analysis::GasState gas;
  std::int64_t contacts = 0, collisions = 0;
  std::optional<Expected> expected;

  /// Returns the granular temperature relative to the local flow (m0 v0^2). Returns the total temperature, flow
  /// included, if the gas is so dilute that a local flow is undefined.
  double temperature() const;
};

/// Returns the pairs of grains that are in contact, in ascending order.
std::vector<Pair> pairs_in_contact(const Gas& gas);

/// Computes the observables of a gas at this instant for its time series. Advances the predictions `theory`, if there
/// are any, and includes them. `analysis_seconds`: wall time (s), increased. `potential`: potential energy if it is
/// known.
Note take_note(Gas& gas, std::optional<HomogeneousGas>& theory, double& analysis_seconds,
               std::optional<double> potential = {});
/// Laws of the contacts of a gas; `surface`: of rough grains, empty for smooth ones.
struct LawsOfContacts {
  GrainContactLaw normal;
  std::optional<SurfaceLaw> surface;
};
/// Returns the observables of a gas from its snapshot on a device, without predictions. `like`: masses, radii, moments
/// of inertia and box of the grains; `before`: energy budget whose entries the snapshot replaces, except contact_error.
Note note_of(const device::Snapshot& snapshot, const Bodies& like, const LawsOfContacts& laws, const GasEnergy& before);
/// Advances the predictions `theory` to the instant of `note`, and adds them to `note`. `gas`: gas in the same stage.
void expect(Note& note, const Gas& gas, HomogeneousGas& theory);

/// Converts the observables to columns of the group "gas" of the result file, one row for each Note. Without `theory`
/// there are no columns of predictions.
ColumnGroup columns_of(std::span<const Note> notes, const std::optional<HomogeneousGas>& theory);

}  // namespace lichtenberg::granular
