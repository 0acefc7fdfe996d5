#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "solvers/network/network.hpp"
#include "solvers/network/parameters.hpp"

namespace lichtenberg::network {

/// Mechanical state of a contact, on which its resistance can depend.
struct ContactState {
  double overlap = 0;  ///< Depth of the overlap (m)
  double force = 0;    ///< Normal force (N); NaN if it is not known
  double radius = 0;   ///< Effective radius (m): r_i r_j / (r_i + r_j), at a wall the particle's radius
  bool wall = false;   ///< True if the contact is with a wall
};

/// Resistor of a particle-centred network: the current path from the centre of a particle through a contact to the
/// centre of the other particle, or to a wall.
struct Path {
  double length[2] = {0, 0};       ///< Length from each centre to the contact (m); at a wall only the first counts
  double resistivity[2] = {1, 1};  ///< Resistivity of each particle, relative to the parameters
  bool wall = false;               ///< True if the contact is with a wall
  ContactState contact{};
};

/// Particle of a contact-centred network: its contacts are the terminals between which it conducts.
struct Particle {
  Point centre{};                    ///< Centre (m)
  double radius = 0;                 ///< Radius (m)
  double resistivity = 1;            ///< Resistivity relative to the parameters
  int index = 0;                     ///< Index for error messages
  std::vector<Point> contacts;       ///< Contact points (m)
  std::vector<ContactState> states;  ///< State of each contact
};

/// Resistor model: gives the resistances of a packing's network from Parameters. Each model is an entry of
/// resistor_models().
struct ResistorModel {
  std::string name, help;
  std::vector<std::string> needs;  ///< Names of the required parameters
  /// Computes the resistance (Ohm) of a path in a particle-centred network. Null if the model supports contact-centred
  /// networks only.
  double (*path)(const Parameters&, const Path&);
  /// Computes the conductances (S) between the n contacts of a particle in a contact-centred network: [n, n],
  /// symmetric; the diagonal has no meaning.
  Eigen::MatrixXd (*particle)(const Parameters&, const Particle&);
  bool flat = false;                  ///< True if the model holds for disks in the plane only
  std::vector<std::string> allows{};  ///< Names of optional parameters
  bool contacts_only = false;         ///< True if particles resist only at their contacts
  bool uses_force = false;            ///< True if the model needs the forces of contacts
};

/// Returns all resistor models.
const std::vector<ResistorModel>& resistor_models();
/// Returns the resistor model with this name. Throws InputError if there is none.
const ResistorModel& resistor_model(const std::string& name);

/// Description of a member of Parameters: its name, unit and help text, and a pointer to the member.
struct ParameterEntry {
  const char *name, *unit, *help;
  std::optional<double> Parameters::*value;
};
/// Returns the descriptions of all members of Parameters.
std::span<const ParameterEntry> parameter_entries();

/// Returns true if the resistor model needs the parameter.
bool needs(const ResistorModel& model, const ParameterEntry& parameter);
/// Returns true if the resistor model needs or allows the parameter.
bool uses(const ResistorModel& model, const ParameterEntry& parameter);
/// Lists the parameters of a model for a message, as in "resistivity and contact_radius, and optional
/// film_resistance".
std::string parameters_in_words(const ResistorModel& model);

/// Checks the parameters for a resistor model. Throws InputError if a needed parameter is absent or a given one is not
/// used. Also throws it if a value is not positive and finite.
void check(const ResistorModel& model, const Parameters& parameters);

/// Checks that a resistor model holds for particles of these radii (m) in this number of dimensions (2 or 3). Throws
/// InputError for a model of flat disks in three dimensions. For a model that needs the contact radius, also throws it
/// unless that is smaller than each particle radius.
void check_particles(const ResistorModel& model, const Parameters& parameters, std::span<const double> radius,
                     int dimension);

/// Converts the resistance matrix of a conductor with n terminals to the equivalent network: conductances (S) between
/// each two terminals, [n, n], with zero diagonal.
/// `resistance` is the matrix P [n, n] (Ohm) in V = P I + c, with terminal potentials V, injected currents I of sum 0,
/// and any constant c. Then I = G V with G = P^-1 - P^-1 1 1^T P^-1 / (1^T P^-1 1). The conductance between terminals i
/// and j is -G_ij. A constant added to all entries of P has no effect.
Eigen::MatrixXd links_of_terminals(const Eigen::MatrixXd& resistance);

}  // namespace lichtenberg::network
