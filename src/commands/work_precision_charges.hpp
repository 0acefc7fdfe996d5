#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "solvers/periodic/sum.hpp"
#include "src/commands/work_precision.hpp"
#include "src/effects/induced_dipoles.hpp"
#include "src/model/bodies.hpp"

namespace lichtenberg::work_precision {

/// Charges at the places of a scene's first instant, and the forces that they should feel.
struct ChargedSubject {
  Bodies bodies;
  std::optional<effects::InducedDipolesOptions> dipoles;
  std::vector<int> sample;       ///< of whom forces are compared
  periodic::Response reference;  ///< of the sample
  double rms_force = 0;

  periodic::Sources sources() const { return {bodies.box.lengths, bodies.position, bodies.charge}; }
  double diameter() const;  ///< of the smallest grain
  double half_box() const;  ///< along its shortest side
  /// Root mean square and largest error of these forces ([3 N]) over the rms force.
  std::vector<double> errors(const std::vector<double>& force) const;
};

/// The charges' forces by LAMMPS (`lmp`), with its PPPM at this accuracy and a cut-off; the seconds are those that it
/// reports itself for an evaluation on one core. Throws InputError if it is not installed.
std::unique_ptr<Trial> make_lammps_trial(const ChargedSubject& subject, double accuracy, double cutoff);

}  // namespace lichtenberg::work_precision
