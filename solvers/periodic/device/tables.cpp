#include "solvers/periodic/device/tables.hpp"

#include <fmt/format.h>

#include "solvers/error.hpp"
#include "solvers/neighbours/table.hpp"
#include "solvers/periodic/charge_mesh.hpp"
#include "solvers/periodic/self_term.hpp"

namespace lichtenberg::periodic::device {
namespace {

constexpr int highest_order = 7;

std::vector<float> window_of(const Mesh& mesh) {
  std::vector<float> window;
  for (const std::vector<double>& coefficients : window_pieces(mesh.window, mesh.order))
    for (const double weight : coefficients) window.push_back(static_cast<float>(weight));
  return window;
}

NearTable near_table(const Mesh& mesh, const Cloud& cloud, const std::vector<double>& polynomial) {
  const double cutoff2 = cloud.cutoff * cloud.cutoff;
  NearTable table{.cutoff2 = static_cast<float>(cutoff2), .kernels = {polynomial, 2 / cutoff2}};
  for (int k = 0; k < 3; ++k) table.length[k] = static_cast<float>(mesh.lengths[k] * 0x1p-32);
  return table;
}

Mirrors mirrors_of(const Mesh& mesh, const Enclosure& enclosure) {
  Mirrors mirrors;
  for (int k = 0; k < 3; ++k) {
    const bool lower = enclosure.sides[2 * k] == Side::grounded, upper = enclosure.sides[2 * k + 1] == Side::grounded;
    mirrors.along[k] = lower || upper;
    // If both sides are grounded, the mesh is periodic with twice the length of the box.
    if (upper && !lower)
      mirrors.twice[k] = fixed_point_coordinate(2 * enclosure.lengths[k], units_per_box / mesh.lengths[k]);
  }
  return mirrors;
}

}  // namespace

MeshTables make_tables(const Mesh& mesh, const Cloud& cloud, const Enclosure& enclosure) {
  checked(mesh, highest_order);  // Throws for unsupported meshes
  checked_cutoff(mesh.lengths, cloud.cutoff);
  const std::vector<double> charge_polynomial = cloud_polynomial(cloud, Kind::charges),
                            dipole_polynomial = cloud_polynomial(cloud, Kind::dipoles);
  if (charge_polynomial.size() > most_terms)
    throw InputError(
        fmt::format("A near part of degree {} is beyond the single precision of a device, which reaches "
                    "an accuracy of 1e-6: it has {} at most.",
                    charge_polynomial.size() - 1, most_terms - 1));
  MeshTables tables{.mesh = mesh, .near = near_table(mesh, cloud, charge_polynomial), .window = window_of(mesh)};
  if (mesh.window == Window::spline && mesh.order >= lowest_dipole_order && dipole_polynomial.size() <= most_terms)
    tables.multipoles = near_table(mesh, cloud, dipole_polynomial);
  const Influence influence = optimal_influence(mesh, cloud);
  const auto waves = waves_from_middle(influence, mesh.order);
  const auto [across, down, up] = mesh.points;
  const int deep = up / 2 + 1;
  tables.factor.resize(influence.factor.size());
  for (int y = 0; y < down; ++y)
    for (int x = 0; x < across; ++x)
      for (int z = 0; z < deep; ++z)
        tables.factor[(static_cast<std::size_t>(x) * down + y) * deep + z] =
            static_cast<float>(influence.factor[(static_cast<std::size_t>(y) * across + x) * deep + z]);
  for (int k = 0; k < 3; ++k) {
    tables.inverse_spacing[k] = static_cast<float>(1 / mesh.spacing()[k]);
    for (int n = 0; n < 2; ++n) tables.wave[n][k] = static_cast<float>(waves[n][k]);
  }
  tables.self = static_cast<float>(cloud.potential(0));
  tables.self_field = static_cast<float>(cloud.dipole_field);
  tables.reach = reach_of(mesh);
  tables.cutoff = cloud.cutoff;
  tables.background = mesh.open.any() ? 0 : -cloud.background / mesh.volume();
  tables.mirrors = mirrors_of(mesh, enclosure);
  return tables;
}

}  // namespace lichtenberg::periodic::device
