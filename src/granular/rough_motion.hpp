#pragma once

#include <memory>

#include "src/granular/contact_motion.hpp"
#include "src/granular/pace.hpp"
#include "src/model/checkpoint.hpp"
#include "src/model/surface_law.hpp"

namespace lichtenberg::granular {

/// Time integration of grains with friction, adhesion or walls. It has the interface of ContactMotion, and sums in each
/// substep the forces of all contacts (velocity Verlet). Tangential springs are its state. Reduced units.
class RoughMotion : public ContactMotion {
 public:
  /// Returns the surface law, without materials if all are that of the scene.
  virtual const SurfaceLaw& surface() const = 0;
  /// Forgets all springs, and begins contacts of grains that overlap walls.
  virtual void begin(const Bodies& bodies) = 0;
  /// Returns the elastic and adhesive energy (m0 v0^2) of all contacts, walls included.
  virtual double stored_energy(const Bodies& bodies, std::span<const GrainContact> contacts) const = 0;
  /// Returns the largest relative speed (v0) that the elastic energy of a contact can give its partners.
  virtual double fastest_release(const Bodies& bodies, std::span<const GrainContact> contacts) const = 0;
  /// Returns the time (t0) that substeps must resolve for impact speeds up to `impact` (v0). It is the shortest of the
  /// duration of a contact, its damping time, and half the periods of tangential and adhesive oscillations.
  virtual double time_to_resolve(double impact, const GrainProperties& grains) const = 0;
  /// Adds springs and wall contacts to a checkpoint.
  virtual void save(Checkpoint& checkpoint) const = 0;
  virtual void restore(const Checkpoint& checkpoint) = 0;
};

/// Makes the time integration of grains with this normal law and surface law, for bodies of `dimension` 2 or 3.
std::unique_ptr<RoughMotion> make_rough_motion(const GrainContactLaw& law, const SurfaceLaw& surface, int dimension);

/// Returns the surface law in an elastic stage of equilibration: walls, without friction and adhesion.
SurfaceLaw elastic(const SurfaceLaw& law);

/// Returns the angular velocity (1/t0) of grain i as a vector in space. The bodies must rotate.
inline Vec3 spin_of(const Bodies& bodies, int i) {
  if (bodies.dimension == 2) return {0, 0, bodies.angular_velocity[i]};
  return vector_at(bodies.angular_velocity, 3, i);
}
/// Returns the kinetic energy of rotation (m0 v0^2), the sum of I w^2 / 2.
double rotational_energy(const Bodies& bodies);

/// Sets moments of inertia and angular velocities of the grains of a scene. Has no effect if `law` has no inertia.
void set_rotation(const Scene& scene, const SurfaceLaw& law, Bodies& bodies);

}  // namespace lichtenberg::granular
