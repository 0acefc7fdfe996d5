#include "solvers/periodic/accuracy.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <vector>

#include "solvers/error.hpp"
#include "solvers/periodic/mesh.hpp"
#include "solvers/periodic/sum_method.hpp"

namespace lichtenberg::periodic {

namespace {

/// Integral of the squared force between unit charges over all space beyond contact.
double force2(double contact) { return 4 * M_PI / contact; }

/// Returns the squared error of the near part for charges with dipoles: Cloud::neglected with the terms of its
/// derivatives.
double neglected_with(const Cloud& cloud, double dipole2) {
  const double third = dipole2 / 3;
  return cloud.neglected + third * (2 * cloud.neglected_slope + third * cloud.neglected_curvature);
}

/// Returns the number density of the charges.
double density_of(const MeshRequest& request) {
  const Mesh box = request.box(request.contact);
  return request.charges / (box.open.any() ? box.open.volume : box.volume());
}

/// Returns the length whose half (in double precision) or third bounds the cut-off: the shortest periodic side. Without
/// one the longest possible distance bounds it.
double length_for_cutoffs(const MeshRequest& request) {
  double shortest = INFINITY, square = 0;
  for (int k = 0; k < 3; ++k) {
    if (!request.open[k]) shortest = std::min(shortest, request.lengths[k]);
    if (request.open[k]) square += request.lengths[k] * request.lengths[k];
  }
  return std::isfinite(shortest) ? shortest : 3 * std::max(std::sqrt(square), 2 * request.contact);
}

double longest_in_single(const MeshRequest& request) {
  const double length = length_for_cutoffs(request);
  return Near<float>::longest_cutoff({length, length, length});
}

double dipole2_of(const MeshRequest& request) {
  return request.polarizability ? induced_dipole2(*request.polarizability, density_of(request), request.contact) : 0;
}

/// Returns the mesh in the given box whose spacings are at most the longest side over `along_longest`; empty if
/// `numbers` has no number that large.
std::optional<Mesh> mesh_of(int along_longest, const std::vector<int>& numbers, Mesh mesh, int order, Window window) {
  const Vec3 lengths = mesh.lengths;
  const double longest = std::max({lengths.x, lengths.y, lengths.z});
  mesh.order = order, mesh.window = window;
  for (int k = 0; k < 3; ++k) {
    const auto points = std::ranges::lower_bound(numbers, lengths[k] / longest * along_longest * (1 - 1e-12));
    if (points == numbers.end()) return {};
    mesh.points[k] = *points;
  }
  return mesh;
}

/// Returns a mesh with the same spacings in a smaller box, for which the error estimate is the same and takes less
/// time.
Mesh sample_of(const Mesh& mesh) {
  Mesh sample = mesh;
  for (int k = 0; k < 3; ++k) {
    sample.points[k] = std::min(mesh.points[k], 16);
    sample.lengths[k] = mesh.spacing()[k] * sample.points[k];
  }
  return sample;
}

/// Returns the first index of 0 ... count - 1 for which a condition holds that holds for all larger ones; `count` if
/// there is none. The condition is tested near `guess` first.
template <class Holds>
int first_index(int count, int guess, const Holds& holds) {
  int low = -1, high = count, step = 1;  // the condition fails at `low` and holds at `high`
  for (int at = std::clamp(guess, 0, count - 1); low + 1 < high; step *= 2) {
    (holds(at) ? high : low) = at;
    if (low < 0 && high > 0)
      at = std::max(high - step, 0);
    else if (high == count && low + 1 < count)
      at = std::min(low + step, count - 1);
    else
      at = low + (high - low) / 2;
  }
  return high;
}

/// Returns the lowest band limit, as a multiple of a small step above 1, whose neglected force is at most `most`. The
/// error falls with the band limit b, about as 16 pi b exp(-2 b) / cutoff, because the prolate function is nearly a
/// Gaussian.
double band_limit_for(double most, double cutoff, double dipole2) {
  constexpr int steps = 1 << 17;
  constexpr double step = 99.0 / steps;
  const auto excess = [&](double b) { return std::log(neglected_with(prolate_cloud(b, cutoff), dipole2) / most); };
  double b = 10;
  for (int k = 0; k < 8; ++k) {
    const double rough = std::log(16 * M_PI * b / (cutoff * most)) - 2 * b;
    b = std::clamp(b + rough / (2 - 1 / b), 1.0, 100.0);
  }
  for (int k = 0; k < 2; ++k) b = std::clamp(b + excess(b) / (2 - 1 / b), 1.0, 100.0);
  const int found =
      first_index(steps - 1, static_cast<int>((b - 1) / step), [&](int n) { return excess(1 + (n + 1) * step) <= 0; });
  return 1 + (found + 1) * step;
}

/// Returns the smallest alpha of a gauss_cloud whose neglected force is at most `most`, by bisection: the error falls
/// with alpha.
double alpha_for(double most, double cutoff, double dipole2) {
  double low = 0.1 / cutoff, high = 20 / cutoff;
  while (high - low > 1e-4 * high) {
    const double middle = 0.5 * (low + high);
    (neglected_with(gauss_cloud(middle, cutoff), dipole2) > most ? low : high) = middle;
  }
  return high;
}

void require_sensible(double accuracy, Vec3 lengths, double contact) {
  require_consistent({.lengths = lengths});
  if (!(contact > 0))
    throw InputError(fmt::format("charges come as near as {} to each other: it must be positive", contact));
  if (!(accuracy >= 1e-8 && accuracy <= 0.1))
    throw InputError(fmt::format("the accuracy {} is not possible for a mesh: it must be from 1e-8 to 0.1", accuracy));
}

double error_of(const MeshChoice& choice, const MeshRequest& request) {
  const double by_mesh = relative_error(sample_of(choice.mesh), choice.cloud(), request.contact, dipole2_of(request));
  return choice.single ? std::hypot(by_mesh, error_of_single_precision) : by_mesh;
}

/// Returns the cut-offs to try, in ascending order. They start beyond contact, because errors are largest just beyond
/// the cut-off.
std::vector<double> cutoffs(double longest, double contact, double cutoff_ratio) {
  constexpr double from_contact = 1.5;
  std::vector<double> cutoffs;
  if (longest > contact) cutoffs.push_back(longest);
  for (double cutoff = longest / cutoff_ratio; cutoff > from_contact * contact; cutoff /= cutoff_ratio)
    cutoffs.push_back(cutoff);
  std::ranges::reverse(cutoffs);
  return cutoffs;
}

/// Numbers of points to try along the longest side, and along the other sides.
struct Points {
  std::vector<int> along_longest, others;

