#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "src/model/bodies.hpp"
#include "src/model/frame.hpp"
#include "src/scene/scene.hpp"

namespace lichtenberg {

/// A scene with a contact potential on its way to rest, by the method that its [minimize] asks for.
class Relaxation {
 public:
  /// Throws InputError if the energy is infinite at the start, Failure if a force is.
  explicit Relaxation(const Scene& scene);
  ~Relaxation();

  /// Goes on by one iteration. False, and nothing happens, if the method finds no lower energy. Throws Failure if a
  /// force is no finite number.
  bool iterate();
  std::int64_t iteration() const;
  std::int64_t evaluations() const;  ///< of energy and forces
  double energy() const;             ///< J
  double largest_force() const;      ///< N, net, on a particle
  double force_unit() const;         ///< N: stiffness over the mean diameter
  /// No net force exceeds minimize.force_tolerance.
  bool at_rest() const;

  Bodies bodies() const;
  /// Its time is the iteration.
  Frame frame() const;

  /// All there is: a relaxation restored from it goes on bit for bit as this one does.
  Checkpoint checkpoint() const;
  /// Throws Failure if that was of another scene.
  void restore(const Checkpoint& checkpoint);

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace lichtenberg
