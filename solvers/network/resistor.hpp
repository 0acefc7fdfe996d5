#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "solvers/network/network.hpp"
#include "solvers/network/parameters.hpp"

namespace lichtenberg::network {

/// Contact in a particle-centred network: a path from one centre to the other, or to a wall.
struct Path {
  double length[2] = {0, 0};       ///< Lengths from each centre to the contact (m); no second one at a wall
  double resistivity[2] = {1, 1};  ///< Resistivity of each particle, relative to the parameters
  bool wall = false;
};

/// Particle in a contact-centred network.
struct Particle {
  Point centre{};               ///< Centre (m)
  double radius = 0;            ///< Radius (m)
  double resistivity = 1;       ///< Resistivity relative to the parameters
  int index = 0;                ///< Index for error messages
  std::vector<Point> contacts;  ///< Contact points (m)
};

/// Model of the resistors. A new model is an entry in resistor.cpp.
struct ResistorModel {
  std::string name, help;
  std::vector<std::string> needs;  ///< Names of the required parameters
  /// Returns the resistance (Ohm) of a path from centre to centre; null: the model supports contact-centred networks
  /// only.
  double (*path)(const Parameters&, const Path&);
  /// Returns the conductances (S) between the contacts of a particle ([n, n], symmetric; the diagonal is not read).
  Eigen::MatrixXd (*particle)(const Parameters&, const Particle&);
  bool flat = false;  ///< True if the model holds for disks in the plane only
};

const std::vector<ResistorModel>& resistor_models();
/// Returns the model with this name. Throws InputError if there is none.
const ResistorModel& resistor_model(const std::string& name);

/// Name, unit, help and value of a parameter.
struct ParameterEntry {
  const char *name, *unit, *help;
  std::optional<double> Parameters::*value;
};
std::span<const ParameterEntry> parameter_entries();

/// Returns true if the model needs the parameter.
bool needs(const ResistorModel& model, const ParameterEntry& parameter);

/// Throws InputError if the model lacks a parameter, does not use a given one, or one is not positive and finite.
void check(const ResistorModel& model, const Parameters& parameters);

/// Throws InputError if the model does not hold for particles of these radii (m) in this number of dimensions: a spot
/// must be smaller than each of them.
void check_particles(const ResistorModel& model, const Parameters& parameters, std::span<const double> radius,
                     int dimension);

/// Returns the conductances between the terminals of a conductor with potentials V = P I + c, sum I = 0. From I = G V
/// with G = P^-1 - P^-1 1 1^T P^-1 / (1^T P^-1 1), the link between two terminals is -G_ij. [n, n] in Ohm gives [n, n]
/// in S with zeros on the diagonal. A constant added to all of P has no effect.
Eigen::MatrixXd links_of_terminals(const Eigen::MatrixXd& resistance);

}  // namespace lichtenberg::network
