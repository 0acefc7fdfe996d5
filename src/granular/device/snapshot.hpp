#pragma once

// A gas on an executor at an instant, in the host's memory: all that a checkpoint of it has.

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "solvers/geometry/vec.hpp"
#include "src/model/checkpoint.hpp"

namespace lichtenberg::granular::device {

struct TurnsAround {
  int x = 0, y = 0, z = 0;
};

/// An open contact, as a checkpoint has it.
struct OpenContact {
  int i, j;
  double since, impact_speed;
  int alone, unused = 0;  // no padding: all bytes are copied
};

/// What a checkpoint has of a grain.
struct GrainRecord {
  Vec3 place, momentum;
  double charge = 0;
  std::int64_t collisions = 0;
  TurnsAround image;
  int unused = 0;
};

/// Counted since the gas began.
struct Counters {
  std::int64_t steps = 0, contact_steps = 0, collisions = 0, transfers = 0, evaluations = 0;
};

struct Snapshot {
  double time = 0;
  std::shared_ptr<const void> memory;     ///< of what follows; it is used again once nobody has it
  std::span<const GrainRecord> grains;    ///< [N], by number
  std::span<const OpenContact> contacts;  ///< in any order
  Counters count;
  double dissipated = 0, exchanged = 0, driven = 0, overlap = 0;
  double potential = 0;                                   ///< energy of charges, where the snapshot was to have it
  bool charged = false, exchanges = false, sums = false;  ///< what there is: charges, their exchange, their forces
  std::vector<double> restitution;                        ///< RestitutionCheck's
  std::function<void(Checkpoint&)> dipoles;               ///< puts them into a checkpoint; none: there are none
};

/// Changes what has changed in the checkpoint that was loaded. On any thread.
void store(const Snapshot& snapshot, Checkpoint& checkpoint);

}  // namespace lichtenberg::granular::device
