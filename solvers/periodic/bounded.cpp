#include "solvers/periodic/bounded.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "solvers/error.hpp"
#include "solvers/geometry/box.hpp"
#include "solvers/periodic/field_sums.hpp"
#include "solvers/periodic/short_range.hpp"

namespace lichtenberg::periodic {
namespace {

bool is_grounded(const Enclosure& enclosure, int axis) {
  return enclosure.sides[2 * axis] == Side::grounded || enclosure.sides[2 * axis + 1] == Side::grounded;
}

Vec3 extents_of(const Sources& sources) {
  Vec3 extents;
  for (int k = 0; k < 3; ++k) {
    double low = INFINITY, high = -INFINITY;
    for (int i = 0; i < sources.size(); ++i) {
      low = std::min(low, sources.position[3 * i + k]);
      high = std::max(high, sources.position[3 * i + k]);
    }
    if (sources.size() > 0 && !std::isfinite(high - low)) throw Failure("the position of a charge is not finite");
    extents[k] = sources.size() > 0 ? rounded_up(high - low) : 0;
  }
  return extents;
}

void require_inside(const Enclosure& enclosure, const Sources& sources) {
  for (int k = 0; k < 3; ++k) {
    if (enclosure.unbounded || enclosure.sides[2 * k] == Side::periodic) continue;
    for (int i = 0; i < sources.size(); ++i)
      if (const double x = sources.position[3 * i + k]; !(x >= 0 && x <= enclosure.lengths[k]))
        throw Failure(
            fmt::format("charge {} has left the domain through the {} side: contacts with the sides must be stiffer, "
                        "or steps shorter",
                        i, side_names[2 * k + (x > 0)]));
  }
}

/// Chooses a mesh. Adds the accuracy and the domain of the caller to the message of an InputError, because the box of
/// the mesh includes images.
template <class Choose>
MeshChoice choose_with_domain(double accuracy, const Enclosure& enclosure, const Choose& choose) {
  try {
    return choose();
  } catch (const InputError& error) {
    const auto [x, y, z] = enclosure.lengths;
    const std::string domain =
        enclosure.unbounded ? std::string("an unbounded domain, for a box around the charges")
                            : fmt::format("a domain of {:g} x {:g} x {:g}, with images in grounded sides", x, y, z);
    throw InputError(fmt::format("accuracy {:g} in {}: {}", accuracy, domain, error.what()));
  }
}

/// Extents of the charges in an unbounded enclosure, in units of `unit`. The unit is the longest extent, if the choice
/// of the mesh depends on no other length. Clouds of the same shape then have the same mesh; otherwise the unit is 1.
struct CloudShape {
  Vec3 extents;
  double unit = 1;
};

/// Returns the shape of charges with these extents. Extents that are results of rounded_up() have ratios 2^(n/8).
CloudShape shape_of(const Vec3& extents, const MeshRequest& request) {
  const double longest = std::max({extents.x, extents.y, extents.z});
  const double shortest = std::min({extents.x, extents.y, extents.z}), volume = extents.x * extents.y * extents.z;
  // The distance of near pairs is then half the mean spacing.
  const bool has_shape = !request.fixed.any() && !request.polarizability && shortest > request.contact &&
                         0.5 * std::cbrt(volume / std::max(request.charges, 1)) > request.contact;
  CloudShape shape{extents};
  if (!has_shape) return shape;
  for (int k = 0; k < 3; ++k) {
    const double n = 8 * std::log2(extents[k] / longest);
    if (std::abs(n - std::nearbyint(n)) > 1e-9) return {extents};
    shape.extents[k] = std::exp2(std::nearbyint(n) / 8);
  }
  shape.unit = longest;
  return shape;
}

MeshChoice choose_for(const CloudShape& shape, MeshRequest request, const Enclosure& enclosure) {
  const double accuracy = request.accuracy;
  request.accuracy = std::max(0.5 * accuracy, 1e-8), request.contact /= shape.unit;
  return choose_with_domain(accuracy, enclosure,
                            [&] { return choose_quick_mesh(enclosure.request(request, shape.extents)); });
}

void scale(std::span<double> values, double by) {
  if (by == 1) return;
  for (double& value : values) value *= by;
}

}  // namespace

double rounded_up(double length) { return length > 0 ? std::exp2(std::ceil(8 * std::log2(length)) / 8) : 0; }

MeshChoice choose_cloud_mesh(const Vec3& extents, const MeshRequest& request, const Enclosure& enclosure) {
  const CloudShape shape = shape_of(extents, request);
  const double unit = shape.unit;
  MeshChoice choice = choose_for(shape, request, enclosure);
  choice.cutoff *= unit, choice.alpha /= unit, choice.mesh.lengths = unit * choice.mesh.lengths;
  choice.mesh.open.range *= unit, choice.mesh.open.volume *= unit * unit * unit;
  return choice;
}

bool Enclosure::is_periodic() const {
  return std::ranges::all_of(sides, [](Side side) { return side == Side::periodic; }) && !unbounded;
}

int Enclosure::copies() const {
  int copies = 1;
  for (int k = 0; k < 3; ++k)
    if (is_grounded(*this, k)) copies *= 2;
  return copies;
}

MeshRequest Enclosure::request(MeshRequest own, Vec3 extents) const {
  own.lengths = unbounded ? extents : lengths;
  // The error is relative to forces of pairs as near as half the mean spacing. Nearer pairs have larger forces.
  const double volume =
      std::max(extents.x, own.contact) * std::max(extents.y, own.contact) * std::max(extents.z, own.contact);
  if (unbounded && own.charges > 0) own.contact = std::max(own.contact, 0.5 * std::cbrt(volume / own.charges));
  own.charges *= copies();
  for (int k = 0; k < 3; ++k) {
    const bool lower = sides[2 * k] == Side::grounded, upper = sides[2 * k + 1] == Side::grounded;
    own.open[k] = unbounded || (sides[2 * k] != Side::periodic && !(lower && upper));
    if (lower || upper) own.lengths[k] *= 2;
  }
  return own;
}

void append_images(const Enclosure& enclosure, std::vector<double>& position, std::vector<double>& charge,
                   std::vector<double>& dipole) {
  for (int axis = 0; axis < 3; ++axis) {
    if (!is_grounded(enclosure, axis)) continue;
    const double twice = enclosure.sides[2 * axis] == Side::grounded ? 0 : 2 * enclosure.lengths[axis];
    const std::size_t n = charge.size();
    for (std::size_t i = 0; i < n; ++i) charge.push_back(-charge[i]);
    for (std::size_t c = 0; c < 3 * n; ++c) {
      const bool along = static_cast<int>(c % 3) == axis;
      position.push_back(along ? twice - position[c] : position[c]);
      if (!dipole.empty()) dipole.push_back(along ? dipole[c] : -dipole[c]);
    }
  }
}

BoundedSum::BoundedSum(const MeshRequest& request, const Enclosure& enclosure, const MeshChoice& choice)
    : request_(request), enclosure_(enclosure) {
  if (!enclosure.unbounded) sized_.push_back({{}, false, choice.mesh.lengths, make_mesh_sum(choice)});
}

/// Returns the sum for the extents of the sources, and sets the unit. Three sums are kept: the sides of a cloud exceed
/// the next rounded length at different times while it grows, and then its shape returns.
BoundedSum::Sized& BoundedSum::sized_for(const Sources& sources) {
  if (!enclosure_.unbounded) return sized_.front();
  const bool by_pairs = sources.size() <= few;
  const CloudShape shape = by_pairs ? CloudShape{extents_of(sources)} : shape_of(extents_of(sources), request_);
  unit_ = shape.unit;
  const auto found = std::ranges::find_if(
      sized_, [&](const Sized& sized) { return sized.extents == shape.extents && sized.by_pairs == by_pairs; });
  if (found != sized_.end()) return *found;
  if (sized_.size() > 2) {
    const SumSeconds past = sized_.front().sum->seconds();
    earlier_.near += past.near, earlier_.mesh += past.mesh;
    sized_.erase(sized_.begin());
  }
  if (by_pairs) {
    constexpr double no_period = 1e100;
    sized_.push_back({shape.extents,
                      true,
                      {no_period, no_period, no_period},
                      std::make_unique<MinimumImage>(MinimumImage::Reach::box)});
  } else {
    const MeshChoice choice = choose_for(shape, request_, enclosure_);
    sized_.push_back({shape.extents, false, choice.mesh.lengths, make_mesh_sum(choice)});
  }
  return sized_.back();
}

const Sources& BoundedSum::with_images(const Sources& sources, Vec3 lengths) {
  require_inside(enclosure_, sources);
  all_ = sources;
  all_.lengths = lengths;
  if (enclosure_.unbounded) return in_unit(sources, lengths);
  if (enclosure_.copies() == 1) return all_;
  position_.assign(sources.position.begin(), sources.position.end());
  charge_.assign(sources.charge.begin(), sources.charge.end());
  dipole_.assign(sources.dipole.begin(), sources.dipole.end());
  append_images(enclosure_, position_, charge_, dipole_);
  return all_ = {lengths, position_, charge_, dipole_};
}

/// Returns the sources with positions in the unit of the latest sum. It is 1 if they have dipoles.
const Sources& BoundedSum::in_unit(const Sources& sources, Vec3 lengths) {
  position_.assign(sources.position.begin(), sources.position.end());
  scale(position_, 1 / unit_);
  return all_ = {lengths, position_, sources.charge, sources.dipole};
}

void BoundedSum::evaluate(const Sources& sources, std::span<const Pair>, parallel::Team& team, Response& response) {
  Sized& sized = sized_for(sources);
  sized.sum->evaluate(with_images(sources, sized.lengths), {}, team, response);
  resize(response, sources.size());
  response.energy /= enclosure_.copies() * unit_;
  scale(response.potential, 1 / unit_);
  scale(response.field, 1 / (unit_ * unit_));
  scale(response.force, 1 / (unit_ * unit_));
}

void BoundedSum::forces(const Sources& sources, std::span<const Pair>, parallel::Team& team,
                        std::vector<double>& force) {
  Sized& sized = sized_for(sources);
  sized.sum->forces(with_images(sources, sized.lengths), {}, team, force);
  force.resize(sources.position.size());
  scale(force, 1 / (unit_ * unit_));
}

void BoundedSum::dipole_field(const Sources& sources, std::span<const Pair>, parallel::Team& team,
                              std::span<double> field) {
  Sized& sized = sized_for(sources);
  const Sources& all = with_images(sources, sized.lengths);
  std::vector<double> fields(all.position.size());
  sized.sum->dipole_field(all, {}, team, fields);
  std::copy_n(fields.begin(), field.size(), field.begin());
}

SumSeconds BoundedSum::seconds() const {
  SumSeconds seconds = earlier_;
  for (const Sized& sized : sized_) {
    const SumSeconds part = sized.sum->seconds();
    seconds.near += part.near, seconds.mesh += part.mesh;
  }
  return seconds;
}

MeshChoice choose_bounded_mesh(const MeshRequest& request, const Enclosure& enclosure, const Sources& sources,
                               parallel::Team& team) {
  if (enclosure.unbounded) return choose_cloud_mesh(extents_of(sources), request, enclosure);
  std::vector<double> position(sources.position.begin(), sources.position.end());
  std::vector<double> charge(sources.charge.begin(), sources.charge.end()), none;
  if (std::ranges::all_of(charge, [](double q) { return q == 0; }))
    for (std::size_t i = 0; i < charge.size(); ++i) charge[i] = i % 2 == 0 ? 1 : -1;
  append_images(enclosure, position, charge, none);
  const MeshRequest all = enclosure.request(request);
  return choose_with_domain(request.accuracy, enclosure, [&] {
    return choose_measured_mesh(all, {all.box(request.contact).lengths, position, charge}, team);
  });
}

}  // namespace lichtenberg::periodic
