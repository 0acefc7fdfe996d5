#include "solvers/laplace/accuracy/gaps.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "solvers/geometry/closed_curve.hpp"

namespace lichtenberg::laplace {
namespace {

constexpr double far = 2;  // Largest relevant gap, in radii

double cube(double x) { return x * x * x; }

bool one_potential(const LaplaceProblem& problem, int a, int b) {
  const Group &one = problem.groups[a], &other = problem.groups[b];
  return a == b || (!one.floating && !other.floating && one.potential == other.potential);
}

class Search {
 public:
  explicit Search(const LaplaceProblem& problem) : problem_(problem), found_(whole_box()) {
    for (const Body& body : problem.bodies)
      if (const Disk* disk = std::get_if<Disk>(&body.shape)) disks_.push_back({*disk, body.group});
    std::ranges::sort(disks_, {}, &Circle::left);
    for (std::size_t i = 0; i < disks_.size(); ++i) {
      consider(far * disks_[i].disk.radius, disks_[i].disk.radius);
      check_right_neighbours(i);
      check_other_shapes(disks_[i]);
      check_sides(disks_[i], disks_[i].disk.radius);
    }
    for (const Body& body : problem.bodies)
      if (const auto* freeform = std::get_if<Freeform>(&body.shape)) check_curve(*freeform->curve, body);
  }
  NarrowGap found() const { return found_; }

 private:
  struct Circle {
    Disk disk;
    int group = 0;
    double left() const { return disk.centre.x - disk.radius; }
  };

  NarrowGap whole_box() const {
    const double side = std::max(problem_.size.x, problem_.size.y);
    return {side, side};
  }

  void consider(double gap, double radius) {
    const NarrowGap narrow_gap{std::clamp(gap, 0.0, far * radius), radius};
    if (narrow_gap.radius * cube(narrow_gap.gap) < found_.radius * cube(found_.gap)) found_ = narrow_gap;
  }

  void check_right_neighbours(std::size_t i) {
    const Circle& one = disks_[i];
    const double reach = one.disk.centre.x + (1 + far) * one.disk.radius;
    for (std::size_t j = i + 1; j < disks_.size() && disks_[j].left() <= reach; ++j)
      if (!one_potential(problem_, one.group, disks_[j].group))
        consider(gap(one.disk, disks_[j].disk), std::min(one.disk.radius, disks_[j].disk.radius));
  }

  void check_other_shapes(const Circle& one) {
    for (const Body& body : problem_.bodies)
      if (!std::holds_alternative<Disk>(body.shape) && !one_potential(problem_, one.group, body.group))
        consider(gap(one.disk, body.shape), one.disk.radius);
  }

  void check_sides(const Circle& one, double radius) {
    const Vec2 p = one.disk.centre;
    const std::array distance = {p.x, problem_.size.x - p.x, p.y, problem_.size.y - p.y};
    const Group& group = problem_.groups[one.group];
    for (std::size_t s = 0; s < distance.size(); ++s) {
      const Side& side = problem_.sides[s];
      if (side.kind == Side::Kind::insulating || side.profile) continue;
      if (group.floating || group.potential != side.potential) consider(distance[s] - one.disk.radius, radius);
    }
  }

  /// The radius of a curve is twice its area over its perimeter, as for a disk. Its gaps are those of points on it.
  void check_curve(const ClosedCurve& curve, const Body& own) {
    const double radius = 2 * curve.area() / curve.perimeter();
    if (!curve.hollow()) consider(far * radius, radius);
    for (const Vec2 p : curve.polygon(1e-3 * radius)) {
      const bool in_box = p.x >= 0 && p.x <= problem_.size.x && p.y >= 0 && p.y <= problem_.size.y;
      if (!in_box) continue;
      check_sides({{p, 0}, own.group}, radius);
      for (const Body& other : problem_.bodies)
        if (&other != &own && !std::holds_alternative<Disk>(other.shape) &&
            !one_potential(problem_, own.group, other.group))
          consider(gap({p, 0}, other.shape), radius);
    }
  }

  const LaplaceProblem& problem_;
  std::vector<Circle> disks_;
  NarrowGap found_;
};

}  // namespace

NarrowGap narrowest(const LaplaceProblem& problem) { return Search(problem).found(); }

double difficulty(const NarrowGap& narrow_gap, double cell) {
  return std::sqrt(cell / narrow_gap.radius) * std::pow(cell / std::max(cell, narrow_gap.gap), 1.5);
}

double cell_for(const NarrowGap& narrow_gap, double difficulty) {
  const double resolved = std::sqrt(difficulty * std::sqrt(narrow_gap.radius) * std::pow(narrow_gap.gap, 1.5));
  if (resolved <= narrow_gap.gap) return resolved;
  return std::max(narrow_gap.gap, narrow_gap.radius * difficulty * difficulty);
}

}  // namespace lichtenberg::laplace
