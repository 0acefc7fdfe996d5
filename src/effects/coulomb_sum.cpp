#include "src/effects/coulomb_sum.hpp"

#include <algorithm>

#include "solvers/periodic/ewald.hpp"
#include "solvers/periodic/short_range.hpp"
#include "src/effects/induced_dipoles.hpp"
#include "src/model/motion.hpp"
#include "src/scene/grain_threads.hpp"

namespace lichtenberg::effects {
namespace {

Vec3 lengths_of(const Scene& scene) { return scene.domain.box().lengths; }

/// Returns half of the shortest periodic side (d0); infinite without one.
double half_of_box(const Scene& scene) {
  const Box<3> box = scene.domain.box();
  double shortest = INFINITY;
  for (int k = 0; k < scene.dimension(); ++k)
    if (box.periodic(k)) shortest = std::min(shortest, box.lengths[k]);
  return 0.5 * shortest;
}

/// Returns the default cutoff (d0) of shifted_force. It leaves clearance for the skin of neighbour lists.
double default_cutoff(const Scene& scene) { return std::min(7.0, 0.9 * longest_cutoff(scene)); }

}  // namespace

periodic::Enclosure enclosure_of(const Domain& domain) {
  periodic::Enclosure enclosure{.lengths = domain.size, .unbounded = domain.open};
  if (domain.open) enclosure.lengths = {};
  for (int s = 0; s < 6; ++s)
    enclosure.sides[s] = domain.open || s >= 2 * domain.dimension() ? periodic::Side::open
                         : domain.sides[s].periodic                 ? periodic::Side::periodic
                         : domain.sides[s].electrode                ? periodic::Side::grounded
                                                                    : periodic::Side::open;
  return enclosure;
}

std::string sides_in_words(const Scene& scene) {
  const periodic::Enclosure enclosure = enclosure_of(scene.domain);
  if (enclosure.unbounded)
    return fmt::format("none: the mesh follows the extents of the charges; up to {} charges are summed by pairs",
                       periodic::BoundedSum::few);
  std::string open, grounded;
  for (int s = 0; s < 2 * scene.dimension(); ++s) {
    std::string& names = enclosure.sides[s] == periodic::Side::grounded ? grounded : open;
    if (enclosure.sides[s] != periodic::Side::periodic)
      names += fmt::format("{}{}", names.empty() ? "" : ", ", side_names[s]);
  }
  std::string text = grounded.empty() ? "" : "image charges beyond " + grounded;
  if (!open.empty()) text += fmt::format("{}empty space beyond {}", text.empty() ? "" : "; ", open);
  return text;
}

double longest_cutoff(const Scene& scene) {
  const auto [smallest, largest] = std::ranges::minmax(scene.conductors, {}, &Conductor::radius);
  return half_of_box(scene) * (1 - 1e-9) - 2 * (largest.radius - smallest.radius);
}

periodic::MeshRequest mesh_request(const Scene& scene) {
  const auto& options = *scene.effects.find<CoulombOptions>();
  const auto* dipoles = scene.effects.find<InducedDipolesOptions>();
  return {.accuracy = options.accuracy,
          .charges = static_cast<int>(scene.conductors.size()),
          .lengths = lengths_of(scene),
          .contact = 2 * scene.smallest_radius(),
          .polarizability = dipoles ? std::optional(dipoles->polarizability) : std::nullopt,
          .fixed = {options.cutoff, options.alpha, options.mesh, options.order}};
}

periodic::MeshChoice mesh_for(const Scene& scene) {
  const std::vector<double> charge = initial_charges(scene);
  std::vector<double> position;
  for (const Conductor& grain : scene.conductors)
    for (int k = 0; k < 3; ++k) position.push_back(grain.position[k]);
  const periodic::MeshRequest request = mesh_request(scene);
  const periodic::Enclosure enclosure = enclosure_of(scene.domain);
  const periodic::Sources sources{request.lengths, position, charge};
  parallel::Team team(threads_for_grains(scene));
  return enclosure.is_periodic() ? periodic::choose_measured_mesh(request, sources, team)
                                 : periodic::choose_bounded_mesh(request, enclosure, sources, team);
}

std::string accuracy_warning(const Scene& scene, const periodic::MeshChoice& choice) {
  constexpr double most = 0.1;  // largest allowed effects.coulomb.accuracy
  const double requested = scene.effects.find<CoulombOptions>()->accuracy;
  if (mesh_request(scene).fixed.complete()) {
    if (choice.error <= most) return "";
    return fmt::format(
        "effects.coulomb: the estimated force error is {:.2g} of the rms force at random positions with the given "
        "cutoff, mesh and order: at most {:g} is allowed",
        choice.error, most);
  }
  if (choice.error <= requested) return "";
  return fmt::format(
      "effects.coulomb.accuracy = {:g} is not reached: forces are off by {:.2g} of the rms force where the grains are",
      requested, choice.error);
}

std::unique_ptr<periodic::Sum> make_sum(const Scene& scene, std::string& warning) {
  const auto& options = *scene.effects.find<CoulombOptions>();
  switch (options.sum) {
    case CoulombSum::mesh:
      return with_table_name(scene, "effects.coulomb", [&] {
        const periodic::MeshChoice choice = mesh_for(scene);
        warning = accuracy_warning(scene, choice);
        const periodic::Enclosure enclosure = enclosure_of(scene.domain);
        return enclosure.is_periodic() ? periodic::make_mesh_sum(choice)
                                       : std::make_unique<periodic::BoundedSum>(mesh_request(scene), enclosure, choice);
      });
    case CoulombSum::ewald:
      return std::make_unique<periodic::Ewald>(options.accuracy);
    case CoulombSum::minimum_image:
      return std::make_unique<periodic::MinimumImage>(periodic::MinimumImage::Reach::box);
    case CoulombSum::shifted_force:
      break;
  }
  return std::make_unique<periodic::ShiftedForce>(options.cutoff.value_or(default_cutoff(scene)), options.damping);
}

}  // namespace lichtenberg::effects
