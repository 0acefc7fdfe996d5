#pragma once

#include <functional>
#include <map>
#include <memory>
#include <span>
#include <utility>
#include <vector>

namespace lichtenberg::theory {

// Theory of a homogeneous gas of grains with binary collisions, in reduced units. Mass and diameter of a grain are 1.
// The temperature T is the variance of each component of its velocity (G 2.12). The density n is the number of grains
// per volume.

/// Computes the radial distribution function (pair correlation function) at contact of hard spheres (Carnahan and
/// Starling 1969): g = (1 - phi/2) / (1 - phi)^3, with the volume fraction phi = pi density / 6.
double contact_value(double density);

/// Computes the collision frequency of a grain, omega = 4 n g sqrt(pi T), with density n, temperature T and g =
/// contact_value(n).
double collision_frequency(double density, double temperature);

/// Computes the time tau of Haff's cooling law for a constant restitution coefficient eps. n is the density, T_0 the
/// initial temperature, and g = contact_value(n).
///
///   1/tau = (2/3) sqrt(pi) (1 - eps^2) n g sqrt(T_0) (1 + 3 a_2/16)
///
/// a_2 (`sonine`) is the second Sonine coefficient of the velocities (van Noije and Ernst 1998).
double haff_time(double density, double temperature, double restitution, double sonine = 0);

/// Computes the temperature of a freely cooling gas of constant restitution by Haff's law, T_0 / (1 + t/tau)^2 (Haff
/// 1983).
double haff_temperature(double initial, double tau, double time);

/// Computes the mean of f(v, x) over the impacts of a Maxwellian gas. v is the normal speed of impact: v^2 = 4 T x,
/// with x distributed as exp(-x). Throws Failure if it is not finite.
double impact_mean(double temperature, const std::function<double(double speed, double x)>& f);

/// Laws of a collision of two grains: restitution coefficient, duration and transferred charge.
struct Impacts {
  std::function<double(double speed)> restitution;
  /// Mean duration t_c of collisions as a function of temperature. In this time a grain has no other collision, so that
  /// the collision frequency omega becomes omega / (1 + omega t_c). Empty: 0.
  std::function<double(double temperature)> duration{};
  /// Mean square of the transferred charge, whose sign is random. Empty: 0.
  std::function<double(double speed)> charge_square{};
};

/// Table of means over the impacts of a Maxwellian gas as functions of temperature. They are interpolated by
/// polynomials through Chebyshev points of ln T, to about 1e-12. Each polynomial is made at its first use, and results
/// do not depend on the order of calls.
class ImpactTable {
 public:
  explicit ImpactTable(Impacts impacts) : impacts_(std::move(impacts)) {}

  double lost(double temperature) const;           ///< <(1 - eps(v)^2) x>, energy loss (impact_mean)
  double charge_square(double temperature) const;  ///< <dq^2>; 0 without a charge law
  double duration(double temperature) const;       ///< mean duration of collisions; 0 without one

 private:
  struct TableInterval;
  const TableInterval& interval_at(double log_temperature) const;

  Impacts impacts_;
  mutable std::map<int, std::shared_ptr<const TableInterval>> intervals_;
};

/// State of a cooling homogeneous gas at one time.
struct CoolingState {
  double temperature = 0;
  double charge_square = 0;  ///< <q^2> of grains, 0 at the start
  double collisions = 0;     ///< number of collisions of a grain since the start
};

/// Integrates the temperature T and the mean square charge <q^2> of a freely cooling homogeneous gas from T =
/// `initial`. Returns them at these times (ascending, >= 0), to 1e-9:
///
///   dT/dt = -(omega/3) T <(1 - eps(v)^2) x>,   d<q^2>/dt = omega <dq^2>,
///
/// with the collision frequency omega, reduced by the duration of collisions (Impacts::duration). Velocities are
/// Maxwellian (impact_mean), and there are no forces between charges.
std::vector<CoolingState> cool(double density, const Impacts& impacts, double initial, std::span<const double> times);
/// Integrates temperature and mean square charge of a freely cooling gas like cool(density, impacts, initial, times),
/// but with tabulated means over impacts.
std::vector<CoolingState> cool(double density, const ImpactTable& table, double initial, std::span<const double> times);

/// Computes the mean square charge <dq^2> that a collision transfers. The charge is +-strength (Psi_1 m_eff
/// v^2)^(exponent + Psi_2), with Psi_1 uniform in [.1, 10^(1/2)] and Psi_2 uniform in +-.05 exponent (G 4.3).
double impact_charge_square(double strength, double exponent, double effective_mass, double speed);

}  // namespace lichtenberg::theory
