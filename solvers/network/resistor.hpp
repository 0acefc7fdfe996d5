#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "solvers/network/network.hpp"
#include "solvers/network/parameters.hpp"

namespace lichtenberg::network {

/// A contact as the particle-centred network sees it: a path from one centre to the other, or to a wall.
struct Path {
  double length[2] = {0, 0};       ///< m, from each centre to the contact; no second one at a wall
  double resistivity[2] = {1, 1};  ///< of each particle, relative to the parameters
  bool wall = false;
};

/// A particle as the contact-centred network sees it.
struct Particle {
  Point centre{};               ///< m
  double radius = 0;            ///< m
  double resistivity = 1;       ///< relative to the parameters
  int index = 0;                ///< for messages
  std::vector<Point> contacts;  ///< m, where it is touched
};

/// A model of the resistors. Adding one means adding an entry in resistor.cpp.
struct ResistorModel {
  std::string name, help;
  std::vector<std::string> needs;  ///< names of parameters
  /// Resistance (Ohm) of a path from centre to centre; null: a model of contact-centred networks only.
  double (*path)(const Parameters&, const Path&);
  /// Conductances (S) between the contacts of a particle ([n, n], symmetric; the diagonal is not read).
  Eigen::MatrixXd (*particle)(const Parameters&, const Particle&);
  bool flat = false;  ///< of disks in the plane only
};

const std::vector<ResistorModel>& resistor_models();
/// Throws InputError for a name that is none of theirs.
const ResistorModel& resistor_model(const std::string& name);

/// Every parameter's name, unit and value.
struct ParameterEntry {
  const char *name, *unit, *help;
  std::optional<double> Parameters::*value;
};
std::span<const ParameterEntry> parameter_entries();

/// Whether the model needs the parameter.
bool needs(const ResistorModel& model, const ParameterEntry& parameter);

/// Throws InputError if the model lacks a parameter, has no use for one, or one is not positive and finite.
void check(const ResistorModel& model, const Parameters& parameters);

/// Throws InputError if the model does not hold for particles of these radii (m) in so many dimensions: a spot must be
/// smaller than each of them.
void check_particles(const ResistorModel& model, const Parameters& parameters, std::span<const double> radius,
                     int dimension);

/// Conductances between the terminals of a conductor whose potentials are V = P I + c, sum I = 0:
/// I = G V with G = P^-1 - P^-1 1 1^T P^-1 / (1^T P^-1 1), and what links two terminals is -G_ij. [n, n] in Ohm gives
/// [n, n] in S with zeros on the diagonal. The same constant added to all of P changes nothing.
Eigen::MatrixXd links_of_terminals(const Eigen::MatrixXd& resistance);

}  // namespace lichtenberg::network
