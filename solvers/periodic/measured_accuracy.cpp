#include <algorithm>
#include <cmath>
#include <ranges>
#include <vector>

#include "solvers/error.hpp"
#include "solvers/periodic/accuracy.hpp"
#include "solvers/periodic/dipoles.hpp"
#include "solvers/periodic/ewald.hpp"
#include "solvers/periodic/mesh.hpp"

namespace lichtenberg::periodic {

namespace {

constexpr int few = 200;  ///< Number of charges up to which Ewald's sum is used directly: its cost is negligible

/// Sample of sources with the reference forces on them.
struct Exact {
  std::vector<int> sample;
  std::vector<double> force;
};

std::vector<int> spread_over(int size, int most) {
  std::vector<int> sample;
  for (int s = 0; s < std::min(size, most); ++s)
    sample.push_back(static_cast<int>(static_cast<std::int64_t>(s) * size / std::min(size, most)));
  return sample;
}

/// Returns the sources in the box of a mesh, which is longer along open axes.
Sources in_box(const MeshChoice& choice, Sources sources) {
  sources.lengths = choice.mesh.lengths;
  return sources;
}

Response evaluated(const MeshChoice& choice, const Sources& sources, parallel::Team& team) {
  Response response;
  make_mesh_sum(choice)->evaluate(in_box(choice, sources), {}, team, response);
  return response;
}

/// Returns the choice with the volume in which charges of the density around a charge fit, if it is clearly smaller
/// than the periodic box.
MeshChoice with_volume(MeshChoice choice, const MeshRequest& request) {
  const double density = density_around(request, choice.cutoff);
  if (!choice.mesh.open.any() && request.charges < 0.5 * density * choice.mesh.volume())
    choice.mesh.open.volume = request.charges / density;
  return choice;
}

/// Computes reference forces, with an error of 1/30 of the requested one. Empty with open axes if no mesh reaches this
/// error.
Exact exact_forces(const MeshRequest& request, const Sources& sources, parallel::Team& team) {
  constexpr double share = 1.0 / 30;
  const double finer = request.accuracy * share;
  const bool open = request.box(request.contact).open.any();
  if ((sources.size() > few || open) && finer >= 1e-8) {
    try {
      MeshRequest exact = request;
      exact.accuracy = finer, exact.only_double = true, exact.fixed = {};
      const MeshChoice choice = with_volume(choose_quick_mesh(exact), request);
      return {spread_over(sources.size(), sources.size()), evaluated(choice, sources, team).force};
    } catch (const InputError&) {  // No mesh reaches this accuracy: use Ewald's sum
    }
  }
  if (open) return {};
  constexpr int enough = 64;
  Response response;
  const std::vector<int> sample = spread_over(sources.size(), sources.size() > few ? enough : few);
  Ewald(splitting_for(sources, std::max(0.1 * finer, 1e-12))).evaluate_at(sample, sources, team, response);
  return {sample, response.force};
}

/// Returns MeshRequest::local_density of a sample of the sources; empty if it is nowhere clearly above their mean
/// density beyond contact.
std::vector<double> local_density_of(const MeshRequest& request, const Sources& sources, parallel::Team& team) {
  constexpr double clearly = 1.5, beyond_contact = 1.5;
  const Vec3& lengths = request.lengths;
  const double longest = std::max({lengths.x, lengths.y, lengths.z}), mean = density_around(request, request.contact);
  std::vector<double> within;  // Number of other sources, summed over the sample
  for (double radius = longest; radius > request.contact; radius *= M_SQRT1_2) within.push_back(0);
  const std::vector<int> sample = spread_over(sources.size(), 64);
  std::vector<std::vector<double>> others_of(sample.size(), within);
  team.for_each(static_cast<int>(sample.size()), [&](int s) {
    for (int j = 0; j < sources.size(); ++j) {
      double square = 0;
      for (int k = 0; k < 3; ++k) {
        double separation = (sources.position[3 * sample[s] + k] - sources.position[3 * j + k]) / longest;
        if (!request.open[k]) separation -= lengths[k] / longest * std::nearbyint(longest / lengths[k] * separation);
        square += separation * separation;
      }
      const int level = square > 0 ? std::min(-1 - std::ilogb(square), static_cast<int>(within.size()) - 1) : -1;
      if (level >= 0) ++others_of[s][level];
    }
  });
  for (const std::vector<double>& others : others_of)
    for (std::size_t level = 0; level < within.size(); ++level) within[level] += others[level];
  bool clustered = false;
  double radius = longest * std::pow(M_SQRT2, 1.0 - static_cast<double>(within.size())), others = 0;
  for (double& density : within | std::views::reverse) {
    others += density;
    density = others / (static_cast<double>(sample.size()) * 4 * M_PI / 3 * std::pow(radius, 3));
    clustered |= radius > beyond_contact * request.contact && density > clearly * mean;
    radius *= M_SQRT2;
  }
  return clustered ? within : std::vector<double>{};
}

/// Returns MeshRequest::used of the sources.
std::array<double, 2> used_part_of(const Sources& sources) {
  constexpr int cells = 64;
  std::array<double, 2> used{};
  for (int k = 0; k < 2; ++k) {
    std::array<bool, cells> has{};
    for (int i = 0; i < sources.size(); ++i) {
      const double x = sources.position[3 * i + k] / sources.lengths[k];
      has[std::min(static_cast<int>(cells * (x - std::floor(x))), cells - 1)] = true;
    }
    int gap = 0, run = 0;
    for (int c = 0; c < 2 * cells; ++c) {
      run = has[c % cells] ? 0 : run + 1;
      gap = std::max(gap, run);
    }
    used[k] = 1 - static_cast<double>(gap) / cells;
  }
  return used;
}

/// Returns the dipoles that the charges induce on this mesh. Empty if they have no stable state, which the run itself
/// reports in detail.
std::vector<double> induced_dipoles(const MeshChoice& choice, const MeshRequest& request, const Sources& sources,
                                    parallel::Team& team) {
  std::vector<double> dipole;
  if (!request.polarizability) return dipole;
  const auto sum = make_mesh_sum(choice);
  Response response;
  try {
    InducedDipoles(*sum, DipoleSum::ewald, *request.polarizability, request.accuracy)
        .evaluate(in_box(choice, sources), {}, team, dipole, response);
  } catch (const InputError&) {
    dipole.clear();
  }
  return dipole;
}

/// Returns false if the forces are rounding errors only, as for a single non-zero charge. A relative error has no
/// meaning then.
bool has_forces(const Exact& exact, const Sources& sources, double contact) {
  if (exact.sample.empty()) return false;
  double charge2 = 0, squares = 0;
  for (const double q : sources.charge) charge2 += q * q;
  for (const double f : exact.force) squares += f * f;
  constexpr double rounding = 1e-9;
  const double random = random_force(charge2, sources.size(), sources.volume(), contact);
  return std::sqrt(squares / static_cast<double>(exact.sample.size())) > rounding * random;
}

double found_error(const MeshChoice& choice, const Sources& sources, const Exact& exact, parallel::Team& team) {
  const Response found = evaluated(choice, sources, team);
  double error = 0, size = 0;
  for (std::size_t s = 0; s < exact.sample.size(); ++s)
    for (int k = 0; k < 3; ++k) {
      error += std::pow(found.force[3 * exact.sample[s] + k] - exact.force[3 * s + k], 2);
      size += std::pow(exact.force[3 * s + k], 2);
    }
  return std::sqrt(error / size);
}

}  // namespace

MeshChoice choose_measured_mesh(const MeshRequest& given_request, const Sources& given, parallel::Team& team) {
  if (given_request.fixed.complete() || given.size() < 2) return choose_quick_mesh(given_request);
  MeshRequest request = given_request;
  request.local_density = local_density_of(request, given, team), request.used = used_part_of(given);
  std::vector<double> charge(given.charge.begin(), given.charge.end());
  if (std::ranges::all_of(charge, [](double q) { return q == 0; }))
    for (std::size_t i = 0; i < charge.size(); ++i) charge[i] = i % 2 == 0 ? 1 : -1;
  MeshChoice best = with_volume(choose_quick_mesh(request), request);  // Throws if the request is out of reach
  Sources sources{given.lengths, given.position, charge};
  const std::vector<double> dipole = induced_dipoles(best, request, sources, team);
  sources.dipole = dipole;
  const Exact exact = exact_forces(request, sources, team);
  constexpr int rounds = 4;
  if (!has_forces(exact, sources, request.contact)) return best;
  MeshRequest now = request;
  now.accuracy = std::max(0.5 * request.accuracy, 1e-8);
  constexpr double least_single = 7e-7;  // Nearly twice the error of single precision itself
  if (request.accuracy > least_single) now.accuracy = std::max(now.accuracy, least_single);
  for (int round = 0; round < rounds; ++round) {
    MeshChoice found = best;
    try {
      found = with_volume(choose_quick_mesh(now), request);
    } catch (const InputError&) {  // The finer accuracy is out of reach
      if (round > 0) return best;
    }
    found.error = found_error(found, sources, exact, team);
    if (round == 0 || found.error <= request.accuracy || found.error < best.error) best = found;
    if (!(found.error > request.accuracy) && !(found.error < request.accuracy / 3)) return best;
    now.accuracy = std::clamp(now.accuracy * std::clamp(0.6 * request.accuracy / found.error, 0.1, 10.0), 1e-8, 0.1);
  }
  return best;
}

std::unique_ptr<Sum> make_mesh_sum(const MeshChoice& choice) {
  if (choice.single) return std::make_unique<SingleMesh>(choice.mesh, choice.cloud());
  return std::make_unique<ParticleMesh>(choice.mesh, choice.cloud());
}

}  // namespace lichtenberg::periodic
