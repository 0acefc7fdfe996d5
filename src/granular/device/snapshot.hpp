#pragma once

// State of a gas on an executor at one instant, in host memory: the content of a checkpoint.

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "solvers/geometry/vec.hpp"
#include "src/model/checkpoint.hpp"

namespace lichtenberg::granular::device {

/// Number of periods by which a grain has crossed the periodic box, along each axis.
struct ImageCount {
  int x = 0, y = 0, z = 0;
};

/// A contact of two grains that has begun and not ended at the time of a checkpoint (members as in GrainContact). i and
/// j are indices of the grains in the scene.
struct OpenContact {
  int i, j;
  double since, impact_speed;
  int alone, unused = 0;  // no padding: all bytes are copied
};

/// State of a grain in a checkpoint, in reduced units.
struct GrainRecord {
  Vec3 position, momentum;
  double charge = 0;
  std::int64_t collisions = 0;
  ImageCount image;
  int unused = 0;
};

/// Rotation of a grain in a checkpoint, in reduced units. Bit k of `at_walls`: it is in contact with wall k.
struct RoughRecord {
  Vec3 spin;
  unsigned at_walls = 0, unused = 0;
};
/// A contact of a grain with a side of the domain. `wall`: index among the sides that are walls.
struct WallRecord {
  int grain = 0, side = 0, wall = 0, unused = 0;
  double since = 0, impact_speed = 0;
  Vec3 spring;
};
/// State of rough grains in a checkpoint, in addition to that of smooth ones.
struct RoughSnapshot {
  bool rotates = false;
  std::vector<RoughRecord> grains{};  ///< [N], in the order of the scene
  std::vector<Vec3> springs{};        ///< elongations of the contacts of two grains, in the order of Snapshot::contacts
  std::vector<WallRecord> walls{};    ///< in the order of grains and sides
};

/// Counters since the start of the run: outer steps (from one evaluation of the smooth forces to the next), contact
/// substeps, contact onsets, charge transfers, refused transfers, Coulomb sums.
struct Counters {
  std::int64_t steps = 0, contact_steps = 0, collisions = 0, transfers = 0, refused = 0, evaluations = 0;
};

/// Copy of the state of a gas on a device at one instant in host memory, as needed for a checkpoint. Reduced units.
struct Snapshot {
  double time = 0;
  std::shared_ptr<const void> memory;     ///< owner of the spans; reused after its release
  std::span<const GrainRecord> grains;    ///< [N], in the order of the scene
  std::span<const OpenContact> contacts;  ///< in any order
  Counters count;
  /// Energies since the start (GasEnergy): dissipated by contacts, given by charge exchange, given by drives.
  /// `overlap`: largest ratio of overlap to sum of radii.
  double dissipated = 0, exchanged = 0, driven = 0, overlap = 0;
  double potential = 0;                                   ///< energy of smooth forces; 0 unless the caller sets it
  bool charged = false, exchanges = false, sums = false;  ///< whether the scene has charges, exchange, Coulomb forces
  std::vector<double> restitution;                        ///< saved RestitutionCheck
  std::shared_ptr<const RoughSnapshot> rough;             ///< null: smooth grains
  std::function<void(Checkpoint&)> dipoles;               ///< writes the dipoles to a checkpoint; empty: no dipoles
};

/// Stores the contacts of a snapshot in a checkpoint: pairs in ascending order, and of rough grains the springs and the
/// contacts with walls.
void store_contacts(const Snapshot& from, Checkpoint& to);
/// Updates a checkpoint of a gas (Gas::save) to the state of a snapshot of this gas on a device. The function may run
/// on any thread.
void store(const Snapshot& snapshot, Checkpoint& checkpoint);

}  // namespace lichtenberg::granular::device
