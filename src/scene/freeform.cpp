#include "src/scene/freeform.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "src/field_methods/field_method.hpp"

namespace lichtenberg {
namespace {

/// Returns points of a curve with lines between them that deviate by 1e-4 of its size.
std::vector<Vec2> edge_of(const ClosedCurve& curve) {
  const Vec2 size = curve.high() - curve.low();
  return curve.polygon(1e-4 * std::max(size.x, size.y));
}

std::vector<Vec2> edge_of(const Bar& bar) {
  const Vec2 half = 0.5 * bar.width / norm(bar.to - bar.from) * perpendicular(bar.to - bar.from);
  return {bar.from - half, bar.from + half, bar.to + half, bar.to - half};
}

bool lines_meet(Vec2 a, Vec2 b, Vec2 c, Vec2 d) {
  const auto side = [](Vec2 p, Vec2 q, Vec2 r) { return cross(q - p, r - p); };
  return side(a, b, c) * side(a, b, d) <= 0 && side(c, d, a) * side(c, d, b) <= 0 &&
         std::max(std::min(a.x, b.x), std::min(c.x, d.x)) <= std::min(std::max(a.x, b.x), std::max(c.x, d.x)) &&
         std::max(std::min(a.y, b.y), std::min(c.y, d.y)) <= std::min(std::max(a.y, b.y), std::max(c.y, d.y));
}

bool edges_meet(const std::vector<Vec2>& a, const std::vector<Vec2>& b) {
  for (std::size_t i = 0; i < a.size(); ++i)
    for (std::size_t j = 0; j < b.size(); ++j)
      if (lines_meet(a[i], a[(i + 1) % a.size()], b[j], b[(j + 1) % b.size()])) return true;
  return false;
}

ClosedCurve make_curve(const ElectrodeDraft& electrode) {
  if (electrode.shape == "polygon") return make_polygon(electrode.points, electrode.corner_radius, electrode.hollow);
  if (electrode.shape == "curve") return make_spline(electrode.points, electrode.hollow);
  return make_ellipse(electrode.centre, electrode.semi_axes, electrode.angle * std::numbers::pi / 180,
                      electrode.hollow);
}

std::string key_of(const ElectrodeDraft& electrode) {
  return electrode.shape == "ellipse" ? "electrode.semi_axes" : "electrode.points";
}

}  // namespace

bool is_freeform(const ElectrodeDraft& electrode) {
  return electrode.shape == "polygon" || electrode.shape == "ellipse" || electrode.shape == "curve";
}

std::shared_ptr<const ClosedCurve> make_freeform(const Draft& draft, const ElectrodeDraft& electrode,
                                                 const std::string& name) {
  const auto refuse_it = [&](const std::string& why) {
    refuse(draft.scene.path, electrode.line,
           fmt::format("{}: the {} \"{}\" {}", key_of(electrode), electrode.shape, name, why));
  };
  std::shared_ptr<const ClosedCurve> curve;
  try {
    curve = std::make_shared<ClosedCurve>(make_curve(electrode));
  } catch (const InputError& error) {
    refuse_it(error.what());
  }
  const Vec2 size = plane(draft.scene.domain.size);
  const Bar domain{{0, 0.5 * size.y}, {size.x, 0.5 * size.y}, size.y};
  const std::vector<Vec2> edge = edge_of(*curve), box = edge_of(domain);
  const bool meets = edges_meet(edge, box), inside = signed_distance(domain, edge[0]) <= 0;
  if (!meets && !inside && (curve->hollow() || !curve->covers(box[0])))
    refuse_it(fmt::format("{} the domain, which goes from [0, 0] to [{:g}, {:g}] m",
                          curve->hollow() ? "does not reach into" : "lies outside", size.x, size.y));
  const double cell = std::max(size.x, size.y) / draft.field.options.cells;
  constexpr double most_thin_cells = 8;  // A tip of 14 degrees is thinner than a cell over this length
  const ClosedCurve::ThinParts thin = draft.field.accuracy ? ClosedCurve::ThinParts{} : curve->thin_parts(cell);
  if (thin.longest > most_thin_cells * cell || thin.all > 0.5 * curve->perimeter())
    refuse_it(
        fmt::format("is thinner than a cell of the field's grid, {:.3g} m, over {:.3g} m of its surface: use more "
                    "field.cells or make it thicker",
                    cell, thin.all));
  return curve;
}

bool touch(const Freeform& a, const Disk& b) { return gap(b, a) <= 0; }

bool touch(const Freeform& a, const Bar& b) {
  const std::vector<Vec2> edge = edge_of(*a.curve), bar = edge_of(b);
  return a.curve->covers(bar[0]) || (!a.curve->hollow() && signed_distance(b, edge[0]) <= 0) || edges_meet(edge, bar);
}

bool touch(const Freeform& a, const Ring& b) {
  const std::vector<Vec2> edge = edge_of(*a.curve);
  return a.curve->hollow() || std::ranges::any_of(edge, [&](Vec2 p) { return signed_distance(b, p) <= 0; });
}

bool touch(const Freeform& a, const Freeform& b) {
  if (a.curve->hollow() && b.curve->hollow()) return true;
  const std::vector<Vec2> edge = edge_of(*a.curve), other = edge_of(*b.curve);
  return (!b.curve->hollow() && a.curve->covers(other[0])) || (!a.curve->hollow() && b.curve->covers(edge[0])) ||
         edges_meet(edge, other);
}

void check_freeforms(const Draft& draft, const std::vector<Electrode>& electrodes) {
  const FieldMethodKind* method = draft.field.method;
  const bool on_device = draft.field.options.device == FieldDevice::cuda;
  for (std::size_t i = 0; i < electrodes.size(); ++i) {
    if (!electrodes[i].curve) continue;
    const auto refuse_it = [&](const std::string& subject, const std::string& others) {
      refuse(draft.scene.path, draft.electrodes[i].line,
             fmt::format("{} does not solve a scene where the electrode \"{}\" has electrode.shape = \"{}\": {}",
                         subject, electrodes[i].name, draft.electrodes[i].shape, others));
    };
    if (method && !method->curves)
      refuse_it(fmt::format("field.method = \"{}\"", method->name),
                "methods that are allowed: " +
                    field_methods_that(2, [](const FieldMethodKind& other) { return other.curves; }));
    if (on_device) refuse_it("field.device = \"cuda\"", "\"cpu\" is allowed");
  }
}

}  // namespace lichtenberg
