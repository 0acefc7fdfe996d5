#pragma once

#include <functional>
#include <map>
#include <memory>
#include <span>
#include <utility>
#include <vector>

namespace lichtenberg::theory {

// A homogeneous gas of grains that collide one pair at a time, in reduced units: mass and diameter of a grain are 1,
// temperature T is the variance of each component of its velocity (G 2.12), density is grains a volume.

/// Pair correlation at contact (Carnahan and Starling 1969): g = (1 - phi/2) / (1 - phi)^3, phi = pi density / 6.
double contact_value(double density);

/// Collisions of one grain a time, omega = 4 n g sqrt(pi T).
double collision_frequency(double density, double temperature);

/// tau of Haff's law for a constant restitution: 1/tau = (2/3) sqrt(pi) (1 - eps^2) n g sqrt(T_0) (1 + 3 a_2/16), a_2
/// the second Sonine coefficient of the velocities (van Noije and Ernst 1998).
double haff_time(double density, double temperature, double restitution, double sonine = 0);

/// T_0 / (1 + t/tau)^2 (Haff 1983).
double haff_temperature(double initial, double tau, double time);

/// Mean over the impacts of a Maxwellian gas of f(v, x), v the normal speed of impact: v^2 = 4 T x, x ~ exp(-x).
double impact_mean(double temperature, const std::function<double(double speed, double x)>& f);

/// What a collision does.
struct Impacts {
  std::function<double(double speed)> restitution;
  /// What omega^-1 is longer by, as a function of temperature: collisions last, and a grain does not meet the next one
  /// meanwhile, omega / (1 + omega t_c). Empty: 0.
  std::function<double(double temperature)> duration{};
  /// Mean square of the charge that moves, whose sign is random. Empty: 0.
  std::function<double(double speed)> charge_square{};
};

/// What impacts do on average, as functions of temperature: between, by polynomials through Chebyshev points of ln T,
/// made where they are first asked for, within 1e-12. What is asked for when does not show in them.
class ImpactTable {
 public:
  explicit ImpactTable(Impacts impacts) : impacts_(std::move(impacts)) {}

  double lost(double temperature) const;           ///< <(1 - eps(v)^2) x>
  double charge_square(double temperature) const;  ///< <dq^2>; 0 where nothing is known of it
  double duration(double temperature) const;       ///< what omega^-1 is longer by; 0 where nothing is known of it

 private:
  struct Piece;
  const Piece& piece_at(double log_temperature) const;

  Impacts impacts_;
  mutable std::map<int, std::shared_ptr<const Piece>> pieces_;
};

struct CoolingState {
  double temperature = 0;
  double charge_square = 0;  ///< <q^2> of grains, 0 at the start
  double collisions = 0;     ///< of a grain, since the start
};

/// The gas at these times (rising, >= 0), to 1e-9:
///   dT/dt = -(omega/3) T <(1 - eps(v)^2) x>,   d<q^2>/dt = omega <dq^2>,
/// with Maxwellian velocities, and no forces between charges.
std::vector<CoolingState> cool(double density, const Impacts& impacts, double initial, std::span<const double> times);
std::vector<CoolingState> cool(double density, const ImpactTable& table, double initial, std::span<const double> times);

/// Drag `stokes` (v_gas - v) of a gas whose velocity at each grain is Gaussian, of this standard deviation a component,
/// and drawn anew after each `hold` (effects::GasDrag).
struct RandomDrag {
  double stokes = 0, speed = 0, hold = 1;
};

/// The temperature that it drives grains to, which lose energy in collisions, averaged over time, to 1e-9. Within a
/// hold C = <v_gas v> a component grows by stokes (speed^2 - C) and decays by collisions at the rate nu at which these
/// let a grain forget its velocity: <v.(v' - v)> = -(1 + eps) v_n^2 / 4 of each, v_n^2 = 4 T x, over <v^2> = 3 T gives
/// nu = omega <(1 + eps) x> / 3 (Enskog's decay of velocities). The momentum that the partner gets is lost, for its
/// v_gas is another. With lambda = stokes + nu the mean over a hold is
///   C = speed^2 stokes / lambda (1 - (1 - exp(-lambda hold)) / (lambda hold)),
/// and 2 stokes (C - T) = (omega/3) T <(1 - eps^2) x>. At density 0 this is speed^2 (1 - (1 - exp(-S h)) / (S h)), S h
/// being stokes hold; where v_gas is drawn anew the temperature then is speed^2 tanh(S h / 2). Maxwellian velocities.
double driven_temperature(double density, const Impacts& impacts, const RandomDrag& drag);

/// <|q|> of Gaussian charges: sqrt(2 <q^2> / pi).
double mean_charge(double charge_square);

/// <dq^2> of a collision that moves +-strength (Psi_1 m_eff v^2)^(exponent + Psi_2), with Psi_1 uniform in [.1,
/// 10^(1/2)] and Psi_2 in +-.05 exponent (G 4.3).
double impact_charge_square(double strength, double exponent, double effective_mass, double speed);

}  // namespace lichtenberg::theory
