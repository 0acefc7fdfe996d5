#include "solvers/network/resistor.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "solvers/error.hpp"

namespace lichtenberg::network {
namespace {

using std::numbers::pi;

/// Returns the conductances of every pair of a particle's contacts, given the resistance (Ohm) as a function of their
/// distance.
template <class Resistance>
Eigen::MatrixXd all_pairs(const Particle& particle, const Resistance& resistance) {
  const auto n = static_cast<Eigen::Index>(particle.contacts.size());
  Eigen::MatrixXd links = Eigen::MatrixXd::Zero(n, n);
  for (Eigen::Index j = 0; j < n; ++j)
    for (Eigen::Index i = j + 1; i < n; ++i)
      links(i, j) = links(j, i) = 1 / resistance(distance(particle.contacts[i], particle.contacts[j]));
  return links;
}

// Constant: the same resistance for every resistor.

double constant_path(const Parameters& p, const Path& path) {
  return *p.resistance * (path.wall ? path.resistivity[0] : 0.5 * (path.resistivity[0] + path.resistivity[1]));
}
Eigen::MatrixXd constant_particle(const Parameters& p, const Particle& particle) {
  return all_pairs(particle, [&](double) { return *p.resistance * particle.resistivity; });
}

// Length: a wire of constant cross-section along each resistor.

double length_path(const Parameters& p, const Path& path) {
  return *p.resistance_per_length *
         (path.length[0] * path.resistivity[0] + (path.wall ? 0 : path.length[1] * path.resistivity[1]));
}
Eigen::MatrixXd length_particle(const Parameters& p, const Particle& particle) {
  return all_pairs(particle, [&](double d) { return *p.resistance_per_length * particle.resistivity * d; });
}

// Constriction: a particle is at one potential except near its contacts. Contact spots of radius b are disks on a
// half-space of resistivity rho, with rho / (4 b) on either side (Holm 1967). The contacts of a particle then form a
// star, whose mesh is equivalent to the particle-centred network.

/// Returns the resistance (Ohm) of a surface film over the contact spot, f / (pi b^2) for the resistance f of its unit
/// area; 0 without a film.
double film(const Parameters& p, double radius) {
  return p.film_resistance ? *p.film_resistance / (pi * radius * radius) : 0;
}

/// Returns the conductances between the contacts of a particle of one potential: the mesh of a star with these legs
/// (S).
Eigen::MatrixXd mesh_of_star(const Eigen::VectorXd& leg) { return leg * leg.transpose() / leg.sum(); }

double constriction_path(const Parameters& p, const Path& path) {
  return *p.resistivity / (4 * *p.contact_radius) * (path.resistivity[0] + (path.wall ? 0 : path.resistivity[1])) +
         film(p, *p.contact_radius);
}
Eigen::MatrixXd constriction_particle(const Parameters& p, const Particle& particle) {
  const auto n = static_cast<Eigen::Index>(particle.contacts.size());
  const double side = *p.resistivity * particle.resistivity / (4 * *p.contact_radius);
  if (p.film_resistance) {
    Eigen::VectorXd leg(n);
    for (Eigen::Index k = 0; k < n; ++k)
      leg[k] = 1 / (side + film(p, *p.contact_radius) * (particle.states[k].wall ? 1 : 0.5));
    return mesh_of_star(leg);
  }
  const double leg = 4 * *p.contact_radius / (*p.resistivity * particle.resistivity);
  return Eigen::MatrixXd::Constant(n, n, leg / static_cast<double>(n));
}

// Contact radius from the load. A spot of radius b that follows from force or overlap takes the place of the given one.

/// Contact spot: its radius, and the radius (m) of a single spot with the same constriction on one side.
struct Constriction {
  double radius = 0, conducting_radius = 0;
};

/// Returns the spot of smooth elastic spheres, b^3 = 3 F R / (4 E*) (Hertz 1882).
Constriction hertz_constriction(const Parameters& p, const ContactState& contact) {
  const double b = std::cbrt(0.75 * contact.force * contact.radius / *p.elastic_modulus);
  if (!(b <= contact.radius))
    throw InputError(fmt::format(
        "elastic_modulus = {:g} Pa is too small: the contact radius would be {:.3g} m under {:.3g} N, where at most "
        "{:.3g} m, the effective radius of the contact, is allowed",
        *p.elastic_modulus, b, contact.force, contact.radius));
  return {b, b};
}

/// Returns the spot of elastic spheres from their overlap delta, b^2 = R delta (Hertz 1882).
Constriction overlap_constriction(const Parameters&, const ContactState& contact) {
  const double b = std::sqrt(contact.radius * contact.overlap);
  return {b, b};
}

/// Returns the spot of rough spheres: F / (pi H s^2) microscopic spots of radius s within Hertz's area, whose
/// constrictions 1/(n s) and 1/b add (Greenwood, Br. J. Appl. Phys. 17, 1621 (1966)).
Constriction greenwood_constriction(const Parameters& p, const ContactState& contact) {
  const double b = hertz_constriction(p, contact).radius, pressure = contact.force / (pi * b * b);
  if (pressure > *p.hardness)
    throw InputError(fmt::format(
        "hardness = {:g} Pa is too small: under {:.3g} N a contact has the mean pressure {:.3g} Pa, and yields as a "
        "whole; the hardness must be above it",
        *p.hardness, contact.force, pressure));
  const double asperities = contact.force / (pi * *p.hardness * *p.spot_radius * *p.spot_radius);
  return {b, 1 / (1 / (asperities * *p.spot_radius) + 1 / b)};
}

using ConstrictionOf = Constriction(const Parameters&, const ContactState&);

template <ConstrictionOf constriction_of>
double load_path(const Parameters& p, const Path& path) {
  const Constriction constriction = constriction_of(p, path.contact);
  return *p.resistivity / (4 * constriction.conducting_radius) *
             (path.resistivity[0] + (path.wall ? 0 : path.resistivity[1])) +
         film(p, constriction.radius);
}
template <ConstrictionOf constriction_of>
Eigen::MatrixXd load_particle(const Parameters& p, const Particle& particle) {
  Eigen::VectorXd leg(static_cast<Eigen::Index>(particle.states.size()));
  for (Eigen::Index k = 0; k < leg.size(); ++k) {
    const ContactState& contact = particle.states[k];
    const Constriction constriction = constriction_of(p, contact);
    leg[k] = 1 / (*p.resistivity * particle.resistivity / (4 * constriction.conducting_radius) +
                  film(p, constriction.radius) * (contact.wall ? 1 : 0.5));
  }
  return mesh_of_star(leg);
}

[[noreturn]] void refuse_contact_radius(double contact_radius, const std::string& why, int particle, double radius) {
  throw InputError(fmt::format("contact_radius = {:g} m is too large: {} particle {} of radius {:g} m", contact_radius,
                               why, particle, radius));
}

/// Throws InputError if contacts overlap: the formulas hold for spots that are small compared to their distances.
void check_contact_radius(const Particle& particle, double contact_radius) {
  for (std::size_t j = 0; j < particle.contacts.size(); ++j)
    for (std::size_t i = 0; i < j; ++i)
      if (distance(particle.contacts[i], particle.contacts[j]) <= 2 * contact_radius)
        refuse_contact_radius(contact_radius, "contacts would overlap on", particle.index, particle.radius);
}

/// Returns the particle with its contacts moved to the surface, because an overlap puts them inside.
Particle with_contacts_on_surface(Particle particle) {
  const Point& centre = particle.centre;
  for (Point& contact : particle.contacts) {
    const double stretch = particle.radius / distance(centre, contact);
    for (int axis = 0; axis < 3; ++axis) contact[axis] = centre[axis] + stretch * (contact[axis] - centre[axis]);
  }
  return particle;
}

/// Returns the links; throws InputError for conductances that are not positive, which result from spots too wide for
/// the formulas.
Eigen::MatrixXd checked_links(const Particle& particle, double contact_radius, const Eigen::MatrixXd& resistance) {
  Eigen::MatrixXd links = links_of_terminals(resistance);
  for (Eigen::Index j = 0; j < links.cols(); ++j)
    for (Eigen::Index i = 0; i < j; ++i)
      if (!(links(i, j) > 0))
        refuse_contact_radius(contact_radius, "contacts are too wide for their distance on", particle.index,
                              particle.radius);
  return links;
}

/// Links between the contacts of a particle from its Neumann Green's function, which is known up to a constant: `own`
/// (Ohm) at one contact, `pair_function(d)` (Ohm) for two contacts at a distance d (m).
template <class PairFunction>
Eigen::MatrixXd green_particle(const Particle& touched, double contact_radius, double own, PairFunction pair_function) {
  const Particle particle = with_contacts_on_surface(touched);
  check_contact_radius(particle, contact_radius);
  const auto n = static_cast<Eigen::Index>(particle.contacts.size());
  Eigen::MatrixXd resistance(n, n);
  for (Eigen::Index j = 0; j < n; ++j)
    for (Eigen::Index i = 0; i < n; ++i)
      resistance(i, j) = i == j ? own : pair_function(distance(particle.contacts[i], particle.contacts[j]));
  return checked_links(particle, contact_radius, resistance);
}

/// Computes the links of a disk of radius a. Its Neumann Green's function is -(rho_s / pi) ln(d / a) between points of
/// the rim. Its mean over a contact of half-angle eps at one potential is -(rho_s / pi) ln sin(eps / 2).
Eigen::MatrixXd disk_particle(const Parameters& p, const Particle& particle) {
  const double scale = *p.sheet_resistance * particle.resistivity / pi;
  const double own = -scale * std::log(std::sin(0.5 * std::asin(*p.contact_radius / particle.radius)));
  return green_particle(particle, *p.contact_radius, own,
                        [&](double d) { return -scale * std::log(d / particle.radius); });
}

/// Computes the links of a sphere by its Neumann Green's function, with circular contact spots of radius b.
Eigen::MatrixXd sphere_particle(const Parameters& p, const Particle& particle) {
  const double rho = *p.resistivity * particle.resistivity, a = particle.radius, b = *p.contact_radius;
  const double own = rho * (1 / (4 * b) + (std::log(a / (2 * b)) + 1.5) / (4 * pi * a));
  return green_particle(particle, b, own, [&](double d) {
    return rho / (4 * pi) * (2 / d - (std::log(d / (2 * a)) + std::log1p(d / (2 * a))) / a);
  });
}

}  // namespace

const std::vector<ResistorModel>& resistor_models() {
  static const std::vector<ResistorModel> models = {
      {"constant", "the same resistance for every resistor", {"resistance"}, constant_path, constant_particle},
      {"length",
       "resistance in proportion to the resistor's length",
       {"resistance_per_length"},
       length_path,
       length_particle},
      {"constriction",
       "Holm's constriction, rho / (4 contact_radius) on either side of a contact; the particle itself resists nothing",
       {"resistivity", "contact_radius"},
       constriction_path,
       constriction_particle,
       false,
       {"film_resistance"},
       true},
      {"hertz",
       "Holm's constriction of elastic spheres, whose contact radius follows from the force (packings alone)",
       {"resistivity", "elastic_modulus"},
       load_path<hertz_constriction>,
       load_particle<hertz_constriction>,
       false,
       {"film_resistance"},
       true,
       true},
      {"overlap",
       "Holm's constriction, the contact radius is the square root of effective radius times overlap",
       {"resistivity"},
       load_path<overlap_constriction>,
       load_particle<overlap_constriction>,
       false,
       {"film_resistance"},
       true},
      {"greenwood",
       "rough elastic spheres: constrictions of many spots, whose area is force over hardness, and of Hertz's area "
       "(packings alone)",
       {"resistivity", "elastic_modulus", "hardness", "spot_radius"},
       load_path<greenwood_constriction>,
       load_particle<greenwood_constriction>,
       false,
       {"film_resistance"},
       true,
       true},
      {"disk",
       "a disk of a sheet with small contacts on its rim (Neumann Green's function); contact-centred only",
       {"sheet_resistance", "contact_radius"},
       nullptr,
       disk_particle,
       true},
      {"sphere",
       "a sphere with small circular contacts (Neumann Green's function); contact-centred only",
       {"resistivity", "contact_radius"},
       nullptr,
       sphere_particle},
  };
  return models;
}

const ResistorModel& resistor_model(const std::string& name) {
  std::vector<std::string> names;
  for (const ResistorModel& model : resistor_models()) {
    if (model.name == name) return model;
    names.push_back(model.name);
  }
  throw InputError(fmt::format("there is no resistor model \"{}\"; allowed are {}", name, fmt::join(names, ", ")));
}

std::span<const ParameterEntry> parameter_entries() {
  static constexpr std::array entries = {
      ParameterEntry{"resistance", "Ohm", "resistance of every resistor", &Parameters::resistance},
      ParameterEntry{"resistance_per_length", "Ohm/m", "resistance of a resistor over its length",
                     &Parameters::resistance_per_length},
      ParameterEntry{"sheet_resistance", "Ohm", "sheet resistance of a disk: its resistivity over its thickness",
                     &Parameters::sheet_resistance},
      ParameterEntry{"resistivity", "Ohm m", "resistivity of the particles", &Parameters::resistivity},
      ParameterEntry{"contact_radius", "m", "half of the width of a contact (between spheres its radius)",
                     &Parameters::contact_radius},
      ParameterEntry{"film_resistance", "Ohm m^2",
                     "resistance of a film on the surfaces times its area; over a contact, divided by the spot's area",
                     &Parameters::film_resistance},
      ParameterEntry{"elastic_modulus", "Pa",
                     "elastic modulus of a contact: its inverse is the sum of (1 - nu^2)/E over both bodies",
                     &Parameters::elastic_modulus},
      ParameterEntry{"hardness", "Pa", "hardness: load over the area that truly touches", &Parameters::hardness},
      ParameterEntry{"spot_radius", "m", "radius of a microscopic spot that truly touches", &Parameters::spot_radius},
  };
  return entries;
}

bool needs(const ResistorModel& model, const ParameterEntry& parameter) {
  return std::ranges::find(model.needs, parameter.name) != model.needs.end();
}

bool uses(const ResistorModel& model, const ParameterEntry& parameter) {
  return needs(model, parameter) || std::ranges::find(model.allows, parameter.name) != model.allows.end();
}

std::string parameters_in_words(const ResistorModel& model) {
  const std::string words = fmt::format("{}", fmt::join(model.needs, " and "));
  return model.allows.empty() ? words : fmt::format("{}, and optional {}", words, fmt::join(model.allows, " and "));
}

void check(const ResistorModel& model, const Parameters& parameters) {
  for (const ParameterEntry& entry : parameter_entries()) {
    const std::optional<double>& value = parameters.*entry.value;
    if (value && (!(*value > 0) || !std::isfinite(*value)))
      throw InputError(fmt::format("{} = {:g} {} is not allowed: it must be greater than 0 and finite", entry.name,
                                   *value, entry.unit));
    if (needs(model, entry) && !value)
      throw InputError(fmt::format("the resistor model \"{}\" needs {} in {}", model.name, entry.name, entry.unit));
    if (value && !uses(model, entry))
      throw InputError(fmt::format("the resistor model \"{}\" does not use {}: leave it out; allowed is {}", model.name,
                                   entry.name, parameters_in_words(model)));
  }
}

void check_particles(const ResistorModel& model, const Parameters& parameters, std::span<const double> radius,
                     int dimension) {
  if (model.flat && dimension == 3)
    throw InputError(fmt::format(
        "the resistor model \"{}\" is one of disks in the plane: particles in space may have any other", model.name));
  if (std::ranges::find(model.needs, "contact_radius") == model.needs.end()) return;
  for (std::size_t i = 0; i < radius.size(); ++i)
    if (*parameters.contact_radius >= radius[i])
      refuse_contact_radius(*parameters.contact_radius, "no contact can be that wide on", static_cast<int>(i),
                            radius[i]);
}

Eigen::MatrixXd links_of_terminals(const Eigen::MatrixXd& resistance) {
  const auto n = resistance.rows();
  if (n < 2) return Eigen::MatrixXd::Zero(n, n);
  // Solves for currents and the constant together: P may be singular, the bordered matrix is not. Entries are scaled to
  // about 1.
  const double scale = resistance.cwiseAbs().maxCoeff();
  Eigen::MatrixXd bordered = Eigen::MatrixXd::Ones(n + 1, n + 1);
  bordered.topLeftCorner(n, n) = resistance / scale;
  bordered(n, n) = 0;
  const Eigen::MatrixXd conductance = bordered.partialPivLu().inverse().topLeftCorner(n, n) / scale;
  Eigen::MatrixXd links = -0.5 * (conductance + conductance.transpose());
  links.diagonal().setZero();
  return links;
}

}  // namespace lichtenberg::network