  Points(const MeshRequest& request, const SumMethod& method) : along_longest(method.points), others(method.points) {
    const auto& fixed = request.fixed.points;
    if (!fixed) return;
    along_longest = {*fixed};
    others.insert(std::ranges::lower_bound(others, *fixed), *fixed);
  }
};

/// Meshes of one method with one kind of window.
struct Meshes {
  const MeshRequest& request;
  const Points points;
  const Window window;

  /// Returns the mesh with `number` points along the longest side.
  std::optional<Mesh> of(int number, int order, double cutoff) const {
    return mesh_of(number, points.others, request.box(cutoff), order, window);
  }
  bool fine_enough(int number, int order, const Cloud& cloud, double most) const {
    const auto mesh = of(number, order, cloud.cutoff);
    return mesh && mesh_error(sample_of(*mesh), cloud, dipole2_of(request)) <= most;
  }
  /// Returns the coarsest mesh whose squared error is at most `most`; empty if there is none. `guess`: index of its
  /// number of points, updated.
  std::optional<Mesh> coarsest(const Cloud& cloud, double most, int order, int& guess) const {
    const int count = static_cast<int>(points.along_longest.size());
    guess = first_index(count, guess, [&](int n) { return fine_enough(points.along_longest[n], order, cloud, most); });
    return guess == count ? std::nullopt : of(points.along_longest[guess], order, cloud.cutoff);
  }
};

/// Estimated work (ns), without that of the mesh points.
double work_on_charges(const SumMethod& method, const MeshRequest& request, double cutoff, double order) {
  return request.charges *
         (method.near(density_around(request, cutoff), cutoff) + method.charge + method.row * order * order);
}

/// Chooses the splitting of 1/r at this cut-off for a squared error of the near part of at most `most`; empty if alpha
/// is given and the error exceeds it.
std::optional<MeshChoice> split_at(double cutoff, double most, const MeshRequest& request) {
  const double dipole2 = dipole2_of(request);
  MeshChoice choice{.cutoff = cutoff, .alpha = request.fixed.alpha.value_or(0)};
  if (request.gauss && choice.alpha == 0) choice.alpha = alpha_for(most, cutoff, dipole2);
  if (choice.alpha == 0) choice.band_limit = band_limit_for(most, cutoff, dipole2);
  if (choice.alpha > 0 && neglected_with(choice.cloud(), dipole2) > most) return {};
  return choice;
}

/// Returns the cut-offs to try, without those for which even the finest mesh is too coarse. Shorter cut-offs need finer
/// meshes; for small charges in a large box nearly all are excluded.
std::vector<double> cutoffs_of(const Meshes& meshes, double most, const MeshRequest& request, const SumMethod& method) {
  if (request.fixed.cutoff) return {*request.fixed.cutoff};
  std::vector<double> all = cutoffs(method.longest_cutoff, request.contact, method.cutoff_ratio);
  const int finest = meshes.points.along_longest.back();
  const int order = request.fixed.order.value_or(method.highest_order);
  const auto too_short = [&](double cutoff) {
    const auto choice = split_at(cutoff, most, request);
    return !choice || !meshes.fine_enough(finest, order, choice->cloud(), most);
  };
  if (!all.empty() && too_short(all.front())) all.erase(all.begin(), std::ranges::partition_point(all, too_short));
  return all;
}

/// Chooses the parameters with the least work, with a squared error of at most `most` in both the near part and the
/// mesh. Returns empty if none needs less work than `least`; otherwise sets `least` to their work.
std::optional<MeshChoice> choose_with(Window window, double most, const MeshRequest& request, const SumMethod& method,
                                      double& least) {
  const Meshes meshes{request, Points(request, method), window};
  const auto coarsest_of_all = meshes.of(meshes.points.along_longest.front(), method.lowest_order, request.contact);
  if (!coarsest_of_all) return {};
  const double least_on_mesh = work_on_mesh(method, *coarsest_of_all, request);
  std::optional<MeshChoice> best;
  std::vector<int> guesses(method.highest_order + 1);
  for (const double cutoff : cutoffs_of(meshes, most, request, method)) {
    if (cutoff > method.longest_cutoff || work_on_charges(method, request, cutoff, 0) + least_on_mesh >= least) break;
    auto choice = split_at(cutoff, most, request);
    if (!choice) continue;
    const Cloud cloud = choice->cloud();
    for (int order = method.lowest_order; order <= method.highest_order; ++order) {
      const double by_charges = work_on_charges(method, request, cutoff, order);
      if (order != request.fixed.order.value_or(order) || by_charges + least_on_mesh >= least) continue;
      const auto mesh = meshes.coarsest(cloud, most, order, guesses[order]);
      if (!mesh || by_charges + work_on_mesh(method, *mesh, request) >= least) continue;
      least = by_charges + work_on_mesh(method, *mesh, request);
      choice->mesh = *mesh;
      best = choice;
    }
  }
  return best;
}

/// Chooses parameters with the first windows that reach the accuracy, or, if the method compares windows, with those
/// that take the least work.
std::optional<MeshChoice> choose(double most, const MeshRequest& request, const SumMethod& method) {
  std::optional<MeshChoice> best;
  double least = INFINITY;
  for (const Window window : method.windows) {
    if (const auto choice = choose_with(window, most, request, method, least)) best = choice;
    if (best && !method.on_device) break;
  }
  return best;
}

/// Throws InputError for an order given explicitly that a ParticleMesh does not support.
void require_order_in_double(const MeshRequest& request) {
  const int order = request.fixed.order.value_or(highest_double_order);
  const int lowest = request.polarizability ? lowest_dipole_order : 4;
  if (order >= lowest && order <= highest_double_order) return;
  const std::string reason = why_not_single(request);
  throw InputError(fmt::format(
      "order = {} is not allowed: forces are computed in double precision here, as {}, with splines of order "
      "{} to {}",
      order, reason.empty() ? "single does not reach the accuracy" : reason, lowest, highest_double_order));
}

MeshChoice in_double(double accuracy, const MeshRequest& request, int lowest_order) {
  require_sensible(accuracy, request.box(request.contact).lengths, request.contact);
  const double most = 0.5 * accuracy * accuracy * force2(request.contact);
  const SumMethod method = in_double_precision(length_for_cutoffs(request), lowest_order);
  auto best = choose(most, request, method);
  if (!best)
    throw InputError(
        fmt::format("no mesh of up to 1024 points along a side reaches an accuracy of {} in a box of {} x "
                    "{} x {} with a cutoff of up to half of it{}",
                    accuracy, request.lengths.x, request.lengths.y, request.lengths.z,
                    request.fixed.any() ? ", with the given parameters" : ""));
  best->error = error_of(*best, request);
  return *best;
}

std::vector<Window> windows_of(const MeshRequest& request) {
  if (request.splines) return {Window::spline};
  return {Window::prolate, Window::spline};
}

/// Returns the parameters given explicitly for one kind of window, in double precision. Chooses the band limit for the
/// least error: a larger one increases the error of the mesh, a smaller one that of the near part.
MeshChoice fixed_with(Window window, const MeshRequest& request) {
  const auto [cutoff, alpha, points, order] = request.fixed;
  auto numbers = quick_numbers();
  numbers.insert(std::ranges::lower_bound(numbers, *points), *points);
  const auto mesh = mesh_of(*points, numbers, request.box(*cutoff), *order, window);
  if (!mesh) throw InputError(fmt::format("{} points along the longest side are more than 1024", *points));
  MeshChoice best{.mesh = *mesh, .cutoff = *cutoff, .band_limit = 1, .alpha = alpha.value_or(0)};
  best.error = error_of(best, request);
  if (alpha) return best;
  for (double limit = 1.25; limit <= 40; limit += 0.25) {
    MeshChoice other = best;
    other.band_limit = limit;
    other.error = error_of(other, request);
    if (other.error < best.error) best = other;
  }
  return best;
}

/// Returns the same parameters in single precision; empty if single precision does not support them or would add to
/// their error noticeably.
std::optional<MeshChoice> in_single(MeshChoice choice, const MeshRequest& request) {
  if (choice.mesh.points[2] % 2 != 0 || choice.error < finest_single ||
      std::ssize(cloud_polynomial(choice.cloud())) > Near<float>::highest_degree + 1)
    return {};
  choice.single = true;
  choice.error = error_of(choice, request);
  return choice;
}

/// Returns the parameters given explicitly, in single precision where possible. Double precision is tried only if
/// single precision is excluded.
MeshChoice fixed_alone(const MeshRequest& request) {
  const int order = *request.fixed.order;
  std::optional<MeshChoice> best;
  if (why_not_single(request).empty() && order >= 4 && order <= 8)
    for (const Window window : windows_of(request)) {
      const auto choice = in_single(fixed_with(window, request), request);
      if (choice && (!best || choice->error < best->error)) best = choice;
    }
  if (best) return *best;
  require_order_in_double(request);
  return fixed_with(Window::spline, request);
}

}  // namespace

Mesh MeshRequest::box(double cutoff) const {
  Mesh mesh{.lengths = lengths, .open = {.along = open}};
  if (!mesh.open.any()) return mesh;
  double square = 0;
  mesh.open.volume = 1;
  for (int k = 0; k < 3; ++k) {
    if (open[k]) square += lengths[k] * lengths[k];
    mesh.open.volume *= open[k] ? std::max(lengths[k], contact) : lengths[k];
  }
  // Clouds reach as far as the cut-off. The margin is for rounded positions.
  mesh.open.range = (std::sqrt(square) + cutoff) * (1 + 1e-6);
  for (int k = 0; k < 3; ++k)
    if (open[k]) mesh.lengths[k] = std::max(lengths[k] + mesh.open.range + cutoff, 3 * cutoff) * (1 + 1e-6);
  return mesh;
}

double density_around(const MeshRequest& request, double radius) {
  const double mean = density_of(request);
  if (request.local_density.empty()) return mean;
  const double longest = std::max({request.lengths.x, request.lengths.y, request.lengths.z});
  const std::size_t last = request.local_density.size() - 1;
  const double level = std::clamp(2 * std::log2(longest / radius), 0.0, static_cast<double>(last));
  const auto lower = static_cast<std::size_t>(level), upper = std::min(lower + 1, last);
  return std::max(
      mean, std::lerp(request.local_density[lower], request.local_density[upper], level - static_cast<double>(lower)));
}

double random_force(double charge2, double charges, double volume, double contact) {
  return charge2 * std::sqrt(force2(contact) / (charges * volume));
}

double relative_error(const Mesh& mesh, const Cloud& cloud, double contact, double dipole2) {
  return std::sqrt((neglected_with(cloud, dipole2) + mesh_error(mesh, cloud, dipole2)) / force2(contact));
}

double induced_dipole2(double polarizability, double density, double contact) {
  constexpr double neighbours = 6;
  return polarizability * polarizability * (density * force2(contact) + neighbours / std::pow(contact, 4));
}

std::string why_not_single(const MeshRequest& request) {
  const FixedParameters& fixed = request.fixed;
  if (request.only_double || request.on_device) return "that is requested";
  if (request.polarizability) return "single does not include dipoles";
  if (!fixed.complete() && request.accuracy < finest_single)
    return fmt::format("single is good for an accuracy of {:g} and more", finest_single);
  if (fixed.points.value_or(0) % 2 != 0) return "single needs an even number of points";
  if (fixed.cutoff.value_or(0) > longest_in_single(request))
    return fmt::format("single needs a cutoff of a third of the box, {:.4g}, or less", longest_in_single(request));
  return "";
}

double seconds_of(const MeshChoice& choice, const MeshRequest& request) {
  const Mesh& mesh = choice.mesh;
  const SumMethod method = choice.single ? in_single_precision(choice.cutoff, {mesh.window})
                                         : in_double_precision(2 * choice.cutoff, mesh.order);
  const double density = request.charges / (mesh.open.volume > 0 ? mesh.open.volume : mesh.volume());
  const double charge = method.near(density, choice.cutoff) + method.charge + method.row * mesh.order * mesh.order;
  return 1e-9 * (request.charges * charge + work_on_mesh(method, mesh, request));
}

MeshChoice choose_mesh(double accuracy, int charges, Vec3 lengths, double contact, int lowest_order) {
  return in_double(accuracy, {.charges = charges, .lengths = lengths, .contact = contact}, lowest_order);
}

MeshChoice choose_quick_mesh(const MeshRequest& request) {
  if (request.fixed.complete()) return fixed_alone(request);
  require_sensible(request.accuracy, request.box(request.contact).lengths, request.contact);
  const double own2 = error_of_single_precision * error_of_single_precision;
  const double most = 0.5 * (request.accuracy * request.accuracy - own2) * force2(request.contact);
  std::optional<MeshChoice> best;
  if (request.on_device && !request.polarizability) {
    best = choose(most, request, on_device(length_for_cutoffs(request), windows_of(request)));
    if (best) best->error = std::hypot(error_of(*best, request), error_of_single_precision);
    if (best) return *best;
  }
  if (why_not_single(request).empty())
    best = choose(most, request, in_single_precision(longest_in_single(request), windows_of(request)));
  if (!best) {
    require_order_in_double(request);
    return in_double(request.accuracy, request, request.polarizability ? lowest_dipole_order : 4);
  }
  best->single = true;
  best->error = error_of(*best, request);
  return *best;
}

}  // namespace lichtenberg::periodic
