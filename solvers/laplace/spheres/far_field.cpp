#include "solvers/laplace/spheres/far_field.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace lichtenberg::laplace::spheres {
namespace {

/// Harmonics of degree 1 along x, y and z.
constexpr std::array<int, 3> first_degree = {at(1, 1), at(1, -1), at(1, 0)};

}  // namespace

FarImages images_beyond(double range, double target_radius, double source_radius, double accuracy) {
  // Terms decrease like ((R_s + R_t) / range)^(l + t).
  const double reach = (target_radius + source_radius) / range;
  const int degree = std::clamp(static_cast<int>(std::ceil(std::log(0.1 * accuracy) / std::log(reach))), 3, 40);
  return {range, degree, ewald_split(range, 0.1 * accuracy)};
}

FarImages all_images(const Mirrors& mirrors, double largest_radius, int degree, double accuracy) {
  // An image within the cut-off costs as much as seven waves, and the product of their numbers is fixed.
  constexpr double images = 24;
  const double cutoff = std::cbrt(images * 3 / (4 * std::numbers::pi * mirrors.density()));
  return {0, 2 * degree + 1, ewald_split_of_all(std::max(cutoff, 8 * largest_radius), 0.1 * accuracy)};
}

FarField::FarField(const Mirrors& mirrors, const std::vector<Site>& targets, const std::vector<Site>& sources,
                   const FarImages& images, const FarField* past)
    : mirrors_(mirrors), targets_(targets), sources_(sources), source_start_(starts(sources)) {
  if (past && past->lattice_->fits(mirrors, images.beyond, images.degree, images.split))
    coupling_ = past->coupling_, lattice_ = past->lattice_;
  else {
    coupling_ = std::make_shared<const Coupling>(images.degree);
    lattice_ = std::make_shared<const LatticeSum>(mirrors, images.beyond, images.degree, images.split);
  }
  for (const MirrorImage& image : mirrors.images)
    if (std::find(masks_.begin(), masks_.end(), image.mask) == masks_.end()) masks_.push_back(image.mask);
  for (const int mask : masks_) find_derivatives(mask, images.beyond == 0 && &targets == &sources);
}

/// Computes the derivatives for one mask. Without mirrors the reverse displacement has the same derivatives, with the
/// opposite sign for odd degrees.
void FarField::find_derivatives(int mask, bool same_sites) {
  const bool once = same_sites && mask == 0;
  std::vector<Vec3> from, positions;
  for (std::size_t t = 0; t < targets_.size(); ++t)
    for (std::size_t s = 0; s < (once ? t + 1 : sources_.size()); ++s) {
      from.push_back(mirrored(sources_[s].centre, mask));
      positions.push_back(targets_[t].centre);
    }
  Eigen::MatrixXd found = lattice_->far_derivatives(mask, from, positions);
  if (!once) {
    derivatives_.push_back(std::move(found));
    return;
  }
  const auto n = static_cast<Eigen::Index>(targets_.size());
  Eigen::VectorXd parity(found.rows());
  for (int l = 0; l <= lattice_->degree(); ++l) parity.segment(at(l, -l), 2 * l + 1).setConstant(l & 1 ? -1 : 1);
  Eigen::MatrixXd both(found.rows(), n * n);
  for (Eigen::Index t = 0, column = 0; t < n; ++t)
    for (Eigen::Index s = 0; s <= t; ++s, ++column) {
      both.col(s * n + t) = parity.cwiseProduct(found.col(column));
      both.col(t * n + s) = found.col(column);
    }
  derivatives_.push_back(std::move(both));
}

/// Adds the background's field. The field of images beyond the range is harmonic except for the background -1/V of a
/// charge (LatticeSum), whose potential at a distance d is 2 pi / 3 V |d|^2. Opposite charges cancel it up to a uniform
/// field opposite to the sum of dipoles.
template <class T>
void FarField::add_background(const T* multipoles, const std::vector<int>& target_start, T* local) const {
  std::array<T, 3> sum{};
  for (std::size_t s = 0; s < sources_.size(); ++s) {
    if (sources_[s].degree < 1) continue;
    const T* a = multipoles + source_start_[s];
    const double area = sources_[s].radius * sources_[s].radius;
    for (const MirrorImage& image : mirrors_.images)
      for (int k = 0; k < 3; ++k)
        sum[k] += a[first_degree[k]] * (image.mask >> k & 1 ? -1.0 : 1.0) * (image.sign * area);
  }
  for (T& component : sum) component *= -4 * std::numbers::pi / (3 * mirrors_.volume());
  for (std::size_t t = 0; t < targets_.size(); ++t) {
    if (targets_[t].degree < 1) continue;
    T* b = local + target_start[t];
    for (int k = 0; k < 3; ++k) b[first_degree[k]] += targets_[t].radius * sum[k];
  }
}

template <class T>
void FarField::add(const T* multipoles, T* local, parallel::Team& team, int beyond) const {
  const int sources = static_cast<int>(sources_.size());
  const std::vector<int> target_start = starts(targets_, beyond);
  team.for_each(static_cast<int>(targets_.size()), [&](int t) {
    const Site& target = targets_[t];
    for (std::size_t k = 0; k < masks_.size(); ++k)
      for (int s = 0; s < sources; ++s)
        coupling_->add(derivatives_[k].col(static_cast<Eigen::Index>(t) * sources + s).data(),
                       {sources_[s].degree, sources_[s].radius, masks_[k], 1}, multipoles + source_start_[s],
                       {target.degree + beyond, target.radius}, local + target_start[t]);
  });
  add_background(multipoles, target_start, local);
}

template void FarField::add(const double*, double*, parallel::Team&, int) const;
template void FarField::add(const Lanes*, Lanes*, parallel::Team&, int) const;

}  // namespace lichtenberg::laplace::spheres
