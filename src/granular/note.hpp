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

/// What is noted of a gas between frames too.
struct Note {
  /// What theory expects of a homogeneous gas.
  struct Expected {
    double temperature = 0, collisions = 0;
    std::optional<double> charge_square;
  };
  double time = 0;
  GasEnergy energy;
  analysis::GasState gas;
  std::int64_t contacts = 0, collisions = 0;
  std::optional<Expected> expected;

  /// Relative to the local flow, or where the gas is too thin for that of all motion.
  double temperature() const;
};

std::vector<Pair> pairs_in_contact(const Gas& gas);

/// Carries `theory`, if there is any, on to now. `potential`: what is known of that energy already.
Note take_note(Gas& gas, std::optional<HomogeneousGas>& theory, double& analysis_seconds,
               std::optional<double> potential = {});
/// Of a gas on a device, without what theory expects. `like` has its masses, radii and box, `before` what was booked
/// before it went there, of which the device knows no more.
Note note_of(const device::Snapshot& snapshot, const Bodies& like, const GrainContactLaw& law, const GasEnergy& before);
/// What `theory` expects of the gas, in its present stage, when the note was taken.
void expect(Note& note, const Gas& gas, HomogeneousGas& theory);

/// The notes as columns of the group "gas", a row a note; those that have no expectation lack its columns.
ColumnGroup columns_of(std::span<const Note> notes, const std::optional<HomogeneousGas>& theory);

}  // namespace lichtenberg::granular
