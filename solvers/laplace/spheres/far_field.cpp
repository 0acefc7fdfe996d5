#include "solvers/laplace/spheres/far_field.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace lichtenberg::laplace::spheres {
namespace {

double largest_radius(const std::vector<Site>& sites) {
  double radius = 0;
  for (const Site& site : sites) radius = std::max(radius, site.radius);
  return radius;
}

}  // namespace

FarField::FarField(const Mirrors& mirrors, const std::vector<Site>& targets, const std::vector<Site>& sources,
                   double range, double accuracy)
    : mirrors_(&mirrors),
      targets_(targets),
      sources_(sources),
      target_start_(starts(targets)),
      source_start_(starts(sources)) {
  // Terms fall off like ((R_s + R_t) / range)^(l + t).
  const double reach = (largest_radius(targets) + largest_radius(sources)) / range;
  const int degree = std::clamp(static_cast<int>(std::ceil(std::log(0.1 * accuracy) / std::log(reach))), 3, 40);
  coupling_ = std::make_shared<const Coupling>(degree);
  const LatticeSum lattice(mirrors, range, degree, 0.1 * accuracy);
  for (const MirrorImage& image : mirrors.images)
    if (std::find(masks_.begin(), masks_.end(), image.mask) == masks_.end()) masks_.push_back(image.mask);
  for (const int mask : masks_) {
    std::vector<Vec3> from, places;
    for (const Site& target : targets)
      for (const Site& source : sources) {
        from.push_back(mirrored(source.centre, mask));
        places.push_back(target.centre);
      }
    derivatives_.push_back(lattice.far_derivatives(mask, from, places));
  }
}

/// What is beyond the range is harmonic but for the background -1/V of a charge (LatticeSum), whose potential about a
/// distance d is 2 pi / 3 V |d|^2: cancelled by opposite charges but for a uniform field against the sum of dipoles.
void FarField::add_background(const double* multipoles, double* local) const {
  Vec3 sum;
  for (std::size_t s = 0; s < sources_.size(); ++s) {
    if (sources_[s].degree < 1) continue;
    const double* a = multipoles + source_start_[s];
    const double area = sources_[s].radius * sources_[s].radius;
    for (const MirrorImage& image : mirrors_->images)
      sum += mirrored({a[at(1, 1)], a[at(1, -1)], a[at(1, 0)]}, image.mask) * (image.sign * area);
  }
  sum *= -4 * std::numbers::pi / (3 * mirrors_->volume());
  for (std::size_t t = 0; t < targets_.size(); ++t) {
    if (targets_[t].degree < 1) continue;
    double* b = local + target_start_[t];
    b[at(1, 1)] += targets_[t].radius * sum.x;
    b[at(1, -1)] += targets_[t].radius * sum.y;
    b[at(1, 0)] += targets_[t].radius * sum.z;
  }
}

void FarField::add(const double* multipoles, double* local, parallel::Team& team) const {
  const int sources = static_cast<int>(sources_.size());
  team.for_each(static_cast<int>(targets_.size()), [&](int t) {
    const Site& target = targets_[t];
    for (std::size_t k = 0; k < masks_.size(); ++k)
      for (int s = 0; s < sources; ++s)
        coupling_->add(derivatives_[k].col(static_cast<Eigen::Index>(t) * sources + s).data(), sources_[s].degree,
                       sources_[s].radius, masks_[k], 1, multipoles + source_start_[s], target.degree, target.radius,
                       local + target_start_[t]);
  });
  add_background(multipoles, local);
}

}  // namespace lichtenberg::laplace::spheres
