#include "solvers/periodic/device/tables.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "solvers/error.hpp"
#include "solvers/periodic/charge_mesh.hpp"
#include "solvers/periodic/near.hpp"
#include "solvers/periodic/turn.hpp"

namespace lichtenberg::periodic::device {
namespace {

constexpr int highest_order = 7;

std::vector<float> window_of(const Mesh& mesh) {
  std::vector<float> window;
  for (const std::vector<double>& of_power : window_pieces(mesh.window, mesh.order))
    for (const double weight : of_power) window.push_back(static_cast<float>(weight));
  return window;
}

NearTable near_table(const Mesh& mesh, const Cloud& cloud, const std::vector<double>& value) {
  NearTable table;
  table.cutoff2 = static_cast<float>(cloud.cutoff * cloud.cutoff);
  const double turn = 2 / (cloud.cutoff * cloud.cutoff);
  table.turn = static_cast<float>(turn);
  for (int k = 0; k < 3; ++k) table.length[k] = static_cast<float>(mesh.lengths[k] * 0x1p-32);
  table.terms = static_cast<int>(value.size());
  for (int n = 0; n < table.terms; ++n) {
    table.value[n] = static_cast<float>(value[n]);
    if (n > 0) table.slope[n - 1] = static_cast<float>(2 * turn * n * value[n]);
  }
  return table;
}

MultipoleTable multipole_table(const Mesh& mesh, const Cloud& cloud, const std::vector<double>& value) {
  MultipoleTable table{.charges = near_table(mesh, cloud, value)};
  const double twice = 4 / (cloud.cutoff * cloud.cutoff);
  for (int n = 2; n < table.charges.terms; ++n) {
    table.second[n - 2] = static_cast<float>(-twice * twice * n * (n - 1) * value[n]);
    if (n > 2) table.third[n - 3] = static_cast<float>(twice * twice * twice * n * (n - 1) * (n - 2) * value[n]);
  }
  return table;
}

}  // namespace

MeshTables make_tables(const Mesh& mesh, const Cloud& cloud) {
  checked(mesh, highest_order);  // refuses what it cannot do
  const NearPart near(mesh.lengths, cloud);
  const std::vector<double>&of_charges = near.coefficients(Kind::charges),
        &of_dipoles = near.coefficients(Kind::dipoles);
  if (of_charges.size() > most_terms)
    throw InputError(
        fmt::format("A near part of degree {} is beyond the single precision of a device, which reaches "
                    "an accuracy of 1e-6: it has {} at most.",
                    of_charges.size() - 1, most_terms - 1));
  MeshTables tables{.mesh = mesh, .near = near_table(mesh, cloud, of_charges), .window = window_of(mesh)};
  if (mesh.window == Window::spline && mesh.order >= lowest_dipole_order && of_dipoles.size() <= most_terms)
    tables.multipoles = multipole_table(mesh, cloud, of_dipoles);
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
    tables.over_spacing[k] = static_cast<float>(1 / mesh.spacing()[k]);
    for (int n = 0; n < 2; ++n) tables.wave[n][k] = static_cast<float>(waves[n][k]);
  }
  tables.self = static_cast<float>(cloud.potential(0));
  tables.self_field = static_cast<float>(cloud.dipole_field);
  tables.reach = 0.5 * mesh.order * std::max({mesh.spacing().x, mesh.spacing().y, mesh.spacing().z});
  tables.cutoff = cloud.cutoff;
  tables.background = -cloud.background / mesh.volume();
  return tables;
}

}  // namespace lichtenberg::periodic::device
