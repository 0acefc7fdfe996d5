#include "solvers/laplace/multipole/arrangement.hpp"

#include <algorithm>

#include "solvers/error.hpp"

namespace lichtenberg::laplace {

namespace {

/// Beyond this order products of powers and binomials leave the range of double precision.
constexpr int largest_order = 1000;
/// A centre this close to a side, in units of the box, is meant to be on it.
constexpr double on_side = 1e-12;

constexpr std::array<const char*, 4> side_name{"left", "right", "bottom", "top"};

std::string name(std::size_t body) { return "body " + std::to_string(body); }

std::vector<Source> circles(const LaplaceProblem& problem) {
  std::vector<Source> disks;
  for (std::size_t b = 0; b < problem.bodies.size(); ++b) {
    const auto* disk = std::get_if<Disk>(&problem.bodies[b].shape);
    if (!disk) throw InputError(name(b) + " is no disk: the multipole method solves scenes of disks only");
    disks.push_back({to_complex(disk->centre), disk->radius, 0});
  }
  return disks;
}

/// Distance of p from a side, positive inside the box.
double distance(Complex p, int side, Vec2 size) {
  switch (side) {
    case left:
      return p.real();
    case right:
      return size.x - p.real();
    case bottom:
      return p.imag();
    default:
      return size.y - p.imag();
  }
}

void put_on_side(Complex& p, int side, Vec2 size) {
  switch (side) {
    case left:
      p.real(0);
      break;
    case right:
      p.real(size.x);
      break;
    case bottom:
      p.imag(0);
      break;
    default:
      p.imag(size.y);
  }
}

/// Puts centres that are meant to be on a side exactly there.
void check_against_sides(const LaplaceProblem& problem, Arrangement& arrangement) {
  const double tiny = on_side * std::max(problem.size.x, problem.size.y);
  for (std::size_t b = 0; b < arrangement.disks.size(); ++b) {
    Source& disk = arrangement.disks[b];
    for (int s = 0; s < 4; ++s) {
      const double away = distance(disk.centre, s, problem.size);
      if (std::abs(away) > tiny) {
        if (away <= disk.radius)
          throw InputError(name(b) + " touches or crosses the " + side_name[s] +
                           " side: the multipole method allows disks inside the box and disks centred on a side");
        continue;
      }
      put_on_side(disk.centre, s, problem.size);
      arrangement.copies[b] *= 2;
      if (problem.sides[s].kind == Side::Kind::insulating) continue;
      if (arrangement.anchored[b])
        throw InputError(name(b) +
                         " is centred in a corner of two electrodes: the multipole method allows corners with at "
                         "least one insulating side");
      arrangement.anchored[b] = true;
      const Group& group = problem.groups[problem.bodies[b].group];
      if (group.floating || group.potential != problem.sides[s].potential)
        throw InputError(name(b) + " is centred on the " + side_name[s] +
                         " side, an electrode: its group must be fixed at that side's potential");
    }
  }
}

/// exp(-alpha), alpha being the bipolar coordinate of the circle of radius `radius` that has another of radius `other`
/// at a distance `gap` from surface to surface: where the images of charges in that other circle accumulate.
double decay_rate(double radius, double other, double gap) {
  const double t = gap * (gap + 2 * other) / (2 * (gap + radius + other) * radius);  // cosh(alpha) - 1
  return 1 / (1 + t + std::sqrt(t * (t + 2)));
}

}  // namespace

Arrangement::Arrangement(const LaplaceProblem& problem, const Mirrors& mirrors, double accuracy)
    : disks(circles(problem)),
      decay(disks.size(), 0.0),
      copies(disks.size(), 1),
      anchored(disks.size(), false),
      cells(mirrors, disks) {
  if (mirrors.bounded) check_against_sides(problem, *this);
  find_orders(accuracy);
}

void Arrangement::find_orders(double accuracy) {
  for (std::size_t i = 0; i < disks.size(); ++i) {
    Source& disk = disks[i];
    // Whatever is not near is beyond the window.
    decay[i] = disk.radius / (disk.radius + cells.window * std::min(cells.width, cells.height));
    cells.for_each_near(disk.centre, [&](int j, const Image& image, Complex shift) {
      const double d = std::abs(disk.centre - image.centre(disks[j].centre) - shift);
      if (static_cast<int>(i) == j && d < disk.radius) return;
      const double gap = d - disk.radius - disks[j].radius;
      if (!(gap > 0))
        throw InputError(name(i) + " and " + name(j) +
                         (i == static_cast<std::size_t>(j) ? "'s mirror image" : std::string()) +
                         " touch or overlap: the multipole method needs a gap between disks");
      decay[i] = std::max(decay[i], decay_rate(disk.radius, disks[j].radius, gap));
    });
    const double order = std::ceil(std::log(accuracy) / std::log(decay[i])) + 2;
    disk.order = static_cast<int>(std::min<double>(order, largest_order));
  }
}

}  // namespace lichtenberg::laplace
